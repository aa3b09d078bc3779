"""Root mean square error over the interquartile range (thesis 3.2.2: 0.63 for the cost estimated from forces)."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import ArrayLike, NDArray

from data_schema.errors import InputRefused, unknown_name
from data_schema.rounding import number_text
from data_schema.vocabulary import Undefined
from stats.checks import Missing, Sample, as_sample, complete_rows
from stats.exact.numbers import Floats, finite, greatest
from stats.results import Result, missing_text, with_unit

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
    ratio: float | Undefined = Undefined("the measured values have no interquartile range")
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
