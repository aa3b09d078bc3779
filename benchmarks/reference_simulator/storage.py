"""Stored reference results, one TOML file a scene: written by `regenerate`, read by `stored`."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, fields, replace
from decimal import Context, Decimal
from enum import StrEnum
from fractions import Fraction
from pathlib import Path
from typing import Any, get_type_hints

from benchmarks.reference_simulator.cases import CASES, cases
from benchmarks.reference_simulator.leg import (
    CostForce,
    FlightGains,
    ForceCap,
    GranularParameters,
    HoppingParameters,
    LegParameters,
    PlatformParameters,
    SwitchingRule,
)
from benchmarks.reference_simulator.result import ModeChange, ReferenceResult

_LEG = {
    "body_mass": "body_mass_kg",
    "foot_mass": "foot_mass_kg",
    "rest_length": "rest_length_m",
    "k_compression": "compression_stiffness_n_m",
    "k_extension": "extension_stiffness_n_m",
    "b_compression": "compression_damping_kg_s",
    "b_extension": "extension_damping_kg_s",
    "b_ad": "active_damping_kg_m",
    "force_cap": "constant_cap_n",
    "upper_link": "upper_link_m",
    "lower_link": "lower_link_m",
    "torque_constant": "torque_constant_n_m_a",
    "velocity_constant": "torque_constant_n_m_a",
    "motor_resistance": "motor_resistance_ohm",
    "switch_compression": "switch_compression_m",
    "guard_length": "shortest_leg_m",
}
_GRANULAR = {
    "foot_radius": "foot_radius_m",
    "kg_scale": "stiffness_scale",
    "bg_scale": "drag_scale",
    "cone_angle": "cone_angle_rad",
    "mu": "recruitment_rate",
    "k_sh": "penetration_stiffness_n_m",
    "sigma": "depth_stress_n_m3",
    "c_g": "surrounding_mass_factor",
    "b_g": "inertial_drag_factor",
    "added_mass_constant": "shed_mass_kg_m",
    "rho": "grain_density_kg_m3",
    "phi": "packing_fraction",
}
_HOPPING = {"switch_speed_tolerance": "velocity_tolerance_m_s", "rest_tolerance": "length_tolerance_m"}
_PLATFORM = {
    "platform_stiffness": "stiffness_n_m",
    "platform_damping": "damping_kg_s",
    "platform_drag": "lift_kg_m",
    "platform_travel": "travel_m",
    "release_time": "release_s",
    "reset_time": "reset_s",
    "engage_time": "engage_s",
    "release_tolerance": "release_length_m",
    "shortest_hold": "shortest_hold_s",
}
_CAPS = {ForceCap.NONE: (), ForceCap.CONSTANT: ("constant_force_cap",), ForceCap.TORQUE: ("torque_cap",)}
_COSTS = {
    CostForce.APPLIED: (),
    CostForce.COMMANDED: ("cost_of_commanded_force",),
    CostForce.TORQUE_LIMITED: ("cost_torque_cap",),
}


def scene_effects(p: GranularParameters | HoppingParameters) -> frozenset[str] | None:
    """The effects of a scene that is this case; None where no scene can be, as with contact at once."""
    common = {"leg_damping", "active_damping", "motor_heat", *_CAPS[p.force_cap], *_COSTS[p.cost_force]}
    if isinstance(p, HoppingParameters):
        ground = "rigid_ground" if p.platform is None else "emulated_ground"
        return frozenset(
            common | {ground, "touchdown_impact", "latched_switching", "short_leg_guard", "cost_of_whole_jump"}
        )
    if p.immediate_contact:
        return None
    common |= {"hydrostatic_stiffness", "inertial_drag", "added_mass", "contact_once_risen", "sampled_control"}
    common.add("latched_switching" if p.switching_rule == SwitchingRule.LATCHED else "short_leg_guard")
    if p.flight_gains == FlightGains.HELD:
        common.add("held_gains_in_flight")
    return frozenset(common)


def scene_values(p: GranularParameters | HoppingParameters) -> dict[str, Fraction]:
    """The parameters of a scene that is this case, in SI units, by their names in a scene file."""
    found = {"stall_torque": p.stall_torque_n_m / 2} | _read(p, _LEG)
    if isinstance(p, HoppingParameters):
        platform = {} if p.platform is None else _read(p.platform, _PLATFORM)
        return found | _read(p, _HOPPING) | platform | {"initial_velocity": Fraction(0), "initial_height": Fraction(0)}
    dropped = p.drop_height_m is not None
    return (
        found
        | _read(p, _GRANULAR)
        | {
            "control_rate": 1 / p.tick_s,
            "switch_speed_tolerance": Fraction(0),
            "rest_tolerance": Fraction(0),
            "initial_velocity": Fraction(0) if dropped else p.initial_velocity_m_s,
            "initial_height": Fraction(0) if p.drop_height_m is None else p.drop_height_m - p.rest_length_m,
        }
    )


def _read(p: object, names: Mapping[str, str]) -> dict[str, Fraction]:
    return {name: Fraction(getattr(p, field)) for name, field in names.items()}


DATA = Path(__file__).parents[2] / "simulator" / "accuracy" / "references"
STORED_DIGITS = 36
# A case is computed twice, with different working precision and different order of the series.
COARSE_DIGITS, COARSE_ORDER = 38, 28
FINE_DIGITS, FINE_ORDER = 48, 36


@dataclass(frozen=True, slots=True)
class StoredCase:
    """A case as stored; `agreeing_digits` is on how many digits both computations of every number agree."""

    name: str
    parameters: GranularParameters | HoppingParameters
    agreeing_digits: int
    jumps: tuple[ReferenceResult, ...]


def regenerate(scenes: Iterable[str] = tuple(CASES), folder: Path = DATA) -> None:
    """Compute the cases of the scenes anew and write their files; about ten minutes for all on one core."""
    for scene in scenes:
        found = []
        for case in cases(scene):
            coarse, fine = case.compute(COARSE_DIGITS, COARSE_ORDER), case.compute(FINE_DIGITS, FINE_ORDER)
            jumps = tuple(_shortened(jump) for jump in fine)
            found.append(StoredCase(case.name, case.parameters, agreeing_digits(coarse, fine), jumps))
        folder.mkdir(parents=True, exist_ok=True)
        (folder / f"{scene}.toml").write_text(document(scene, found), encoding="utf-8")


def stored(scene: str, folder: Path = DATA) -> tuple[StoredCase, ...]:
    """The stored cases of a scene; UnknownName if it has none."""
    cases(scene)
    document = tomllib.loads((folder / f"{scene}.toml").read_text(encoding="utf-8"))
    return tuple(_case(table) for table in document["case"])


def agreeing_digits(first: tuple[ReferenceResult, ...], second: tuple[ReferenceResult, ...]) -> int:
    """On how many significant digits two computations agree in all their numbers; 0 if their events differ."""
    agreement = STORED_DIGITS
    for one, other in zip(first, second, strict=True):
        if one.outcome != other.outcome or _modes(one) != _modes(other):
            return 0
        for left, right in zip(_numbers(one), _numbers(other), strict=True):
            if left != right:
                scale = max(abs(left), abs(right))
                agreement = min(agreement, -(abs(left - right) / scale).adjusted() - 1)
    return agreement


def _modes(result: ReferenceResult) -> list[str]:
    return [change.mode for change in result.mode_changes]


def _numbers(result: ReferenceResult) -> list[Decimal]:
    """Every number of a result but the energy residual, which is rounding alone."""
    values = [getattr(result, field.name) for field in fields(result) if field.name != "energy_residual_j"]
    return [value for value in values if isinstance(value, Decimal)] + [c.time_s for c in result.mode_changes]


def _shortened(result: ReferenceResult) -> ReferenceResult:
    """The result rounded to the digits that are stored."""
    context = Context(prec=STORED_DIGITS)
    rounded: dict[str, Any] = {
        field.name: context.plus(getattr(result, field.name))
        for field in fields(result)
        if isinstance(getattr(result, field.name), Decimal)
    }
    changes = tuple(ModeChange(context.plus(change.time_s), change.mode) for change in result.mode_changes)
    rounded["energy_residual_j"] = Context(prec=2).plus(result.energy_residual_j)
    return replace(result, mode_changes=changes, **rounded)


def document(scene: str, found: Iterable[StoredCase]) -> str:
    """The text of a scene's file."""
    return "\n".join(_lines(scene, found)) + "\n"


def _lines(scene: str, found: Iterable[StoredCase]) -> Iterator[str]:
    yield f"# Reference results of {scene}: Taylor series in fixed-point numbers, by benchmarks.reference_simulator."
    yield f"# Computed with {COARSE_DIGITS} digits at order {COARSE_ORDER} and {FINE_DIGITS} at order {FINE_ORDER}; SI."
    yield f'scene = "{scene}"'
    for case in found:
        yield from ("", "[[case]]", f'name = "{case.name}"', f"agreeing_digits = {case.agreeing_digits}")
        yield from ("", "[case.parameters]")
        yield from _entries(case.parameters)
        yield from _scene(case.parameters)
        for jump in case.jumps:
            yield from ("", "[[case.jump]]")
            yield from _entries(jump)


def _scene(parameters: GranularParameters | HoppingParameters) -> Iterator[str]:
    """The case in the words of the simulator's scenes, where one can be it: what results are found by."""
    effects = scene_effects(parameters)
    if effects is not None:
        yield from ("", "[case.scene]", f"effects = {json.dumps(sorted(effects))}", "", "[case.scene.values]")
        yield from (f'{name} = "{_plain(value)}"' for name, value in scene_values(parameters).items())


def _entries(record: LegParameters | PlatformParameters | ReferenceResult) -> Iterator[str]:
    """A dataclass as TOML; what is None is left out, what is a dataclass comes last."""
    nested: list[str] = []
    for field in fields(record):
        value = getattr(record, field.name)
        if isinstance(value, PlatformParameters):
            nested = ["", f"[case.parameters.{field.name}]", *_entries(value)]
        elif isinstance(value, tuple):
            yield f"{field.name} = ["
            yield from (f'  ["{change.time_s}", "{change.mode}"],' for change in value)
            yield "]"
        elif isinstance(value, bool):
            yield f"{field.name} = {str(value).lower()}"
        elif isinstance(value, Fraction):
            yield f'{field.name} = "{_plain(value)}"'
        elif value is not None:
            yield f'{field.name} = "{value}"'
    yield from nested


def _plain(value: Fraction) -> str:
    """A fraction as a decimal where it is one exactly."""
    decimal = Decimal(value.numerator) / Decimal(value.denominator)
    return f"{decimal:f}" if Fraction(decimal) == value else str(value)


def _case(table: dict[str, Any]) -> StoredCase:
    given = dict(table["parameters"])
    kind = HoppingParameters if "platform" in given or "straight_leg_m" in given else GranularParameters
    if "platform" in given:
        given["platform"] = PlatformParameters(**_typed(PlatformParameters, given["platform"]))
    parameters = kind(**_typed(kind, given))
    return StoredCase(table["name"], parameters, table["agreeing_digits"], tuple(map(_jump, table["jump"])))


def _typed(kind: type, given: dict[str, Any]) -> dict[str, Any]:
    """Strings as the type that the field of `kind` has: words, or exact rational numbers."""
    hints = get_type_hints(kind)
    typed: dict[str, Any] = {}
    for name, value in given.items():
        hint = hints[name]
        if not isinstance(value, str):
            typed[name] = value
        elif isinstance(hint, type) and issubclass(hint, StrEnum):
            typed[name] = hint(value)
        else:
            typed[name] = Fraction(value)
    return typed


def _jump(table: dict[str, Any]) -> ReferenceResult:
    values: dict[str, Any] = {field.name: None for field in fields(ReferenceResult)}
    values |= {name: Decimal(text) for name, text in table.items() if name not in ("outcome", "mode_changes")}
    values["outcome"] = table["outcome"]
    values["mode_changes"] = tuple(ModeChange(Decimal(time), mode) for time, mode in table["mode_changes"])
    return ReferenceResult(**values)
