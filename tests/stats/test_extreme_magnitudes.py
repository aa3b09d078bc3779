"""Whatever finite values are given: numbers, or a reason why there is none; never NaN, infinity or a bare error.

Groups are drawn from all of the range of doubles, their sizes mixed within groups and between them.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

import stats
from data_schema.errors import LabbookError
from data_schema.vocabulary import Undefined
from labbook.analysis.outcomes.run_energy import joules_per_jump
from stats.compare.shared_error import SharedError
from tests.helpers.extremes import assert_sound, degrees_of_freedom, doubles, groups, levels, positive

Three = tuple[list[float], list[float], list[float]]
ONE = st.builds(lambda values, times: values * times, groups(), st.sampled_from([1, 1, 1, 26]))
"""Few values, or more than 50, which are summed in another way."""
THREE = st.tuples(ONE, ONE, ONE)
SIX = st.tuples(*[groups(st.just(6))] * 3)
BETWEEN_PLACES = (
    [1.7976931348623157e308, 0.5, 0.0, *[2.0**-51] * 3],
    [1.596672247627776e293, 1.7976931348623157e308, 0.0, 0.0, *[2.0**-51] * 2],
    [0.0] * 6,
)
"""A parabola through all rows whose coefficients are doubles, and which exceeds them between the rows."""


def named(three: Three) -> dict[str, list[float]]:
    return dict(zip("abc", three, strict=True))


def shared(three: Three, df: float = 3.0) -> SharedError:
    return SharedError({("idle", "level"): three[2][0], ("idle", "slope"): three[2][1]}, {"idle": df})


OF_GROUPS: dict[str, Callable[[Three], Any]] = {
    "compare_two student": lambda three: stats.compare_two(three[0], three[1], "student"),
    "compare_two welch": lambda three: stats.compare_two(three[0], three[1], "welch"),
    "bartlett": lambda three: stats.bartlett(named(three)),
    "levene": lambda three: stats.levene(named(three)),
    "brown_forsythe": lambda three: stats.brown_forsythe(named(three)),
    "welch_anova": lambda three: stats.welch_anova(named(three)),
    "dunnett less": lambda three: stats.dunnett(three[0], {"b": three[1]}, alternative="less"),
    "equivalence student": lambda three: stats.equivalence(three[0], three[1], **bounds(three), route="student"),
    "equivalence above": lambda three: stats.equivalence(three[0], three[1], low=three[2][0], high=None),
    "percent_savings": lambda three: stats.percent_savings(positive(three[0]), three[1]),
    "permutation_test": lambda three: stats.permutation_test(three[0][:4], three[1][:4]),
    "permutation_test drawn": lambda three: stats.permutation_test(three[0], three[1], exact_limit=1, resamples=50),
    "residuals_of_groups": lambda three: stats.residuals_of_groups(named(three)),
    "autocorrelation": lambda three: stats.autocorrelation(three[0]),
}
"""Functions of groups that need not be of one size; others are asked at any level (`AT_LEVELS`)."""
OF_ROWS: dict[str, Callable[[Three], Any]] = {
    "fit_linear of two": lambda three: stats.fit_linear(three[0], {"x": three[1], "z": three[2]}),
    "fit_linear through 0": lambda three: stats.fit_linear(three[0], {"x": three[1]}, intercept=False),
    "PolynomialFit.at": lambda three: stats.fit_polynomial(three[1], three[0], 2).at(three[2][0]),
    "fit_passive_drain": lambda three: stats.fit_passive_drain(positive(three[0]), three[1], abs(three[2][0])),
    "fit_stiffness": lambda three: stats.fit_stiffness(*(np.tile(group, 50) for group in three)),
    "rmse_over_iqr": lambda three: stats.rmse_over_iqr(three[0], three[1]),
    "force_points": lambda three: stats.force_points(sorted(three[0]), three[1], three[2], 2.0),
    "additive_residuals": lambda three: stats.additive_residuals(three[0], list("aabbcc"), list("xyxyxy")),
    "permutation_test by day": lambda three: stats.permutation_test(three[0], three[1], DAYS, DAYS),
    "bootstrap_difference by day": lambda three: stats.bootstrap_difference(
        three[0], three[1], DAYS, DAYS, resamples=100
    ),
}
"""Functions of values that belong together by their places; others are asked at any level (`ROWS_AT_LEVELS`)."""
DAYS = ["mon", "mon", "mon", "tue", "tue", "tue"]


def bounds(three: Three) -> dict[str, float]:
    low, high = min(three[2]), max(three[2])
    return {"low": low, "high": high} if low < high else {"low": -1.0, "high": 1.0}


def difference_with_shared(three: Three, level: float = 0.95, df: float = 3.0) -> Any:
    found = stats.compare_two(three[0], three[1], alpha=1.0 - level if level > 0.5 else 0.05)
    return stats.difference_with_shared(found.t, found.df, found.p, found.difference_ci, shared(three, df), level)


def of_drain(three: Three, level: float, _df: float) -> Any:
    fit = stats.fit_passive_drain(positive(three[0]), three[1], abs(three[2][0]))
    return [fit.at(abs(three[2][1]), level), fit.slope_ci_mah_s(level), fit.intercept_ci_mah(level)]


def check(call: Callable[[], Any]) -> None:
    try:
        result = call()
    except LabbookError as error:
        result = str(error)
    if isinstance(result, str):
        assert result.endswith(".")
        assert not re.search(r"\bnan\b|\binf\b", result)
    else:
        assert_sound(result)


@pytest.mark.parametrize("name", OF_GROUPS)
@given(THREE)
def test_groups_of_any_magnitude_give_numbers_or_reasons(name, three):
    check(lambda: OF_GROUPS[name](three))


@pytest.mark.parametrize("name", OF_ROWS)
@given(SIX)
@example(BETWEEN_PLACES)
def test_rows_of_any_magnitude_give_numbers_or_reasons(name, three):
    check(lambda: OF_ROWS[name](three))


OF_NUMBERS: dict[str, Callable[[float, float, float], Any]] = {
    "bayes_factor": lambda one, _two, _three: stats.bayes_factor(one, 5, 6),
    "bayes_factor scale": lambda one, two, _three: stats.bayes_factor(one, 5, 6, abs(two)),
    "joules_per_jump": lambda one, two, three: joules_per_jump(abs(one), two, abs(three), 25),
}


@pytest.mark.parametrize("name", OF_NUMBERS)
@given(doubles(), doubles(), doubles())
def test_numbers_of_any_magnitude_give_numbers_or_reasons(name, one, two, three):
    check(lambda: OF_NUMBERS[name](one, two, three))


AT_LEVELS: dict[str, Callable[[Three, float, float], Any]] = {
    "describe": lambda three, level, _df: stats.describe(three[0], level),
    "compare_two": lambda three, level, _df: stats.compare_two(three[0], three[1], alpha=level),
    "f_test": lambda three, level, _df: stats.f_test(three[0], three[1], level),
    "one_way_anova": lambda three, level, _df: stats.one_way_anova(named(three), level=level),
    "tukey": lambda three, level, _df: stats.compare_all_pairs(named(three), level=level),
    "games_howell": lambda three, level, _df: stats.compare_all_pairs(named(three), variances="unequal", level=level),
    "dunnett": lambda three, level, _df: stats.dunnett(three[0], {"b": three[1], "c": three[2]}, level=level),
    "dunnett greater": lambda three, level, _df: stats.dunnett(
        three[0], {"b": three[1]}, alternative="greater", level=level
    ),
    "equivalence": lambda three, level, _df: stats.equivalence(three[0], three[1], **bounds(three), alpha=level),
    "equivalence percent": lambda three, level, _df: stats.equivalence(
        three[0], positive(three[1]), low=-5.0, high=5.0, bounds="percent", alpha=level
    ),
    "percent_savings": lambda three, level, df: stats.percent_savings(
        positive(three[0]),
        three[1],
        shared_in_control=shared(three, df),
        shared_in_treated=shared(three[::-1], df),
        level=level,
    ),
    "describe_shared": lambda three, level, df: stats.describe_shared(three[0], shared(three, df), level),
    "difference_with_shared": difference_with_shared,
    "bootstrap_difference": lambda three, level, _df: stats.bootstrap_difference(
        three[0], three[1], level=level, resamples=100
    ),
    "normal_quantiles": lambda three, level, _df: stats.normal_quantiles(
        stats.residuals_of_groups(named(three)), level
    ),
    "holm": lambda _three, level, df: stats.holm({"one": level, "two": 0.01}, "runs", alpha=min(level, df / (1 + df))),
}


def of_gain_line(three: Three, level: float, _df: float) -> Any:
    return stats.fit_gain_line(three[1], three[0], level=level).at(three[2][0], level)


ROWS_AT_LEVELS: dict[str, Callable[[Three, float, float], Any]] = {
    "fit_linear": lambda three, level, _df: stats.fit_linear(three[0], {"x": three[1]}, level=level),
    "LinearFit.at": lambda three, level, _df: stats.fit_linear(three[0], {"x": three[1]}).at({"x": three[2][0]}, level),
    "fit_polynomial": lambda three, level, _df: stats.fit_polynomial(three[1], three[0], 2, level=level),
    "PolynomialFit.at": lambda three, level, _df: stats.fit_polynomial(three[1], three[0], 2).at(three[2][0], level),
    "fit_gain_line": of_gain_line,
    "PassiveDrain": of_drain,
}


@pytest.mark.parametrize("name", AT_LEVELS)
@given(THREE, levels(), degrees_of_freedom())
def test_groups_at_any_level_and_degrees_of_freedom_give_numbers_or_reasons(name, three, level, df):
    check(lambda: AT_LEVELS[name](three, level, df))


@pytest.mark.parametrize("name", ROWS_AT_LEVELS)
@given(SIX, levels())
def test_rows_at_any_level_give_numbers_or_reasons(name, three, level):
    check(lambda: ROWS_AT_LEVELS[name](three, level, 1.0))


POWERS: dict[str, Callable[[float, float, float, float], Any]] = {
    "power_t": lambda one, two, _three, alpha: stats.power_t(one, abs(two), 5, 6, alpha),
    "power_t one-sided": lambda one, two, _three, alpha: stats.power_t(one, abs(two), 2, 1, alpha, sides=1),
    "power_welch": lambda one, two, three, alpha: stats.power_welch(one, abs(two), abs(three), 3, 2, alpha),
    "power_anova": lambda one, two, three, alpha: stats.power_anova([one, two, 0.0], abs(three), 4, alpha),
    "power_equivalence": lambda one, two, three, alpha: stats.power_equivalence(
        one, abs(two), -abs(three), abs(three), 5, 6, alpha
    ),
    "power_equivalence student": lambda one, two, three, alpha: stats.power_equivalence(
        one, abs(two), -abs(three), abs(three), 2, 1, alpha, route="student"
    ),
    "power_percent_equivalence": lambda one, two, three, alpha: stats.power_percent_equivalence(
        one, abs(two), abs(three), -3.0, 3.0, 5, 6, alpha
    ),
}


@pytest.mark.parametrize("name", POWERS)
@given(doubles(), doubles(), doubles(), levels())
def test_powers_at_any_level_give_numbers_or_reasons(name, one, two, three, alpha):
    check(lambda: POWERS[name](one, two, three, alpha))


def test_shared_errors_of_any_degrees_of_freedom_bound_a_mean():
    ends = [
        stats.describe_shared([2, 2, 2, 2], SharedError({("drain", "rail"): 0.1}, {"drain": df})).ci_high
        for df in (1e6, 1e16, 1e17, 1e20, 1e100, np.inf)
    ]
    assert ends == pytest.approx([2.0 + 0.1 * 1.959963984540054] * 6, rel=1e-6)
    none = stats.describe_shared([2, 2, 2, 2], SharedError({("drain", "rail"): 0.1}, {"drain": 1e-6})).ci_high
    assert isinstance(none, Undefined)


def test_small_levels_leave_small_powers_and_wide_intervals():
    assert stats.power_t(1, 1, 6, 6, alpha=1e-300).power < 1e-200
    assert stats.power_welch(1, 1, 1, 6, 6, alpha=1e-260).power < 1e-200
    low, high = stats.compare_two([1.0, 2.0, 3.0], [2.0, 3.0, 5.0], alpha=1e-100).difference_ci
    assert high - low > 1e20
