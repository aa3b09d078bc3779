"""Whether the uncertainties of a predicted and a measured value account for their difference.

The difference is divided by the expanded uncertainty of both, the error ratio E_n of ISO 13528: of the measured value
the half width of its 95 % interval on the side of the prediction, of the prediction two standard uncertainties, added
in quadrature. They agree where the ratio lies within -1 to 1.
"""

from __future__ import annotations

import math

from data_schema.vocabulary import Undefined
from reports.numbers import Number, Value
from reports.predicted import COVERAGE_FACTOR
from stats.exact.tails import t_quantile


def agreement(measured: Number, value: Value, error: Value) -> tuple[Number, Number]:
    """Return the difference and the error ratio."""
    if isinstance(value, Undefined) or isinstance(measured.value, Undefined):
        none = value if isinstance(value, Undefined) else measured.value
        return Number(none, measured.unit), Number(none, "1")
    difference = value - measured.value
    return Number(difference, measured.unit), Number(_ratio(measured, measured.value, difference, error), "1")


def _ratio(measured: Number, value: float, difference: float, error: Value) -> Value:
    end = measured.ci_high if difference > 0.0 else measured.ci_low
    if not isinstance(end, float):
        return Undefined("the measured value has no interval")
    if isinstance(error, Undefined):
        return error
    expanded = math.hypot(_to_95_percent(measured) * (end - value), COVERAGE_FACTOR * error)
    return difference / expanded if expanded > 0.0 else Undefined("neither value has an uncertainty")


def _to_95_percent(measured: Number) -> float:
    """Return by what an interval of another level is multiplied to be one of 95 %."""
    if not isinstance(measured.df, float) or measured.ci_level == 0.95:
        return 1.0
    return t_quantile(0.95, measured.df) / t_quantile(measured.ci_level, measured.df)
