"""The decision test of a treatment against a control on shared days: worked example, its rules, and what must agree."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import optimize
from scipy import stats as scipy_stats
from statsmodels.stats.weightstats import ttost_ind

from data_schema.errors import InputRefused
from data_schema.reasons import Reason
from data_schema.vocabulary import Rule, Undefined
from stats.compare.shared_error import SharedError
from stats.days.decision import Contrast, contrast_by_day, rule_of_days
from stats.days.overall import overall_equivalence, overall_savings
from tests.helpers.campaigns import DESIGNS, LAYOUTS, campaign
from tests.helpers.wording import refuses, says

# Runs of four days, joules (control, treated) and apex heights in mm.
JOULES = [
    ([42.1, 40.3], [37.9, 36.2, 38.8]),
    ([44.0, 41.6, 43.1], [38.4, 39.9]),
    ([40.2], [36.9, 35.1, 37.7]),
    ([43.3, 45.2], [39.8, 38.5, 40.6, 39.1]),
]
APEXES = [
    ([345.2, 343.9], [346.1, 344.8, 347.0]),
    ([344.1, 346.3, 345.0], [347.2, 345.9]),
    ([343.0], [345.5, 344.2, 346.0]),
    ([345.9, 344.4], [346.8, 347.7, 345.1, 346.2]),
]
DRAIN = SharedError({("drain", "level"): 0.54}, {"drain": 4.0})


def contrast(days: list[tuple[list[float], list[float]]], shared: SharedError | None = None) -> Contrast:
    control, treated = ([(value, at) for at, day in enumerate(days) for value in day[side]] for side in (0, 1))
    return contrast_by_day(
        [value for value, _ in treated],
        [value for value, _ in control],
        days_treated=[at for _, at in treated],
        days_control=[at for _, at in control],
        shared_treated=None if shared is None else [shared] * len(treated),
        shared_control=None if shared is None else [shared] * len(control),
    )


def ends(ci: tuple[float, float] | Undefined) -> tuple[float, float]:
    assert not isinstance(ci, Undefined)
    return ci


def assert_undefined(why: Reason, *numbers: object) -> None:
    assert {number.code if isinstance(number, Undefined) else number for number in numbers} == {why}


@pytest.mark.parametrize(
    ("days", "rule", "savings", "apex"),
    [
        (4, Rule.PAIRED,
         (9.314743400, 7.599037886, 10.907698724, 14.13919346, 7.663569044e-4),
         (0.4620781420, 0.3136916244, 0.6114650014, 59.34844087, -37.93985737, 2.014042221e-5)),
        (3, Rule.WITHIN,
         (8.777752346, 3.478534562, 13.817914717, 5.174805886, 1.400491989e-2),
         (0.4677979850, 0.07199140365, 0.8654331177, 20.99101897, -14.80236213, 3.344705031e-4)),
    ],
)  # fmt: skip
def test_the_worked_example_is_met_to_nine_digits(
    days: int, rule: Rule, savings: tuple[float, ...], apex: tuple[float, ...]
) -> None:
    """Source: the derivation of the rule, its intervals found there by root-finding."""
    joules = contrast(JOULES[:days], DRAIN)
    found = joules.savings()
    assert joules.rule is rule
    assert found.df == 3
    assert (found.value, *ends(found.ci), found.t, found.p) == pytest.approx(savings, rel=1e-9)
    height = contrast(APEXES[:days]).equivalence(-3.0, 3.0)
    assert (height.value, *ends(height.ci), height.t_low, height.t_high, height.p) == pytest.approx(apex, rel=1e-9)
    assert height.equivalent is True


def test_which_runs_there_are_decides_the_rule() -> None:
    pair, single = ([1.0, 2.0], [1.5, 1.2]), ([1.0], [1.5, 1.2])
    assert contrast([single] * 4).rule is Rule.PAIRED
    assert contrast([single, single, pair]).rule is Rule.WITHIN
    assert contrast([single] * 3).rule is Rule.NONE
    nowhere = contrast([([1.0, 2.0], []), ([], [1.5, 1.2])])
    assert nowhere.rule is Rule.NONE
    assert (nowhere.counts.other_control, nowhere.counts.other_treated, nowhere.counts.control) == (2, 2, 0)
    without_days = contrast_by_day([1.5, 1.2, 1.1], [1.0, 2.0])
    assert (without_days.rule, without_days.df) == (Rule.WITHIN, 1)


@given(*[st.lists(st.sampled_from("abcde"), min_size=1, max_size=9)] * 2)
def test_the_rule_of_days_is_that_of_the_contrast_of_their_runs(treated: list[str], control: list[str]) -> None:
    contrast = contrast_by_day(
        [1.0 + n for n in range(len(treated))], [2.0] * len(control), days_treated=treated, days_control=control
    )
    assert rule_of_days(treated, control) is contrast.rule


def test_without_a_claim_there_is_an_estimate_and_no_test() -> None:
    found = contrast([([50.0, 50.0], []), ([], [44.0, 44.0])])
    savings, bounded = found.savings(), found.equivalence(-3.0, 3.0)
    assert savings.value == pytest.approx(12.0)
    assert found.difference().value == pytest.approx(-6.0)
    assert bounded.value == pytest.approx(-12.0)
    nothing = savings.p, savings.ci, found.difference().p, bounded.p, bounded.equivalent
    assert_undefined(Reason.NO_DAY_HOLDS_BOTH, *nothing)
    one_day = {"days_treated": [1, 1], "days_control": [1, 1]}  # it holds both, at other levels of another factor
    apart = contrast_by_day([44.0, 43.0], [50.0, 51.0], **one_day, strata_treated=["s"] * 2, strata_control=["l"] * 2)
    assert_undefined(Reason.NO_DAY_HOLDS_BOTH_ALIKE, apart.savings().p)
    assert_undefined(Reason.NO_DAY_WITH_TWO, contrast([([50.0], [44.0, 43.0])] * 2).savings().p)


def test_without_a_claim_the_means_are_those_of_the_days_with_both() -> None:
    """A fourth treated run, of a day without a control, made 10 % of what is 5 % on the days with both."""
    found = contrast([([100.0], [95.0]), ([110.0], [104.5]), ([90.0], [85.5]), ([], [70.0])])
    assert (found.rule, found.n, found.counts.other_treated) == (Rule.NONE, (3, 3), 1)
    assert found.savings().value == pytest.approx(5.0)
    assert found.difference().value == pytest.approx(-5.0)
    assert found.equivalence(-3.0, 3.0).value == pytest.approx(-5.0)


def test_one_day_is_welchs_t_with_the_smaller_df() -> None:
    control, treated = [42.1, 40.3, 44.0, 41.6], [37.9, 36.2, 38.8, 38.4, 39.9, 36.9]
    found = contrast_by_day(treated, control).difference()
    welch = scipy_stats.ttest_ind(treated, control, equal_var=False)
    assert found.t == pytest.approx(welch.statistic, rel=1e-13)
    assert found.p == pytest.approx(2 * scipy_stats.t.sf(abs(welch.statistic), 3), rel=1e-12)


def test_four_days_are_a_paired_t_test_of_day_means() -> None:
    found = contrast(JOULES).difference()
    means = np.array([[np.mean(side) for side in day] for day in JOULES])
    paired = scipy_stats.ttest_rel(means[:, 1], means[:, 0])
    assert (found.t, found.p) == pytest.approx((paired.statistic, paired.pvalue), rel=1e-11)
    assert ends(found.ci) == pytest.approx(tuple(paired.confidence_interval()), rel=1e-11)


def drawn(seed: int) -> Contrast:
    rng = np.random.default_rng(seed)
    layout = list(LAYOUTS.values())[seed % 12]
    drain = SharedError({("drain", "level"): 0.02, ("drain", "slope"): 0.01}, {"drain": float(1 + seed % 7)})
    made = campaign(layout, DESIGNS[seed % len(DESIGNS)], 1.0 - 0.1 * rng.random(), 0.1, rng)
    return made.contrast(drain if seed % 2 else None)


@given(st.integers(0, 10**6), st.sampled_from([0.5, 0.9, 0.95, 0.999]))
def test_the_interval_leaves_out_zero_just_where_the_test_rejects(seed: int, level: float) -> None:
    found = drawn(seed)
    if found.rule is Rule.NONE:
        return
    savings, difference = found.savings(level), found.difference(level)
    assert savings.p == difference.p
    assert isinstance(savings.p, float)
    if isinstance(savings.ci, Undefined):
        assert savings.ci.code is Reason.CONTROL_NEAR_ZERO
    else:
        low, high = savings.ci
        assert (low > 0.0 or high < 0.0) == (savings.p < 1.0 - level)
    low, high = ends(difference.ci)
    assert (low > 0.0 or high < 0.0) == (difference.p < 1.0 - level)


@given(st.integers(0, 10**6))
def test_fiellers_ends_are_where_the_test_reaches_its_quantile(seed: int) -> None:
    found = drawn(seed)
    ci = found.savings().ci
    if isinstance(ci, Undefined):
        return
    quantile = scipy_stats.t.ppf(0.975, found.df)
    own = [scipy_stats.t.ppf(0.975, df) / quantile if df < 4 else 1.0 for df in found.treated_shared.df.values()]
    more = own[0] ** 2 if own else 1.0

    def surplus(percent: float) -> float:
        ratio = 1.0 - percent / 100.0
        assert isinstance(found.control_mean, float)
        assert isinstance(found.treated_mean, float)
        unit = 4.0**found.scale.exponent
        variance = unit * (found.variance(ratio) + more * found.shared(ratio).se ** 2)
        return (found.treated_mean - ratio * found.control_mean) ** 2 - quantile**2 * variance

    estimate = found.savings().value
    assert isinstance(estimate, float)
    for end in ci:
        width = abs(end - estimate)
        root = optimize.brentq(surplus, end - 0.5 * width, end + 0.5 * width, xtol=1e-13 * max(1.0, abs(end)))
        assert end == pytest.approx(root, rel=1e-8, abs=1e-8)


@given(st.integers(0, 10**6), st.sampled_from([(-3.0, 3.0), (-1.0, 8.0), (-20.0, 5.0)]), st.booleans())
def test_equivalence_is_shown_just_where_the_interval_lies_within_the_bounds(
    seed: int, bounds: tuple[float, float], percent: bool
) -> None:
    found = drawn(seed)
    if found.rule is Rule.NONE:
        return
    low, high = bounds if percent else (bounds[0] / 100.0, bounds[1] / 100.0)
    result = found.equivalence(low, high, percent=percent)
    if isinstance(result.ci, Undefined):
        assert result.equivalent is False
        return
    assert result.equivalent == (low <= result.ci[0] and result.ci[1] <= high)


@pytest.mark.parametrize("percent", [True, False])
def test_one_bound_alone_is_one_of_both_tests(percent: bool) -> None:
    found = contrast(JOULES)
    both, low, high = (found.equivalence(*ends, percent=percent) for ends in ((-3.0, 4.0), (-3.0, None), (None, 4.0)))
    assert (low.t_low, high.t_high) == (both.t_low, both.t_high)
    assert isinstance(low.t_high, Undefined)
    assert both.p == max(low.p, high.p)  # type: ignore[type-var]
    assert low.ci == both.ci == high.ci
    says(low.t_high.reason, "no upper bound")


def test_without_days_equivalence_is_two_one_sided_tests_with_the_smaller_degrees_of_freedom() -> None:
    a, b = [0.4123, 0.4098, 0.4151, 0.4119, 0.4107, 0.4140], [0.4131, 0.4102, 0.4127, 0.4156, 0.4118]
    found = contrast_by_day(a, b).equivalence(-0.004, 0.003, percent=False)
    _p, low, high = ttost_ind(np.array(a), np.array(b), -0.004, 0.003, usevar="unequal")
    assert (found.t_low, found.t_high) == pytest.approx((low[0], high[0]), rel=1e-9)
    assert found.df == 4


def test_an_error_in_common_cancels_in_the_difference_and_stays_in_the_ratio() -> None:
    with_drain, without = contrast(JOULES, DRAIN), contrast(JOULES)
    assert with_drain.difference().t == without.difference().t
    wide, narrow = ends(with_drain.savings().ci), ends(without.savings().ci)
    assert wide[0] < narrow[0]
    assert narrow[1] < wide[1]


@pytest.mark.parametrize("days", [5, 4, 2, 1])
def test_without_a_day_it_is_the_contrast_of_the_others(days: int) -> None:
    """To the last digit, and by their rule: of five days four are paired, of four three are within."""
    every = [*JOULES, JOULES[0]][:days]
    for left_out in range(days):
        rest = [([], []) if at == left_out else day for at, day in enumerate(every)]
        found, expected = contrast(every, DRAIN).without(str(left_out)), contrast(rest, DRAIN)
        assert found == expected
        assert found.savings() == expected.savings()
        assert found.days == tuple(str(at) for at in range(days) if at != left_out) or found.rule is Rule.NONE


def test_constant_runs_have_no_test() -> None:
    found = contrast([([40.0, 40.0], [36.0, 36.0])] * 5)
    assert found.savings().value == pytest.approx(10.0)
    for result in (found.savings(), found.difference()):
        assert_undefined(Reason.SAME_ON_EVERY_DAY, result.p, result.t, result.ci)
    assert_undefined(Reason.NO_SCATTER_AT_BOUND, found.equivalence(-3.0, 3.0).p)
    within = contrast([([40.0, 40.0], [36.0, 36.0])] * 2).difference().p
    assert_undefined(Reason.GROUPS_WITHOUT_SCATTER, within)


@pytest.mark.parametrize("n", [3, 5, 6, 7])
def test_equal_runs_do_not_scatter_by_rounding(n: int) -> None:
    """The mean of n equal doubles, summed and divided, is often another double: a t of 1e15 followed from it."""
    for each in np.random.default_rng(n).uniform(30.0, 50.0, 50):
        control, treated = float(each), 0.9 * float(each)
        found = contrast([([control] * n, [treated] * n)], DRAIN)
        assert_undefined(Reason.GROUPS_WITHOUT_SCATTER, found.savings().p)
        assert overall_savings({"small": found, "large": found}).scope.groups == ()


def test_what_days_do_to_both_sides_costs_no_digits() -> None:
    """Days differ a million times as much as their pairs do: the same test as without them."""
    days = [0.0, 3e6, -7e6, 1e6]
    pairs = [(40.0, 36.5), (41.0, 36.0), (39.0, 36.25), (40.5, 37.0)]
    far = contrast([([day + control], [day + treated]) for day, (control, treated) in zip(days, pairs, strict=True)])
    near = contrast([([control], [treated]) for control, treated in pairs])
    assert far.difference().p == pytest.approx(near.difference().p, rel=1e-9)
    equal = contrast([([40.1 + day], [36.3 + day]) for day in (0.3, 1.7, 2.9, 7.1)])
    assert isinstance(equal.difference().p, Undefined)


def test_what_cannot_be_compared_is_refused() -> None:
    with pytest.raises(InputRefused, match="one condition only"):
        contrast_by_day([1.0], [2.0], days_treated=["monday"])
    with refuses(InputRefused, "for each value"):
        contrast_by_day([1.0, 2.0], [2.0], days_treated=["monday"], days_control=["monday"])
    with pytest.raises(InputRefused, match="lower one first"):
        contrast(JOULES).equivalence(3.0, -3.0)
    with pytest.raises(InputRefused, match="Neither bound"):
        contrast(JOULES).equivalence(None, None)
    with pytest.raises(InputRefused, match=r"greater than -100"):
        contrast(JOULES).equivalence(-100.0, None)


def test_the_overall_effect_of_one_group_is_that_group_by_its_delta_interval() -> None:
    one = contrast(JOULES, DRAIN)
    overall, savings = overall_savings({"small": one}), one.savings()
    for name in ("value", "se", "shared_se", "df"):
        assert getattr(overall.estimate, name) == pytest.approx(getattr(savings, name), rel=1e-12), name
    assert isinstance(overall.spread_percent, Undefined)


def test_the_overall_effect_adds_what_a_day_does_to_all_groups_before_it_is_squared() -> None:
    """Two groups with the same runs on the same days are one group; on days of their own they are two."""
    one = contrast(JOULES)
    same = overall_savings({"a": one, "b": one})
    assert same.estimate.se == pytest.approx(overall_savings({"a": one}).estimate.se, rel=1e-12)
    assert same.estimate.df == 3
    other = contrast([([], [])] * 4 + JOULES)
    apart = overall_savings({"a": one, "b": other})
    assert apart.estimate.se == pytest.approx(same.estimate.se / math.sqrt(2), rel=1e-12)  # type: ignore[operator]
    assert apart.estimate.df == pytest.approx(6.0)
    assert apart.estimate.value == pytest.approx(same.estimate.value)


@pytest.mark.parametrize(("shared", "df"), [(True, 3.0), (False, 6.0)])
def test_two_groups_are_told_apart_by_a_t_test_on_their_days(shared: bool, df: float) -> None:
    """On the same days what a day does to both cancels; two groups with the same runs have no errors to differ by."""
    other = [(control, [value + 1.0 - 0.3 * at for value in treated]) for at, (control, treated) in enumerate(JOULES)]
    groups = {"a": contrast(JOULES), "b": contrast(other if shared else [([], [])] * 4 + other)}
    found = overall_savings(groups).heterogeneity
    assert not isinstance(found, Undefined)
    by_day = [[departs / math.sqrt(12) for _day, departs in one.relative_departures] for one in groups.values()]
    apart = groups["a"].ratio - groups["b"].ratio
    if shared:
        variance = sum((a - b) ** 2 for a, b in zip(*by_day, strict=True))
    else:
        variance = sum(each**2 for one in by_day for each in one)
        df = variance**2 / sum(sum(each**2 for each in one) ** 2 / 3 for one in by_day)
    assert found.f == pytest.approx(apart**2 / variance, rel=1e-9)
    assert found.df == pytest.approx((1.0, df), rel=1e-9)
    assert found.p == pytest.approx(2.0 * scipy_stats.t.sf(abs(apart) / math.sqrt(variance), df), rel=1e-9)
    same = overall_savings({"a": groups["a"], "b": groups["a"]}).heterogeneity
    assert isinstance(same, Undefined)
    assert isinstance(overall_savings({"a": groups["a"]}).heterogeneity, Undefined)


def test_groups_without_a_claim_are_left_out_of_the_overall_effect() -> None:
    none = contrast([([50.0, 51.0], []), ([], [44.0, 43.0])])
    constant = contrast([([control], [control - 4.0]) for control in (40.0, 41.5, 39.0, 42.25, 40.5)])
    one = contrast(JOULES[:3])
    for left_out in (none, constant):  # a difference that is the same on every day has no known error
        overall = overall_savings({"a": one, "b": left_out})
        assert (overall.scope.groups, overall.scope.left_out) == (("a",), ("b",))
        assert overall.scope.days_measured_only
        assert overall.estimate == overall_savings({"a": one}).estimate
    nothing = overall_savings({"b": none})
    assert isinstance(nothing.estimate.value, Undefined)
    assert isinstance(overall_equivalence({"b": none}, -3.0, 3.0).bounded.p, Undefined)


def rounded_alike(joules: tuple[float, float], name: str, days: int, runs: int = 1) -> Contrast:
    """Return a contrast of runs that a charger shows alike: their one error is that of its rounding."""
    errors = [SharedError({("rounding", f"{name} {side}"): 1.4}, {"rounding": math.inf}) for side in (0, 1)]
    labels = [day for day in range(days) for _ in range(runs)]
    control, treated = ([value] * len(labels) for value in joules)
    return contrast_by_day(
        treated,
        control,
        days_treated=labels,
        days_control=labels,
        shared_treated=[errors[1]] * len(labels),
        shared_control=[errors[0]] * len(labels),
    )


@pytest.mark.parametrize(("days", "runs", "df"), [(4, 1, 3.0), (2, 3, 4.0)])
def test_groups_that_err_by_rounding_alone_have_an_overall_effect(days: int, runs: int, df: float) -> None:
    """Page one said that no group can be compared, above a table that had the saving of each."""
    groups = {
        "a": rounded_alike((44.0, 35.0), "a", days, runs),
        "b": rounded_alike((40.0, 34.0), "b", days, runs),
    }
    errors = [math.hypot(1.4, 1.4 * one.ratio) / (one.control_mean or math.nan) for one in groups.values()]  # type: ignore[operator]
    overall = overall_savings(groups)
    found = overall.estimate
    assert (overall.scope.groups, overall.scope.left_out) == (("a", "b"), ())
    assert found.value == pytest.approx(100.0 * (9.0 / 44.0 + 6.0 / 40.0) / 2.0)
    assert (found.se, found.df) == (0.0, df)
    assert found.shared_se == pytest.approx(100.0 * math.hypot(*errors) / 2.0)
    half = scipy_stats.t.ppf(0.975, df) * 100.0 * math.hypot(*errors) / 2.0
    assert ends(found.ci) == pytest.approx((found.value - half, found.value + half))  # type: ignore[operator]
    assert not isinstance(overall.heterogeneity, Undefined)
    apart = 9.0 / 44.0 - 6.0 / 40.0
    assert overall.heterogeneity.f == pytest.approx(apart**2 / math.hypot(*errors) ** 2)
    assert isinstance(overall_equivalence(groups, -30.0, 30.0).bounded.p, float)
    beside = overall_savings({"a": contrast(JOULES), "b": groups["b"]})
    assert beside.scope.groups == ("a", "b")
    assert beside.estimate.df == pytest.approx(3.0)


def test_the_reason_without_an_overall_effect_is_that_of_the_groups() -> None:
    constant, equal = contrast([([40.0], [36.0])] * 4), contrast([([40.0, 40.0], [36.0, 36.0])] * 2)
    nothing, none = contrast([([-1.0], [-2.0]), ([-3.0], [-2.5])] * 2), contrast([([50.0], []), ([], [44.0])])
    for groups, why in (
        ([constant, none], Reason.SAME_ON_EVERY_DAY),
        ([equal, constant], Reason.NO_GROUP_SCATTERS),
        ([nothing, none], Reason.NOTHING_TO_SAVE),
        ([none, none], Reason.NO_GROUP_WITH_CLAIM),
    ):
        found = overall_savings({str(at): one for at, one in enumerate(groups)}).estimate
        assert_undefined(why, found.value, found.ci, found.p)


def test_there_is_no_overall_effect_where_a_group_has_savings_without_bounds() -> None:
    """One run of 1160 J among 41 J gave an overall interval of 28 to 68 % where its group had none."""
    slip = [([1160.5, 41.0] if not at else control, treated) for at, (control, treated) in enumerate(JOULES)]
    groups = {"a": contrast(JOULES), "b": contrast(slip)}
    assert isinstance(groups["b"].savings().ci, Undefined)
    found = overall_savings(groups).estimate
    assert_undefined(Reason.GROUP_WITHOUT_BOUNDS, found.p, found.ci)
    assert isinstance(overall_savings(groups, 0.5).estimate.ci, tuple)


def test_overall_equivalence_is_shown_just_where_its_interval_lies_within_the_bounds() -> None:
    groups = {"a": contrast(APEXES), "b": contrast(APEXES[:3])}
    found = overall_equivalence(groups, -3.0, 3.0).bounded
    assert found.equivalent is True
    low, high = ends(found.ci)
    tight = overall_equivalence(groups, -3.0, high - 1e-6).bounded
    assert tight.equivalent is False
    assert found.value == pytest.approx(-overall_savings(groups).estimate.value)  # type: ignore[operator]
    assert -3.0 < low < high < 3.0


def test_a_day_counts_once_however_many_levels_it_holds() -> None:
    """Two surfaces on each of four days: four days, not eight; the level of a surface cancels within it."""
    rng = np.random.default_rng(4)
    days, levels = np.repeat(["a", "b", "c", "d"], 6), np.tile(np.repeat(["sand", "gravel"], 3), 4)
    control, treated = (rng.normal(40.0, 1.0, 24) + 30.0 * (levels == "sand") - saved for saved in (0.0, 4.0))
    alike = {"strata_treated": levels, "strata_control": levels}
    found = contrast_by_day(treated, control, days_treated=days, days_control=days, **alike)
    assert (found.rule, found.days, found.df) == (Rule.PAIRED, ("a", "b", "c", "d"), 3)
    by_hand = [(treated - control)[days == day].mean() for day in found.days]
    test = scipy_stats.ttest_1samp(by_hand, 0.0)
    assert found.difference().t == pytest.approx(test.statistic, rel=1e-12)
    few, uneven = days < "c", (levels == "sand") | (days == "a")
    some = few & uneven
    alike = {"strata_treated": levels[few], "strata_control": levels[some]}
    within = contrast_by_day(treated[few], control[some], days_treated=days[few], days_control=days[some], **alike)
    assert (within.rule, within.days, within.df) == (Rule.WITHIN, ("a", "b"), 6)
    assert (within.counts.other_control, within.counts.other_treated) == (0, 3)
    cells = [some & (days == day) & (levels == level) for day, level in (("a", "sand"), ("a", "gravel"), ("b", "sand"))]
    by_cell = [(treated - control)[cell].mean() for cell in cells]
    assert within.difference().value == pytest.approx(np.mean(by_cell))


@pytest.mark.parametrize("power", [-330, 330])
def test_percent_of_tiny_and_huge_values_are_the_same(power: int) -> None:
    """Near 1e100 the fourth power of a value is no double."""
    scaled = [tuple([math.ldexp(value, power) for value in side] for side in day) for day in JOULES]
    for days, others in ((JOULES, scaled), (JOULES[:3], scaled[:3])):
        one, other = contrast(days), contrast(others)  # type: ignore[arg-type]
        assert other.savings().ci == one.savings().ci
        assert other.equivalence(-3.0, 3.0) == one.equivalence(-3.0, 3.0)
