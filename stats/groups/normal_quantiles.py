"""How residuals lie beside the normal distribution that tests assume: to look at, no test."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy import special

from data_schema.errors import InputRefused
from data_schema.rounding import level_text
from data_schema.vocabulary import Undefined
from stats.checks import as_level
from stats.groups.residuals import Residuals
from stats.results import Result
from stats.wording import counted, missing_text, number_text

_SEED = 2021
_USUAL_DRAWS, _USUAL_NUMBERS, _MOST_NUMBERS = 4000, 4_000_000, 20_000_000


@dataclass(frozen=True, slots=True)
class NormalQuantile(Result):
    """One residual beside what is expected at its place."""

    expected: float
    """Median of the standard normal values at this place in the order."""
    observed: float
    """The residual, in the unit of the values."""
    low: float | Undefined
    """Where the band begins, in that unit."""
    middle: float | Undefined
    """Its median."""
    high: float | Undefined
    """Where the band ends."""


@dataclass(frozen=True, slots=True)
class NormalQuantiles(Result):
    """Residuals in order beside the standard normal values that belong to their places; all of shape (n,)."""

    expected: tuple[float, ...]
    """Medians of the order statistics of n standard normal values; shape (n,)."""
    observed: tuple[float, ...]
    """Residuals, from the lowest up; shape (n,)."""
    low: tuple[float, ...] | Undefined
    """Where the band begins, in the unit of the residuals; shape (n,)."""
    middle: tuple[float, ...] | Undefined
    """Its median: the line that residuals of normal values lie about; shape (n,)."""
    high: tuple[float, ...] | Undefined
    """Where the band ends, shape (n,)."""
    sd: float | Undefined
    """Residual standard deviation."""
    level: float
    """How often each residual, taken by itself, lies in the band where the values are normal."""
    missing: int = 0
    """Values left out because they, or a label of theirs, were missing."""

    @property
    def outside(self) -> int | Undefined:
        """How many residuals lie outside the band."""
        if isinstance(self.low, Undefined):
            return self.low
        if isinstance(self.high, Undefined):
            return self.high
        ends = zip(self.observed, self.low, self.high, strict=True)
        return sum(not low <= value <= high for value, low, high in ends)

    def rows(self) -> tuple[NormalQuantile, ...]:
        """Return each residual at its place, for `to_frame`."""
        lines = [
            [line] * len(self.observed) if isinstance(line, Undefined) else line
            for line in (self.low, self.middle, self.high)
        ]
        return tuple(map(NormalQuantile, self.expected, self.observed, *lines))

    def sentence(self) -> str:
        """Return in words how many residuals lie outside the band, and how many of normal values would."""
        n, outside, left_out = len(self.observed), self.outside, missing_text(self.missing)
        if isinstance(outside, Undefined):
            return f"There is no band for n = {counted(n, 'residual')}{left_out}, because {outside.reason}."
        usual, comma = number_text((1.0 - self.level) * n, 2), "," if left_out else ""
        return (
            f"{outside} of n = {n} residuals{left_out}{comma} lie outside the {level_text(self.level)} band of each "
            f"place; of normal values {usual} do on average."
        )


def normal_quantiles(residuals: Residuals, level: float = 0.95) -> NormalQuantiles:
    """Order residuals beside normal quantiles, with a pointwise band.

    The i-th of n uniform values in order has a beta distribution with parameters i and n + 1 - i; the expected value is
    the normal quantile of its median. That holds for values. Residuals have less freedom, and their own standard
    deviation scales them: a band from those betas at 90 % holds 99 % of them (n = 25, one group). So the band is that
    of normal values put through the same model, drawn from a fixed seed.
    """
    if not isinstance(residuals, Residuals):
        raise InputRefused(f"residuals are {residuals!r}: give those of `residuals_of_groups` or `additive_residuals`.")
    level = as_level("level", level)
    n = len(residuals.values)
    place = np.arange(1.0, n + 1.0)
    expected = special.ndtri(special.betaincinv(place, n + 1.0 - place, 0.5))
    band = _band(residuals, level)
    low, middle, high = (band,) * 3 if isinstance(band, Undefined) else band
    return NormalQuantiles(
        expected=tuple(expected.tolist()),
        observed=tuple(sorted(residuals.values)),
        low=low,
        middle=middle,
        high=high,
        sd=residuals.sd,
        level=level,
        missing=residuals.missing,
    )


def _band(residuals: Residuals, level: float) -> tuple[tuple[float, ...], ...] | Undefined:
    """Return low end, median and high end for each place, in the unit of the residuals, or why there is no band."""
    sd, n, tail = residuals.sd, len(residuals.values), (1.0 - level) / 2.0
    if isinstance(sd, Undefined):
        return sd
    if sd == 0.0:
        return Undefined("all residuals are 0")
    if residuals.df == 1:
        return Undefined("with one degree of freedom all residuals of so many values have one shape")
    # So many that the ends lie among them: the share beyond is then the tail, and no less.
    draws = max(min(_USUAL_DRAWS, _USUAL_NUMBERS // n), math.ceil(1.0 / tail)) if tail > 0.0 else math.inf
    if draws * n > _MOST_NUMBERS:
        return Undefined("so many residuals would take too many draws at a level so near 1")
    drawn = residuals.of_noise(np.random.default_rng(_SEED).standard_normal((n, int(draws))))
    drawn.sort(axis=0)
    lines = np.quantile(drawn, (tail, 0.5, 1.0 - tail), axis=1, method="weibull")
    with np.errstate(over="ignore"):
        lines = sd * lines
    if not np.isfinite(lines).all():
        return Undefined("the band is too large for a double")
    return tuple(tuple(line.tolist()) for line in lines)
