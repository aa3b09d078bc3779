"""Figures 3.8, 3.9, 3.11, 3.12 (set 1) and 3.13 (set 2): jumps over what the thesis varied."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from simulator.gains import stiffness_n_m
from simulator.kernel.composition import compose
from simulator.kernel.layout import APEX, TOUCHDOWN
from simulator.scene import Scene
from simulator.sweep.chunks import recipe_of_rows, simulate_rows
from simulator.sweep.outputs import PLACE
from simulator.thesis.motions import Pair
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
BoolArray = NDArray[np.bool_]


@dataclass(frozen=True, slots=True, eq=False)
class Jumps:
    """One jump for each point of a grid; all arrays have the grid's shape, joules are those of the stance (Eq. 3.5).

    Where `jumped` is false the jump did not reach an apex, and every number of it is NaN: it is drawn as a gap.
    `ill_conditioned` jumps hang on a knife's edge of the sampled controller, or grow errors that much.
    """

    jumped: BoolArray
    ill_conditioned: BoolArray
    heat_j: FloatArray
    mechanical_j: FloatArray
    drag_j: FloatArray
    apex_height_m: FloatArray

    @property
    def cost_j(self) -> FloatArray:
        """Energetic cost of the jump, J (Eq. 3.5)."""
        return self.heat_j + self.mechanical_j + self.drag_j

    @property
    def efficiency(self) -> FloatArray:
        """Share of the cost that becomes mechanical energy."""
        return self.mechanical_j / self.cost_j


@dataclass(frozen=True, slots=True, eq=False)
class OverVelocity:
    """Jumps, shape (n,), over the downward speed at touchdown in m/s, shape (n,)."""

    touchdown_speed_m_s: FloatArray
    jumps: Pair[Jumps]


@dataclass(frozen=True, slots=True, eq=False)
class OverGround:
    """Jumps, shape (sigmas, drag scales), over `sigma` in N/m^3 and `b_g`, of which the scene's own are nominal."""

    sigma_n_m3: FloatArray
    drag_scale: FloatArray
    nominal_sigma_n_m3: float
    nominal_drag_scale: float
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
    return OverGround(SIGMAS_N_M3, DRAG_SCALES, scene["sigma"], scene["b_g"], _with_both(scene, grid, accuracy))


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


def jumps_over(scene: Scene, values: Mapping[str, ArrayLike], accuracy: float) -> Jumps:
    """Simulate a jump of the scene for each point of a grid: the parameters' arrays, broadcast against each other.

    Raises `UsageError` for a parameter that the scene does not read, or a value outside its box.
    """
    for name, given in values.items():
        for extreme in (np.min(given), np.max(given)):
            scene.changed({name: float(extreme)})
    recipe = recipe_of_rows(scene, accuracy)
    grid = np.broadcast_arrays(*(np.asarray(given, np.float64) for given in values.values()))
    names = [parameter.name for parameter in compose(scene.effects).parameters]
    table = np.tile(recipe.base, (grid[0].size, 1))
    for name, column in zip(values, grid, strict=True):
        table[:, names.index(name)] = column.ravel()
    rows = simulate_rows(recipe, table)[:, 0].reshape(*grid[0].shape, -1)
    jumped = np.isin(rows[..., PLACE["outcome"]], (APEX, TOUCHDOWN))

    def output(name: str) -> FloatArray:
        return np.where(jumped, rows[..., PLACE[name]], np.nan)

    return Jumps(
        jumped=jumped,
        ill_conditioned=rows[..., PLACE["ill_conditioned"]] == 1.0,
        heat_j=output("stance_heat_J"),
        mechanical_j=output("stance_mechanical_J"),
        drag_j=output("stance_drag_J"),
        apex_height_m=output("apex_height_m"),
    )
