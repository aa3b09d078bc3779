"""What the figures of the thesis's ch. 3 show, as their drawings take it; SI units, all arrays of floats.

CE is the compression-extension controller, AD active damping.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class GroundCurves:
    """Functions of the ground over depth, shape (n,), and the depth at which the cone under the foot is complete."""

    depth_m: FloatArray
    resistance_n: FloatArray
    drag_kg_m: FloatArray
    added_mass_kg: FloatArray
    cone_depth_m: float


@dataclass(frozen=True, slots=True, eq=False)
class JumpPath:
    """Body and toe of one jump over the time since touchdown, shape (n,); velocities are up positive."""

    time_s: FloatArray
    body_height_m: FloatArray
    toe_height_m: FloatArray
    toe_velocity_m_s: FloatArray
    switch_time_s: float
    liftoff_time_s: float


@dataclass(frozen=True, slots=True, eq=False)
class TwoPaths:
    """The same jump with either controller."""

    ce: JumpPath
    ad: JumpPath


@dataclass(frozen=True, slots=True, eq=False)
class EnergyCurves:
    """Mechanical energies of one jump (thesis 3.1.5) over the time since touchdown, shape (n,)."""

    time_s: FloatArray
    leg_spring_j: FloatArray
    body_kinetic_j: FloatArray
    body_gravity_j: FloatArray
    ground_spring_j: FloatArray
    foot_kinetic_j: FloatArray
    foot_gravity_j: FloatArray
    total_j: FloatArray
    switch_time_s: float
    liftoff_time_s: float


@dataclass(frozen=True, slots=True, eq=False)
class TwoEnergies:
    """Energies of the same jump with either controller."""

    ce: EnergyCurves
    ad: EnergyCurves


@dataclass(frozen=True, slots=True, eq=False)
class PowerMap:
    """Power of the ground on the foot, W (negative: lost), shape (velocities, depths), and the foot's paths over it."""

    depth_m: FloatArray
    velocity_m_s: FloatArray
    power_w: FloatArray
    paths: tuple[TwoPaths, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Measures:
    """What jumps cost and reach, arrays of one shape; `efficiency` is mechanical energy over cost. NaN is a gap."""

    cost_j: FloatArray
    efficiency: FloatArray
    apex_height_m: FloatArray
    mechanical_j: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class OverSpeed:
    """Measures, shape (n,), over the downward speed at touchdown."""

    speed_m_s: FloatArray
    ce: Measures
    ad: Measures


@dataclass(frozen=True, slots=True, eq=False)
class OverGrounds:
    """Measures, shape (stresses, drag scales), over `sigma` and `b_g`; the nominal ground is marked."""

    stress_n_m3: FloatArray
    drag_scale: FloatArray
    nominal_stress_n_m3: float
    nominal_drag_scale: float
    ce: Measures
    ad: Measures


@dataclass(frozen=True, slots=True, eq=False)
class DampingCosts:
    """Cost in J, shape (stiffness factors, drag factors, gains, feet, coefficients); the first coefficient is 0: CE."""

    stiffness_factors: tuple[float, ...]
    drag_factors: tuple[float, ...]
    extension_gains: tuple[float, ...]
    extension_stiffnesses_n_m: tuple[float, ...]
    foot_radii_m: tuple[float, ...]
    active_damping_kg_m: FloatArray
    cost_j: FloatArray
