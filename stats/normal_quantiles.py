"""How residuals lie beside the normal distribution that tests assume: to look at, no test."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import special

from data_schema.rounding import level_text
from data_schema.vocabulary import Undefined
from stats.checks import as_level
from stats.double_double import Floats
from stats.residuals import Residuals
from stats.results import Result
from stats.wording import counted, number_text

_SEED = 2021
_FEWEST_DRAWS, _MOST_DRAWS, _MOST_NUMBERS = 100, 4000, 4_000_000


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
        n = len(self.observed)
        if isinstance(self.outside, Undefined):
            return f"There is no band for n = {counted(n, 'residual')}, because {self.outside.reason}."
        usual = number_text((1.0 - self.level) * n, 2)
        return (
            f"{self.outside} of n = {counted(n, 'residual')} lie outside the {level_text(self.level)} band of each "
            f"place; of normal values {usual} do on average."
        )


def normal_quantiles(residuals: Residuals, level: float = 0.95) -> NormalQuantiles:
    """Order residuals beside normal quantiles, with a pointwise band.

    The i-th of n uniform values in order has a beta distribution with parameters i and n + 1 - i; the expected value is
    the normal quantile of its median. That holds for values. Residuals have less freedom, and their own standard
    deviation scales them: a band from those betas at 90 % holds 99 % of them (n = 25, one group). So the band is that
    of normal values put through the same model, drawn from a fixed seed.
    """
    level = as_level("level", level)
    n = len(residuals.values)
    place = np.arange(1.0, n + 1.0)
    expected = special.ndtri(special.betaincinv(place, n + 1.0 - place, 0.5))
    sd = residuals.sd
    low: tuple[float, ...] | Undefined
    middle: tuple[float, ...] | Undefined
    high: tuple[float, ...] | Undefined
    if isinstance(sd, Undefined):
        low = middle = high = sd
    else:
        with np.errstate(over="ignore"):
            lines = sd * _band(residuals, level)
        beyond = Undefined("the band is too large for a double")
        low, middle, high = (tuple(line.tolist()) if np.isfinite(line).all() else beyond for line in lines)
    return NormalQuantiles(
        expected=tuple(expected.tolist()),
        observed=tuple(sorted(residuals.values)),
        low=low,
        middle=middle,
        high=high,
        sd=sd,
        level=level,
    )


def _band(residuals: Residuals, level: float) -> Floats:
    """Return low end, median and high end for each place, shape (3, n), in residual standard deviations."""
    n, basis = len(residuals.values), residuals._basis
    draws = max(_FEWEST_DRAWS, min(_MOST_DRAWS, _MOST_NUMBERS // n))
    drawn = np.random.default_rng(_SEED).standard_normal((n, draws))
    drawn -= basis @ (basis.T @ drawn)
    drawn /= np.sqrt(np.sum(drawn * drawn, axis=0) / residuals.df)
    drawn.sort(axis=0)
    tail = (1.0 - level) / 2.0
    return np.asarray(np.quantile(drawn, (tail, 0.5, 1.0 - tail), axis=1))
