"""Equivalence within bounds: two one-sided t-tests (TOST), the tool for "no loss of jump height".

With raw bounds low < mean(a) - mean(b) < high both one-sided tests ask whether the difference lies beyond a bound.
Percent bounds are shares of the mean of b, the control. That mean is itself estimated, so a bound of delta is tested
as the contrast mean(a) - (1 + delta) mean(b) (Sasabuchi), with variance Var(a) + (1 + delta)^2 Var(b): taking the
control's mean as known would claim too much. The interval beside it holds all delta that such a test does not reject
(Fieller). Either way it has level 1 - 2 alpha and lies within the bounds just where the tests reject. Where the
control's mean does not differ from 0 there is no such interval, and no percentage is shown whatever the tests say.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, Literal

from numpy.typing import ArrayLike

from data_schema.errors import InputRefused, unknown_name
from data_schema.reasons import Reason
from data_schema.rounding import error_of, given_text, interval_text, level_text, number_text, p_text, statistic_text
from data_schema.vocabulary import Undefined
from stats.checks import Missing, as_level, as_number, as_pair
from stats.compare.summary import AS_A_AND_B, Groups, Names, pair_of_names, read_groups
from stats.exact.numbers import QUANTILE_BEYOND_DOUBLES, exact_root, finite, finite_pair, root_between, to_120_bits
from stats.exact.tails import complement_level, exact_df, t_quantile, t_upper
from stats.results import Result, missing_text, with_unit

Ends = tuple[Fraction, Fraction]

_MOST_DOUBLINGS = 200
"""Widenings after which an end of an interval counts as infinite."""
_MOST_STEPS = 5000
"""Of the search within the last widening: an end may lie 300 decades below it."""


@dataclass(frozen=True, slots=True)
class OneSided:
    """A one-sided t-test at a bound."""

    t: float | Undefined
    df: float
    p: float
    log10_p: float


@dataclass(frozen=True, slots=True)
class Contrast:
    """Two means with the variances of their errors, in the unit of the values."""

    mean: Fraction
    """mean(a)."""
    control_mean: Fraction
    """mean(b), which relative bounds are shares of."""
    variances: Ends
    """Squared standard errors of the means of a and b, to 30 digits."""
    dfs: tuple[int, int]
    """Degrees of freedom of each; both the same number where they are one estimate, `pooled`."""
    pooled: bool
    relative: bool
    """Whether bounds are shares of mean(b)."""

    @property
    def estimate(self) -> Fraction:
        """The difference, or what it is relative to mean(b)."""
        difference = self.mean - self.control_mean
        return difference / self.control_mean if self.relative else difference

    def error(self, bound: Fraction) -> tuple[Fraction, float] | None:
        """Return the standard error of the contrast at the bound and its degrees of freedom; None without scatter."""
        slope = to_120_bits(1 + bound) if self.relative else Fraction(1)
        parts = (self.variances[0], slope * slope * self.variances[1])
        variance = sum(parts, Fraction(0))
        if variance == 0:
            return None
        df = self.dfs[0] if self.pooled else exact_df(list(zip(parts, self.dfs, strict=True)))
        return exact_root(variance), float(df)

    def test(self, bound: Fraction, *, above: bool) -> OneSided | Undefined:
        """Test that the truth lies above the bound, or below it."""
        error = self.error(bound)
        if error is None:
            return Undefined(Reason.NO_SCATTER_AT_BOUND)
        se, df = error
        at_bound = bound * self.control_mean if self.relative else bound
        t = to_120_bits((self.mean - self.control_mean - at_bound) / se)
        tail = t_upper(t if above else -t, df)
        return OneSided(finite(t, "t"), df, tail.p, tail.log10_p)

    def interval(self, level: float | Fraction) -> Ends | Undefined:
        """Return all bounds that the two-sided test of level 1 - `level` does not reject."""
        if self.relative:
            if self.error(to_120_bits(self.estimate)) is None:
                return Undefined(Reason.ALL_COMPARED_ZERO)
            ends = [self._end(side, level) for side in (-1, 1)]
        else:
            error = self.error(Fraction(0))
            quantile = 0.0 if error is None else t_quantile(level, error[1])
            if math.isinf(quantile):
                return QUANTILE_BEYOND_DOUBLES
            half = None if error is None else Fraction(quantile) * error[0]
            ends = [None if half is None else self.estimate + side * half for side in (-1, 1)]
        low, high = ends
        if low is None or high is None:
            return Undefined(Reason.CONTROL_NEAR_ZERO)
        return low, high

    def _end(self, side: int, level: float | Fraction) -> Fraction | None:
        """Return where |t| reaches its quantile, on one side of the estimate."""
        estimate = to_120_bits(self.estimate)
        error = self.error(estimate)
        if error is None:
            return None
        quantile, control_mean = t_quantile(level, error[1]), to_120_bits(self.control_mean)
        if math.isinf(quantile):
            return None
        step = side * to_120_bits(Fraction(quantile) * error[0] / control_mean)

        def surplus(steps: float) -> float:
            # Away from the estimate the contrast is that distance times mean(b): nothing cancels.
            away = Fraction(steps) * step
            found = self.error(estimate + away)
            if found is None:
                return math.inf
            return float(abs(away) * control_mean / found[0]) - t_quantile(level, found[1])

        inside, outside = (0.0, surplus(0.0)), 1.0
        for _ in range(_MOST_DOUBLINGS):
            found = outside, surplus(outside)
            if found[1] >= 0.0:
                return estimate + Fraction(root_between(surplus, inside, found, _MOST_STEPS)) * step
            inside, outside = found, 2.0 * outside
        return None


def contrasts(read: Groups, *, percent: bool) -> tuple[Fraction | Undefined, list[Contrast | Undefined]]:
    """Return the difference of two groups, the second of which is the control, and its contrasts, Welch's first."""
    if read.empty:
        none = Undefined(Reason.GROUP_EMPTY, group=f"group {read.empty[0]}")
        return none, [none, none]
    a, b = read.filled
    if percent and b.exact_mean <= 0:
        none = Undefined(Reason.CONTROL_MEAN_NOT_POSITIVE)
        return none, [none, none]
    unit = Fraction(2) ** read.exponent
    means = a.exact_mean * unit, b.exact_mean * unit

    def of(variances: Ends, dfs: tuple[int, int], pooled: bool) -> Contrast:
        in_unit = to_120_bits(variances[0] * unit**2), to_120_bits(variances[1] * unit**2)
        return Contrast(*means, in_unit, dfs, pooled, percent)

    welch: Contrast | Undefined
    student: Contrast | Undefined
    welch = student = Undefined(Reason.GROUPS_WITHOUT_SCATTER)
    single = next((group for group in (a, b) if group.n < 2), None)
    if single is not None:
        welch = Undefined(Reason.SINGLE_NO_VARIANCE, group=f"group {single.name}")
    elif read.squares_within:
        welch = of((a.exact_mean_variance, b.exact_mean_variance), (a.n - 1, b.n - 1), pooled=False)
    df = read.df_within
    if df < 1:
        student = Undefined(Reason.TWO_NOT_POOLED)
    elif read.squares_within:
        variance = read.squares_within / df
        student = of((variance / a.n, variance / b.n), (df, df), pooled=True)
    estimate = means[0] - means[1]
    return estimate / means[1] if percent else estimate, [welch, student]


_NO_LOW = Undefined(Reason.NO_LOWER_BOUND)
_NO_HIGH = Undefined(Reason.NO_UPPER_BOUND)


@dataclass(frozen=True, slots=True)
class Tost(Result):
    """Two one-sided tests by one way of estimating the scatter."""

    test: str
    """"Welch" or "Student"."""
    t_low: float | Undefined
    """Estimate minus the lower bound, over its standard error; large speaks against a loss."""
    df_low: float | Undefined
    """Degrees of freedom of `t_low`."""
    p_low: float | Undefined
    """One-sided p against "at or below the lower bound"."""
    log10_p_low: float | Undefined
    """Its decimal logarithm."""
    t_high: float | Undefined
    """Estimate minus the upper bound, over its standard error; far below 0 speaks against a gain."""
    df_high: float | Undefined
    """Degrees of freedom of `t_high`."""
    p_high: float | Undefined
    """One-sided p against "at or above the upper bound"."""
    log10_p_high: float | Undefined
    """Its decimal logarithm."""
    p: float | Undefined
    """The larger of both, or the only one."""
    log10_p: float | Undefined
    """Decimal logarithm of p, right at any size."""
    estimate_ci: tuple[float, float] | Undefined
    """Two-sided interval of level 1 - 2 alpha, in the unit of the bounds."""
    equivalent: bool | Undefined
    """Whether p is at most alpha and, in percent, the interval exists and lies within the bounds."""


def tost(
    name: str, contrast: Contrast | Undefined, bounds: tuple[Fraction | None, Fraction | None], alpha: float
) -> Tost:
    """Return both one-sided tests of a contrast at level alpha; the bounds, the lower first, are in its unit."""
    if isinstance(contrast, Undefined):
        return Tost(name, *(contrast,) * 12)
    tests = {}
    for side, bound in zip(("low", "high"), bounds, strict=True):
        if bound is not None:
            test = contrast.test(bound, above=side == "low")
            if isinstance(test, Undefined):
                return Tost(name, *(test,) * 12)
            tests[side] = test
    worst = max(tests.values(), key=lambda one: one.log10_p)
    ends = contrast.interval(complement_level(2.0 * alpha))
    inside = not contrast.relative or (not isinstance(ends, Undefined) and _within(ends, *bounds))
    per = 100 if contrast.relative else 1
    shown = ends if isinstance(ends, Undefined) else finite_pair(ends[0] * per, ends[1] * per)
    of_sides: dict[str, Any] = {}
    for side, none in (("low", _NO_LOW), ("high", _NO_HIGH)):
        one = tests.get(side)
        for field in ("t", "df", "p", "log10_p"):
            of_sides[f"{field}_{side}"] = getattr(one, field) if one else none
    return Tost(
        name, **of_sides, p=worst.p, log10_p=worst.log10_p, estimate_ci=shown, equivalent=worst.p <= alpha and inside
    )


def _within(ends: Ends, low: Fraction | None, high: Fraction | None) -> bool:
    return (low is None or ends[0] >= low) and (high is None or ends[1] <= high)


Bounds = Literal["raw", "percent"]
BOUNDS: tuple[Bounds, ...] = ("raw", "percent")
"""In the values' unit, or in percent of the control's mean."""
EquivalenceRoute = Literal["welch", "student"]
ROUTES: tuple[EquivalenceRoute, ...] = ("welch", "student")
"""Each group with a scatter of its own, or one pooled."""


@dataclass(frozen=True, slots=True)
class Equivalence(Result):
    """Group a against group b, the control, and bounds that matter."""

    n_a: int
    """Number of values of group a."""
    n_b: int
    """Number of values of group b."""
    mean_a: float | Undefined
    """Mean of group a, in the unit of the values."""
    mean_b: float | Undefined
    """Mean of group b, in the unit of the values."""
    bounds: Bounds
    """Unit of bounds, estimate and interval: that of the values, or percent of the control's mean."""
    low: float | Undefined
    """Lower bound of what does not matter, in the unit that `bounds` names."""
    high: float | Undefined
    """Upper bound of what does not matter, in the unit that `bounds` names."""
    estimate: float | Undefined
    """mean(a) - mean(b) in the unit of the values, or 100 (mean(a) / mean(b) - 1) in percent."""
    route: EquivalenceRoute
    """Which of both tests is reported."""
    alpha: float
    """Level of each one-sided test."""
    p: float | Undefined
    """Of the test reported."""
    log10_p: float | Undefined
    """Decimal logarithm of p, right at any size."""
    estimate_ci: tuple[float, float] | Undefined
    """Of the test reported, level 1 - 2 alpha: 90 % at alpha = 0.05."""
    equivalent: bool | Undefined
    """Whether the test reported shows that the means differ by less than the bounds."""
    welch: Tost
    """Both tests with each group's own scatter."""
    student: Tost
    """Both tests with one scatter pooled from both groups."""
    missing: int
    """How many values were left out as NaN."""
    names: Names = AS_A_AND_B
    """What groups a and b are called in reasons and in the sentence."""

    def sentence(self, a: str | None = None, b: str | None = None, unit: str = "", confounded_with: str = "") -> str:
        """Return the result in words: estimate with interval, bounds, t at each bound, p, n.

        `confounded_with` is what it cannot be told from, such as "a difference between days": nothing is claimed then.
        """
        a, b = self.names[0] if a is None else a, self.names[1] if b is None else b
        if isinstance(self.estimate, Undefined):
            return f"{a} (n = {self.n_a}) and {b} (n = {self.n_b}) cannot be compared: {self.estimate.reason}."
        unit, short = (unit, unit) if self.bounds == "raw" else (f"% of {b}'s mean", "%")
        estimate = number_text(self.estimate, error=error_of(self.estimate_ci))
        estimate = f"{a} (n = {self.n_a}) minus {b} (n = {self.n_b}) is {estimate}{with_unit(unit)}"
        if isinstance(self.p, Undefined):
            return f"{estimate}; no test whether it lies {self._bounds(unit)}, because {self.p.reason}."
        chosen = self.welch if self.route == "welch" else self.student
        tests = [
            statistic_text("t", t, (df,))
            for t, df in ((chosen.t_low, chosen.df_low), (chosen.t_high, chosen.df_high))
            if not isinstance(t, Undefined)
        ]
        tests_text = f"{chosen.test}'s {' and '.join(tests)}, {p_text(self.p, self.alpha)}"
        if isinstance(self.estimate_ci, Undefined):
            why = f"because its {level_text(1.0 - 2.0 * self.alpha)} CI is undefined: {self.estimate_ci.reason}"
            shown = f"{estimate} and is not shown to lie {self._bounds(unit)} ({tests_text})"
            return f"{shown}, {why}{missing_text(self.missing)}."
        verdict = f" and is {'shown' if self.equivalent is True else 'not shown'} to lie {self._bounds(unit)}"
        if confounded_with:
            verdict = f"; that it lies {self._bounds(unit)} cannot be told from {confounded_with}"
        return (
            f"{estimate} ({interval_text(self.estimate_ci, 1.0 - 2.0 * self.alpha, short)}){verdict}, "
            f"{tests_text}{missing_text(self.missing)}."
        )

    def _bounds(self, unit: str) -> str:
        if isinstance(self.high, Undefined):
            return f"above {given_text(self.low)}{with_unit(unit)} (non-inferiority)"
        if isinstance(self.low, Undefined):
            return f"below {given_text(self.high)}{with_unit(unit)} (non-superiority)"
        return f"within {given_text(self.low)} to {given_text(self.high)}{with_unit(unit)} (equivalence)"


def equivalence(
    a: ArrayLike,
    b: ArrayLike,
    *,
    low: float | None = None,
    high: float | None = None,
    bounds: Bounds = "raw",
    route: EquivalenceRoute = "welch",
    alpha: float = 0.05,
    missing: Missing = "refuse",
    names: Names = AS_A_AND_B,
) -> Equivalence:
    """Test whether the means of two independent samples, shapes (n_a,) and (n_b,), differ by less than the bounds.

    `low` alone (with `high` None) is non-inferiority, `high` alone its mirror image. Percent bounds are in percent of
    mean(b), which must be positive; how they are tested stands at the top of this module. `names` are what the groups
    are called in the sentence, and where something is undefined or refused.
    Raises `InputRefused` for infinite values, for NaN unless `missing` is "drop", for bounds that are none, in the
    wrong order or at most -100 percent, alpha from 0.5, or one name for both groups.
    """
    if bounds not in BOUNDS:
        raise unknown_name("unit of bounds", bounds, BOUNDS)
    if route not in ROUTES:
        raise unknown_name("route", route, ROUTES)
    low, high = _checked(low, high, lowest=-100.0 if bounds == "percent" else -math.inf)
    alpha = as_level("alpha", alpha)
    if alpha >= 0.5:
        raise InputRefused(f"alpha is {alpha!r}: give a number below 0.5, for example 0.05.")
    names = pair_of_names(names)
    read = read_groups(as_pair(names, a, b), missing)
    percent = bounds == "percent"
    estimate, by_test = contrasts(read, percent=percent)
    per = 100 if percent else 1
    within = (None if low is None else Fraction(low) / per, None if high is None else Fraction(high) / per)
    found = {
        test: tost(name, contrast, within, alpha)
        for (test, name), contrast in zip((("welch", "Welch"), ("student", "Student")), by_test, strict=True)
    }
    means = dict(zip(read.names, read.means, strict=True))
    sizes = dict(zip(read.names, read.sizes, strict=True))
    chosen = found[route]
    return Equivalence(
        n_a=sizes.get(names[0], 0),
        n_b=sizes.get(names[1], 0),
        mean_a=means.get(names[0], Undefined(Reason.GROUP_EMPTY, group=f"group {names[0]}")),
        mean_b=means.get(names[1], Undefined(Reason.GROUP_EMPTY, group=f"group {names[1]}")),
        bounds=bounds,
        low=_NO_LOW if low is None else low,
        high=_NO_HIGH if high is None else high,
        estimate=estimate if isinstance(estimate, Undefined) else finite(per * estimate, "the estimate"),
        route=route,
        alpha=alpha,
        p=chosen.p,
        log10_p=chosen.log10_p,
        estimate_ci=chosen.estimate_ci,
        equivalent=chosen.equivalent,
        welch=found["welch"],
        student=found["student"],
        missing=read.missing,
        names=names,
    )


def _checked(low: float | None, high: float | None, lowest: float) -> tuple[float | None, float | None]:
    if low is None and high is None:
        raise InputRefused("Neither bound is given: give low, high or both.")
    low = None if low is None else as_number("low", low, above=lowest)
    high = None if high is None else as_number("high", high, above=lowest)
    if low is not None and high is not None and low >= high:
        raise InputRefused(f"The bounds are {low!r} to {high!r}: give the lower one first.")
    return low, high
