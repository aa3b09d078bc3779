"""Stiffness and damping of a spring from the oscillations of masses on it, whose positions and velocities have errors.

The motion m x'' = m g - k x - d x' - F of each mass, from a start of its own, is fitted to positions and velocities at
once; the standard deviations of both are estimated with it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.optimize

from data_schema.errors import InputRefused
from data_schema.units import STANDARD_GRAVITY_M_S2
from stats.lines.regression import LinearFit
from stats.lines.stiffness import fit_stiffness, force_points
from stats.scatter import Floats, Interval
from stats.tails import t_quantile

_WEIGHINGS, _LEAST = 3, 1e-12
"""Fits with weights estimated anew, and the least spread in m and m/s, of data without errors."""
_FIXED_POINT = 30
_HIGHEST_ORDER = 20
"""Of autoregressions that are tried: 67 ms at 300 Hz."""


@dataclass(frozen=True, slots=True, eq=False)
class Oscillation:
    """One trajectory of a mass on the spring; arrays of shape (n,).

    Displacement in m is positive the way the spring is compressed, velocity in m/s is its rate of change.
    """

    mass_kg: float
    time_s: Floats
    displacement_m: Floats
    velocity_m_s: Floats

    def points(self) -> tuple[Floats, Floats, Floats]:
        """Return displacement, velocity and the spring's force in N between samples, of shape (n - 1,)."""
        place, velocity, force = force_points(self.time_s, self.displacement_m, self.velocity_m_s, self.mass_kg)
        return place, velocity, force + self.mass_kg * STANDARD_GRAVITY_M_S2


@dataclass(frozen=True, slots=True)
class Coefficient:
    """A physical coefficient with its standard error and Student's interval."""

    value: float
    se: float
    ci: Interval


@dataclass(frozen=True, slots=True, eq=False)
class OscillationFit:
    """What is fitted: stiffness in N/m, damping in kg/s, and the force in N at no compression.

    `spreads` are the standard deviations of positions and velocities; `residuals` has for each trajectory theirs, of
    shape (2, n). The intervals are `widened` by this factor, at most, as residuals go together along a trajectory.
    """

    stiffness: Coefficient
    damping: Coefficient
    force_at_zero_n: float
    spreads: tuple[float, float]
    widened: float
    residuals: Sequence[Floats]

    @property
    def values(self) -> tuple[float, float, float]:
        """Stiffness, damping, and the force at no compression."""
        return self.stiffness.value, self.damping.value, self.force_at_zero_n


def plane_of(several: Sequence[Oscillation]) -> LinearFit:
    """Fit the thesis's plane: forces by differences of velocities, over position and velocity (4.2.6)."""
    columns = zip(*(one.points() for one in several), strict=True)
    return fit_stiffness(*(np.concatenate(column) for column in columns))


def fit_oscillations(several: Sequence[Oscillation], plane: LinearFit, level: float = 0.95) -> OscillationFit:
    """Fit all trajectories together, from what the plane says on.

    Raises `InputRefused` where the motions do not tell stiffness from damping, and errors of numpy's where they are
    none of a mass on a spring.
    """
    force_n, stiffness_n_m, damping_kg_s = plane.coefficients
    found = fitted_with(several, (stiffness_n_m, damping_kg_s, force_n), (1.0, 1.0), level)
    for _ in range(_WEIGHINGS):
        weighed = found.spreads
        found = fitted_with(several, found.values, weighed, level)
        if np.allclose(found.spreads, weighed, rtol=1e-3, atol=0.0):
            break
    return found


def fitted_with(
    several: Sequence[Oscillation], start: Sequence[float], spreads: tuple[float, float], level: float
) -> OscillationFit:
    """Fit k, d and F by least squares of residuals in their spreads; the starts of motion are projected out.

    Squares of positions and of velocities each have half of the degrees of freedom. Errors may go together along a
    trajectory: what they do to the coefficients is what independent errors of their long-run variance would, as both
    change slowly beside them. That leaves as many degrees of freedom as there are such independent errors.
    """
    first = np.array(start)
    scale = np.maximum(np.abs(first), (1.0, 0.1, 0.1))

    def left(shares: Floats) -> list[Floats]:
        k, d, force_n = (shares * scale).tolist()
        return [_left(one, k, d, force_n, spreads) for one in several]

    def flat(shares: Floats) -> Floats:
        return np.concatenate([of_one.ravel() for of_one in left(shares)])

    fit = scipy.optimize.least_squares(flat, first / scale, x_scale="jac")
    df = 2 * sum(one.time_s.size for one in several) - 3 - 2 * len(several)
    if df < 1 or not np.linalg.matrix_rank(fit.jac) == first.size:
        raise InputRefused("the leg does not move enough to tell stiffness from damping: displace it more.")
    at_end = left(fit.x)
    bread = np.linalg.inv(fit.jac.T @ fit.jac)
    of_positions = np.concatenate([np.arange(one[0].size + one[1].size) < one[0].size for one in at_end])
    of_rows = [fit.jac[of_row].T @ fit.jac[of_row] for of_row in (of_positions, ~of_positions)]
    each_fitted = 2.0 + 3.0 / len(several)
    inflation = [
        _long_run_over_variance([one[row] for one in at_end], each_fitted * float(np.trace(bread @ of_row)) / 3.0)
        for row, of_row in enumerate(of_rows)
    ]
    meat = inflation[0] * of_rows[0] + inflation[1] * of_rows[1]
    covariance = bread @ meat @ bread * 2.0 * fit.cost / df
    half = t_quantile(level, max(df / max(inflation), 1.0))
    values, errors = (fit.x * scale).tolist(), (np.sqrt(np.diag(covariance)) * scale).tolist()
    stiffness, damping = (
        Coefficient(value, se, (value - half * se, value + half * se))
        for value, se in zip(values[:2], errors[:2], strict=True)
    )
    if not np.isfinite([*values, *errors]).all():
        raise FloatingPointError
    residuals = [of_one * np.array(spreads)[:, np.newaxis] for of_one in at_end]
    squares = [sum(float(of_one[row] @ of_one[row]) for of_one in residuals) for row in (0, 1)]
    positions, velocities = (max((2.0 * square / df) ** 0.5, _LEAST) for square in squares)
    widened = float(np.sqrt(max(inflation)))
    return OscillationFit(stiffness, damping, values[2], (positions, velocities), widened, residuals)


def _left(one: Oscillation, k: float, d: float, force_n: float, spreads: tuple[float, float]) -> Floats:
    """Return what the motion leaves of positions and velocities, in their spreads, shape (2, n); starts fitted."""
    time_s = one.time_s - one.time_s[0]
    decay, rest_m = d / (2.0 * one.mass_kg), (one.mass_kg * STANDARD_GRAVITY_M_S2 - force_n) / k
    turning = np.sqrt(complex(k / one.mass_kg - decay**2)) or 1e-12
    envelope = np.exp(-decay * time_s)
    cosine = (envelope * np.cos(turning * time_s)).real
    sine = (envelope * np.sin(turning * time_s) / turning).real
    from_place = np.stack([cosine + decay * sine, -(k / one.mass_kg) * sine])
    from_speed = np.stack([sine, cosine - decay * sine])
    weights = 1.0 / np.array(spreads)[:, np.newaxis]
    measured = np.stack([one.displacement_m - rest_m, one.velocity_m_s]) * weights
    design = np.stack([(from_place * weights).ravel(), (from_speed * weights).ravel()], axis=1)
    if not (np.isfinite(design).all() and np.isfinite(measured).all()):
        return np.full(measured.shape, np.inf)  # least_squares takes a smaller step
    starts, *_ = np.linalg.lstsq(design, measured.ravel(), rcond=None)
    return np.asarray(measured - (design @ starts).reshape(measured.shape))


def _long_run_over_variance(residuals: Sequence[Floats], fitted: float) -> float:
    """Return how much more the mean of residuals varies than if they were independent, at least 1.

    That is the long-run variance of an autoregression over the variance; its order has the least of Akaike's criterion
    (den Haan and Levin 1997). Residuals come in arrays of shape (n,), one a trajectory. Fitting `fitted` coefficients
    to each takes so many n-ths of the long-run variance from every autocovariance, which are put back.
    """
    n, mean_n = sum(one.size for one in residuals), float(np.mean([one.size for one in residuals]))
    lags = range(min(_HIGHEST_ORDER, min(one.size for one in residuals) // 4) + 1)
    raw = np.array([sum(float(one[lag:] @ one[: one.size - lag]) for one in residuals) for lag in lags])
    if not (np.isfinite(raw).all() and raw[0] > 0.0):
        return 1.0
    raw, variance, long_run = raw / raw[0], 1.0, 1.0
    for _ in range(_FIXED_POINT):
        variance = 1.0 + fitted / mean_n * long_run
        before, long_run = long_run, min(_of_autoregression(raw + variance - 1.0, n), mean_n / 2.0)
        if abs(long_run - before) < 1e-3 * before:
            break
    return max(long_run / variance, 1.0)


def _of_autoregression(covariances: Floats, n: int) -> float:
    """Return the long-run variance of the autoregression of the best order, by Levinson's recursion."""
    innovation, weights = float(covariances[0]), np.zeros(0)
    best, found = n * np.log(innovation), innovation
    for order in range(1, covariances.size):
        last = (covariances[order] - weights @ covariances[order - 1 : 0 : -1]) / innovation
        weights = np.append(weights - last * weights[::-1], last)
        innovation *= 1.0 - last**2
        if innovation <= 0.0 or weights.sum() >= 1.0:
            break
        if (criterion := n * np.log(innovation) + 2 * order) < best:
            best, found = criterion, innovation / (1.0 - weights.sum()) ** 2
    return float(found)
