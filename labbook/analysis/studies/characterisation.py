"""What a leg's gains are in physical units: its stiffness and damping from oscillations of a mass (thesis 4.2.6)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import scipy.optimize
import scipy.stats
from numpy.typing import NDArray

from data_schema.errors import InputRefused
from data_schema.reasons import Reason
from data_schema.units import STANDARD_GRAVITY_M_S2
from data_schema.vocabulary import Undefined
from stats.compare.summary import autocorrelation
from stats.lines.stiffness import MINIMUM_POINTS, GainLine, Stiffness, fit_gain_line, fit_stiffness, force_points

Floats = NDArray[np.float64]
Condition = tuple[float | None, float, float]
"""Neutral length in m, gain and damping gain: what is fitted together, whatever the mass."""
FEWEST_GAINS = 3
_WEIGHINGS, _LEAST = 3, 1e-12
"""Fits with weights estimated anew, and the least spread in m and m/s, of data without errors."""


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
class MeasuredGains:
    """One condition: its gains, and the leg's stiffness in N/m and damping in kg/s.

    `residual_lag1` is the correlation of neighbouring velocities' residuals: above 0 the leg is no linear spring
    and the intervals are too short. `plane` is the thesis's fit to forces by differences, errors shared by neighbours.
    """

    neutral_m: float | None
    gain: float
    damping_gain: float
    masses_kg: tuple[float, ...]
    trajectories: int
    n: int
    stiffness: Coefficient
    damping: Coefficient
    residual_lag1: float | Undefined
    plane: Stiffness


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
    with fewer than 250 points are left out. Raises `InputRefused` where none has as many.
    """
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
    conditions = tuple(
        _measured(by_condition[key], level) for key in sorted(enough, key=lambda key: (key[0] or 0.0, *key[1:]))
    )
    lengths = dict.fromkeys(one.neutral_m for one in conditions)
    return Characterisation(
        conditions=conditions,
        lines=tuple(_lines([one for one in conditions if one.neutral_m == length]) for length in lengths),
        too_few={key: count for key, count in points.items() if key not in enough},
        level=level,
    )


def _measured(several: Sequence[Oscillation], level: float) -> MeasuredGains:
    forces = [force_points(one.time_s, one.displacement_m, one.velocity_m_s, one.mass_kg) for one in several]
    weights_n = [one.mass_kg * STANDARD_GRAVITY_M_S2 for one in several]
    columns = (
        [one.displacement_m for one in forces],
        [one.velocity_m_s for one in forces],
        [one.force_n + weight_n for one, weight_n in zip(forces, weights_n, strict=True)],
    )
    plane = fit_stiffness(*(np.concatenate(column) for column in columns), level=level)
    stiffness, damping, lag1 = _fitted(several, plane, level)
    first = several[0]
    return MeasuredGains(
        neutral_m=first.neutral_m,
        gain=first.gain,
        damping_gain=first.damping_gain,
        masses_kg=tuple(sorted({one.mass_kg for one in several})),
        trajectories=len(several),
        n=sum(one.time_s.size for one in several),
        stiffness=stiffness,
        damping=damping,
        residual_lag1=lag1,
        plane=plane,
    )


def _fitted(
    several: Sequence[Oscillation], plane: Stiffness, level: float
) -> tuple[Coefficient, Coefficient, float | Undefined]:
    """Fit k, d and F by least squares, from the plane's on; starts are linear and projected out.

    The standard deviations of positions and velocities weigh them; they are estimated anew after each fit.
    """
    start = np.array([plane.stiffness_n_m, plane.damping_kg_s, plane.force_at_zero_n])
    if start[0] <= 0.0:
        raise InputRefused(
            f"the force does not rise with the compression in {several[0].file}: give positions that grow as it is "
            "compressed, and velocities that are their rate."
        )
    scale = np.maximum(np.abs(start), (1.0, 0.1, 0.1))

    def left(shares: Floats, spreads: tuple[float, float]) -> Floats:
        k, d, force_n = (shares * scale).tolist()
        return np.concatenate([_left(one, k, d, force_n, spreads) for one in several], axis=1)

    shares = start / scale
    for _ in range(_WEIGHINGS):
        parts = left(shares, (1.0, 1.0))
        spreads = max(float(np.std(parts[0])), _LEAST), max(float(np.std(parts[1])), _LEAST)
        fit = scipy.optimize.least_squares(lambda tried, of=spreads: left(tried, of).ravel(), shares, x_scale="jac")
        shares = fit.x
    points = sum(one.time_s.size for one in several)
    df = 2 * points - 3 - 2 * len(several)
    try:
        covariance = np.linalg.inv(fit.jac.T @ fit.jac) * 2.0 * fit.cost / df
    except np.linalg.LinAlgError:
        names = ", ".join(one.file for one in several[:3])
        raise InputRefused(
            f"the leg does not move enough in {names} to tell stiffness from damping: displace it more."
        ) from None
    half = float(scipy.stats.t.ppf(0.5 + 0.5 * level, df))
    found = [
        Coefficient(float(value), float(se), (float(value - half * se), float(value + half * se)))
        for value, se in zip((shares * scale)[:2], (np.sqrt(np.diag(covariance)) * scale)[:2], strict=True)
    ]
    return found[0], found[1], autocorrelation(left(shares, (1.0, 1.0))[1]).r


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
    starts, *_ = np.linalg.lstsq(design, measured.ravel(), rcond=None)
    return np.asarray(measured - (design @ starts).reshape(measured.shape))


def _lines(conditions: Sequence[MeasuredGains]) -> GainLines:
    return GainLines(
        neutral_m=conditions[0].neutral_m,
        stiffness=_line([one.gain for one in conditions], [one.stiffness.value for one in conditions]),
        damping=_line([one.damping_gain for one in conditions], [one.damping.value for one in conditions]),
    )


def _line(gains: Sequence[float], values: Sequence[float]) -> GainLine | Undefined:
    if len(set(gains)) < FEWEST_GAINS:
        return Undefined(Reason.TOO_FEW_GAINS, n=len(set(gains)), least=FEWEST_GAINS)
    return fit_gain_line(gains, values)
