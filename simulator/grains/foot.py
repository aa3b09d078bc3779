"""A foot that makes the motion of a jump in a bed of grains: discrete elements beside the bulk model (thesis 3.2.4).

The motion is that of the scene, whose ground is the bulk model; the grains push the foot and do not change its way.
What they take up is told therefore, their kinetic energy and the foot's work; the force late in stance, when the bulk
model holds the foot still, is not that of a foot with a robot on it.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass, replace

import numpy as np

from data_schema.errors import UsageError
from simulator.compiled import Row
from simulator.grains.bed import BEDS, GRAVITY, Bed, BedAsked, settled
from simulator.grains.stepping import (
    ELASTIC,
    FORCE,
    HEIGHT,
    KINETIC,
    LOST,
    NEVER,
    WORK,
    FootPath,
    Whole,
    advance,
    compiled_steps,
)
from simulator.jump import simulate
from simulator.parameter import GRAVITY_M_S2
from simulator.scene import Scene
from simulator.sweep.chunks import cores
from simulator.thesis.figures import Pair, both_controllers

RECORD_EVERY_S = 5e-4
AFTER_LIFTOFF_S = 0.03
DIAMETERS_M, SEEDS = (0.01, 0.014), 3
_SAME_TIME_S = 1e-9


@dataclass(frozen=True, slots=True, eq=False)
class FootMotion:
    """The foot of one jump from touchdown on, arrays of shape (n,): time, height over the surface and velocity.

    `reaction_n` is the bulk model's force on the foot, up positive. The leg extends from `extension_time_s` on, when it
    is shortest, to lift-off.
    """

    time_s: Row
    height_m: Row
    velocity_m_s: Row
    reaction_n: Row
    extension_time_s: float
    liftoff_time_s: float

    @property
    def max_depth_m(self) -> float:
        """How deep the foot gets."""
        return float(-self.height_m.min())

    @property
    def bulk_work_j(self) -> Row:
        """What the foot has done on the bulk model's ground since touchdown, shape (n,)."""
        power_w = -self.reaction_n * self.velocity_m_s
        return np.concatenate([[0.0], np.cumsum(0.5 * (power_w[1:] + power_w[:-1]) * np.diff(self.time_s))])

    def path(self, radius_m: float, step_s: float, surface_m: float) -> FootPath:
        """Return the foot at every step, over a floor that lies `surface_m` under the surface of the bed."""
        from scipy.interpolate import CubicHermiteSpline

        height = CubicHermiteSpline(self.time_s, self.height_m, self.velocity_m_s)
        at_s = np.arange(int(self.time_s[-1] / step_s) + 1) * step_s
        return FootPath(radius_m, surface_m + height(at_s), height.derivative()(at_s))


def foot_motion(scene: Scene, accuracy: float = 1e-6) -> FootMotion:
    """Simulate a jump on the bulk model and return its foot's motion until shortly after lift-off.

    Raises `UsageError` where the foot does not leave the ground.
    """
    result = simulate(scene, accuracy, trajectory=True)
    motion, jump = result.trajectory, result.jump
    if motion is None or jump.liftoff_time_s is None:
        raise UsageError(
            f"{scene.title}: the foot does not leave the ground ({jump.outcome}), and there is no jump to follow: "
            "choose gains with which `labbook sim run` comes to lift-off."
        )
    time_s = motion["time"].to_numpy() - jump.touchdown_time_s
    shown = (time_s >= 0.0) & (time_s <= jump.liftoff_time_s + AFTER_LIFTOFF_S)
    shown &= np.diff(time_s, prepend=-1.0) > _SAME_TIME_S
    columns = {name: motion[name].to_numpy()[shown] for name in map(str, motion.data_vars)}
    time_s = time_s[shown]
    stance = time_s < jump.liftoff_time_s
    reaction_n = sum(
        scene[f"{part}_mass"] * (columns[f"{part}_acceleration"] + GRAVITY_M_S2) for part in ("body", "foot")
    )
    return FootMotion(
        time_s,
        columns["foot_height"],
        columns["foot_velocity"],
        np.where(stance, reaction_n, 0.0),
        float(time_s[np.argmin(np.where(stance, columns["leg_length"], np.inf))]),
        jump.liftoff_time_s,
    )


@dataclass(frozen=True, slots=True, eq=False)
class GrainsJump:
    """What one bed does under one jump; arrays of shape (n,) over the time since touchdown.

    `force_n` is the grains' mean force on the foot since the time before, up positive; `work_j` is what the foot has
    done on them. `book_residual` is how far their energy book is open at the end, as a share of that work.
    """

    time_s: Row
    kinetic_j: Row
    force_n: Row
    work_j: Row
    extension_time_s: float
    book_residual: float
    processor_s: float
    ns_a_grain_and_step: float

    @property
    def peak_compression_j(self) -> float:
        """The grains' largest kinetic energy while the leg is compressed."""
        return float(self.kinetic_j[self.time_s < self.extension_time_s].max(initial=0.0))

    @property
    def peak_extension_j(self) -> float:
        """The grains' largest kinetic energy from the leg's shortest length on."""
        return float(self.kinetic_j[self.time_s >= self.extension_time_s].max(initial=0.0))

    @property
    def extension_work_j(self) -> float:
        """What the foot does on the grains from the leg's shortest length on."""
        return float(self.work_j[-1] - np.interp(self.extension_time_s, self.time_s, self.work_j))


@dataclass(frozen=True, slots=True, eq=False)
class BedJumps:
    """One bed, without its grains' places, and what it does under a jump with either controller."""

    asked: BedAsked
    n_grains: int
    solid_fraction: float
    jumps: Pair[GrainsJump]


@dataclass(frozen=True, slots=True, eq=False)
class GrainsStudy:
    """Jumps of a scene on beds of grains: the feet's motions, and what each bed does under them."""

    scene: Scene
    motions: Pair[FootMotion]
    beds: tuple[BedJumps, ...]
    settling_s: float

    def of_diameter(self, diameter_m: float) -> tuple[BedJumps, ...]:
        """Return the beds of grains of this size."""
        return tuple(bed for bed in self.beds if bed.asked.diameter_m == diameter_m)


def jump_in(bed: Bed, foot_radius_m: float, motion: FootMotion, stop: Whole = NEVER) -> GrainsJump:
    """Let a foot make a motion in a bed, its zero where the highest grain under it stands; `stop` as in `advance`."""
    asked, grains = bed.asked, bed.grains
    under = np.hypot(*(grains.x[:, :2] - 0.5 * asked.width_m).T) < foot_radius_m
    surface_m = float((grains.x[:, 2] + grains.radius_m)[under].max())
    foot = motion.path(foot_radius_m, asked.step_s, surface_m)
    steps, every = len(foot.height_m) - 1, max(1, round(RECORD_EVERY_S / asked.step_s))
    started = time.thread_time()
    _, record = advance(
        grains, asked.material, asked.width_m, asked.step_s, steps, gravity=GRAVITY, foot=foot, every=every, stop=stop
    )
    spent_s = time.thread_time() - started
    book_j = record[:, [KINETIC, HEIGHT, ELASTIC, LOST]].sum(axis=1) - record[:, WORK]
    return GrainsJump(
        time_s=asked.step_s * every * np.arange(1.0, len(record) + 1.0),
        kinetic_j=record[:, KINETIC],
        force_n=record[:, FORCE],
        work_j=record[:, WORK],
        extension_time_s=motion.extension_time_s,
        book_residual=float(abs(book_j[-1] - book_j[0]) / record[-1, WORK]),
        processor_s=spent_s,
        ns_a_grain_and_step=1e9 * spent_s / (steps * len(grains.x)),
    )


def jumps_on_grains(
    scene: Scene,
    asked: BedAsked,
    diameters_m: Sequence[float] = DIAMETERS_M,
    seeds: int = SEEDS,
    accuracy: float = 1e-6,
    step: Callable[[str], None] = lambda _what: None,
) -> GrainsStudy:
    """Let the foot of a scene's jump, with either controller, into beds of grains; on all cores.

    Parameters
    ----------
    scene : on granular ground, with active damping; compression-extension is the same with `b_ad` of 0
    asked : what all beds have in common; the density of the grains is the scene's
    diameters_m, seeds : beds of grains of each mean diameter, and so many of each
    step : is told, when the steps are compiled and after each bed and each jump, what goes on then

    Raises
    ------
    UsageError for a scene without grains, without active damping or whose foot does not leave the ground, and for a
    bed that is too small for the foot's motion.
    """
    _check_scene(scene)
    pair = both_controllers(scene)
    motions = Pair(ce=foot_motion(pair.ce, accuracy), ad=foot_motion(pair.ad, accuracy))
    wanted = [
        replace(asked, diameter_m=diameter_m, density_kg_m3=scene["rho"], seed=seed)
        for diameter_m in diameters_m
        for seed in range(seeds)
    ]
    for bed in wanted:
        _check_room(bed, scene["foot_radius"], max(motions.ce.max_depth_m, motions.ad.max_depth_m))
    compiled_steps()
    step("settling beds")
    stop, _ = np.zeros(1, np.int64), BEDS.folder  # made while no thread makes files
    started = time.process_time()
    with ThreadPoolExecutor(max_workers=cores()) as threads:
        try:
            beds = {asked_for: threads.submit(settled, asked_for, stop) for asked_for in wanted}
            for count, _ in enumerate(as_completed(beds.values()), 1):
                step("settling beds" if count < len(beds) else "jumping")
            settling_s = time.process_time() - started
            jumps = {
                (bed, name): threads.submit(
                    jump_in, beds[bed].result(), scene["foot_radius"], getattr(motions, name), stop
                )
                for bed in wanted
                for name in ("ce", "ad")
            }
            for _ in as_completed(jumps.values()):
                step("jumping")
        except BaseException:  # Ctrl-C above all
            stop[0] = 1
            threads.shutdown(wait=False, cancel_futures=True)
            raise
    return GrainsStudy(
        scene,
        motions,
        tuple(
            BedJumps(
                bed,
                len(beds[bed].result().grains.x),
                beds[bed].result().solid_fraction,
                Pair(ce=jumps[bed, "ce"].result(), ad=jumps[bed, "ad"].result()),
            )
            for bed in wanted
        ),
        settling_s,
    )


def _check_scene(scene: Scene) -> None:
    if "hydrostatic_stiffness" not in scene.effects:
        raise UsageError(f"{scene.name} has no grains: give a scene on granular ground, such as sim1, sim2 or bed.")
    if "b_ad" not in scene.read or scene["b_ad"] <= 0.0:
        raise UsageError(
            f"{scene.name} has no active damping, so that both jumps would be one: give it with --set b_ad=VALUE or "
            "--set damping_gain=VALUE."
        )
    if "rho" not in scene.read:
        raise UsageError(f"{scene.name} does not say how dense its grains are: switch +inertial_drag on.")


def _check_room(asked: BedAsked, foot_radius_m: float, max_depth_m: float) -> None:
    if not asked.diameter_m > 0.0:
        raise UsageError(f"--diameter {asked.diameter_m:g} is no size of grains: give a number above 0, in m.")
    if asked.diameter_m > foot_radius_m:
        raise UsageError(
            f"--diameter {asked.diameter_m:g} does not fit under a foot of {foot_radius_m:g} m radius: give grains of "
            "at most that, in m."
        )
    needs_m = max_depth_m + 3.0 * asked.diameter_m
    if asked.depth_m < needs_m:
        raise UsageError(
            f"the foot sinks {max_depth_m:.3g} m into a bed of {asked.depth_m:g} m: give --grain "
            f"depth={math.ceil(100 * needs_m) / 100:g}."
        )
    if asked.width_m < 4.0 * foot_radius_m:
        raise UsageError(
            f"a box of {asked.width_m:g} m is narrower than two feet of {2 * foot_radius_m:g} m: give --grain "
            f"width={math.ceil(600 * foot_radius_m) / 100:g}."
        )
