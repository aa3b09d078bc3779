"""A simulated scene as a table for people and as data for programs."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

from labbook.presenting.durations import time_text
from labbook.presenting.simulation.jump_warnings import times, warnings
from labbook.presenting.simulation.mode_names import mode_name
from simulator.declared import all_parameters
from simulator.effects.registry import EFFECTS
from simulator.jump import grown_rounding
from simulator.result import JumpResult, SceneResult
from simulator.scene import Scene

OUTCOMES = {
    "liftoff": "the foot left the ground",
    "apex": "the robot jumped and reached its apex",
    "touchdown": "the robot jumped and came down again",
    "no_liftoff": "the foot never left the ground",
    "no_trigger": "the robot came to rest without extending its leg",
    "carried": "the rising platform met the foot again before the body fell",
    "leg_folded": "the leg folded",
    "leg_straight": "the leg was stretched straight",
    "timeout": "the flight did not end in the time allowed",
    "step_limit": "the motion took more steps than are allowed",
}
"""Sentences of the outcomes."""

_WHOLE = ("liftoff", "apex", "touchdown")
"""Outcomes of jumps whose cost is whole."""

COST, COST_SO_FAR = "cost of the jump", "cost until it ended"

ROWS = (
    ("touchdown", "touchdown_time_s", "s after the start"),
    ("lift-off", "liftoff_time_s", "s after touchdown"),
    ("apex", "apex_time_s", "s after touchdown"),
    ("next touchdown", "next_touchdown_time_s", "s after touchdown"),
    ("deepest foot", "max_depth_m", "m below the surface"),
    ("apex of the body", "apex_height_m", "m above the surface"),
    ("lowest body", "min_body_height_m", "m above the surface"),
    ("body height at lift-off", "liftoff_body_height_m", "m above the surface"),
    ("body velocity at lift-off", "liftoff_body_velocity_m_s", "m/s"),
    ("foot velocity at lift-off", "liftoff_foot_velocity_m_s", "m/s"),
    ("body velocity at next touchdown", "next_touchdown_body_velocity_m_s", "m/s"),
    ("shortest leg", "min_leg_length_m", "m"),
    ("longest leg", "max_leg_length_m", "m"),
    ("force capped for", "capped_time_s", "s"),
    (COST, "cost_J", "J"),
    ("  heat in the motors", "{span}_heat_J", "J"),
    ("  mechanical", "{span}_mechanical_J", "J"),
    ("  motors' drag", "{span}_drag_J", "J"),
    ("  passive draw", "passive_J", "J"),
    ("work of the leg", "leg_work_J", "J"),
    ("  lost to the ground", "ground_loss_J", "J"),
    ("  brought by the grains", "grain_energy_J", "J"),
    ("  lost to the rail", "friction_loss_J", "J"),
    ("  lost at impacts", "impact_loss_J", "J"),
    ("  platform's reset", "reset_work_J", "J"),
)
"""Lines of the table: name, key of the result, unit; the cost is summed over the stance or the whole jump."""

_ALWAYS = ("liftoff_time_s", "max_depth_m", "apex_height_m", "cost_J")
_BRANCHES = ("as decided", "had it fallen otherwise")


def as_data(result: SceneResult) -> dict[str, Any]:
    """Return everything a simulation gave, for JSON: the last jump's values at the top, and all jumps in a list."""
    scene = result.scene
    return {
        "scene": scene.name,
        "title": scene.title,
        "effects": [name for name in EFFECTS if name in scene.effects],
        "values": {name: scene[name] for name in scene.read},
        "assumed": {name: scene.values[name].why for name in scene.assumed},
        "set_by_user": {name: scene[name] for name in scene.set_by_user},
        "accuracy": result.accuracy,
        "compile_time_s": result.compile_time_s,
        "wall_time_s": result.wall_time_s,
        **_jump_data(scene, result.jump),
        "jumps": [_jump_data(scene, jump) for jump in result.jumps],
    }


def _jump_data(scene: Scene, jump: JumpResult) -> dict[str, Any]:
    """Return a jump's values; a change of mode has the names of the scene's ground beside the kernel's."""
    data: dict[str, Any] = _finite(asdict(jump))
    for branch in (data, data["other_branch"] or {}):
        for change in branch.get("mode_changes", ()):
            change |= {f"{side}_name": mode_name(scene, change[side]) for side in ("before", "after")}
    return data


def _finite(value: Any) -> Any:
    """Put None where a number is infinite or none: JSON has neither."""
    if isinstance(value, float) and not math.isfinite(value):
        return None
    if isinstance(value, Mapping):
        return {key: _finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(item) for item in value]
    return value


def as_lines(result: SceneResult) -> list[str]:
    """Return the table that people read, with what the numbers rest on."""
    jump, scene = result.jump, result.scene
    many = len(result.jumps) > 1 or scene.jumps > 1
    which = f", jump {len(result.jumps)} of {scene.jumps}" if many else ""
    return [
        f"{scene.name}: {scene.title}",
        f"{outcome_text(jump.outcome, which)}.",
        *warnings(result),
        "",
        *_table(result),
        *(_all_jumps(result) if many else []),
        "",
        *_notes(result),
        *set_by_user_line(scene),
        *_assumed(scene),
        f"{abs(jump.energy_residual_J):.1e} J are not accounted for, of {jump.energy_at_play_J:.3g} J that the energy "
        "book turns over.",
        _effort(result),
    ]


def outcome_text(outcome: str, which: str = "") -> str:
    """Say how a jump ended, with the outcome's name."""
    return f"{OUTCOMES.get(outcome, outcome)} ({outcome}{which})"


def title_text(scene: Scene, which: str, outcome: str) -> str:
    """Return what heads a figure: the scene, which of its jumps is shown, and how that ended where it ended early."""
    ended = "" if outcome in _WHOLE else f"; {outcome_text(outcome)}"
    return f"{scene.name}{which}: {scene.title}{ended}"


def _effort(result: SceneResult) -> str:
    """Say what all jumps took, as the time is that of all."""
    steps, evaluations = (sum(getattr(jump, name) for jump in result.jumps) for name in ("steps", "rhs_evaluations"))
    where = f" in {_jumps_text(result)}" if result.scene.jumps > 1 else ""
    return (
        f"{steps} steps, {evaluations} evaluations{where} for a relative error of {result.accuracy:g}; "
        f"{time_text(result.wall_time_s)}, after {time_text(result.compile_time_s)} of compiling."
    )


def _digits(accuracy: float) -> int:
    """Return how many digits an accuracy is worth, and one."""
    return min(13, max(3, 1 + math.ceil(-math.log10(accuracy))))


def _table(result: SceneResult) -> list[str]:
    """Set the jump's numbers in columns, those of the other branch beside them; what is 0 or absent is left out."""
    jump, digits = result.jump, _digits(max(result.accuracy, grown_rounding(result.jump, result.accuracy)))
    span = "jump" if "cost_of_whole_jump" in result.scene.effects else "stance"
    branches = [jump] if jump.other_branch is None else [jump, jump.other_branch]
    rows = (
        [("", *_BRANCHES, ""), ("outcome", *(branch.outcome for branch in branches), "")] if len(branches) > 1 else []
    )
    for name, key, unit in ROWS:
        values = [getattr(branch, key.format(span=span)) for branch in branches]
        if any(value not in (None, 0.0) for value in values) or key in _ALWAYS:
            shown = COST_SO_FAR if name == COST and jump.outcome not in _WHOLE else name
            rows.append((shown, *(_number(value, digits) for value in values), unit))
    widths = [max(map(len, cells)) for cells in zip(*rows, strict=True)]
    return ["  ".join(f"{cell:<{width}}" for cell, width in zip(row, widths, strict=True)).rstrip() for row in rows]


def _number(value: float | None, digits: int) -> str:
    return "-" if value is None else f"{value:.{digits}g}"


def _all_jumps(result: SceneResult) -> list[str]:
    apexes = [jump.apex_height_m for jump in result.jumps if jump.apex_height_m is not None]
    total = sum(jump.cost_J for jump in result.jumps)
    heights = f", apexes of {min(apexes):.4g} to {max(apexes):.4g} m" if apexes else ""
    edges, unclosed = (sum(getattr(jump, flag) for jump in result.jumps) for flag in ("ill_conditioned", "open_book"))
    flagged = f", {edges} of them ill-conditioned" if edges else ""
    flagged += f", {unclosed} with an energy book that does not close" if unclosed else ""
    return ["", f"{_jumps_text(result)}{flagged}: {total:.6g} J{heights}."]


def _jumps_text(result: SceneResult) -> str:
    """Say how many jumps were simulated: "all 80 jumps", "3 of 80 jumps" where the third ended otherwise."""
    made, wanted = len(result.jumps), result.scene.jumps
    return f"all {wanted} jumps" if made == wanted else f"{made} of {wanted} jumps"


def _notes(result: SceneResult) -> list[str]:
    jump, scene = result.jump, result.scene
    reach_m = scene["upper_link"] + scene["lower_link"]
    notes = []
    if jump.max_leg_length_m > reach_m and jump.outcome != "leg_straight":
        notes.append(
            f"note: in flight the leg would be {jump.max_leg_length_m:.4g} m long, more than its links reach "
            f"({reach_m:.4g} m)."
        )
    counted = {name: sum(item.counters.get(name, 0) for item in result.jumps) for name in jump.counters}
    if any(counted.values()):
        notes.append(
            "note: "
            + ", ".join(f"{name.replace('_', ' ')} {times(count)}" for name, count in counted.items() if count)
            + (f" in {_jumps_text(result)}." if scene.jumps > 1 else ".")
        )
    return notes


def set_by_user_line(scene: Scene) -> list[str]:
    """Return a line with the parameters that were set by who uses the scene; none where none was."""
    texts = [_value_text(scene, name) for name in scene.set_by_user]
    return [f"set by you: {', '.join(texts)}."] if texts else []


def _assumed(scene: Scene) -> list[str]:
    if not scene.assumed:
        return [f"every {'other ' if scene.set_by_user else ''}parameter has a source."]
    return ["rests on assumed parameters:", *(f"  {text}" for text in assumed_texts(scene))]


def assumed_texts(scene: Scene) -> list[str]:
    """Return each assumed parameter that is in force with its value and why it was chosen."""
    return [f"{_value_text(scene, name)}: {scene.values[name].why}" for name in scene.assumed]


def _value_text(scene: Scene, name: str) -> str:
    unit = all_parameters()[name].unit
    return f"{name} = {scene[name]:g}{'' if unit == '1' else ' ' + unit}"
