"""The test of a difference from which a shared error does not cancel."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from data_schema.errors import InputRefused
from data_schema.rounding import alpha_beside
from data_schema.vocabulary import Undefined
from stats.checks import as_level, as_number
from stats.compare.shared_error import SharedError, as_shared, joined
from stats.exact.distributions import t_quantile
from stats.exact.finite import QUANTILE_BEYOND_DOUBLES, as_interval, finite, times_power
from stats.exact.tails import normal_two_sided, t_two_sided
from stats.results import Result
from stats.wording import df_text, interval_text, number_text, p_text

NORMAL = Undefined("both errors are known as if from infinitely many values: t is normal")


@dataclass(frozen=True, slots=True)
class SharedTest(Result):
    """A t-test of a difference and its interval, both with what is left of a shared error."""

    t: float | Undefined
    """Difference over both errors together."""
    df: float | Undefined
    """Degrees of freedom of the quantile (`joint`)."""
    p: float | Undefined
    """Two-sided."""
    ci_low: float | Undefined
    """Lower end of the interval of the difference, in the unit of the values."""
    ci_high: float | Undefined
    """Its upper end, in the unit of the values."""
    level: float
    """Level of the interval."""

    @property
    def log10_p(self) -> float | Undefined:
        """Decimal logarithm of p, right at any size."""
        if isinstance(self.t, Undefined):
            return self.t
        if isinstance(self.df, Undefined):
            return finite(normal_two_sided(self.t).log10_p, "log10 p") if self.df is NORMAL else self.df
        return finite(t_two_sided(self.t, self.df).log10_p, "log10 p")

    def sentence(self, difference: str = "the difference", unit: str = "") -> str:
        """Return the test in words: t, df, p, interval."""
        if isinstance(self.t, Undefined):
            return f"No test of {difference} with its shared error: {self.t.reason}."
        ends = as_interval(self.ci_low, self.ci_high)
        name = "z" if self.df is NORMAL else f"t({df_text(self.df)})"
        return (
            f"With its shared error {difference} has the {interval_text(ends, self.level, unit)}, "
            f"{name} = {number_text(self.t)}, {p_text(self.p, self.log10_p, alpha_beside(self.level))}."
        )


def difference_with_shared(
    t: float | Undefined,
    df: float | Undefined,
    p: float | Undefined,
    interval: tuple[float, float] | Undefined,
    shared: SharedError,
    level: float = 0.95,
) -> SharedTest:
    """Add what is left of a shared error to the test of a difference; p <= 1 - level where 0 does not lie inside.

    `t`, `df`, `p` and the `interval` of that level are those of the scatter alone, each a number or undefined. Raises
    `InputRefused` for anything else, such as an interval whose ends are no two finite numbers in order.
    """
    level, shared = as_level("level", level), as_shared("shared", shared)
    _check_test(t, df, p)
    if not isinstance(interval, Undefined):
        interval = _two_ends(interval)
    if isinstance(interval, Undefined):
        return SharedTest(t, df, p, interval, interval, level)
    if isinstance(df, Undefined) or shared.se == 0.0:
        return SharedTest(t, df, p, *interval, level)
    middle, scatter_half = interval[0] / 2.0 + interval[1] / 2.0, interval[1] / 2.0 - interval[0] / 2.0
    se = finite(scatter_half / t_quantile(level, df), "the standard error")
    if isinstance(se, Undefined):
        return SharedTest(se, df, se, se, se, level)
    both, half, exponent = joined(se, df, shared, level)
    shown_df = both.df if math.isfinite(both.df) else NORMAL
    if half == 0.0 or math.isinf(half):
        none = Undefined("the interval has no width") if half == 0.0 else QUANTILE_BEYOND_DOUBLES
        return SharedTest(none, shown_df, none, none, none, level)
    t = finite(times_power(middle, -exponent) / half * both.quantile, "t")
    p = t if isinstance(t, Undefined) else t_two_sided(t, both.df).p
    half = times_power(half, exponent)
    low, high = (finite(end, "an end of the interval") for end in (middle - half, middle + half))
    return SharedTest(t, shown_df, p, low, high, level)


def _check_test(t: Any, df: Any, p: Any) -> None:
    """Raise `InputRefused` for what is neither undefined nor a number that a t-test can have."""
    if not isinstance(t, Undefined):
        as_number("t", t)
    if not isinstance(df, Undefined) and df != math.inf:
        as_number("the degrees of freedom", df, above=0.0)
    if not isinstance(p, Undefined) and as_number("p", p, low=0.0) > 1.0:
        raise InputRefused(f"p is {p!r}: give a probability, from 0 to 1.")


def _two_ends(interval: Any) -> tuple[float, float]:
    try:
        low, high = interval
    except (TypeError, ValueError) as error:
        raise InputRefused(f"the interval is {interval!r}: give its two ends, as (-1.0, 3.0).") from error
    low, high = as_number("the interval's lower end", low), as_number("its upper end", high)
    if low > high:
        raise InputRefused(f"the interval goes from {low:g} to {high:g}: give its lower end first.")
    return low, high
