from fractions import Fraction

import numpy as np
import pytest
import scipy.stats
import statsmodels.api as sm
from hypothesis import given
from hypothesis import strategies as st

from data_schema.vocabulary import Undefined
from stats.compare.two_sample import compare_two
from stats.groups.anova import one_way_anova, welch_anova
from tests.helpers.wording import says

GROUPS = {"0": [42.1, 39.8, 44.0], "50": [36.9, 38.2, 35.1, 37.7], "100": [37.0, 39.5]}


def test_agrees_with_scipy_and_with_a_regression_on_dummies():
    found = one_way_anova(GROUPS)
    reference = scipy.stats.f_oneway(*GROUPS.values())
    assert (found.f, found.p) == pytest.approx((reference.statistic, reference.pvalue), rel=1e-10)
    values = np.concatenate(list(GROUPS.values()))
    dummies = np.repeat(np.eye(3), [3, 4, 2], axis=0)
    model = sm.OLS(values, sm.add_constant(dummies[:, 1:])).fit()
    assert (found.f, found.p, found.eta_squared) == pytest.approx((model.fvalue, model.f_pvalue, model.rsquared))
    assert (found.df_between, found.df_within, found.groups, found.group_ns) == (2, 6, ("0", "50", "100"), (3, 4, 2))
    says(found.sentence("gain"), "One-way ANOVA over", "F(2, 6)")


def test_two_groups_are_students_t_squared():
    a, b = GROUPS["0"], GROUPS["50"]
    student = compare_two(a, b, route="student")
    found = one_way_anova({"a": a, "b": b})
    assert found.f == pytest.approx(student.t**2)
    assert found.p == pytest.approx(student.p)


def test_constants_have_no_f():
    """W3: other programs return F = 51.6, p = 1.3e-6 for groups of 0.1 alone."""
    same = one_way_anova({"a": [0.1] * 3, "b": [0.1] * 7, "c": [0.1] * 5})
    assert isinstance(same.f, Undefined)
    assert isinstance(same.p, Undefined)
    assert isinstance(same.eta_squared, Undefined)
    apart = one_way_anova({"a": [1.0, 1.0], "b": [2.0, 2.0]})
    assert isinstance(apart.p, Undefined)
    assert apart.eta_squared == 1.0
    says(apart.sentence(), "no group has")


def test_equal_means_give_f_of_exactly_zero():
    found = one_way_anova({"a": [0.1, 0.3], "b": [0.1, 0.3, 0.1, 0.3]})
    assert (found.f, found.p) == (0.0, 1.0)


def test_too_few_groups_or_values():
    says(one_way_anova({"a": [1.0, 2.0], "b": []}).f.reason, "2 groups")
    single = one_way_anova({"a": [1.0], "b": [2.0]})
    assert isinstance(single.f, Undefined)
    assert single.df_within == 0
    assert one_way_anova({}).df_between == 0


@given(
    st.lists(st.lists(st.floats(-3.0, 3.0), min_size=1, max_size=6), min_size=2, max_size=4).filter(
        lambda groups: any(np.ptp(np.array(group) + 1e15) > 0.0 for group in groups)
    ),
    st.sampled_from([0.0, 1e3, 1e9, 1e15]),
)
def test_f_agrees_with_exact_arithmetic_on_random_values(groups, offset):
    """Also where F is tiny: differences of rounded means would keep few digits there."""
    groups = {str(k): np.array(group) + offset for k, group in enumerate(groups)}
    exact = [[Fraction(float(x)) for x in values] for values in groups.values()]
    n, k = sum(map(len, exact)), len(exact)
    grand = sum(map(sum, exact)) / n
    means = [sum(values) / len(values) for values in exact]
    between = sum(len(values) * (mean - grand) ** 2 for values, mean in zip(exact, means, strict=True))
    within = sum((x - mean) ** 2 for values, mean in zip(exact, means, strict=True) for x in values)
    found = one_way_anova(groups)
    assert found.f == pytest.approx(float(between / (k - 1) / (within / (n - k))), rel=1e-14, abs=1e-300)


def test_an_empty_group_leaves_the_question_open():
    """W12: other programs report F of the groups that are left, without a word."""
    found = one_way_anova({**GROUPS, "150": []})
    says(found.f.reason, "'150'", "is empty")
    assert found.empty_groups == ("150",)
    assert found.groups == ("0", "50", "100")


def test_shares_of_variance_and_their_interval():
    found = one_way_anova(GROUPS)
    n, surplus = 9, found.df_between * (found.f - 1.0)
    assert found.omega_squared == pytest.approx(surplus / (surplus + n))
    low, high = found.eta_squared_ci
    assert 0.0 <= low < found.eta_squared < high < 1.0
    for end, tail in ((low, 0.975), (high, 0.025)):
        below = scipy.special.ncfdtr(2, 6, n * end / (1.0 - end), found.f)
        assert below == pytest.approx(tail, rel=1e-9) or (end == 0.0 and below < tail)
    assert one_way_anova(GROUPS, level=0.9).eta_squared_ci[1] < high


@pytest.mark.parametrize("anova", [one_way_anova, welch_anova])
@pytest.mark.parametrize("level", [0.8, 0.95, 0.99])
@given(
    st.lists(st.lists(st.floats(-5.0, 5.0).map(lambda x: round(x, 2)), min_size=2, max_size=6), min_size=2, max_size=4)
)
def test_the_estimate_of_the_share_lies_in_its_interval(anova, level, groups):
    """F below 1 gives 0, as effectsize shows it; a negative share once stood beside an interval that begins at 0."""
    found = anova(groups, level=level)
    if not isinstance(found.omega_squared, Undefined):
        low, high = found.omega_squared_ci
        assert 0.0 <= low <= found.omega_squared <= high <= 1.0


def test_groups_that_differ_less_than_chance_share_nothing():
    assert one_way_anova({"a": [1.0, 3.0], "b": [2.0, 2.5]}).omega_squared == 0.0
