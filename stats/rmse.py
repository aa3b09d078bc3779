"""Root mean square error over the interquartile range (thesis 3.2.2: 0.63 for the cost estimated from forces)."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from data_schema.errors import InputRefused, unknown_name
from data_schema.vocabulary import Undefined
from stats.checks import as_values
from stats.double_double import Floats
from stats.error_free import scaled
from stats.wording import number_text, with_unit

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
class RmseOverIqr:
    """Error of a prediction in interquartile ranges of what was measured."""

    ratio: float | Undefined
    rmse: float
    """Root of the mean squared difference, predicted minus measured, in the unit of the values."""
    iqr: float
    """Upper minus lower quartile of the measured values."""
    quartile_low: float
    quartile_high: float
    definition: str
    """Of the quartiles: a name of `QUARTILES`."""
    n: int

    def sentence(self, what: str = "the prediction", unit: str = "") -> str:
        """Return the error in words, with the definition of the quartiles and n."""
        ratio = number_text(self.ratio, 3)
        if isinstance(self.ratio, Undefined):
            ratio = f"undefined, because {self.ratio.reason}"
        return (
            f"RMSE of {what} {number_text(self.rmse)}{with_unit(unit)}, RMSE/IQR {ratio} (IQR of the measured values "
            f"{number_text(self.iqr)}{with_unit(unit)}, quartiles {self.definition.replace('_', '-')}, n = {self.n})."
        )


def rmse_over_iqr(measured: ArrayLike, predicted: ArrayLike, *, definition: str = "linear") -> RmseOverIqr:
    """Compare predictions with measurements, both of shape (n,), in one unit.

    Differences are taken as doubles whatever the input's type and scaled before squaring: int16 and 1e200 are right
    (W25). Raises `UnknownName` for another definition, `InputRefused` for no values, NaN or infinite ones, or
    lengths that differ.
    """
    if definition not in QUARTILES:
        raise unknown_name("definition of quartiles", definition, QUARTILES)
    truth, guess = as_values("the measured values", measured), as_values("the predicted values", predicted)
    if truth.size != guess.size or not truth.size:
        raise InputRefused(
            f"there are {truth.size} measured and {guess.size} predicted values: give one prediction for each "
            "measurement, and at least one."
        )
    exponent = math.frexp(max(float(np.abs(truth).max()), float(np.abs(guess).max())))[1] + 1
    truth, guess = scaled(truth, -exponent), scaled(guess, -exponent)
    differences = guess - truth
    largest = math.frexp(float(np.abs(differences).max()))[1]
    differences = scaled(differences, -largest)
    rmse = math.sqrt(math.fsum(differences * differences) / truth.size)
    ordered = np.sort(truth)
    low, high = (_quantile(ordered, share, definition) for share in (0.25, 0.75))
    iqr = high - low
    ratio: float | Undefined = Undefined("the measured values have no interquartile range")
    if iqr > 0.0:
        ratio = math.ldexp(rmse / iqr, largest)
    return RmseOverIqr(
        ratio=ratio,
        rmse=math.ldexp(rmse, largest + exponent),
        iqr=math.ldexp(iqr, exponent),
        quartile_low=math.ldexp(low, exponent),
        quartile_high=math.ldexp(high, exponent),
        definition=definition,
        n=truth.size,
    )


def _quantile(ordered: Floats, share: float, definition: str) -> float:
    place = min(max(QUARTILES[definition](ordered.size, share), 0.0), ordered.size - 1.0)
    below = int(place)
    above = min(below + 1, ordered.size - 1)
    return float(ordered[below] + (place - below) * (ordered[above] - ordered[below]))
