import math

import numpy as np
import pytest
from statsmodels.stats.weightstats import ttost_ind

from data_schema.errors import InputRefused, UnknownName
from data_schema.vocabulary import Undefined
from stats.compare.equivalence import ROUTES, equivalence
from stats.compare.savings import percent_savings
from stats.compare.two_sample import compare_two
from stats.exact.tails import t_quantile
from tests.helpers.wording import refuses, says

AD = [0.4123, 0.4098, 0.4151, 0.4119, 0.4107, 0.4140]
CE = [0.4131, 0.4102, 0.4127, 0.4156, 0.4118]


@pytest.mark.parametrize("route", ROUTES)
def test_agrees_with_statsmodels(route):
    found = equivalence(AD, CE, low=-0.004, high=0.003, route=route)
    chosen = found.welch if route == "welch" else found.student
    p, low, high = ttost_ind(
        np.array(AD), np.array(CE), -0.004, 0.003, usevar="unequal" if route == "welch" else "pooled"
    )
    assert (chosen.t_low, chosen.p_low, chosen.df_low) == pytest.approx(low, rel=1e-9)
    assert (chosen.t_high, chosen.p_high, chosen.df_high) == pytest.approx(high, rel=1e-9)
    assert found.p == pytest.approx(p, rel=1e-9)
    assert found.log10_p == pytest.approx(math.log10(found.p), rel=1e-12)


@pytest.mark.parametrize("route", ROUTES)
def test_the_interval_is_that_of_the_difference_at_90_percent_unrounded(route):
    """W22: heights in metres; pingouin's interval of [-1.5, 2.4] mm is [-0. 0.], rounded to two decimals."""
    found = equivalence(AD, CE, low=-0.004, high=0.004, route=route)
    plain = compare_two(AD, CE, route=route, alpha=0.1)
    assert found.estimate_ci == pytest.approx(plain.difference_ci, rel=1e-12)
    assert found.estimate_ci[0] < 0.0 < found.estimate_ci[1]
    assert found.estimate == plain.difference


@pytest.mark.parametrize("bounds", ["raw", "percent"])
@pytest.mark.parametrize("route", ROUTES)
def test_the_interval_lies_within_the_bounds_just_where_both_tests_reject(bounds, route):
    unit = 1.0 if bounds == "raw" else 100.0 / np.mean(CE)
    middle = equivalence(AD, CE, low=-1.0, high=1.0, bounds=bounds, route=route)
    for end, side in zip(middle.estimate_ci, ("low", "high"), strict=True):
        for nudge, equivalent in ((-1e-6 * unit, side == "low"), (1e-6 * unit, side == "high")):
            low, high = (end + nudge, 90.0) if side == "low" else (-90.0, end + nudge)
            assert equivalence(AD, CE, low=low, high=high, bounds=bounds, route=route).equivalent is equivalent
        at = equivalence(
            AD, CE, low=end if side == "low" else None, high=end if side == "high" else None, bounds=bounds, route=route
        )
        assert at.p == pytest.approx(0.05, rel=1e-7)


def test_percent_bounds_take_the_controls_mean_as_estimated():
    """With the mean as known the bound would be a number of metres: t would be larger than it is."""
    found = equivalence(AD, CE, low=-1.0, high=1.0, bounds="percent", route="student")
    a, b, theta = np.array(AD), np.array(CE), 0.99
    pooled = (np.sum((a - a.mean()) ** 2) + np.sum((b - b.mean()) ** 2)) / (a.size + b.size - 2)
    t = (a.mean() - theta * b.mean()) / math.sqrt(pooled * (1.0 / a.size + theta**2 / b.size))
    assert found.student.t_low == pytest.approx(t, rel=1e-9)
    assert found.estimate == pytest.approx(100.0 * (a.mean() / b.mean() - 1.0), rel=1e-9)


def test_the_percent_interval_is_fiellers():
    found = equivalence(AD, CE, low=-1.0, high=1.0, bounds="percent", route="student")
    a, b = np.array(AD), np.array(CE)
    df = a.size + b.size - 2
    pooled = (np.sum((a - a.mean()) ** 2) + np.sum((b - b.mean()) ** 2)) / df
    squared = t_quantile(0.9, df) ** 2
    quadratic = b.mean() ** 2 - squared * pooled / b.size
    root = math.sqrt((a.mean() * b.mean()) ** 2 - quadratic * (a.mean() ** 2 - squared * pooled / a.size))
    ends = [100.0 * ((a.mean() * b.mean() + side * root) / quadratic - 1.0) for side in (-1.0, 1.0)]
    assert found.estimate_ci == pytest.approx(ends, rel=1e-9)
    # Welch's takes its degrees of freedom at each end, the savings take them at the estimate: close, not the same.
    saved = percent_savings(CE, AD, level=0.9).percent_ci
    assert equivalence(AD, CE, low=-1.0, high=1.0, bounds="percent").estimate_ci == pytest.approx(
        [-saved[1], -saved[0]], abs=2e-3
    )


def test_percent_bounds_are_hundredths_exactly():
    """-5 % of 100 is -5: a bound of -5 times the double .01 is another."""
    found = equivalence([94, 95, 96], [99, 100, 101], low=-5.0, high=5.0, bounds="percent")
    assert (found.estimate, found.welch.t_low, found.student.t_low, found.welch.p_low) == (-5.0, 0.0, 0.0, 0.5)


def test_non_inferiority_asks_for_one_bound():
    found = equivalence(AD, CE, low=-0.004, high=None)
    both = equivalence(AD, CE, low=-0.004, high=0.004)
    assert found.p == found.welch.p_low == both.welch.p_low
    assert "no upper bound" in found.high.reason
    assert "no upper bound" in found.welch.t_high.reason
    assert "non-inferiority" in found.sentence("AD", "CE", "m")
    assert "non-superiority" in equivalence(AD, CE, low=None, high=0.004).sentence()
    mirrored = equivalence([-x for x in AD], [-x for x in CE], low=None, high=0.004)
    assert mirrored.p == pytest.approx(found.p, rel=1e-13)


def test_sentence():
    text = equivalence(AD, CE, low=-0.004, high=0.004).sentence("AD", "CE", "m")
    says(text, "n = 6", "n = 5", "-0.0004 m", "90 %", "-0.0026", "-0.004")
    assert "90 % CI" in text
    percent = equivalence(AD, CE, low=-0.5, high=0.5, bounds="percent").sentence("AD", "CE", "m")
    says(percent, "not shown to", "-0.5", "0.5 %")
    confounded = equivalence(AD, CE, low=-0.004, high=0.004).sentence("AD", "CE", "m", "a difference between days")
    says(confounded, "-0.004", "0.004 m", "cannot be told")
    assert "shown" not in confounded
    says(equivalence([1.0], [2.0], low=-1.0, high=1.0).sentence(), "no test whether")


@pytest.mark.parametrize("route", ROUTES)
def test_constants_have_a_difference_and_no_test(route):
    """W1, W2: other programs give p from 0/0."""
    found = equivalence([0.04] * 10, [0.04] * 30, low=-0.01, high=0.01, route=route)
    assert found.estimate == 0.0
    says(found.p.reason, "neither group has")
    assert "no test" in found.sentence()


def test_what_does_not_exist_is_undefined_field_by_field():
    single = equivalence([0.41], CE, low=-0.01, high=0.01)
    assert "single value" in single.welch.p.reason
    assert isinstance(single.student.p, float)
    assert "at least 3" in equivalence([1.0], [2.0], low=-1.0, high=1.0).student.p.reason
    says(equivalence(AD, [], low=-1.0, high=1.0).estimate.reason, "b is empty")
    assert "cannot be compared" in equivalence([], CE, low=-1.0, high=1.0).sentence()
    assert "not positive" in equivalence(AD, [-x for x in CE], low=-1.0, high=1.0, bounds="percent").p.reason
    noisy = equivalence([30.0, 31.0, 29.0], [1.0, 100.0, -70.0], low=-50.0, high=50.0, bounds="percent")
    assert isinstance(noisy.p, float)
    assert isinstance(noisy.estimate_ci, Undefined)
    assert equivalence([*AD, math.nan], CE, low=-1.0, high=1.0, missing="drop").missing == 1


def test_wrong_input():
    with pytest.raises(InputRefused, match="lower one first"):
        equivalence(AD, CE, low=1.0, high=-1.0)
    with pytest.raises(InputRefused, match="Neither bound"):
        equivalence(AD, CE, low=None, high=None)
    with pytest.raises(InputRefused, match="greater than -100"):
        equivalence(AD, CE, low=-100.0, high=5.0, bounds="percent")
    with pytest.raises(InputRefused, match=r"below 0\.5"):
        equivalence(AD, CE, low=-1.0, high=1.0, alpha=0.5)
    with pytest.raises(UnknownName, match="percent"):
        equivalence(AD, CE, low=-1.0, high=1.0, bounds="percnt")
    with pytest.raises(UnknownName, match="welch"):
        equivalence(AD, CE, low=-1.0, high=1.0, route="welsh")
    with pytest.raises(InputRefused, match="group 'a'"):
        equivalence([math.inf], CE, low=-1.0, high=1.0)


def test_p_below_all_doubles_goes_by_its_logarithm():
    rng = np.random.default_rng(3)
    a, b = rng.normal(size=400), rng.normal(size=400)
    found = equivalence(a, b, low=-1e3, high=1e3)
    assert found.p == 0.0
    assert -4000.0 < found.log10_p < -308.0
    assert found.equivalent is True


@pytest.mark.parametrize("route", ROUTES)
@pytest.mark.parametrize("high", [None, 9e6])
def test_no_percentage_is_shown_of_a_mean_that_may_be_0(route, high):
    """The test at the bound rejects, yet what share of nearly nothing the difference is nobody can say."""
    far, near_0 = [2000.0, 1900.0, 2100.0, 2050.0, 1980.0], [3.0, -2.0, 5.0, -1.0, 2.0]
    found = equivalence(far, near_0, low=-5.0, high=high, bounds="percent", route=route)
    chosen = found.welch if route == "welch" else found.student
    assert chosen.p_low < 1e-6
    assert isinstance(found.estimate_ci, Undefined)
    assert found.equivalent is chosen.equivalent is False
    says(found.sentence(), "not shown to", "90 %", "not distinguishable from")


def test_one_bound_alone_needs_no_word_of_the_other():
    both = equivalence(AD, CE, low=-1.0, high=None)
    assert equivalence(AD, CE, low=-1.0) == both
    assert equivalence(AD, CE, high=1.0) == equivalence(AD, CE, low=None, high=1.0)
    with refuses(InputRefused, "Neither bound is"):
        equivalence(AD, CE)
