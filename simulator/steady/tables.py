"""The published experiments, simulated.

A robot goes on repeating the last of the many jumps that a scene makes. On the ground emulator (thesis 4.3) three
controllers jump at five extension gains, with what happens while the extending leg drives the ground down; on the force
plate (3.2.2) compression-extension jumps at four gains on rigid ground. On the bed of glass beads (ch. 5) every jump
begins with a drop, with two feet, two extension gains and five gains of active damping.
"""

from __future__ import annotations

import statistics
from collections.abc import Callable, Collection
from dataclasses import dataclass

import numpy as np

from simulator.gains import active_damping_kg_m, fitted_active_damping_kg_m, stiffness_n_m
from simulator.jump import simulate
from simulator.kernel.layout import INTRUDING
from simulator.result import JumpResult
from simulator.scene import Scene
from simulator.scene_file import load_scene

JUMPS_NOT_COUNTED = 2
"""The first jumps of an experiment, left out of the published apexes (thesis 4.3.3)."""


Done = Callable[[str], None]
"""Called with what is done."""


@dataclass(frozen=True, slots=True)
class SteadyJump:
    """The last jump of a scene, touchdown to touchdown: SI units, joules over the whole jump.

    `apex_change_m` is the difference of its apex from the one before, and `apex_sd_m` the standard deviation of the
    scene's apexes without the first two.
    """

    apex_height_m: float
    apex_change_m: float
    apex_sd_m: float
    heat_j: float
    mechanical_j: float
    drag_j: float
    cost_j: float
    period_s: float
    max_depth_m: float
    touchdown_velocity_m_s: float
    impact_loss_j: float
    capped_time_s: float
    min_leg_length_m: float


def steady_jump(scene: Scene, accuracy: float) -> SteadyJump:
    """Simulate all jumps of a scene and return the last.

    Raises `RuntimeError` where a jump does not end in a touchdown, and `UsageError` for an accuracy that cannot be had.
    """
    jumps = simulate(scene, accuracy).jumps
    last = jumps[-1]
    apexes = [apex_of(scene, jump) for jump in jumps]
    if last.next_touchdown_time_s is None or last.next_touchdown_body_velocity_m_s is None:
        raise _stopped(scene, last)
    return SteadyJump(
        apex_height_m=apexes[-1],
        apex_change_m=apexes[-1] - apexes[-2],
        apex_sd_m=statistics.stdev(apexes[JUMPS_NOT_COUNTED:]),
        heat_j=last.jump_heat_J,
        mechanical_j=last.jump_mechanical_J,
        drag_j=last.jump_drag_J,
        cost_j=last.cost_J,
        period_s=last.next_touchdown_time_s,
        max_depth_m=last.max_depth_m,
        touchdown_velocity_m_s=last.next_touchdown_body_velocity_m_s,
        impact_loss_j=last.impact_loss_J,
        capped_time_s=last.capped_time_s,
        min_leg_length_m=last.min_leg_length_m,
    )


def apex_of(scene: Scene, jump: JumpResult) -> float:
    """Return a jump's apex height in m; raises `RuntimeError` where it has none."""
    if jump.apex_height_m is None:
        raise _stopped(scene, jump)
    return jump.apex_height_m


def _stopped(scene: Scene, jump: JumpResult) -> RuntimeError:
    return RuntimeError(f"{scene.name} does not go on jumping ({jump.outcome}), and has no steady jump")


RECORDED_JUMPS = 20
"""So many are recorded to look at the last: jumps settle to well under a micrometre within ten."""
_ROUNDING = 1e-9
"""m and m/s: a step that ends at the switch meets its condition but for rounding."""


@dataclass(frozen=True, slots=True)
class Yielding:
    """How deep the foot stands when the leg switches to extension, m, and the motors' heat from then on while the
    ground yields, J: active damping acts there and nowhere else.
    """

    switch_depth_m: float
    heat_j: float


def yielding_of(scene: Scene, accuracy: float) -> Yielding:
    """Record the jumps of a scene with the latched controller, and measure the last."""
    motion = simulate(scene.changed(jumps=RECORDED_JUMPS), accuracy, trajectory=True).trajectory
    if motion is None:
        raise RuntimeError(f"{scene.name} has no recorded motion")
    last = motion["jump"].to_numpy() == RECORDED_JUMPS - 1
    foot_m, length_m, heat_j = (motion[name].to_numpy()[last] for name in ("foot_height", "leg_length", "heat"))
    rate_m_s = (motion["body_velocity"] - motion["foot_velocity"]).to_numpy()[last]
    compressed = length_m < scene["rest_length"] - scene["switch_compression"] + _ROUNDING
    slow = rate_m_s > -scene["switch_speed_tolerance"] - _ROUNDING
    switch = int(np.argmax((compressed & slow) | (length_m < scene["guard_length"] + _ROUNDING)))
    yields = motion["mode"].to_numpy()[last] == INTRUDING
    spent_j = np.diff(heat_j[switch:])[yields[switch:-1] & yields[switch + 1 :]]
    return Yielding(switch_depth_m=-float(foot_m[switch]), heat_j=float(spent_j.sum()))


GAINS = (100.0, 200.0, 300.0, 400.0, 500.0)
STIFFEST_GAIN = GAINS[-1]
"""Left out of the published results, because the apex was no higher than at the gain before (thesis 4.3.3)."""
CONSTANT_DAMPING_GAIN = 50.0
EXTENSION_GAIN_PER_SCALED_GAIN = 6.0


@dataclass(frozen=True, slots=True)
class EmulatorRow:
    """An extension gain: compression-extension, active damping scaled with the gain, and constant active damping.

    `yielding` is that of compression-extension.
    """

    gain: float
    ce: SteadyJump
    scaled: SteadyJump
    constant: SteadyJump
    yielding: Yielding

    @property
    def scaled_saving(self) -> float:
        """Return the share of the joules of a jump that scaled active damping saves, (CE - AD) / CE."""
        return _lost_share(self.ce.cost_j, self.scaled.cost_j)

    @property
    def constant_saving(self) -> float:
        """Return the share that constant active damping saves."""
        return _lost_share(self.ce.cost_j, self.constant.cost_j)

    @property
    def scaled_loss(self) -> float:
        """Return the share of the apex height that scaled active damping loses, (CE - AD) / CE."""
        return _lost_share(self.ce.apex_height_m, self.scaled.apex_height_m)

    @property
    def constant_loss(self) -> float:
        """Return the share that constant active damping loses."""
        return _lost_share(self.ce.apex_height_m, self.constant.apex_height_m)


@dataclass(frozen=True, slots=True)
class EmulatorTable:
    """The experiments at every gain; `scene` is the one they change."""

    scene: Scene
    rows: tuple[EmulatorRow, ...]

    def at(self, gain: float) -> EmulatorRow:
        """Return the row of a gain."""
        return next(row for row in self.rows if row.gain == gain)

    @property
    def analysed(self) -> tuple[EmulatorRow, ...]:
        """Return the rows that the thesis goes on to analyse: all but the stiffest."""
        return tuple(row for row in self.rows if row.gain != STIFFEST_GAIN)


def emulator_table(accuracy: float, done: Done) -> EmulatorTable:
    """Simulate the experiments; `done` is called with each gain."""
    scene = load_scene("emulator")
    rows = []
    for gain in GAINS:
        stiff = scene.changed({"k_extension": stiffness_n_m(gain)})
        damping_gains = (0.0, gain / EXTENSION_GAIN_PER_SCALED_GAIN, CONSTANT_DAMPING_GAIN)
        scenes = [stiff.changed({"b_ad": active_damping_kg_m(damping_gain)}) for damping_gain in damping_gains]
        ce, scaled, constant = (steady_jump(changed, accuracy) for changed in scenes)
        rows.append(EmulatorRow(gain, ce, scaled, constant, yielding_of(scenes[0], accuracy)))
        done(f"emulator, gain {gain:g}")
    return EmulatorTable(scene, tuple(rows))


def _lost_share(ce: float, ad: float) -> float:
    """Return the share by which active damping lowers joules or an apex (thesis 4.3.2, 4.3.3)."""
    return (ce - ad) / ce


PLATE_GAINS = (300.0, 400.0, 500.0, 600.0)
ESTIMATED_OVER_MEASURED = 1.35
"""Slope of the joules estimated from the plate's forces over those that the battery gave (thesis 3.2.2)."""


@dataclass(frozen=True, slots=True)
class PlateRow:
    """An extension gain."""

    gain: float
    jump: SteadyJump

    @property
    def battery_j(self) -> float:
        """Return the joules of a jump that the battery would give, were the published slope that of the simulation."""
        return self.jump.cost_j / ESTIMATED_OVER_MEASURED


@dataclass(frozen=True, slots=True)
class PlateTable:
    """The experiments at every gain; `scene` is the one they change."""

    scene: Scene
    rows: tuple[PlateRow, ...]


def plate_table(accuracy: float, done: Done) -> PlateTable:
    """Simulate the experiments; `done` is called with each gain."""
    scene = load_scene("force_plate")
    rows = []
    for gain in PLATE_GAINS:
        rows.append(PlateRow(gain, steady_jump(scene.changed({"k_extension": stiffness_n_m(gain)}), accuracy)))
        done(f"force plate, gain {gain:g}")
    return PlateTable(scene, tuple(rows))


FEET_M = {"small": 0.038, "large": 0.051}
BED_GAINS = (400.0, 300.0)
BED_DAMPING_GAINS = (50.0, 100.0, 150.0, 200.0, 250.0)


@dataclass(frozen=True, slots=True)
class BedRow:
    """A condition of the bed: foot, extension gain and damping gain, 0 for compression-extension.

    `cost_j` and `apex_height_m` are those of the jump, `ce_cost_j` and `ce_apex_height_m` those of
    compression-extension with the same foot and extension gain; SI units, joules of the stance.
    """

    foot: str
    gain: float
    damping_gain: float
    cost_j: float
    apex_height_m: float
    max_depth_m: float
    capped_time_s: float
    ce_cost_j: float
    ce_apex_height_m: float

    @property
    def saving(self) -> float:
        """Return the share of the joules of a jump that active damping saves, (CE - AD) / CE (thesis 5.2.1)."""
        return _lost_share(self.ce_cost_j, self.cost_j)

    @property
    def apex_gain_m(self) -> float:
        """Return how much higher the apex is than that of compression-extension (thesis 5.2.2)."""
        return self.apex_height_m - self.ce_apex_height_m


@dataclass(frozen=True, slots=True)
class BedTable:
    """The 24 conditions; `scene` is the one they change."""

    scene: Scene
    rows: tuple[BedRow, ...]

    def of(self, foot: str, gain: float, damping_gains: Collection[float] = BED_DAMPING_GAINS) -> tuple[BedRow, ...]:
        """Return the rows of a foot, an extension gain and these damping gains, which rise."""
        return tuple(
            row for row in self.rows if (row.foot, row.gain) == (foot, gain) and row.damping_gain in damping_gains
        )

    def saving(self, foot: str, gain: float, damping_gains: Collection[float] = BED_DAMPING_GAINS) -> float:
        """Return the mean saving over these damping gains: as the thesis pools them, (CE - mean AD) / CE."""
        return statistics.fmean(row.saving for row in self.of(foot, gain, damping_gains))


def bed_table(accuracy: float, done: Done) -> BedTable:
    """Simulate the conditions; `done` is called with each foot and extension gain."""
    scene = load_scene("bed")
    rows: list[BedRow] = []
    for foot, radius_m in FEET_M.items():
        for gain in BED_GAINS:
            changed = scene.changed({"foot_radius": radius_m, "k_extension": stiffness_n_m(gain)})
            ce = None
            for damping_gain in (0.0, *BED_DAMPING_GAINS):
                damped = changed.changed({"b_ad": fitted_active_damping_kg_m(damping_gain)})
                jump = simulate(damped, accuracy).jump
                apex_m = apex_of(scene, jump)
                ce = ce or (jump.cost_J, apex_m)
                rows.append(
                    BedRow(foot, gain, damping_gain, jump.cost_J, apex_m, jump.max_depth_m, jump.capped_time_s, *ce)
                )
            done(f"bed, {foot} foot, gain {gain:g}")
    return BedTable(scene, tuple(rows))


STEPS = len(GAINS) + len(PLATE_GAINS) + len(FEET_M) * len(BED_GAINS)
"""How often `steady_tables` says that it is done with something."""


@dataclass(frozen=True, slots=True)
class SteadyTables:
    """Steady jumps on the ground emulator (thesis ch. 4) and the force plate (3.2.2), and drops onto the bed (ch. 5).

    All are simulated at one accuracy.
    """

    emulator: EmulatorTable
    force_plate: PlateTable
    bed: BedTable
    accuracy: float


def steady_tables(accuracy: float = 1e-6, done: Done = lambda _what: None) -> SteadyTables:
    """Simulate all experiments; `done` is called with each gain. Raises `UsageError` for an impossible accuracy."""
    return SteadyTables(
        emulator_table(accuracy, done), plate_table(accuracy, done), bed_table(accuracy, done), accuracy
    )
