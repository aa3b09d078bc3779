"""The true values behind the demonstration campaign, and how far its measurements scatter about them.

Each condition of chapter 5 is a jump of the scene `bed` on a ground of its own: stiffer than the scene's, so that
predictions by the scene disagree with the campaign until `labbook calibrate` has found it. The passive charge is the
thesis's (5.1.4), the scatter assumed (`docs/demonstration.md`).

What jumps of a condition differ by, the height of the drop and the apex, stretches drop and flight as gravity would
have it, their times by the root of their heights; the stance is the simulated one.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import asdict, astuple, dataclass, field
from functools import cache

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from data_schema.errors import UsageError, unknown_name
from data_schema.units import MAH_TO_COULOMB

CONTROL_GAIN = 0
"""Active-damping gain of the control (compression-extension) conditions."""
REST_LENGTH_M = 0.27
"""Length of the leg in the air (thesis 5.1.1)."""
FOOT_RADIUS_M = {"small": 0.038, "large": 0.051}
GROUND = {"kg_scale": 1.6}
"""What the ground differs by from that of the scene: 1.4 there."""
_ACCURACY = 1e-6


@dataclass(frozen=True, slots=True)
class Condition:
    """One level of each factor of the bed study."""

    foot: str
    k_gain: int
    b_ad_gain: int

    @property
    def is_control(self) -> bool:
        """Whether this is a compression-extension condition."""
        return self.b_ad_gain == CONTROL_GAIN


@dataclass(frozen=True, slots=True)
class Group:
    """What is true of one foot with one extension gain: what the simulator has of it."""

    foot: str
    k_gain: int

    def joules_per_jump(self, b_ad_gain: int) -> float:
        """Energy from the pack for one jump, above the passive draw."""
        return simulated_jump(self.foot, self.k_gain, b_ad_gain).joules

    def apex_height_m(self, b_ad_gain: int) -> float:
        """Mean apex height of the body above the undisturbed ground."""
        return simulated_jump(self.foot, self.k_gain, b_ad_gain).apex_height_m

    def hop(self, _rng: Generator, b_ad_gain: int, start_m: float, apex_m: float) -> Hop:
        """Return the jump from `start_m` that reaches `apex_m`; nothing else about it is drawn."""
        return simulated_jump(self.foot, self.k_gain, b_ad_gain).hop(start_m, apex_m)


@dataclass(frozen=True, slots=True)
class Scatter:
    """Standard deviations; all are independent and normal.

    `recharge_mah` is in every recharge (where the charger stops), `run_mah` in runs with jumps only (bed,
    drops, 25 jumps together), `day_joules_per_jump` and `day_apex_m` common to all runs of a day.
    """

    recharge_mah: float = 0.35
    run_mah: float = 1.2
    day_joules_per_jump: float = 0.4
    run_apex_m: float = 0.0015
    jump_apex_m: float = 0.003
    day_apex_m: float = 0.00015


_PASSIVE_INTERCEPT_MAH = 1.5
_PASSIVE_AT_12_MIN_MAH = 86.183


@dataclass(frozen=True, slots=True)
class Drain:
    """Charge drawn by the electronics alone: of the thesis at 12 minutes (5.1.4), with an assumed intercept."""

    intercept_mah: float = _PASSIVE_INTERCEPT_MAH
    slope_mah_s: float = (_PASSIVE_AT_12_MIN_MAH - _PASSIVE_INTERCEPT_MAH) / 720

    def charge_mah(self, duration_s: float) -> float:
        """Charge from power on to power off."""
        return self.intercept_mah + self.slope_mah_s * duration_s


def recharged_mah(rng: Generator, duration_s: float, joules: float, voltage_v: float, scatter_mah: float) -> int:
    """Draw what the charger's display says was put back after a run whose jumps took so many joules."""
    return round(Drain().charge_mah(duration_s) + joules / (MAH_TO_COULOMB * voltage_v) + rng.normal(0.0, scatter_mah))


@dataclass(frozen=True, slots=True)
class Truth:
    """The generative model's parameters and the quantities a report should recover."""

    groups: tuple[Group, ...]
    ad_gains: tuple[int, ...] = (50, 100, 150, 200, 250)
    drain: Drain = Drain()
    reference_voltage_v: float = 15.4
    run_duration_s: float = 720.0
    scatter: Scatter = Scatter()
    ground: Mapping[str, float] = field(default_factory=dict)

    @property
    def conditions(self) -> tuple[Condition, ...]:
        """All conditions, the control first within each foot and gain."""
        return tuple(
            Condition(group.foot, group.k_gain, gain)
            for group in self.groups
            for gain in (CONTROL_GAIN, *self.ad_gains)
        )

    def group(self, foot: str, k_gain: int) -> Group:
        """Return the group of a foot and gain; raises `UnknownName` when there is none."""
        groups = {f"{group.foot} {group.k_gain}": group for group in self.groups}
        name = f"{foot} {k_gain}"
        if name not in groups:
            raise unknown_name("foot and gain of the demonstration", name, groups)
        return groups[name]

    def joules_per_jump(self, condition: Condition) -> float:
        """Energy from the pack for one jump, above the passive draw."""
        return self.group(condition.foot, condition.k_gain).joules_per_jump(condition.b_ad_gain)

    def jump_charge_mah(self, joules: float) -> float:
        """Charge that carries `joules` at the reference voltage."""
        return joules / (MAH_TO_COULOMB * self.reference_voltage_v)

    def apex_height_m(self, condition: Condition) -> float:
        """Mean apex height of the body above the undisturbed ground."""
        return self.group(condition.foot, condition.k_gain).apex_height_m(condition.b_ad_gain)

    def saving(self, foot: str, k_gain: int, b_ad_gain: int | None = None) -> float:
        """(CE - AD) / CE of joules a jump, AD at one gain or the mean over all."""
        group = self.group(foot, k_gain)
        gains = self.ad_gains if b_ad_gain is None else (b_ad_gain,)
        return 1.0 - sum(map(group.joules_per_jump, gains)) / len(gains) / group.joules_per_jump(CONTROL_GAIN)

    def as_json(self) -> dict[str, object]:
        """Plain values for `truth.json`."""
        savings = [self.saving(group.foot, group.k_gain) for group in self.groups]
        return {
            "passive": {
                **asdict(self.drain),
                "run_duration_s": self.run_duration_s,
                "charge_at_run_duration_mah": self.drain.charge_mah(self.run_duration_s),
            },
            "reference_voltage_v": self.reference_voltage_v,
            "ground": dict(self.ground),
            "conditions": [
                {
                    **asdict(condition),
                    "joules_per_jump": self.joules_per_jump(condition),
                    "apex_height_m": self.apex_height_m(condition),
                    "saving": None if condition.is_control else self.saving(*astuple(condition)),
                }
                for condition in self.conditions
            ],
            "savings_pooled": [
                {"foot": group.foot, "k_gain": group.k_gain, "saving": saving}
                for group, saving in zip(self.groups, savings, strict=True)
            ],
            "saving_overall": sum(savings) / len(savings),
            "scatter": asdict(self.scatter),
        }


CHAPTER_5 = Truth(
    # In the order in which the thesis ran them (5.1.3): larger foot first, stiffer gain first.
    groups=tuple(Group(foot, k_gain) for foot in ("large", "small") for k_gain in (400, 300)),
    ground=GROUND,
)
"""The campaign of chapter 5 as the simulator has it."""


FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Hop:
    """A hop from its drop to its second touchdown: heights of the body above the undisturbed ground, times since the
    drop. The switch is where the leg is shortest. `motion` samples the hop at times, of shape (n,), rising, to its end
    at most: body height and leg length in m, the leg's velocity in m/s, and 1 where it extends, of shape (4, n).
    """

    lift_off_height_m: float
    apex_height_m: float
    switch_height_m: float
    switch_leg_m: float
    switch_s: float
    apex_s: float
    landing_s: float
    motion: Callable[[FloatArray], FloatArray]


@dataclass(frozen=True, slots=True, eq=False)
class SimulatedJump:
    """A jump of the simulator: arrays of shape (samples,) from its drop to its second touchdown."""

    joules: float
    time_s: FloatArray
    height_m: FloatArray
    leg_m: FloatArray
    touchdown_s: float
    lift_off_s: float
    lift_off_height_m: float
    apex_s: float
    apex_height_m: float

    def hop(self, start_m: float, apex_height_m: float) -> Hop:
        """Return the jump begun at `start_m` and reaching `apex_height_m`."""
        low_m, end_s = self.lift_off_height_m, float(self.time_s[-1])
        drop_share = (start_m - REST_LENGTH_M) / (float(self.height_m[0]) - REST_LENGTH_M)
        rise_share = (apex_height_m - low_m) / (self.apex_height_m - low_m)
        touchdown_s = math.sqrt(drop_share) * self.touchdown_s
        lift_off_s = touchdown_s + self.lift_off_s - self.touchdown_s
        apex_s, landing_s = (
            lift_off_s + math.sqrt(rise_share) * (simulated_s - self.lift_off_s) for simulated_s in (self.apex_s, end_s)
        )
        shortest = int(np.argmin(self.leg_m))
        switch_s = touchdown_s + float(self.time_s[shortest]) - self.touchdown_s

        def motion(time_s: FloatArray) -> FloatArray:
            times_s = [0.0, touchdown_s, lift_off_s, landing_s]
            simulated_s = np.interp(time_s, times_s, [0.0, self.touchdown_s, self.lift_off_s, end_s])
            height_m, leg_m = (np.interp(simulated_s, self.time_s, values) for values in (self.height_m, self.leg_m))
            dropping, flying = time_s < touchdown_s, time_s > lift_off_s
            height_m[dropping] = REST_LENGTH_M + drop_share * (height_m[dropping] - REST_LENGTH_M)
            height_m[flying] = low_m + rise_share * (height_m[flying] - low_m)
            return np.stack([height_m, leg_m, np.gradient(leg_m, time_s), (time_s > switch_s) & ~flying])

        height_m, leg_m = float(self.height_m[shortest]), float(self.leg_m[shortest])
        return Hop(low_m, apex_height_m, height_m, leg_m, switch_s, apex_s, landing_s, motion)


@cache
def simulated_jump(foot: str, k_gain: int, b_ad_gain: int) -> SimulatedJump:
    """Simulate a condition on `GROUND`; raises `UsageError` where the jump has no apex or no second touchdown."""
    from simulator.gains import fitted_active_damping_kg_m, stiffness_n_m
    from simulator.jump import simulate
    from simulator.scene_file import load_scene

    values = {
        "foot_radius": FOOT_RADIUS_M[foot],
        "k_extension": stiffness_n_m(k_gain),
        "b_ad": fitted_active_damping_kg_m(b_ad_gain),
        **GROUND,
    }
    result = simulate(load_scene("bed").changed(values), _ACCURACY, trajectory=True)
    jump, motion = result.jump, result.trajectory
    stance_s, apex_s, low_m = jump.liftoff_time_s, jump.apex_time_s, jump.liftoff_body_height_m
    if motion is None or stance_s is None or apex_s is None or low_m is None or jump.apex_height_m is None:
        raise UsageError(f"the simulated jump of foot {foot}, gains {k_gain} and {b_ad_gain} ends as {jump.outcome}.")
    height_m, touchdown_s = motion["body_height"].to_numpy(), jump.touchdown_time_s
    return SimulatedJump(
        joules=jump.cost_J,
        time_s=motion["time"].to_numpy(),
        height_m=height_m,
        leg_m=height_m - motion["foot_height"].to_numpy(),
        touchdown_s=touchdown_s,
        lift_off_s=touchdown_s + stance_s,
        lift_off_height_m=low_m,
        apex_s=touchdown_s + apex_s,
        apex_height_m=jump.apex_height_m,
    )
