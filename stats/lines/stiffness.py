"""What a commanded virtual spring really is: a plane through force over position and velocity (thesis 4.2.6).

Physical stiffness and damping of several gains then lie on a line each, k = 2.56 gain + 67.36 N/m and
d = 3.32 gain + 19.67 kg/s on the thesis's leg (5.1.1), with which gains become physical units.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.optimize
from numpy.typing import ArrayLike

from data_schema.errors import InputRefused
from data_schema.vocabulary import Undefined
from stats.checks import as_number, as_values
from stats.lines.regression import LinearFit, fit_linear
from stats.results import Result
from stats.scatter import Floats, Interval

MINIMUM_POINTS = 250
"""Thesis 4.2.6: planes were fitted only to conditions with at least this many points."""

_TOGETHER, _FEWEST_SAMPLES = 0.9, 20
"""Correlation of displacement and integrated velocity, and samples, from which on the two are compared."""


def force_points(
    time_s: ArrayLike, displacement_m: ArrayLike, velocity_m_s: ArrayLike, mass_kg: float
) -> tuple[Floats, Floats, Floats]:
    """Return displacement, velocity and the spring's force along one trajectory, each of shape (n - 1,).

    The force is minus the total mass times the rate of change of velocity.

    Displacement is positive the way the spring is compressed, velocity its rate of change; all of shape (n,). The
    force belongs between two samples, and so do the displacement and velocity returned: means of neighbours.
    Taken at the samples instead, the lag of half an interval would turn stiffness into damping (and damping into
    stiffness): 1.7 ms times k, 1 kg/s for 600 N/m at 300 Hz. Call it for each trajectory and put the points together.
    Raises `InputRefused` for fewer than 2 samples, lengths that differ, time that does not increase, or a mass of 0.
    """
    time, position = as_values("the times", time_s), as_values("the displacements", displacement_m)
    velocity = as_values("the velocities", velocity_m_s)
    mass = as_number("the mass", mass_kg, above=0.0)
    if not time.size == position.size == velocity.size or time.size < 2:
        raise InputRefused(
            f"there are {time.size} times, {position.size} displacements and {velocity.size} velocities: give one of "
            "each for at least 2 samples."
        )
    if (time[1:] <= time[:-1]).any():
        raise InputRefused("time does not increase from sample to sample: give one trajectory in order of time.")
    force = -mass * np.diff(velocity) / np.diff(time)
    return 0.5 * position[1:] + 0.5 * position[:-1], 0.5 * velocity[1:] + 0.5 * velocity[:-1], force


def velocity_over_rate(time_s: Floats, displacement_m: Floats, velocity_m_s: Floats) -> float | None:
    """Return how many times the velocity is the rate of change of the displacement, whatever its sign; of shape (n,).

    The displacement is compared with the velocity's integral, each without its straight line over time: its differences
    would be drowned by noise. Noise puts the ratio off by up to 1.2, three samples a period by up to 1.7. None where
    the two do not go together (a leg at rest), or for fewer than 20 samples.
    """
    if time_s.size < _FEWEST_SAMPLES:
        return None
    centred_s = time_s - time_s.mean()
    with np.errstate(all="ignore"):
        travelled_m = np.zeros(time_s.size)
        travelled_m[1:] = np.cumsum(0.5 * (velocity_m_s[1:] + velocity_m_s[:-1]) * np.diff(time_s))
        ways_m = np.stack([displacement_m, travelled_m])
        ways_m -= ways_m.mean(axis=1, keepdims=True)
        ways_m -= (ways_m @ centred_s / (centred_s @ centred_s))[:, np.newaxis] * centred_s
        moved, travelled = np.sqrt(np.sum(ways_m**2, axis=1)).tolist()
        product = abs(float(ways_m[0] @ ways_m[1]))
    return travelled / moved if product >= _TOGETHER * moved * travelled > 0.0 else None


def fit_stiffness(displacement_m: ArrayLike, velocity_m_s: ArrayLike, force_n: ArrayLike) -> LinearFit:
    """Fit the plane force = F0 + k * displacement + d * velocity to points of shape (n,), whatever their offset.

    Standard errors take neighbouring residuals as independent. Raises `InputRefused` for fewer than 250 points, values
    that are missing or infinite, and, naming the column, where displacement and velocity do not fix both coefficients:
    one of them constant, or one a multiple of the other.
    """
    force = as_values("the forces", force_n)
    if force.size < MINIMUM_POINTS:
        raise InputRefused(
            f"there are {force.size} points and the plane needs at least {MINIMUM_POINTS} (thesis 4.2.6): put the "
            "points of more trajectories together."
        )
    return fit_linear(force, {"displacement": displacement_m, "velocity": velocity_m_s})


@dataclass(frozen=True, slots=True)
class GainLine(Result):
    """Physical coefficient = slope * gain + offset."""

    slope: float
    """N/m (or kg/s) per unit of gain."""
    slope_se: float
    """Its standard error, in the unit of the slope."""
    slope_ci: Interval | Undefined
    """Student's interval of the slope; undefined where the fit is exact."""
    offset: float
    """At gain 0, in N/m (or kg/s): what the mechanism has of its own."""
    offset_se: float
    """Its standard error, in N/m (or kg/s)."""
    offset_ci: Interval | Undefined
    """Student's interval of the offset."""
    fit: LinearFit
    """All that least squares says of the line; with weights, of coefficients over their standard deviations."""
    gains: tuple[float, float]
    """Least and largest gain."""
    scatter_sd: float = 0.0
    """Standard deviation about the line beside the standard errors given, in N/m (or kg/s); 0 without them."""


def fit_gain_line(
    gain: ArrayLike,
    coefficient: ArrayLike,
    *,
    standard_error: ArrayLike | None = None,
    level: float = 0.95,
) -> GainLine:
    """Fit physical stiffness (N/m) or damping (kg/s) of several conditions over their gains, both of shape (n,).

    With standard errors, shape (n,), in the coefficients' unit, conditions weigh by the inverse of their variance: that
    of their error, and where they scatter more than their errors, a variance common to all, with which their squares
    about the line are as many as its degrees of freedom (Paule and Mandel 1982). Intervals are Student's, of the
    scatter about the line (Knapp and Hartung 2003).
    Raises `InputRefused` for fewer than 3 conditions, a single gain, lengths that differ, values that are missing or
    infinite, and for a standard error that is not above 0.
    """
    gains, values = as_values("the gains", gain), as_values("the coefficients", coefficient)
    scatter_sd, fit = 0.0, fit_linear(values, {"gain": gains}, level=level)
    fit.spread("the line")
    if standard_error is not None:
        error = as_values("the standard errors", standard_error)
        if gains.size != error.size or (error <= 0.0).any():
            raise InputRefused(
                f"there are {gains.size} gains and {error.size} standard errors: give one of each a condition, errors "
                "above 0."
            )
        scatter_sd = _scatter_sd(gains, values, error)
        weights = 1.0 / np.hypot(error, scatter_sd)
        columns = {"offset": weights, "gain": gains * weights}
        fit = fit_linear(values * weights, columns, intercept=False, level=level)
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
        fit=fit,
        gains=(float(gains.min()), float(gains.max())),
        scatter_sd=scatter_sd,
    )


def _scatter_sd(gains: Floats, values: Floats, errors: Floats) -> float:
    """Return the standard deviation with which the weighted squares about the line are its degrees of freedom."""

    def excess(sd: float) -> float:
        weights = 1.0 / np.hypot(errors, sd)
        columns = np.stack([weights, gains * weights], axis=1)
        solution, *_ = np.linalg.lstsq(columns, values * weights, rcond=None)
        return float(np.sum((values * weights - columns @ solution) ** 2)) - (gains.size - 2)

    if excess(0.0) <= 0.0:
        return 0.0
    return float(scipy.optimize.brentq(excess, 0.0, float(np.ptp(values)) * gains.size))
