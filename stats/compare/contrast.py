"""The contrast of two means that bounds on a difference or on a ratio are tested by, in exact fractions.

At a bound delta it is mean(a) - mean(b) - delta, or mean(a) - (1 + delta) mean(b) for bounds relative to mean(b).
Numbers are rounded once, at the end: means, scatter and bounds may be of any sizes.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction

from scipy import optimize

from data_schema.vocabulary import Undefined
from stats.compare.summary import Groups
from stats.exact.numbers import QUANTILE_BEYOND_DOUBLES, Number, exact_root, finite, shortened
from stats.exact.tails import exact_df, t_quantile, t_upper

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
        slope = shortened(1 + bound) if self.relative else Fraction(1)
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
            return Undefined("nothing scatters at the bound")
        se, df = error
        at_bound = bound * self.control_mean if self.relative else bound
        t = shortened((self.mean - self.control_mean - at_bound) / se)
        tail = t_upper(t if above else -t, df)
        return OneSided(finite(t, "t"), df, tail.p, tail.log10_p)

    def interval(self, level: Number) -> Ends | Undefined:
        """Return all bounds that the two-sided test of level 1 - `level` does not reject."""
        if self.relative:
            if self.error(shortened(self.estimate)) is None:
                return Undefined("all values compared with the control are 0, and a share of 0 does not scatter")
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
            return Undefined("the control's mean is not distinguishable from 0 at this level")
        return low, high

    def _end(self, side: int, level: Number) -> Fraction | None:
        """Return where |t| reaches its quantile, on one side of the estimate."""
        estimate = shortened(self.estimate)
        error = self.error(estimate)
        if error is None:
            return None
        quantile, control_mean = t_quantile(level, error[1]), shortened(self.control_mean)
        if math.isinf(quantile):
            return None
        step = side * shortened(Fraction(quantile) * error[0] / control_mean)

        def surplus(steps: float) -> float:
            # Away from the estimate the contrast is that distance times mean(b): nothing cancels.
            away = Fraction(steps) * step
            found = self.error(estimate + away)
            if found is None:
                return math.inf
            return float(abs(away) * control_mean / found[0]) - t_quantile(level, found[1])

        inside, outside = 0.0, 1.0
        for _ in range(_MOST_DOUBLINGS):
            if surplus(outside) >= 0.0:
                steps = optimize.brentq(surplus, inside, outside, xtol=1e-300, rtol=1e-14, maxiter=_MOST_STEPS)
                return estimate + Fraction(float(steps)) * step
            inside, outside = outside, 2.0 * outside
        return None


@dataclass(frozen=True, slots=True)
class Contrasts:
    """One contrast by either estimate of the scatter."""

    estimate: Fraction | Undefined
    """The difference in the values' unit, or relative to mean(b)."""
    by_test: tuple[Contrast | Undefined, Contrast | Undefined]
    """Welch's and Student's."""


def contrasts(read: Groups, *, percent: bool) -> Contrasts:
    """Return the contrasts of two groups, the second of which is the control."""
    if read.empty:
        none = Undefined(f"group {read.empty[0]} is empty")
        return Contrasts(none, (none, none))
    a, b = read.filled
    if percent and b.exact_mean <= 0:
        none = Undefined("the control's mean is not positive, so that nothing is a share of it")
        return Contrasts(none, (none, none))
    unit = Fraction(2) ** read.exponent
    means = a.exact_mean * unit, b.exact_mean * unit

    def of(variances: Ends, dfs: tuple[int, int], pooled: bool) -> Contrast:
        in_unit = shortened(variances[0] * unit**2), shortened(variances[1] * unit**2)
        return Contrast(*means, in_unit, dfs, pooled, percent)

    welch: Contrast | Undefined
    student: Contrast | Undefined
    welch = student = Undefined("neither group has any scatter")
    single = next((group for group in (a, b) if group.n < 2), None)
    if single is not None:
        welch = Undefined(f"group {single.name} has a single value, and its variance needs at least 2")
    elif read.squares_within:
        welch = of((a.exact_mean_variance, b.exact_mean_variance), (a.n - 1, b.n - 1), pooled=False)
    df = read.df_within
    if df < 1:
        student = Undefined("there are 2 values and the pooled variance needs at least 3")
    elif read.squares_within:
        variance = read.squares_within / df
        student = of((variance / a.n, variance / b.n), (df, df), pooled=True)
    estimate = means[0] - means[1]
    return Contrasts(estimate / means[1] if percent else estimate, (welch, student))
