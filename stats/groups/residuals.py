"""What is left unexplained: residuals of comparisons, data for figures to look at, which test nothing.

Errors of predictions are root mean squares over the interquartile range (thesis 3.2.2: 0.63 for the cost estimated from
forces).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy import special

from data_schema.errors import InputRefused
from data_schema.reasons import Reason
from data_schema.vocabulary import Undefined
from stats.checks import as_groups, as_level, as_values
from stats.results import Result
from stats.scatter import Floats, finite, read_groups, scale_of

_SD = "the residual standard deviation"


@dataclass(frozen=True, slots=True)
class Residuals(Result):
    """Values less what the model says of them, in the unit of the values and in their order."""

    values: tuple[float, ...]
    """Each value less what the model says of it; shape (n,)."""
    fitted: tuple[float, ...]
    """What the model says of each, shape (n,)."""
    sd: float | Undefined
    """Residual standard deviation."""
    df: int
    """Its degrees of freedom."""
    group_ns: tuple[int, ...]
    """Sizes of the groups, in their order; shape (k,)."""

    def of_noise(self, drawn: Floats) -> Floats:
        """Return what the group means leave of values drawn, shape (n, draws), over the SD of each draw."""
        parts = np.split(drawn, np.cumsum(self.group_ns)[:-1])
        left = np.concatenate([part - part.mean(axis=0) for part in parts])
        return np.asarray(left / np.sqrt(np.sum(left * left, axis=0) / self.df))


def residuals_of_groups(groups: Mapping[str, ArrayLike] | Sequence[ArrayLike]) -> Residuals:
    """Return values less the mean of their group, group after group; samples of shape (n_i,) in one unit.

    The standard deviation is pooled. Raises `InputRefused` for values that are missing or infinite.
    """
    given = {name: as_values(f"group {name!r}", values) for name, values in as_groups(groups).items()}
    read = read_groups(given)
    left, fitted = [], []
    for group in read.filled:
        scaled = read.scale.scaled(given[group.name])
        left += [read.scale.length(away, "a residual") for away in (scaled - group.mean).tolist()]
        fitted += [read.scale.place(group.mean)] * group.n
    df, none = read.df_within, Undefined(Reason.NO_GROUP_OF_TWO if left else Reason.NO_VALUE)
    sd = read.scale.length(math.sqrt(read.squares_within / df), _SD) if df else none
    if not all(isinstance(each, float) for each in left):
        raise InputRefused("a residual exceeds 1.8e308: change units.")
    known = tuple(each for each in left if isinstance(each, float))
    return Residuals(known, tuple(fitted), sd, df, read.sizes)


_SEED = 2021
_USUAL_DRAWS, _USUAL_NUMBERS, _MOST_NUMBERS = 4000, 4_000_000, 20_000_000


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
    )


def _band(residuals: Residuals, level: float) -> tuple[tuple[float, ...], ...] | Undefined:
    """Return low end, median and high end for each place, in the unit of the residuals, or why there is no band."""
    sd, n, tail = residuals.sd, len(residuals.values), (1.0 - level) / 2.0
    if isinstance(sd, Undefined):
        return sd
    if sd == 0.0:
        return Undefined(Reason.RESIDUALS_ZERO)
    if residuals.df == 1:
        return Undefined(Reason.ONE_SHAPE)
    # So many that the ends lie among them: the share beyond is then the tail, and no less.
    draws = max(min(_USUAL_DRAWS, _USUAL_NUMBERS // n), math.ceil(1.0 / tail)) if tail > 0.0 else math.inf
    if draws * n > _MOST_NUMBERS:
        return Undefined(Reason.TOO_MANY_DRAWS)
    drawn = residuals.of_noise(np.random.default_rng(_SEED).standard_normal((n, int(draws))))
    drawn.sort(axis=0)
    lines = np.quantile(drawn, (tail, 0.5, 1.0 - tail), axis=1, method="weibull")
    with np.errstate(over="ignore"):
        lines = sd * lines
    if not np.isfinite(lines).all():
        return Undefined(Reason.BAND_BEYOND_DOUBLES)
    return tuple(tuple(line.tolist()) for line in lines)


@dataclass(frozen=True, slots=True)
class RmseOverIqr(Result):
    """Error of a prediction in interquartile ranges of what was measured."""

    ratio: float | Undefined
    """`rmse` over `iqr`, dimensionless."""
    rmse: float | Undefined
    """Root of the mean squared difference, predicted minus measured, in the unit of the values."""
    iqr: float | Undefined
    """Upper minus lower quartile of the measured values, in their unit."""
    n: int
    """Number of pairs."""


def rmse_over_iqr(measured: ArrayLike, predicted: ArrayLike) -> RmseOverIqr:
    """Compare predictions with measurements, both of shape (n,), in one unit; quartiles are numpy's default.

    Raises `InputRefused` for no values, missing or infinite ones, or lengths that differ.
    """
    truth, guess = as_values("the measured values", measured), as_values("the predicted values", predicted)
    n = truth.size
    if n != guess.size or not n:
        raise InputRefused(
            f"there are {n} measured and {guess.size} predicted values: give one prediction for each "
            "measurement, and at least one."
        )
    scale = scale_of(truth, guess)
    measured_scaled, away = scale.scaled(truth), scale.scaled(guess) - scale.scaled(truth)
    rmse = math.sqrt(float(away @ away) / n)
    low, high = np.percentile(measured_scaled, (25.0, 75.0)).tolist()
    iqr = high - low
    return RmseOverIqr(
        ratio=finite(rmse / iqr, "the ratio") if iqr > 0.0 else Undefined(Reason.NO_QUARTILE_RANGE),
        rmse=scale.length(rmse, "the root mean square error"),
        iqr=scale.length(iqr, "the interquartile range"),
        n=n,
    )
