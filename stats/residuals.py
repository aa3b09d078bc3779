"""What a comparison of groups leaves unexplained, and how it lies beside the normal distribution that tests assume.

These are data for figures, to look at; they test nothing and have no sentence.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import special

from data_schema.errors import InputRefused
from data_schema.vocabulary import Undefined
from stats.checks import as_groups, as_level, as_sample
from stats.error_free import exact_root, scaled
from stats.finite import finite, refuse_beyond, times_power, to_double
from stats.sums import common_shift, moments, out_of_range

Floats = NDArray[np.float64]

_SD = "the residual standard deviation"
_SEED = 2021
_FEWEST_DRAWS, _MOST_DRAWS, _MOST_NUMBERS = 100, 4000, 4_000_000


@dataclass(frozen=True, slots=True)
class Residuals:
    """Values less what the model says of them, in the unit of the values and in their order."""

    values: tuple[float, ...]
    """Each value less what the model says of it."""
    fitted: tuple[float, ...]
    """What the model says of each."""
    sd: float | Undefined
    """Residual standard deviation."""
    df: int
    """Its degrees of freedom."""
    _basis: Floats = field(repr=False, compare=False)
    """Orthonormal columns that span what the model can fit, shape (n, n - df)."""


@dataclass(frozen=True, slots=True)
class NormalQuantiles:
    """Residuals in order beside the standard normal values that belong to their places; all of shape (n,)."""

    expected: tuple[float, ...]
    """Medians of the order statistics of n standard normal values."""
    observed: tuple[float, ...]
    """Residuals, from the lowest up."""
    low: tuple[float, ...] | Undefined
    """Where the band begins, in the unit of the residuals."""
    middle: tuple[float, ...] | Undefined
    """Its median: the line that residuals of normal values lie about."""
    high: tuple[float, ...] | Undefined
    """Where the band ends."""
    sd: float | Undefined
    """Residual standard deviation."""
    level: float
    """How often each residual, taken by itself, lies in the band where the values are normal."""


def residuals_of_groups(groups: Mapping[str, ArrayLike] | Sequence[ArrayLike]) -> Residuals:
    """Return values less the mean of their group, group after group; samples of shape (n_i,) in one unit.

    The standard deviation is pooled. Raises `InputRefused` for NaN or infinite values.
    """
    values: list[Fraction] = []
    fitted: list[float] = []
    sizes: dict[str, int] = {}
    squares, df = Fraction(0), 0
    for name, given in as_groups(groups).items():
        sample = as_sample(f"group {name!r}", given)
        if sample.values.size == 0:
            continue
        sizes[name] = sample.values.size
        about = moments(sample.values, rest=sample.rest)
        rest = np.zeros(about.n) if sample.rest is None else sample.rest
        values += [
            Fraction(float(value)) + Fraction(float(more)) - about.exact_mean
            for value, more in zip(sample.values, rest, strict=True)
        ]
        fitted += [about.mean] * about.n
        squares, df = squares + about.exact_sum_squares, df + about.n - 1
    sd = finite(exact_root(squares / df), _SD) if df else Undefined("no group has more than one value")
    left = tuple(map(to_double, values))
    refuse_beyond("a residual", map(abs, left))
    design = _dummies([name for name, size in sizes.items() for _ in range(size)])
    return Residuals(left, tuple(fitted), sd, df, design / np.sqrt(design.sum(axis=0)))


def additive_residuals(values: ArrayLike, condition: Sequence[str], day: Sequence[str]) -> Residuals:
    """Return values of shape (n,) less what condition and day add up to (least squares, both held fixed).

    Raises `InputRefused` for NaN, infinite values or labels of another length.
    """
    numbers = as_sample("values", values).values
    for name, labels in (("condition", condition), ("day", day)):
        if len(labels) != numbers.size:
            raise InputRefused(
                f"there are {numbers.size} values and {len(labels)} labels of {name}: give one label for each value."
            )
    exponent = out_of_range(numbers)
    numbers = scaled(numbers, -exponent)
    shift = common_shift(numbers) if numbers.size else 0.0
    design = np.concatenate([_dummies(condition), _dummies(day)], axis=1)
    left_vectors, singular, _right = np.linalg.svd(design, full_matrices=False)
    basis = left_vectors[:, singular > singular.max(initial=0.0) * numbers.size * np.finfo(np.float64).eps]
    fitted = basis @ (basis.T @ (numbers - shift))
    left = numbers - shift - fitted
    # What a fit without a rest leaves is rounding: 1e-16 is no scatter.
    left[np.abs(left) <= numbers.size * np.finfo(np.float64).eps * np.max(np.abs(numbers - shift), initial=0.0)] = 0.0
    df = numbers.size - basis.shape[1]
    sd: float | Undefined = Undefined("every value has a condition or a day of its own")
    if df:
        sd = finite(times_power(math.hypot(*left) / math.sqrt(df), exponent), _SD)
    residuals, said = ([times_power(number, exponent) for number in part.tolist()] for part in (left, shift + fitted))
    refuse_beyond("a residual or a fitted value", map(abs, [*residuals, *said]))
    return Residuals(tuple(residuals), tuple(said), sd, df, basis)


def _dummies(labels: Sequence[str]) -> Floats:
    _names, codes = np.unique(np.asarray(labels, dtype=object).astype(str), return_inverse=True)
    return np.asarray(np.eye(int(codes.max(initial=-1)) + 1)[codes])


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
