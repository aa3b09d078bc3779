from fractions import Fraction

import numpy as np
import pytest
import scipy.stats
import statsmodels.api as sm
from hypothesis import given
from hypothesis import strategies as st

from data_schema.errors import InputRefused
from data_schema.vocabulary import Undefined
from stats.anova import one_way_anova
from stats.two_sample import compare_two

GROUPS = {"0": [42.1, 39.8, 44.0], "50": [36.9, 38.2, 35.1, 37.7], "100": [37.0, 39.5]}


@pytest.mark.parametrize("offset", [0.0, 1e6, 1e12])
def test_f_agrees_with_exact_arithmetic_at_any_offset(offset):
    """As NIST's SmLs sets: at an offset of 1e12 other programs keep two to three digits."""
    groups = {name: [x + offset for x in values] for name, values in GROUPS.items()}
    exact = {name: [Fraction(x) for x in values] for name, values in groups.items()}
    n = sum(map(len, exact.values()))
    grand = sum(map(sum, exact.values())) / n
    means = {name: sum(values) / len(values) for name, values in exact.items()}
    between = sum(len(values) * (means[name] - grand) ** 2 for name, values in exact.items())
    within = sum((x - means[name]) ** 2 for name, values in exact.items() for x in values)
    found = one_way_anova(groups)
    assert found.f == pytest.approx(float((between / 2) / (within / (n - 3))), rel=1e-13)
    assert found.eta_squared == pytest.approx(float(between / (between + within)), rel=1e-13)


def test_agrees_with_scipy_and_with_a_regression_on_dummies():
    found = one_way_anova(GROUPS)
    reference = scipy.stats.f_oneway(*GROUPS.values())
    assert (found.f, found.p) == pytest.approx((reference.statistic, reference.pvalue), rel=1e-10)
    values = np.concatenate(list(GROUPS.values()))
    dummies = np.repeat(np.eye(3), [3, 4, 2], axis=0)
    model = sm.OLS(values, sm.add_constant(dummies[:, 1:])).fit()
    assert (found.f, found.p, found.eta_squared) == pytest.approx((model.fvalue, model.f_pvalue, model.rsquared))
    assert (found.df_between, found.df_within, found.groups, found.group_ns) == (2, 6, ("0", "50", "100"), (3, 4, 2))
    assert found.sentence("gain").startswith("One-way ANOVA over gain: F(2, 6) = ")


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
    assert "no group has any scatter" in apart.sentence()


def test_equal_means_give_f_of_exactly_zero():
    found = one_way_anova({"a": [0.1, 0.3], "b": [0.1, 0.3, 0.1, 0.3]})
    assert (found.f, found.p) == (0.0, 1.0)


def test_too_few_groups_or_values():
    assert "at least 2 groups" in one_way_anova({"a": [1.0, 2.0], "b": []}).f.reason
    single = one_way_anova({"a": [1.0], "b": [2.0]})
    assert isinstance(single.f, Undefined)
    assert single.df_within == 0
    assert one_way_anova({}).df_between == 0


def test_nan_is_refused_by_group():
    with pytest.raises(InputRefused, match="group 'b'"):
        one_way_anova({"a": [1.0, 2.0], "b": [float("nan")]})


@given(
    st.lists(st.lists(st.integers(-99, 99), min_size=2, max_size=6), min_size=2, max_size=5).filter(
        lambda groups: any(len(set(group)) > 1 for group in groups)
    ),
    st.integers(-(2**30), 2**30),
    st.integers(-100, 100),
)
def test_shift_scale_and_order_leave_f_as_it_is(groups, shift, exponent):
    one = one_way_anova({str(k): group for k, group in enumerate(groups)})
    other = one_way_anova({str(k): (np.array(g) + shift) * 2.0**exponent for k, g in enumerate(reversed(groups))})
    assert other.f == pytest.approx(one.f, rel=1e-11, abs=1e-13)
    assert other.p == pytest.approx(one.p, rel=1e-10)
