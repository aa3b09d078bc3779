"""Two one-sided tests of one contrast against its bounds, with the interval that says the same."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from data_schema.vocabulary import Undefined
from stats.compare.contrast import Contrast, Ends
from stats.exact.distributions import complement_level
from stats.exact.finite import finite_pair
from stats.results import Result

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
