"""What gains of the controller are in physical units: stiffness or damping as a line over the gain (thesis 5.1.1)."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from data_schema.vocabulary import Undefined
from stats.checks import Missing
from stats.lines.complete import complete_rows, refuse_few
from stats.lines.fit import Response
from stats.lines.regression import LinearFit, fit_linear
from stats.results import Result


@dataclass(frozen=True, slots=True)
class GainLine(Result):
    """Physical coefficient = slope * gain + offset."""

    slope: float
    """N/m (or kg/s) per unit of gain."""
    slope_se: float
    """Its standard error, in the unit of the slope."""
    slope_ci: tuple[float, float] | Undefined
    """Student's interval of the slope; undefined where the fit is exact."""
    offset: float
    """At gain 0, in N/m (or kg/s): what the mechanism has of its own."""
    offset_se: float
    """Its standard error, in N/m (or kg/s)."""
    offset_ci: tuple[float, float] | Undefined
    """Student's interval of the offset."""
    fit: LinearFit
    """All that least squares says of the line."""

    def at(self, gain: float, level: float = 0.95) -> Response:
        """Return the physical coefficient that a gain stands for, with the line's uncertainty there."""
        return self.fit.at({"gain": gain}, level)

    def sentence(self, what: str = "the coefficient", unit: str = "") -> str:
        """Return the line in words: both coefficients with intervals and p, R squared, residual SD, n."""
        return self.fit.sentence(what, unit)


def fit_gain_line(
    gain: ArrayLike, coefficient: ArrayLike, *, level: float = 0.95, missing: Missing = "refuse"
) -> GainLine:
    """Fit physical stiffness (N/m) or damping (kg/s) of several conditions over their gains, both of shape (n,).

    Raises `InputRefused` for fewer than 3 conditions, a single gain, lengths that differ, infinite values, for NaN
    unless `missing` is "drop" (which leaves out conditions), and where an uncertainty is beyond the doubles.
    """
    (gain, coefficient), left_out = complete_rows([gain, coefficient], missing)
    if np.shape(gain) == np.shape(coefficient):
        refuse_few(np.size(gain), "conditions", left_out)
    fit = fit_linear(coefficient, {"gain": gain}, level=level)
    (offset_se, slope_se), _sd = fit.spread("the line")
    offset_ci, slope_ci = fit.intervals()
    offset, slope = fit.coefficients
    return GainLine(
        slope=slope,
        slope_se=slope_se,
        slope_ci=slope_ci,
        offset=offset,
        offset_se=offset_se,
        offset_ci=offset_ci,
        fit=replace(fit, missing=left_out),
    )
