"""Whether the uncertainties of a predicted and a measured value account for their difference.

The difference is divided by the expanded uncertainty of both, the error ratio E_n of ISO 13528: of the measured value
the half width of its 95 % interval on the side of the prediction, of the prediction two standard uncertainties, added
in quadrature. They agree where the ratio lies within -1 to 1.
"""

from __future__ import annotations

import math

from data_schema.queries.results import NumberRow, ResultRow
from data_schema.vocabulary import Undefined
from labbook.analysis.results.result_cache import NewNumber, number
from reports.predicted import COVERAGE_FACTOR
from stats.exact.distributions import t_quantile

DIFFERENCE, RATIO = "difference", "error_ratio"
"""Names of numbers of a check: how what is predicted compares with what was measured."""


def agrees(result: ResultRow) -> bool | None:
    """Whether a check found agreement, None where it could not tell."""
    ratio = number(result, RATIO).value
    return None if ratio is None else abs(ratio) <= 1.0


def agreement(measured: NumberRow, value: float | Undefined, error: float | Undefined) -> tuple[NewNumber, NewNumber]:
    """Return the difference and the error ratio."""
    unit = measured.unit
    if isinstance(value, Undefined) or measured.value is None:
        none = value if isinstance(value, Undefined) else Undefined(measured.undefined_reason or "nothing was measured")
        return NewNumber(DIFFERENCE, none, unit), NewNumber(RATIO, none, "1")
    difference = value - measured.value
    return NewNumber(DIFFERENCE, difference, unit), NewNumber(RATIO, _ratio(measured, difference, error), "1")


def _ratio(measured: NumberRow, difference: float, error: float | Undefined) -> float | Undefined:
    end = measured.ci_high if difference > 0.0 else measured.ci_low
    if end is None or measured.value is None:
        return Undefined("the measured value has no interval")
    if isinstance(error, Undefined):
        return error
    expanded = math.hypot(_to_95_percent(measured) * (end - measured.value), COVERAGE_FACTOR * error)
    return difference / expanded if expanded > 0.0 else Undefined("neither value has an uncertainty")


def _to_95_percent(measured: NumberRow) -> float:
    """Return by what an interval of another level is multiplied to be one of 95 %."""
    if measured.df is None or measured.ci_level in (None, 0.95):
        return 1.0
    return t_quantile(0.95, measured.df) / t_quantile(measured.ci_level, measured.df)
