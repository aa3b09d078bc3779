"""What a leg's gains are in physical units: its stiffness and damping from oscillations of a mass (thesis 4.2.6)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace

import numpy as np
import scipy.optimize
import scipy.stats
from numpy.typing import NDArray

from data_schema.errors import InputRefused
from data_schema.reasons import Reason
from data_schema.rounding import number_text
from data_schema.units import STANDARD_GRAVITY_M_S2
from data_schema.vocabulary import Undefined
from stats.compare.summary import autocorrelation
from stats.lines.stiffness import (
    MINIMUM_POINTS,
    GainLine,
    Stiffness,
    fit_gain_line,
    fit_stiffness,
    force_points,
    velocity_over_rate,
)

Floats = NDArray[np.float64]
Condition = tuple[float | None, float, float]
"""Neutral length in m, gain and damping gain: what is fitted together, whatever the mass."""
FEWEST_GAINS = 3
TOGETHER = 1.25
"""Factor by which intervals are wider for residuals that go together, above which that is reported."""
_WEIGHINGS, _LEAST = 3, 1e-12
"""Fits with weights estimated anew, and the least spread in m and m/s, of data without errors."""
_FIXED_POINT = 30
_OTHER_UNIT = 3.0
"""Velocity over the rate of the position, or its inverse, from which on a unit is wrong."""


@dataclass(frozen=True, slots=True, eq=False)
class Oscillation:
    """One trajectory of a mass on the leg, from its displacement on; arrays of shape (n,).

    Displacement in m is positive the way the leg is compressed, velocity in m/s is its rate of change. `neutral_m` is
    the leg's length without load, None where the sheet does not say it.
    """

    file: str
    gain: float
    damping_gain: float
    neutral_m: float | None
    mass_kg: float
    time_s: Floats
    displacement_m: Floats
    velocity_m_s: Floats

    @property
    def condition(self) -> Condition:
        """What it is fitted together with."""
        return self.neutral_m, self.gain, self.damping_gain


@dataclass(frozen=True, slots=True)
class Coefficient:
    """A physical coefficient with its standard error and Student's interval."""

    value: float
    se: float
    ci: tuple[float, float]


@dataclass(frozen=True, slots=True)
class OfMass:
    """What the trajectories of one mass say of a condition, and the number of their points."""

    mass_kg: float
    n: int
    stiffness: Coefficient
    damping: Coefficient


@dataclass(frozen=True, slots=True)
class Plane:
    """The thesis's fit, forces by differences over position and velocity, with standard errors of such forces.

    Forces between three samples share the error of the one in the middle, which the errors of `fit` take into account.
    `bias` is what differences, and errors of position and velocity, put on stiffness and damping on the motion that was
    fitted. The intervals are without it: their middle is the coefficient less its bias. Both take the errors of samples
    for independent: there are no intervals where residuals go together.
    """

    fit: Stiffness
    bias: tuple[float, float]


@dataclass(frozen=True, slots=True, eq=False)
class FittedMotion:
    """One trajectory in the plane of force over compression, in N and m: as measured, and as fitted.

    Measured forces are differences of velocities, between samples; fitted ones stand at the samples.
    """

    mass_kg: float
    displacement_m: Floats
    force_n: Floats
    fitted_m: Floats
    fitted_n: Floats


@dataclass(frozen=True, slots=True)
class MeasuredGains:
    """One condition: its gains, and the leg's stiffness in N/m and damping in kg/s, of all masses and of each.

    `masses_left_out` says why masses in kg have no fit of their own. `residual_lag1` is the correlation of neighbouring
    velocities' residuals: above 0 the leg is no linear spring, or the log was smoothed. The intervals are `widened` by
    this factor, at most, for residuals that go together.
    """

    neutral_m: float | None
    gain: float
    damping_gain: float
    masses: tuple[OfMass, ...]
    masses_left_out: Mapping[float, str]
    trajectories: int
    n: int
    stiffness: Coefficient
    damping: Coefficient
    residual_lag1: float | Undefined
    widened: float
    plane: Plane
    motions: tuple[FittedMotion, ...]


@dataclass(frozen=True, slots=True)
class GainLines:
    """Of one neutral length: stiffness over gain and damping over damping gain; undefined with too few gains."""

    neutral_m: float | None
    stiffness: GainLine | Undefined
    damping: GainLine | Undefined


@dataclass(frozen=True, slots=True)
class Characterisation:
    """All conditions with enough points, the lines by neutral length, and the conditions left out with their points."""

    conditions: tuple[MeasuredGains, ...]
    lines: tuple[GainLines, ...]
    too_few: Mapping[Condition, int]
    level: float


def characterisation(oscillations: Sequence[Oscillation], level: float = 0.95) -> Characterisation:
    """Fit each condition's stiffness and damping, and the lines of physical coefficients over gains.

    The motion m x'' = m g - k x - d x' - F of a mass on the leg, from a start of its own for each trajectory, is fitted
    to the positions and the velocities, whose standard deviations are estimated with it: both have errors. Conditions
    with fewer than 250 points are left out. Raises `InputRefused` where none has as many, where a velocity is three
    times or more off the rate of the position, and where a motion is none of a mass on a spring and a damper.
    """
    for one in oscillations:
        _refuse_other_unit(one)
    by_condition: dict[Condition, list[Oscillation]] = {}
    for one in oscillations:
        by_condition.setdefault(one.condition, []).append(one)
    points = {key: sum(one.time_s.size for one in several) for key, several in by_condition.items()}
    enough = [key for key, count in points.items() if count >= MINIMUM_POINTS]
    if not enough:
        raise InputRefused(
            f"no condition has {MINIMUM_POINTS} points (thesis 4.2.6), the most is {max(points.values(), default=0)}: "
            "record more trajectories of each."
        )
    conditions = []
    for key in sorted(enough, key=lambda key: (key[0] or 0.0, *key[1:])):
        with _refused_as_no_spring(by_condition[key]):
            conditions.append(_measured(by_condition[key], level))
    lengths = dict.fromkeys(one.neutral_m for one in conditions)
    return Characterisation(
        conditions=tuple(conditions),
        lines=tuple(_lines([one for one in conditions if one.neutral_m == length], level) for length in lengths),
        too_few={key: count for key, count in points.items() if key not in enough},
        level=level,
    )


def _refuse_other_unit(one: Oscillation) -> None:
    """Refuse a velocity that is far off the rate of the position."""
    share = velocity_over_rate(one.time_s, one.displacement_m, one.velocity_m_s)
    if share is None or 1.0 / _OTHER_UNIT < share < _OTHER_UNIT:
        return
    off = f"{number_text(1.0 / share)} times smaller" if share < 1.0 else f"{number_text(share)} times larger"
    raise InputRefused(
        f"the velocity in {one.file} is {off} than the rate of the position: a unit in its header is likely wrong."
    )


@contextmanager
def _refused_as_no_spring(several: Sequence[Oscillation]) -> Iterator[None]:
    """Refuse trajectories whose fit comes to no finite number."""
    try:
        with np.errstate(all="ignore"):
            yield
    except (ArithmeticError, ValueError) as error:  # LinAlgError is a ValueError
        names = ", ".join(one.file for one in several[:3])
        raise InputRefused(
            f"{names}: no mass on a spring and a damper moves so; look at the units, and log from the release on."
        ) from error


@dataclass(frozen=True, slots=True, eq=False)
class _Fit:
    """Stiffness, damping and the force at no compression, the spreads of positions and velocities, and residuals.

    `inflation` is the long-run variance of either's residuals over their variance (`_long_run_over_variance`).
    """

    values: Floats
    inflation: Floats
    spreads: tuple[float, float]
    stiffness: Coefficient
    damping: Coefficient
    residuals: Sequence[Floats]


def _measured(several: Sequence[Oscillation], level: float) -> MeasuredGains:
    points = [_force_points(one) for one in several]
    plane = fit_stiffness(*(np.concatenate(column) for column in zip(*points, strict=True)), level=level)
    start = np.array([plane.stiffness_n_m, plane.damping_kg_s, plane.force_at_zero_n])
    if start[0] <= 0.0:
        raise InputRefused(
            f"the force does not rise with the compression in {several[0].file}: give positions that grow as it is "
            "compressed, and velocities that are their rate."
        )
    found = _fitted(several, start, (1.0, 1.0), level)
    for _ in range(_WEIGHINGS):
        weighed = found.spreads
        found = _fitted(several, found.values, weighed, level)
        if np.allclose(found.spreads, weighed, rtol=1e-3, atol=0.0):
            break
    first = several[0]
    masses, masses_left_out = _of_masses(several, found, level)
    return MeasuredGains(
        neutral_m=first.neutral_m,
        gain=first.gain,
        damping_gain=first.damping_gain,
        masses=masses,
        masses_left_out=masses_left_out,
        trajectories=len(several),
        n=sum(one.time_s.size for one in several),
        stiffness=found.stiffness,
        damping=found.damping,
        residual_lag1=autocorrelation(np.concatenate([of_one[1] for of_one in found.residuals])).r,
        widened=float(np.sqrt(found.inflation.max())),
        plane=_with_errors(plane, several, points, found),
        motions=tuple(
            _motion(one, residuals, found.values) for one, residuals in zip(several, found.residuals, strict=True)
        ),
    )


def _force_points(one: Oscillation) -> tuple[Floats, Floats, Floats]:
    """Return displacement, velocity and the leg's force between samples."""
    found = force_points(one.time_s, one.displacement_m, one.velocity_m_s, one.mass_kg)
    return found.displacement_m, found.velocity_m_s, found.force_n + one.mass_kg * STANDARD_GRAVITY_M_S2


def _of_masses(
    several: Sequence[Oscillation], pooled: _Fit, level: float
) -> tuple[tuple[OfMass, ...], dict[float, str]]:
    """Fit the trajectories of each mass alone, with the weights of all; also why masses have none."""
    found, left_out = [], dict[float, str]()
    for mass_kg in sorted({one.mass_kg for one in several}):
        same = [one for one in several if one.mass_kg == mass_kg]
        n = sum(one.time_s.size for one in same)
        if len(same) == len(several):
            return (OfMass(mass_kg, n, pooled.stiffness, pooled.damping),), {}
        try:
            with _refused_as_no_spring(same):
                alone = _fitted(same, pooled.values, pooled.spreads, level)
        except InputRefused as error:
            left_out[mass_kg] = str(error)
        else:
            found.append(OfMass(mass_kg, n, alone.stiffness, alone.damping))
    return tuple(found), left_out


def _fitted(several: Sequence[Oscillation], start: Floats, spreads: tuple[float, float], level: float) -> _Fit:
    """Fit k, d and F by least squares of residuals in their spreads; the starts of motion are projected out.

    Squares of positions and of velocities each have half of the degrees of freedom. Errors may go together along a
    trajectory: what they do to the coefficients is what independent errors of their long-run variance would, as both
    change slowly beside them. That leaves as many degrees of freedom as there are such independent errors.
    """
    scale = np.maximum(np.abs(start), (1.0, 0.1, 0.1))

    def left(shares: Floats) -> list[Floats]:
        k, d, force_n = (shares * scale).tolist()
        return [_left(one, k, d, force_n, spreads) for one in several]

    def flat(shares: Floats) -> Floats:
        return np.concatenate([of_one.ravel() for of_one in left(shares)])

    fit = scipy.optimize.least_squares(flat, start / scale, x_scale="jac")
    df = 2 * sum(one.time_s.size for one in several) - 3 - 2 * len(several)
    names = ", ".join(one.file for one in several[:3])
    if df < 1 or not np.linalg.matrix_rank(fit.jac) == start.size:
        raise InputRefused(f"the leg does not move enough in {names} to tell stiffness from damping: displace it more.")
    at_end = left(fit.x)
    bread = np.linalg.inv(fit.jac.T @ fit.jac)
    of_positions = np.concatenate([np.arange(one[0].size + one[1].size) < one[0].size for one in at_end])
    of_rows = [fit.jac[of_row].T @ fit.jac[of_row] for of_row in (of_positions, ~of_positions)]
    each_fitted = 2.0 + 3.0 / len(several)
    inflation = np.array(
        [
            _long_run_over_variance([one[row] for one in at_end], each_fitted * float(np.trace(bread @ of_row)) / 3.0)
            for row, of_row in enumerate(of_rows)
        ]
    )
    meat = inflation[0] * of_rows[0] + inflation[1] * of_rows[1]
    covariance = bread @ meat @ bread * 2.0 * fit.cost / df
    half = float(scipy.stats.t.ppf(0.5 + 0.5 * level, max(df / inflation.max(), 1.0)))
    stiffness, damping = (
        Coefficient(float(value), float(se), (float(value - half * se), float(value + half * se)))
        for value, se in zip((fit.x * scale)[:2], (np.sqrt(np.diag(covariance)) * scale)[:2], strict=True)
    )
    residuals = [of_one * np.array(spreads)[:, np.newaxis] for of_one in at_end]
    squares = (sum(float(of_one[row] @ of_one[row]) for of_one in residuals) for row in (0, 1))
    found = (max((2.0 * square / df) ** 0.5, _LEAST) for square in squares)
    return _Fit(fit.x * scale, inflation, (next(found), next(found)), stiffness, damping, residuals)


_HIGHEST_ORDER = 20
"""Of autoregressions that are tried: 67 ms at 300 Hz."""


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


def _with_errors(
    plane: Stiffness, several: Sequence[Oscillation], points: Sequence[tuple[Floats, Floats, Floats]], found: _Fit
) -> Plane:
    """Carry the errors of positions and velocities, which are independent, to the plane; measure its bias.

    With errors p and e of positions and velocities, step i has m/dt (e_i - e_{i+1}) - d/2 (e_i + e_{i+1})
    - k/2 (p_i + p_{i+1}) of force that is not the plane's. The bias is that of the fitted motion's plane to which the
    errors' squares were added, as they are expected.
    """
    k, d, _force_n = found.values.tolist()
    squares, meat, of_motion, rises = (np.zeros(shape) for shape in ((3, 3), (3, 3), (3, 3), 3))
    for one, of_one, residuals in zip(several, points, found.residuals, strict=True):
        design = np.stack([*of_one[:2], np.ones(of_one[0].size)], axis=1)
        squares += design.T @ design
        per_step = one.mass_kg / np.diff(one.time_s)[:, np.newaxis]
        for spread, before, after in zip(
            found.spreads, (-0.5 * k, per_step - 0.5 * d), (-0.5 * k, -per_step - 0.5 * d), strict=True
        ):
            of_samples = np.zeros((one.time_s.size, 3))
            of_samples[:-1] += design * before
            of_samples[1:] += design * after
            meat += spread**2 * of_samples.T @ of_samples
        still = replace(
            one, displacement_m=one.displacement_m - residuals[0], velocity_m_s=one.velocity_m_s - residuals[1]
        )
        position_m, velocity_m_s, force_n = _force_points(still)
        design = np.stack([position_m, velocity_m_s, np.ones(position_m.size)], axis=1)
        of_motion += design.T @ design + np.diag([*(0.5 * position_m.size * np.square(found.spreads)), 0.0])
        rises += design.T @ force_n
    inverse = np.linalg.inv(squares)
    errors = np.sqrt(np.diag(inverse @ meat @ inverse)).tolist()
    bias = (np.linalg.solve(of_motion, rises) - found.values)[:2].tolist()
    if not np.isfinite([*errors, *bias, found.stiffness.se, found.damping.se]).all():
        raise FloatingPointError
    half = float(scipy.stats.t.ppf(0.5 + 0.5 * plane.level, plane.df))
    intervals = [
        Undefined(Reason.RESIDUALS_TOGETHER)
        if found.inflation.max() > TOGETHER**2
        else (value - off - half * se, value - off + half * se)
        for value, off, se in zip((plane.stiffness_n_m, plane.damping_kg_s), bias, errors[:2], strict=True)
    ]
    fit = replace(
        plane,
        stiffness_se=errors[0],
        stiffness_ci=intervals[0],
        damping_se=errors[1],
        damping_ci=intervals[1],
        force_at_zero_se=errors[2],
    )
    return Plane(fit, (bias[0], bias[1]))


def _motion(one: Oscillation, residuals: Floats, values: Floats) -> FittedMotion:
    fitted_m, fitted_m_s = np.stack([one.displacement_m, one.velocity_m_s]) - residuals
    measured_m, _velocity, force_n = _force_points(one)
    fitted_n = values @ np.stack([fitted_m, fitted_m_s, np.ones(fitted_m.size)])
    return FittedMotion(one.mass_kg, measured_m, force_n, fitted_m, fitted_n)


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


def _lines(conditions: Sequence[MeasuredGains], level: float) -> GainLines:
    return GainLines(
        neutral_m=conditions[0].neutral_m,
        stiffness=_line([one.gain for one in conditions], [one.stiffness for one in conditions], level),
        damping=_line([one.damping_gain for one in conditions], [one.damping for one in conditions], level),
    )


def _line(gains: Sequence[float], found: Sequence[Coefficient], level: float) -> GainLine | Undefined:
    if len(set(gains)) < FEWEST_GAINS:
        return Undefined(Reason.TOO_FEW_GAINS, n=len(set(gains)), least=FEWEST_GAINS)
    errors = [one.se for one in found]
    weighted = errors if min(errors) > 0.0 else None
    return fit_gain_line(gains, [one.value for one in found], standard_error=weighted, level=level)
