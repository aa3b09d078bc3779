"""Figures 3.8, 3.9, 3.11, 3.12 (set 1) and 3.13 (set 2): jumps over what the thesis varied."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from simulator.gains import stiffness_n_m
from simulator.scene import Scene
from simulator.thesis.controllers import Pair
from simulator.thesis.jump_grid import Jumps, jumps_over
from simulator.thesis.ranges import (
    ACTIVE_DAMPINGS_KG_M,
    DRAG_SCALES,
    EXTENSION_GAINS,
    FOOT_RADII_M,
    GROUND_FACTORS,
    SIGMAS_N_M3,
    TOUCHDOWN_SPEEDS_M_S,
)

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class OverVelocity:
    """Jumps, shape (n,), over the downward speed at touchdown in m/s, shape (n,)."""

    touchdown_speed_m_s: FloatArray
    jumps: Pair[Jumps]


@dataclass(frozen=True, slots=True, eq=False)
class OverGround:
    """Jumps, shape (sigmas, drag scales), over `sigma` in N/m^3 and `b_g`."""

    sigma_n_m3: FloatArray
    drag_scale: FloatArray
    jumps: Pair[Jumps]


@dataclass(frozen=True, slots=True, eq=False)
class OverDamping:
    """Jumps, shape (stiffness factors, drag factors, extension stiffnesses, feet, coefficients).

    The first coefficient of active damping, kg/m, is 0: compression-extension. Gains, stiffnesses in N/m, radii in m
    and the factors on the ground's functions rise.
    """

    stiffness_factors: tuple[float, ...]
    drag_factors: tuple[float, ...]
    extension_gains: tuple[float, ...]
    extension_stiffnesses_n_m: tuple[float, ...]
    foot_radii_m: tuple[float, ...]
    active_damping_kg_m: FloatArray
    jumps: Jumps

    @property
    def saving(self) -> FloatArray:
        """Share of the cost that active damping saves, (CE - AD) / CE; the jumps' shape, 0 at the coefficient 0."""
        cost_j = self.jumps.cost_j
        return np.asarray(1.0 - cost_j / cost_j[..., :1])


def over_velocity(scene: Scene, accuracy: float) -> OverVelocity:
    """Simulate set 1 over the speed at which body and foot arrive."""
    speeds = TOUCHDOWN_SPEEDS_M_S
    return OverVelocity(speeds, _with_both(scene, {"initial_velocity": -speeds}, accuracy))


def over_ground(scene: Scene, accuracy: float) -> OverGround:
    """Simulate set 1 over the ground's depth-dependent stress and the scale of its drag."""
    grid = {"sigma": SIGMAS_N_M3[:, np.newaxis], "b_g": DRAG_SCALES[np.newaxis, :]}
    return OverGround(SIGMAS_N_M3, DRAG_SCALES, _with_both(scene, grid, accuracy))


def over_damping(scene: Scene, accuracy: float) -> OverDamping:
    """Simulate set 2 over active damping, feet, extension stiffnesses and scalings of the ground."""
    stiffnesses = tuple(stiffness_n_m(gain) for gain in EXTENSION_GAINS)
    factors, drags, extensions, feet, dampings = np.meshgrid(
        GROUND_FACTORS, GROUND_FACTORS, stiffnesses, FOOT_RADII_M, ACTIVE_DAMPINGS_KG_M, indexing="ij", sparse=True
    )
    values = {
        "kg_scale": factors,
        "bg_scale": drags,
        "k_extension": extensions,
        "foot_radius": feet,
        "b_ad": dampings,
    }
    return OverDamping(
        stiffness_factors=GROUND_FACTORS,
        drag_factors=GROUND_FACTORS,
        extension_gains=EXTENSION_GAINS,
        extension_stiffnesses_n_m=stiffnesses,
        foot_radii_m=FOOT_RADII_M,
        active_damping_kg_m=ACTIVE_DAMPINGS_KG_M,
        jumps=jumps_over(scene, values, accuracy),
    )


def _with_both(scene: Scene, grid: dict[str, FloatArray], accuracy: float) -> Pair[Jumps]:
    return Pair(
        ce=jumps_over(scene, {**grid, "b_ad": 0.0}, accuracy),
        ad=jumps_over(scene, {**grid, "b_ad": scene["b_ad"]}, accuracy),
    )
