"""The true values behind the demonstration campaign, and how far its measurements scatter about them.

Sizes follow chapter 5 of the thesis where it states them (passive charge 86.183 mAh over 12 minutes, a saving
of about 15 % with the small foot and stiff gain, none of them depending on the active-damping gain, apexes up
to 3 mm higher with active damping). The rest is assumed, and said so in `docs/demonstration.md`.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass

from data_schema.errors import unknown_name
from data_schema.units import MAH_TO_COULOMB

CONTROL_GAIN = 0
"""Active-damping gain of the control (compression-extension) conditions."""


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
    """What is true of one foot with one extension gain.

    `saving` is (CE - AD) / CE, the same at every active-damping gain; `jamming_time_s` and
    `extension_intrusion_m` shape the stance in the logs only (see `labbook.demo.hop`).
    """

    foot: str
    k_gain: int
    control_joules_per_jump: float
    saving: float
    control_apex_m: float
    apex_increase_m: float
    jamming_time_s: float
    extension_intrusion_m: float


@dataclass(frozen=True, slots=True)
class Scatter:
    """Standard deviations; all are independent and normal.

    `recharge_mah` is in every recharge (where the charger stops), `run_mah` in runs with jumps only (bed,
    drops, 25 jumps together), `day_joules_per_jump` and `day_apex_m` common to all runs of a day.
    """

    recharge_mah: float = 0.35
    run_mah: float = 1.8
    day_joules_per_jump: float = 0.4
    run_apex_m: float = 0.0015
    jump_apex_m: float = 0.003
    day_apex_m: float = 0.00015


@dataclass(frozen=True, slots=True)
class Truth:
    """The generative model's parameters and the quantities a report should recover."""

    groups: tuple[Group, ...]
    ad_gains: tuple[int, ...]
    passive_intercept_mah: float
    passive_slope_mah_s: float
    reference_voltage_v: float
    run_duration_s: float
    scatter: Scatter

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

    def passive_charge_mah(self, duration_s: float) -> float:
        """Charge drawn by the electronics alone from power on to power off."""
        return self.passive_intercept_mah + self.passive_slope_mah_s * duration_s

    def joules_per_jump(self, condition: Condition) -> float:
        """Energy from the pack for one jump, above the passive draw."""
        group = self.group(condition.foot, condition.k_gain)
        share = 1.0 if condition.is_control else 1.0 - group.saving
        return group.control_joules_per_jump * share

    def jump_charge_mah(self, joules: float) -> float:
        """Charge that carries `joules` at the reference voltage."""
        return joules / (MAH_TO_COULOMB * self.reference_voltage_v)

    def apex_height_m(self, condition: Condition) -> float:
        """Mean apex height of the body above the undisturbed ground."""
        group = self.group(condition.foot, condition.k_gain)
        return group.control_apex_m + (0.0 if condition.is_control else group.apex_increase_m)

    def saving(self, foot: str, k_gain: int) -> float:
        """(CE - AD) / CE of joules a jump: pooled over, and equal at, all active-damping gains."""
        return self.group(foot, k_gain).saving

    def as_json(self) -> dict[str, object]:
        """Plain values for `truth.json`."""
        return {
            "passive": {
                "intercept_mah": self.passive_intercept_mah,
                "slope_mah_s": self.passive_slope_mah_s,
                "run_duration_s": self.run_duration_s,
                "charge_at_run_duration_mah": self.passive_charge_mah(self.run_duration_s),
            },
            "reference_voltage_v": self.reference_voltage_v,
            "conditions": [
                {
                    **asdict(condition),
                    "joules_per_jump": self.joules_per_jump(condition),
                    "apex_height_m": self.apex_height_m(condition),
                    "saving": None if condition.is_control else self.saving(condition.foot, condition.k_gain),
                }
                for condition in self.conditions
            ],
            "savings_pooled": [
                {"foot": group.foot, "k_gain": group.k_gain, "saving": group.saving} for group in self.groups
            ],
            "scatter": asdict(self.scatter),
        }


_PASSIVE_INTERCEPT_MAH = 1.5
_PASSIVE_AT_12_MIN_MAH = 86.183

CHAPTER_5 = Truth(
    # In the order in which the thesis ran them (5.1.3): larger foot first, stiffer gain first.
    groups=(
        Group("large", 400, 42.6, 0.09, 0.345, 0.0010, 0.022, 0.014),
        Group("large", 300, 41.5, 0.05, 0.318, 0.0005, 0.022, 0.012),
        Group("small", 400, 42.0, 0.15, 0.325, 0.0030, 0.030, 0.022),
        Group("small", 300, 41.0, 0.12, 0.292, 0.0020, 0.030, 0.019),
    ),
    ad_gains=(50, 100, 150, 200, 250),
    passive_intercept_mah=_PASSIVE_INTERCEPT_MAH,
    passive_slope_mah_s=(_PASSIVE_AT_12_MIN_MAH - _PASSIVE_INTERCEPT_MAH) / 720,
    reference_voltage_v=15.4,
    run_duration_s=720.0,
    scatter=Scatter(),
)
"""The campaign of chapter 5 with a truth of its size."""
