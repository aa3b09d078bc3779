"""What is left unexplained: residuals of comparisons, data for figures to look at, which test nothing.

Errors of predictions are root mean squares over the interquartile range (thesis 3.2.2: 0.63 for the cost estimated from
forces).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import special

from data_schema.errors import InputRefused, unknown_name
from data_schema.reasons import Reason
from data_schema.rounding import level_text, number_text
from data_schema.vocabulary import Undefined
from stats.checks import Labels, Missing, Sample, as_groups, as_labels, as_level, as_sample, complete_rows
from stats.exact.numbers import (
    Floats,
    common_shift,
    exact_root,
    finite,
    greatest,
    moments,
    out_of_range,
    refuse_beyond,
    times_power,
    to_double,
)
from stats.results import Result, missing_text, plural, with_unit

_SD = "the residual standard deviation"


@dataclass(frozen=True, slots=True)
class Residual(Result):
    """One value less what the model says of it."""

    value: float
    """In the unit of the values."""
    fitted: float
    """What the model says, in the same unit."""


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
    _basis: Floats = field(repr=False, compare=False)
    """Orthonormal columns that span what the model can fit, shape (n, n - df)."""
    missing: int = 0
    """Values left out because they, or a label of theirs, were missing."""

    def of_noise(self, drawn: Floats) -> Floats:
        """Return what the same model leaves of values drawn, shape (n, draws), over the SD of each draw."""
        left = drawn - self._basis @ (self._basis.T @ drawn)
        return np.asarray(left / np.sqrt(np.sum(left * left, axis=0) / self.df))

    def rows(self) -> tuple[Residual, ...]:
        """Return each residual, for `to_frame`."""
        return tuple(map(Residual, self.values, self.fitted))

    def sentence(self) -> str:
        """Return in words how much the model leaves and how far that reaches."""
        n, left_out = len(self.values), missing_text(self.missing)
        if not n:
            return f"There are no residuals (n = 0{left_out})."
        low, high = min(self.values), max(self.values)
        what = f"reach from {number_text(low)} to {number_text(high)}" if low < high else f"are all {number_text(low)}"
        if isinstance(self.sd, Undefined):
            return f"The residuals {what} (n = {n}{left_out}); they have no SD, because {self.sd.reason}."
        return f"The residuals {what}, with SD {number_text(self.sd)} (df = {self.df}, n = {n}{left_out})."


def residuals_of_groups(
    groups: Mapping[str, ArrayLike] | Sequence[ArrayLike], missing: Missing = "refuse"
) -> Residuals:
    """Return values less the mean of their group, group after group; samples of shape (n_i,) in one unit.

    The standard deviation is pooled. Raises `InputRefused` for infinite values, and for NaN unless `missing` is "drop".
    """
    values: list[Fraction] = []
    fitted: list[float] = []
    sizes: dict[str, int] = {}
    squares, df, left_out = Fraction(0), 0, 0
    for name, given in as_groups(groups).items():
        sample = as_sample(f"group {name!r}", given, missing)
        left_out += sample.missing
        if sample.values.size == 0:
            continue
        sizes[name] = sample.values.size
        about = moments(sample.values, sample.rest)
        rest = np.zeros(about.n) if sample.rest is None else sample.rest
        values += [
            Fraction(float(value)) + Fraction(float(more)) - about.exact_mean
            for value, more in zip(sample.values, rest, strict=True)
        ]
        fitted += [about.mean] * about.n
        squares, df = squares + about.exact_sum_squares, df + about.n - 1
    none = Undefined(Reason.NO_GROUP_OF_TWO if values else Reason.NO_VALUE)
    sd = finite(exact_root(squares / df), _SD) if df else none
    left = tuple(map(to_double, values))
    refuse_beyond("a residual", map(abs, left))
    design = _dummies([name for name, size in sizes.items() for _ in range(size)])
    return Residuals(left, tuple(fitted), sd, df, design / np.sqrt(design.sum(axis=0)), left_out)


def additive_residuals(values: ArrayLike, condition: Labels, day: Labels, missing: Missing = "refuse") -> Residuals:
    """Return values of shape (n,) less what condition and day add up to (least squares, both held fixed).

    Raises `InputRefused` for infinite values, labels of another length, and for missing values or labels unless
    `missing` is "drop".
    """
    labels = {"condition": as_labels("condition", condition, missing), "day": as_labels("day", day, missing)}
    (values, *present), left_out = complete_rows([values, *labels.values()], missing)
    n = int(np.size(values))
    for name, of_each in zip(labels, present, strict=True):
        if of_each.size != n:
            raise InputRefused(
                f"there are {n} values and {of_each.size} labels of {name}: give one label for each value."
            )
    sample = as_sample("values", values)
    exponent = out_of_range(sample.values)
    numbers = np.ldexp(sample.values, -exponent)
    shift = common_shift(numbers) if numbers.size else 0.0
    numbers = numbers - shift
    if sample.rest is not None:
        numbers = numbers + np.ldexp(sample.rest, -exponent)
    design = np.concatenate([_dummies(of_each) for of_each in present], axis=1)
    left_vectors, singular, _right = np.linalg.svd(design, full_matrices=False)
    basis = left_vectors[:, singular > singular.max(initial=0.0) * numbers.size * np.finfo(np.float64).eps]
    fitted = basis @ (basis.T @ numbers)
    left = numbers - fitted
    # What a fit without a rest leaves is rounding: 1e-16 is no scatter.
    left[np.abs(left) <= numbers.size * np.finfo(np.float64).eps * np.max(np.abs(numbers), initial=0.0)] = 0.0
    df = numbers.size - basis.shape[1]
    sd: float | Undefined = Undefined(Reason.ALL_ALONE if numbers.size else Reason.NO_VALUE)
    if df:
        sd = finite(times_power(math.hypot(*left) / math.sqrt(df), exponent), _SD)
    residuals, fitted_values = (
        [times_power(number, exponent) for number in part.tolist()] for part in (left, shift + fitted)
    )
    refuse_beyond("a residual or a fitted value", map(abs, [*residuals, *fitted_values]))
    return Residuals(tuple(residuals), tuple(fitted_values), sd, df, basis, left_out)


def _dummies(labels: Sequence[object]) -> Floats:
    _names, codes = np.unique(np.asarray(labels, dtype=object).astype(str), return_inverse=True)
    return np.asarray(np.eye(int(codes.max(initial=-1)) + 1)[codes])


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
            return f"There is no band for n = {plural(n, 'residual')}{left_out}, because {outside.reason}."
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


QUARTILES: dict[str, Callable[[int, float], float]] = {
    "linear": lambda n, share: share * (n - 1),
    "median_unbiased": lambda n, share: share * (n + 1.0 / 3.0) - 2.0 / 3.0,
    "hazen": lambda n, share: share * n - 0.5,
    "weibull": lambda n, share: share * (n + 1) - 1.0,
}
"""Definitions of a quantile by name: where among n ordered values, counted from 0, it is read by interpolation.

"linear" is the default of numpy, scipy and R, with which published ratios were formed, and is therefore the default
here; "median_unbiased" (Hyndman and Fan 1996, their advice) is wider for few values: 6.46 for 5.63 on eight (W27).
"""


@dataclass(frozen=True, slots=True)
class RmseOverIqr(Result):
    """Error of a prediction in interquartile ranges of what was measured."""

    ratio: float | Undefined
    """`rmse` over `iqr`, dimensionless."""
    rmse: float | Undefined
    """Root of the mean squared difference, predicted minus measured, in the unit of the values."""
    iqr: float | Undefined
    """Upper minus lower quartile of the measured values, in their unit."""
    quartile_low: float
    """Lower quartile of the measured values, in their unit."""
    quartile_high: float
    """Upper quartile of the measured values, in their unit."""
    definition: str
    """Of the quartiles: a name of `QUARTILES`."""
    n: int
    """Number of pairs."""
    missing: int = 0
    """Pairs left out because a value was NaN."""

    def sentence(self, what: str = "the prediction", unit: str = "") -> str:
        """Return the error in words, with the definition of the quartiles and n."""
        ratio = number_text(self.ratio, 3)
        if isinstance(self.ratio, Undefined):
            ratio = f"undefined, because {self.ratio.reason}"
        return (
            f"RMSE of {what} {number_text(self.rmse)}{with_unit(unit)}, RMSE/IQR {ratio} (IQR of the measured values "
            f"{number_text(self.iqr)}{with_unit(unit)}, quartiles {self.definition.replace('_', '-')}, n = {self.n}"
            f"{missing_text(self.missing)})."
        )


def rmse_over_iqr(
    measured: ArrayLike, predicted: ArrayLike, *, definition: str = "linear", missing: Missing = "refuse"
) -> RmseOverIqr:
    """Compare predictions with measurements, both of shape (n,), in one unit.

    Differences are taken whatever the input's type, of decimals as they are written, and scaled before squaring: int16
    and 1e200 are right (W25), and neither ratio nor error loses a digit to an offset. Raises `UnknownName` for another
    definition, `InputRefused` for no values, infinite ones, NaN unless `missing` is "drop" (which leaves out pairs), or
    lengths that differ.
    """
    if definition not in QUARTILES:
        raise unknown_name("definition of quartiles", definition, QUARTILES)
    (measured, predicted), left_out = complete_rows([measured, predicted], missing)
    truth, guess = as_sample("the measured values", measured), as_sample("the predicted values", predicted)
    n = truth.values.size
    if n != guess.values.size or not n:
        raise InputRefused(
            f"there are {n} measured and {guess.values.size} predicted values: give one prediction for each "
            "measurement, and at least one."
        )
    rmse = _root_mean_square(*_differences(truth, guess))
    order = np.lexsort((_rest(truth), truth.values))
    low, high = (_quantile(truth, order, share, definition) for share in (0.25, 0.75))
    iqr = high - low
    ratio: float | Undefined = Undefined(Reason.NO_QUARTILE_RANGE)
    if iqr > 0:
        ratio = finite(rmse / iqr, "the ratio")
    return RmseOverIqr(
        ratio=ratio,
        rmse=finite(rmse, "the root mean square error"),
        iqr=finite(iqr, "the interquartile range"),
        quartile_low=float(low),
        quartile_high=float(high),
        definition=definition,
        n=n,
        missing=left_out,
    )


def _differences(truth: Sample, guess: Sample) -> tuple[Floats, int]:
    """Return guess minus truth in units of a power of two, each rounded once, and that power."""
    exponent = 2 if max(greatest(truth.values), greatest(guess.values)) > 2.0**1000 else 0
    far = np.ldexp(guess.values, -exponent) - np.ldexp(truth.values, -exponent)
    return far + np.ldexp(_rest(guess) - _rest(truth), -exponent), exponent


def _root_mean_square(values: Floats, exponent: int) -> Fraction:
    largest = math.frexp(greatest(values))[1]
    values = np.ldexp(values, -largest)
    return Fraction(math.sqrt(math.fsum(values * values) / values.size)) * Fraction(2) ** (largest + exponent)


def _rest(sample: Sample) -> Floats:
    return np.zeros(sample.values.size) if sample.rest is None else sample.rest


def _quantile(sample: Sample, order: NDArray[np.intp], share: float, definition: str) -> Fraction:
    place = min(max(QUARTILES[definition](order.size, share), 0.0), order.size - 1.0)
    below = int(place)
    low, high = (
        Fraction(float(sample.values[i])) + Fraction(float(_rest(sample)[i]))
        for i in order[[below, min(below + 1, order.size - 1)]]
    )
    return low + Fraction(place - below) * (high - low)
