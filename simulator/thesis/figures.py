"""The data of all figures of ch. 3 that a simulation can make, each computed when it is first asked for.

The text says what is varied but gives no range, so the ranges are assumed: round the nominal values, and for figure
3.13 those of the experiments that it predicts. A claim can hold over one range and fail over a wider one.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Generic, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from simulator.gains import stiffness_n_m
from simulator.jump import simulate
from simulator.kernel.composition import compose
from simulator.kernel.layout import APEX, FLIGHT, TOUCHDOWN
from simulator.parameter import GRAVITY_M_S2
from simulator.scene import Scene
from simulator.scene_file import load_scene
from simulator.sweep.chunks import PLACE, recipe_of_rows, simulate_rows

FloatArray = NDArray[np.float64]

DEEPEST_M = 0.08
"""Depth to which the ground's functions are drawn (figures 3.2, 3.6): a little deeper than the feet of set 1 get."""
FASTEST_M_S = 1.2
"""Downward speed of the foot to which the power surface is drawn (figure 3.6)."""
SAMPLE_SPEEDS_M_S = (0.2, 0.6, 1.0)
"""Downward speeds at touchdown of the sample jumps of figure 3.6: the text's own, and two slower ones. From 1.15 m/s on
the guard against short legs ends the compression early."""
TOUCHDOWN_SPEEDS_M_S: FloatArray = np.linspace(0.2, 2.0, 37)
"""Downward speeds at touchdown (figures 3.8, 3.9): drops from 2 mm to 20 cm."""

_HALF_TO_TWICE: FloatArray = np.geomspace(0.5, 2.0, 17)
SIGMAS_N_M3: FloatArray = 1.2e5 * _HALF_TO_TWICE
DRAG_SCALES: FloatArray = 17.2 * _HALF_TO_TWICE
"""`sigma` and `b_g`, half to twice those of poppy seeds (figures 3.11, 3.12)."""

FOOT_RADII_M = (0.03, 0.038, 0.051)
"""The foot published with the simulations, and both of the experiments they accompany (thesis 5.1.1; figure 3.13)."""
EXTENSION_GAINS = (300.0, 400.0)
"""The experiments' soft and stiff gain (thesis 5.1.1)."""
GROUND_FACTORS = (0.5, 1.0, 2.0)
"""Factors on the ground's stiffness and, crossed with them, on its drag."""
ACTIVE_DAMPINGS_KG_M: FloatArray = np.linspace(0.0, 500.0, 26)
"""Coefficients of active damping; from about 600 kg/m on its 1 kHz sampling lifts the foot off a compressed leg."""


BoolArray = NDArray[np.bool_]
_SAME_TIME_S = 1e-12
T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Pair(Generic[T]):
    """The same thing with compression-extension (CE) and with active damping (AD)."""

    ce: T
    ad: T


def both_controllers(scene: Scene) -> Pair[Scene]:
    """Return the scene of set 1 without and with active damping; it is shipped with (thesis 3.2)."""
    return Pair(ce=scene.changed({"b_ad": 0.0}), ad=scene)


@dataclass(frozen=True, slots=True, eq=False)
class Motion:
    """One jump from touchdown to the next; arrays of shape (n,), heights above the undisturbed surface, up positive.

    At an event two samples share one time. `extending` is the controller's phase in stance, `flying` the time after
    lift-off; joules are sums since touchdown. The ground jams `jams` times: the foot stops in it.
    """

    time_s: FloatArray
    body_height_m: FloatArray
    body_velocity_m_s: FloatArray
    foot_height_m: FloatArray
    foot_velocity_m_s: FloatArray
    body_acceleration_m_s2: FloatArray
    leg_work_j: FloatArray
    ground_loss_j: FloatArray
    grain_energy_j: FloatArray
    extending: BoolArray
    flying: BoolArray
    switch_time_s: float
    liftoff_time_s: float
    jams: int

    @property
    def depth_m(self) -> FloatArray:
        """Return the greatest depth of the foot in stance so far, m: how deep the ground is pressed."""
        return np.asarray(np.maximum.accumulate(np.where(self.flying, 0.0, np.maximum(-self.foot_height_m, 0.0))))

    def at_switch(self, values: FloatArray) -> float:
        """Return what a quantity is at the controller's first switch to extension."""
        return float(np.interp(self.switch_time_s, self.time_s, values))


_COLUMNS = {
    "time_s": "time",
    "body_height_m": "body_height",
    "body_velocity_m_s": "body_velocity",
    "foot_height_m": "foot_height",
    "foot_velocity_m_s": "foot_velocity",
    "body_acceleration_m_s2": "body_acceleration",
    "leg_work_j": "leg_work",
    "ground_loss_j": "ground_loss",
    "grain_energy_j": "grain_energy",
}
"""Arrays of a motion, and the sampled variables that they are."""


def motion_of(scene: Scene, accuracy: float) -> Motion:
    """Simulate a jump of a scene on grains with the sampled, unlatched controller, and keep its motion."""
    result = simulate(scene, accuracy, trajectory=True)
    motion, jump = result.trajectory, result.jump
    if motion is None or jump.liftoff_time_s is None:
        raise RuntimeError(f"{scene.name} does not leave the ground, and has no motion to draw")
    columns = {name: motion[of].to_numpy() for name, of in _COLUMNS.items()}
    flying = motion["mode"].to_numpy() == FLIGHT
    extending = _extending(scene, columns) & ~flying
    return Motion(
        **columns,
        extending=extending,
        flying=flying,
        switch_time_s=float(columns["time_s"][np.argmax(extending)]),
        liftoff_time_s=jump.liftoff_time_s,
        jams=sum(change.after == "jammed" for change in jump.mode_changes),
    )


def sample_motions(scene: Scene, touchdown_speed_m_s: float, accuracy: float) -> Pair[Motion]:
    """Simulate one jump with either controller, body and foot arriving at this downward speed."""
    started = both_controllers(scene.changed({"initial_velocity": -touchdown_speed_m_s}))
    return Pair(ce=motion_of(started.ce, accuracy), ad=motion_of(started.ad, accuracy))


def _extending(scene: Scene, columns: dict[str, FloatArray]) -> BoolArray:
    """Decide each tick's phase by the published rule from the state at that tick; it is held until the next.

    Steps land on the ticks at which the phase changes, so that nothing that decides is interpolated.
    """
    time_s, tick_s = columns["time_s"], 1.0 / scene["control_rate"]
    ticks_s = np.arange(int(time_s[-1] / tick_s) + 1) * tick_s
    body_m, foot_m, body_m_s, foot_m_s = (
        np.interp(ticks_s, time_s, columns[name])
        for name in ("body_height_m", "foot_height_m", "body_velocity_m_s", "foot_velocity_m_s")
    )
    rule = (body_m_s > foot_m_s) & (foot_m < 0.0) & (body_m_s > 0.0)
    phase = rule | (body_m - foot_m < scene["guard_length"])
    # Of the samples that share a tick's time, the first ends the step before it, in the phase before.
    ends_step = np.append(np.diff(time_s) < _SAME_TIME_S, False)
    tick = np.searchsorted(ticks_s, time_s + np.where(ends_step, -1.0, 1.0) * _SAME_TIME_S, side="right") - 1
    return np.asarray(phase[np.maximum(tick, 0)])


_POINTS, _SURFACE_POINTS = 401, 161


@dataclass(frozen=True, slots=True, eq=False)
class GroundFunctions:
    """K(z) in N, D(z) in N / (m/s)^2 and m_a(z) in kg at the depths z in m; all of shape (n,).

    The cone of grains under the foot is complete at `cone_depth_m`.
    """

    depth_m: FloatArray
    resistance_n: FloatArray
    drag_kg_m: FloatArray
    added_mass_kg: FloatArray
    cone_depth_m: float


def ground_functions(scene: Scene, depth_m: FloatArray | None = None) -> GroundFunctions:
    """Tabulate the ground's functions of a scene, by default at depths from the surface to `DEEPEST_M`."""
    depths = np.linspace(0.0, DEEPEST_M, _POINTS) if depth_m is None else np.asarray(depth_m, np.float64)
    radius_m = scene["foot_radius"]
    slope = scene["mu"] / math.tan(scene["cone_angle"])
    formed_m = np.clip(depths, 0.0, radius_m / slope)
    foot_m2 = math.pi * radius_m**2
    flat_m2 = math.pi * (radius_m - slope * formed_m) ** 2
    cone_m3 = math.pi * formed_m * (radius_m**2 - slope * radius_m * formed_m + slope**2 * formed_m**2 / 3.0)
    recruited_kg_m3 = scene["phi"] * scene["rho"] * scene["mu"]
    # An area and a volume are added, dimensionally odd, as in the author's code and every published number.
    stress_n_m2 = scene["sigma"] / math.cos(scene["cone_angle"]) * depths
    return GroundFunctions(
        depth_m=depths,
        resistance_n=scene["kg_scale"] * (scene["k_sh"] * cone_m3 / foot_m2 + stress_n_m2 * (foot_m2 + cone_m3)),
        drag_kg_m=scene["bg_scale"]
        * (scene["b_g"] * scene["c_g"])
        * (recruited_kg_m3 * flat_m2 + scene["added_mass_constant"]),
        added_mass_kg=recruited_kg_m3 * cone_m3 + scene["added_mass_constant"] * depths,
        cone_depth_m=radius_m / slope,
    )


@dataclass(frozen=True, slots=True, eq=False)
class PowerSurface:
    """Power in W, shape (velocities, depths), over depth in m and downward velocity of the foot in m/s (negative).

    `motions` start at the downward speeds `SAMPLE_SPEEDS_M_S`.
    """

    depth_m: FloatArray
    velocity_m_s: FloatArray
    power_w: FloatArray
    motions: tuple[Pair[Motion], ...]


def power_surface(scene: Scene, accuracy: float) -> PowerSurface:
    """Compute the surface -D(z) |v|^3 - K(z) |v| of a scene and the paths of three jumps with either controller."""
    ground = ground_functions(scene, np.linspace(0.0, DEEPEST_M, _SURFACE_POINTS))
    velocity_m_s = np.linspace(-FASTEST_M_S, 0.0, _SURFACE_POINTS)
    return PowerSurface(
        depth_m=ground.depth_m,
        velocity_m_s=velocity_m_s,
        power_w=ground_power_w(ground.resistance_n, ground.drag_kg_m, velocity_m_s[:, np.newaxis]),
        motions=tuple(sample_motions(scene, speed, accuracy) for speed in SAMPLE_SPEEDS_M_S),
    )


def ground_power_w(resistance_n: FloatArray, drag_kg_m: FloatArray, velocity_m_s: FloatArray) -> FloatArray:
    """Return the rate of Eq. 3.4, W (negative: lost); arrays broadcast against each other."""
    speed_m_s = np.abs(velocity_m_s)
    return np.asarray(-drag_kg_m * speed_m_s**3 - resistance_n * speed_m_s)


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

    jumps: Jumps
    stiffness_factors: tuple[float, ...] = GROUND_FACTORS
    drag_factors: tuple[float, ...] = GROUND_FACTORS
    extension_gains: tuple[float, ...] = EXTENSION_GAINS
    foot_radii_m: tuple[float, ...] = FOOT_RADII_M
    active_damping_kg_m: FloatArray = field(default_factory=ACTIVE_DAMPINGS_KG_M.copy)

    @property
    def extension_stiffnesses_n_m(self) -> tuple[float, ...]:
        """The stiffnesses of the leg under the extension gains."""
        return tuple(map(stiffness_n_m, self.extension_gains))

    @property
    def saving(self) -> FloatArray:
        """Share of the cost that active damping saves, (CE - AD) / CE; the jumps' shape, 0 at the coefficient 0."""
        cost_j = self.jumps.cost_j
        return np.asarray(1.0 - cost_j / cost_j[..., :1])


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


_PRESSING_POINTS = 20_001


@dataclass(frozen=True, slots=True, eq=False)
class JumpEnergies:
    """Energies in J at the times of a motion, all of shape (n,); heights count from the undisturbed surface.

    `leg_spring_j` (LSP) takes the stiffness in force, `ground_spring_j` (GSP) is what pressing the ground to its
    present depth has cost and is not part of `total_j`. The foot's mass is with the grains it moves until lift-off, as
    in the thesis: their weight is lost from `foot_gravity_j` (GT) there, at once.
    """

    motion: Motion
    leg_spring_j: FloatArray
    body_kinetic_j: FloatArray
    body_gravity_j: FloatArray
    ground_spring_j: FloatArray
    foot_kinetic_j: FloatArray
    foot_gravity_j: FloatArray
    grain_gravity_j: FloatArray
    """The part of the foot's gravitational energy that is the grains' weight."""

    @property
    def total_j(self) -> FloatArray:
        """Total mechanical energy of body, leg and foot, J (Eq. 3.3)."""
        return np.asarray(
            self.leg_spring_j + self.body_kinetic_j + self.body_gravity_j + self.foot_kinetic_j + self.foot_gravity_j
        )


def jump_energies(scene: Scene, motion: Motion) -> JumpEnergies:
    """Compute the energies of a motion of the scene."""
    depth_m = motion.depth_m
    grains_kg = np.where(motion.flying, 0.0, ground_functions(scene, depth_m).added_mass_kg)
    stiffness = np.where(motion.extending, scene["k_extension"], scene["k_compression"])
    compression_m = motion.body_height_m - motion.foot_height_m - scene["rest_length"]
    grain_gravity_j = grains_kg * GRAVITY_M_S2 * motion.foot_height_m
    return JumpEnergies(
        motion=motion,
        leg_spring_j=0.5 * stiffness * compression_m**2,
        body_kinetic_j=0.5 * scene["body_mass"] * motion.body_velocity_m_s**2,
        body_gravity_j=scene["body_mass"] * GRAVITY_M_S2 * motion.body_height_m,
        ground_spring_j=_pressing_j(scene, depth_m),
        foot_kinetic_j=0.5 * (scene["foot_mass"] + grains_kg) * motion.foot_velocity_m_s**2,
        foot_gravity_j=scene["foot_mass"] * GRAVITY_M_S2 * motion.foot_height_m + grain_gravity_j,
        grain_gravity_j=grain_gravity_j,
    )


def _pressing_j(scene: Scene, depth_m: FloatArray) -> FloatArray:
    """Integrate K from the surface to each depth."""
    ground = ground_functions(scene, np.linspace(0.0, float(depth_m.max()), _PRESSING_POINTS))
    slices_j = 0.5 * (ground.resistance_n[1:] + ground.resistance_n[:-1]) * np.diff(ground.depth_m)
    return np.asarray(np.interp(depth_m, ground.depth_m, np.concatenate([[0.0], np.cumsum(slices_j)])))


class ThesisFigures:
    """Figures 3.2 to 3.13; set 1 is the shipped scene `sim1`, set 2 `sim2`. `accuracy` is that of every simulation."""

    def __init__(self, accuracy: float = 1e-6) -> None:
        self.accuracy = accuracy
        self.set_1 = load_scene("sim1")
        self.set_2 = load_scene("sim2")

    @cached_property
    def ground_functions(self) -> GroundFunctions:
        """Figure 3.2."""
        return ground_functions(self.set_1)

    @cached_property
    def example(self) -> Pair[Motion]:
        """Figure 3.4: the jump of set 1's own initial velocity."""
        return sample_motions(self.set_1, -self.set_1["initial_velocity"], self.accuracy)

    @cached_property
    def energies(self) -> Pair[JumpEnergies]:
        """Figure 3.5: the energies of figure 3.4's jumps."""
        scenes = both_controllers(self.set_1)
        return Pair(ce=jump_energies(scenes.ce, self.example.ce), ad=jump_energies(scenes.ad, self.example.ad))

    @cached_property
    def power_surface(self) -> PowerSurface:
        """Figure 3.6."""
        return power_surface(self.set_1, self.accuracy)

    def of_both(self, scene: Scene, grid: dict[str, FloatArray]) -> Pair[Jumps]:
        """Jumps of a scene over a grid, by both controllers."""
        ce, ad = (jumps_over(scene, {**grid, "b_ad": b_ad}, self.accuracy) for b_ad in (0.0, scene["b_ad"]))
        return Pair(ce, ad)

    @cached_property
    def over_velocity(self) -> OverVelocity:
        """Figures 3.8 and 3.9: set 1 over the speed at which body and foot arrive."""
        speeds = TOUCHDOWN_SPEEDS_M_S
        return OverVelocity(speeds, self.of_both(self.set_1, {"initial_velocity": -speeds}))

    @cached_property
    def over_ground(self) -> OverGround:
        """Figures 3.11 and 3.12: set 1 over the ground's depth-dependent stress and the scale of its drag."""
        scene, grid = self.set_1, {"sigma": SIGMAS_N_M3[:, np.newaxis], "b_g": DRAG_SCALES[np.newaxis, :]}
        jumps = self.of_both(scene, grid)
        return OverGround(SIGMAS_N_M3, DRAG_SCALES, scene["sigma"], scene["b_g"], jumps)

    @cached_property
    def over_damping(self) -> OverDamping:
        """Figure 3.13: set 2 over active damping, feet, extension stiffnesses and scalings of the ground."""
        stiffnesses = [stiffness_n_m(gain) for gain in EXTENSION_GAINS]
        axes = (GROUND_FACTORS, GROUND_FACTORS, stiffnesses, FOOT_RADII_M, ACTIVE_DAMPINGS_KG_M)
        names = ("kg_scale", "bg_scale", "k_extension", "foot_radius", "b_ad")
        grid = np.meshgrid(*axes, indexing="ij", sparse=True)
        return OverDamping(jumps_over(self.set_2, dict(zip(names, grid, strict=True)), self.accuracy))
