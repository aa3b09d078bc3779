"""Errors of predictions: root mean squares over the interquartile range of what was measured.

The thesis has 0.63 for the cost estimated from forces (3.2.2).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from data_schema.errors import InputRefused
from data_schema.frozen import frozen
from data_schema.reasons import Reason
from data_schema.vocabulary import Undefined
from stats.checks import as_values
from stats.results import Result
from stats.scatter import finite, scale_of


@frozen
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
