"""The contrast of two means that bounds on a difference or on a ratio are tested by.

At a bound delta it is mean(a) - mean(b) - delta, or mean(a) - (1 + delta) mean(b) for bounds relative to mean(b).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from scipy import optimize

from data_schema.vocabulary import Undefined
from stats.distributions import t_quantile
from stats.groups import Groups
from stats.tails import t_upper

_Interval = tuple[float, float]

MOST_DOUBLINGS = 200
"""Widenings after which an end of an interval counts as infinite."""


@dataclass(frozen=True, slots=True)
class OneSided:
    """A one-sided t-test at a bound."""

    t: float
    df: float
    p: float
    log10_p: float


@dataclass(frozen=True, slots=True)
class Contrast:
    """Two means with their variances, in scaled units."""

    difference: float
    """mean(a) - mean(b)."""
    control_mean: float
    """mean(b), which relative bounds are shares of."""
    variances: tuple[float, float]
    """Squared standard errors of the means of a and b."""
    dfs: tuple[float, float]
    """Degrees of freedom of each; both the same number where they are one estimate, `pooled`."""
    pooled: bool
    relative: bool
    """Whether bounds are shares of mean(b)."""
    exponent: int
    """Raw bounds are in scaled units times 2**exponent."""

    def at(self, bound: float) -> tuple[float, float, float]:
        """Return t at the bound, its standard error and its degrees of freedom, in scaled units."""
        slope = 1.0 + bound if self.relative else 1.0
        top = self.difference - bound * (self.control_mean if self.relative else 1.0)
        parts = (self.variances[0], slope * slope * self.variances[1])
        variance = math.fsum(parts)
        if variance == 0.0:
            return math.copysign(math.inf, top), 0.0, self.dfs[0]
        if self.pooled:
            df = self.dfs[0]
        else:
            df = 1.0 / math.fsum((part / variance) ** 2 / own for part, own in zip(parts, self.dfs, strict=True))
        se = math.sqrt(variance)
        return top / se, se, df

    def test(self, bound: float, *, above: bool) -> OneSided:
        """Test that the truth lies above the bound, or below it."""
        t, _se, df = self.at(bound if self.relative else _scaled(bound, self.exponent))
        towards = t if above else -t
        tail = t_upper(towards, df)
        return OneSided(t, df, tail.p, tail.log10_p)

    def interval(self, level: float) -> _Interval | Undefined:
        """Return all bounds that the two-sided test of level 1 - `level` does not reject."""
        if not self.relative:
            _t, se, df = self.at(0.0)
            half = t_quantile(level, df) * se
            low, high = (math.ldexp(self.difference + side * half, self.exponent) for side in (-1.0, 1.0))
            return low, high
        ends = [self._end(side, level) for side in (-1.0, 1.0)]
        low_end, high_end = ends
        if low_end is None or high_end is None:
            return Undefined("the control's mean is not distinguishable from 0 at this level")
        return low_end, high_end

    def _end(self, side: float, level: float) -> float | None:
        """Return where |t| reaches its quantile, on one side of the estimate."""
        estimate = self.difference / self.control_mean

        def surplus(bound: float) -> float:
            t, _se, df = self.at(bound)
            return abs(t) - t_quantile(level, df)

        _t, se, df = self.at(estimate)
        step = t_quantile(level, df) * se / self.control_mean
        inside, outside = estimate, estimate + side * step
        for _ in range(MOST_DOUBLINGS):
            if surplus(outside) >= 0.0:
                return float(optimize.brentq(surplus, inside, outside, xtol=1e-300, rtol=1e-14))
            step *= 2.0
            inside, outside = outside, estimate + side * step
        return None


@dataclass(frozen=True, slots=True)
class Contrasts:
    """One contrast by either estimate of the scatter."""

    estimate: float | Undefined
    """The difference in the values' unit, or relative to mean(b)."""
    by_test: tuple[Contrast | Undefined, Contrast | Undefined]
    """Welch's and Student's."""


def contrasts(read: Groups, *, percent: bool) -> Contrasts:
    """Return the contrasts of two groups, the second of which is the control."""
    if read.empty:
        none = Undefined(f"group {read.empty[0]} is empty")
        return Contrasts(none, (none, none))
    a, b = read.filled
    difference = a.minus(b)
    control_mean = b.mean
    if percent and control_mean <= 0.0:
        none = Undefined("the control's mean is not positive, so that nothing is a share of it")
        return Contrasts(none, (none, none))

    def of(variances: _Interval, dfs: _Interval, pooled: bool) -> Contrast | Undefined:
        if sum(variances) == 0.0:
            return Undefined("neither group has any scatter")
        return Contrast(difference, control_mean, variances, dfs, pooled, percent, read.exponent)

    welch: Contrast | Undefined
    student: Contrast | Undefined
    single = next((group for group in (a, b) if group.n < 2), None)
    if single is None:
        welch = of((a.mean_variance, b.mean_variance), (a.n - 1.0, b.n - 1.0), pooled=False)
    else:
        welch = Undefined(f"group {single.name} has a single value, and its variance needs at least 2")
    df = a.n + b.n - 2.0
    if df > 0.0:
        variance = float(read.squares_within) / df
        student = of((variance / a.n, variance / b.n), (df, df), pooled=True)
    else:
        student = Undefined("there are 2 values and the pooled variance needs at least 3")
    return Contrasts(difference / control_mean if percent else read.in_unit(difference), (welch, student))


def _scaled(bound: float, exponent: int) -> float:
    """Return a raw bound in scaled units; one beyond all doubles is beyond every scatter too."""
    try:
        return math.ldexp(bound, -exponent)
    except OverflowError:
        return math.copysign(1e300, bound)
