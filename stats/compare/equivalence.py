"""Equivalence within bounds: two one-sided t-tests (TOST), the tool for "no loss of jump height".

With raw bounds low < mean(a) - mean(b) < high both one-sided tests ask whether the difference lies beyond a bound.
Percent bounds are shares of the mean of b, the control. That mean is itself estimated, so a bound of delta is tested
as the contrast mean(a) - (1 + delta) mean(b) (Sasabuchi), with variance Var(a) + (1 + delta)^2 Var(b): taking the
control's mean as known would claim too much. The interval beside it holds all delta that such a test does not reject
(Fieller). Either way it has level 1 - 2 alpha and lies within the bounds just where the tests reject. Where the
control's mean cannot be told from 0 there is no such interval, and no percentage is shown whatever the tests say.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from typing import Literal

from numpy.typing import ArrayLike

from data_schema.errors import InputRefused, unknown_name
from data_schema.rounding import error_of, interval_text, level_text, number_text, p_text, stated_text, statistic_text
from data_schema.vocabulary import Undefined
from stats.checks import Missing, as_level, as_number, as_pair
from stats.compare.contrast import Contrast, Ends, contrasts
from stats.compare.summary import AS_A_AND_B, Names, read_groups, two_names
from stats.exact.numbers import finite, finite_pair
from stats.exact.tails import complement_level
from stats.results import Result, missing_text, with_unit

NO_LOW = Undefined("no lower bound was asked for")
NO_HIGH = Undefined("no upper bound was asked for")


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
    at_low, at_high = tests.get("low"), tests.get("high")
    per = 100 if contrast.relative else 1
    return Tost(
        test=name,
        t_low=at_low.t if at_low else NO_LOW,
        df_low=at_low.df if at_low else NO_LOW,
        p_low=at_low.p if at_low else NO_LOW,
        log10_p_low=at_low.log10_p if at_low else NO_LOW,
        t_high=at_high.t if at_high else NO_HIGH,
        df_high=at_high.df if at_high else NO_HIGH,
        p_high=at_high.p if at_high else NO_HIGH,
        log10_p_high=at_high.log10_p if at_high else NO_HIGH,
        p=worst.p,
        log10_p=worst.log10_p,
        estimate_ci=ends if isinstance(ends, Undefined) else finite_pair(ends[0] * per, ends[1] * per),
        equivalent=worst.p <= alpha and inside,
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

    def sentence(self, a: str | None = None, b: str | None = None, unit: str = "", untold: str = "") -> str:
        """Return the result in words: estimate with interval, bounds, t at each bound, p, n.

        `untold` is what it cannot be told from, such as "a difference between days": nothing is claimed then.
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
        told = f"{chosen.test}'s {' and '.join(tests)}, {p_text(self.p, self.alpha)}"
        if isinstance(self.estimate_ci, Undefined):
            why = f"because its {level_text(1.0 - 2.0 * self.alpha)} CI is undefined: {self.estimate_ci.reason}"
            return (
                f"{estimate} and is not shown to lie {self._bounds(unit)} ({told}), {why}{missing_text(self.missing)}."
            )
        verdict = f" and is {'shown' if self.equivalent is True else 'not shown'} to lie {self._bounds(unit)}"
        if untold:
            verdict = f"; that it lies {self._bounds(unit)} cannot be told from {untold}"
        return (
            f"{estimate} ({interval_text(self.estimate_ci, 1.0 - 2.0 * self.alpha, short)}){verdict}, "
            f"{told}{missing_text(self.missing)}."
        )

    def _bounds(self, unit: str) -> str:
        if isinstance(self.high, Undefined):
            return f"above {stated_text(self.low)}{with_unit(unit)} (non-inferiority)"
        if isinstance(self.low, Undefined):
            return f"below {stated_text(self.high)}{with_unit(unit)} (non-superiority)"
        return f"within {stated_text(self.low)} to {stated_text(self.high)}{with_unit(unit)} (equivalence)"


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
    names = two_names(names)
    read = read_groups(as_pair(names, a, b), missing)
    percent = bounds == "percent"
    pair = contrasts(read, percent=percent)
    per = 100 if percent else 1
    within = (None if low is None else Fraction(low) / per, None if high is None else Fraction(high) / per)
    found = {
        test: tost(name, contrast, within, alpha)
        for (test, name), contrast in zip((("welch", "Welch"), ("student", "Student")), pair.by_test, strict=True)
    }
    means = dict(zip(read.names, read.means, strict=True))
    sizes = dict(zip(read.names, read.sizes, strict=True))
    chosen = found[route]
    return Equivalence(
        n_a=sizes.get(names[0], 0),
        n_b=sizes.get(names[1], 0),
        mean_a=means.get(names[0], Undefined(f"group {names[0]} is empty")),
        mean_b=means.get(names[1], Undefined(f"group {names[1]} is empty")),
        bounds=bounds,
        low=NO_LOW if low is None else low,
        high=NO_HIGH if high is None else high,
        estimate=pair.estimate if isinstance(pair.estimate, Undefined) else finite(per * pair.estimate, "the estimate"),
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
