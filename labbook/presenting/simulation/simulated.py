"""A simulated scene as a table for people and as data for programs.

What a contact mode is called on the ground of a scene: the kernel's names are those of grains.

Warnings about a simulated jump: no robot makes it, it hangs on little, or it is less accurate than asked for.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import asdict
from typing import Any

from data_schema.rounding import decimals_for, fixed_text
from labbook.terminal import columns
from reports.display import time_text
from simulator.declared import all_parameters
from simulator.effects.registry import BOOKED, COSTS, EFFECTS
from simulator.error_bars import largest_share
from simulator.jump import ILL_CONDITIONED_BELOW, close_decision, cost_span, grown_rounding, small_cost
from simulator.result import JumpResult, SceneResult
from simulator.scene import Scene

_MODE_NAMES: Mapping[str, Mapping[str, str]] = {
    "emulated_ground": {
        "intruding": "platform yields",
        "jammed": "platform held",
        "carried": "platform carries the foot up",
    },
    "rigid_ground": {"jammed": "stands"},
}
"""By ground, the names of modes on grounds that are no grains."""


def mode_name(scene: Scene, mode: str) -> str:
    """Return what one of the kernel's modes is called on the scene's ground; its own name where there is no other."""
    on_its_ground = (names for ground, names in _MODE_NAMES.items() if ground in scene.effects)
    return next(on_its_ground, {}).get(mode, mode)


def warnings(result: SceneResult) -> list[str]:
    """Return the warnings about a scene's last jump, which stand before its numbers."""
    return [f"warning: {sentence}" for sentence in _warnings(result)]


def _warnings(result: SceneResult) -> Iterator[str]:
    jump, scene, accuracy = result.jump, result.scene, result.accuracy
    if jump.under_surface:
        reach_m = scene["upper_link"] + scene["lower_link"]
        deeper = f", deeper than the longest leg ({reach_m:.4g} m)" if jump.max_depth_m > reach_m else ""
        yield (
            f"no robot jumps like this. The foot sinks {jump.max_depth_m:.4g} m{deeper}, and the body gets "
            f"{-jump.min_body_height_m:.4g} m under the surface of the grains, which act on the foot alone: give a "
            "larger foot or firmer grains."
        )
    doubts = [*_large_error(result), *(_ill_conditioned(result) if jump.ill_conditioned else ())]
    if jump.ill_conditioned and not doubts:
        first = next(number for number, item in enumerate(result.jumps, 1) if item.ill_conditioned)
        doubts.append(f"this jump follows jump {first}, which is ill-conditioned, and is known no better.")
    yield from doubts
    if jump.open_book:
        share = abs(jump.energy_residual_J) / jump.energy_at_play_J
        yield (
            f"the energy book of this jump does not close within the accuracy. It is off by {share:.1e} of what it "
            f"turns over, where {accuracy:g} was asked for, and so may be the other numbers."
        )
    if jump.cost_J <= 0.0 and jump.outcome in _WHOLE and "no_regeneration" not in scene.effects:
        yield (
            f"the cost of this jump is not positive ({jump.cost_J:.3g} J). Its mechanical part is the net work of the "
            "leg: what the leg takes up as it brakes is given back in full. For a drive that gives nothing back add "
            "--effects +no_regeneration."
        )


def _large_error(result: SceneResult) -> Iterator[str]:
    """Say that the finer simulation differs by more than the accuracy."""
    jump, accuracy = result.jump, result.accuracy
    if jump.errors is None:
        return
    if jump.coarser is not None:
        yield (
            f"at an accuracy of {accuracy:g} this jump ends otherwise ({jump.coarser.outcome}) than at "
            f"{result.finer_accuracy:g} ({jump.outcome}); both are shown."
        )
    elif not jump.errors:
        yield f"at an accuracy of {accuracy:g} the robot does not make this jump."
    elif (share := largest_share(jump, jump.errors)) > accuracy:
        known = f"only to {100.0 * share:.2g} % at best" if math.isfinite(share) else "not in all its numbers"
        yield f"this jump is known {known}, where {accuracy:g} was asked for."


def _ill_conditioned(result: SceneResult) -> Iterator[str]:
    """Say why the last jump is ill-conditioned for itself."""
    jump = result.jump
    if jump.decision_margin == 0.0 and "sampled_control" not in result.scene.effects:
        yield (
            "the controller, which has no clock, chatters in this jump: it changes its phase again and again, the more "
            "often the finer the steps, and each time adds its own error."
        )
    elif close_decision(jump):
        where = "an event of its motion" if jump.decision_tick is None else f"the decision at tick {jump.decision_tick}"
        yield (
            f"this jump hangs on a knife's edge: {where} is only {jump.decision_margin:.2g} local errors away from "
            f"falling otherwise (under {ILL_CONDITIONED_BELOW:g} is ill-conditioned)."
        )
    if rounding := grown_rounding(jump, result.accuracy):
        yield (
            "errors grow in this jump. Sampled damping, or a slow foot at touchdown, multiplies them by up to "
            f"{jump.error_growth:.2g}, so that rounding alone leaves an error of about {100.0 * rounding:.2g} %, "
            "however fine the accuracy asked for."
        )
    if small_cost(jump.cost_J, jump.energy_at_play_J):
        yield (
            f"the cost is a small difference of larger energies ({jump.cost_J:.2g} J, where "
            f"{jump.energy_at_play_J:.2g} J are turned over), and its relative error is as much larger."
        )


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

_NEVER_ROSE = "the robot did not jump: the lifted foot never rose above its print, until the body fell"
"""Sentence of a touchdown that is none."""

_WHOLE = ("liftoff", "apex", "touchdown")
"""Outcomes of jumps whose cost is whole."""

COST, COST_SO_FAR = "cost of the jump", "cost until it ended"

ROWS = (
    ("touchdown", "touchdown_time_s", "s after the start"),
    ("lift-off", "liftoff_time_s", "s after touchdown"),
    ("apex", "apex_time_s", "s after touchdown"),
    ("next touchdown", "next_touchdown_time_s", "s after touchdown"),
    ("deepest foot", "max_depth_m", "m below the surface"),
    ("lifted foot sank", "unresisted_sink_m", "m below its print, unresisted"),
    ("apex of the body", "apex_height_m", "m above the surface"),
    ("foot at the apex", "apex_foot_height_m", "m above the surface"),
    ("lowest body", "min_body_height_m", "m above the surface"),
    ("body height at lift-off", "liftoff_body_height_m", "m above the surface"),
    ("body velocity at lift-off", "liftoff_body_velocity_m_s", "m/s"),
    ("foot velocity at lift-off", "liftoff_foot_velocity_m_s", "m/s"),
    ("body velocity at next touchdown", "next_touchdown_body_velocity_m_s", "m/s"),
    ("shortest leg", "min_leg_length_m", "m"),
    ("longest leg", "max_leg_length_m", "m"),
    ("force capped for", "capped_time_s", "s"),
    (COST, "cost_J", "J"),
    ("  mechanical", "{span}_mechanical_J", "J"),
    *((f"  {energy.label}", f"{{span}}_{energy.name}_J", "J") for energy in COSTS),
    ("  passive draw", "passive_J", "J"),
    ("work of the leg", "leg_work_J", "J"),
    *((f"  {energy.label}", energy.column, "J") for energy in BOOKED),
)
"""Lines of the table: name, key of the result, unit; the cost is summed over the stance or the whole jump."""

_ROUNDING, _MOST_DIGITS = 1e-13, 12
"""An error of at most this share of a number is rounding; so many digits are shown of it."""
_MUCH_DRAG = 5.0
"""Drag of the motors, over the energy that a jump turns over, from which on it is remarked."""
_MOST_SHOWN, _SHOWN_AT_AN_END = 20, 5
"""So many jumps have a line each; of more, those at both ends."""
_ALWAYS = ("liftoff_time_s", "max_depth_m", "apex_height_m", "cost_J")


def scene_data(scene: Scene) -> dict[str, Any]:
    """Return what a scene is, for JSON."""
    return {
        "scene": scene.name,
        "title": scene.title,
        "effects": [name for name in EFFECTS if name in scene.effects],
        "values": {name: scene[name] for name in scene.read},
        "assumed": {name: scene.values[name].why for name in scene.assumed},
        "set_by_user": {name: scene[name] for name in scene.set_by_user},
    }


def as_data(result: SceneResult) -> dict[str, Any]:
    """Return everything a simulation gave, for JSON: the last jump's values at the top, and all jumps in a list."""
    scene = result.scene
    return {
        **scene_data(scene),
        "accuracy": result.accuracy,
        "finer_accuracy": result.finer_accuracy,
        "compile_time_s": result.compile_time_s,
        "interpreted": result.interpreted,
        "wall_time_s": result.wall_time_s,
        **_jump_data(scene, result.jump),
        "jumps": [_jump_data(scene, jump) for jump in result.jumps],
    }


def _jump_data(scene: Scene, jump: JumpResult) -> dict[str, Any]:
    """Return a jump's values; a change of mode has the names of the scene's ground beside the kernel's."""
    data: dict[str, Any] = finite(asdict(jump))
    for branch in (data, data["other_branch"] or {}, data["coarser"] or {}):
        for change in branch.get("mode_changes", ()):
            change |= {f"{side}_name": mode_name(scene, change[side]) for side in ("before", "after")}
    return data


def finite(value: Any) -> Any:
    """Put None where a number is infinite or none: JSON has neither."""
    if isinstance(value, float) and not math.isfinite(value):
        return None
    if isinstance(value, Mapping):
        return {key: finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [finite(item) for item in value]
    return value


def as_lines(result: SceneResult) -> list[str]:
    """Return the table for people, with the assumed parameters."""
    jump, scene, which = result.jump, result.scene, which_jump(result.scene, len(result.jumps))
    outcome, remedy = jump.outcome, ""
    if outcome == "no_liftoff":
        firmer = " or firmer ground" if "hydrostatic_stiffness" in scene.effects else ""
        remedy = f": try a higher k_extension{firmer}"
    assumed = [f"every {'other ' if scene.set_by_user else ''}parameter has a source."]
    if scene.assumed:
        assumed = ["rests on assumed parameters:", *(f"  {text}" for text in assumed_texts(scene))]
    steps, evaluations = (sum(getattr(jump, name) for jump in result.jumps) for name in ("steps", "rhs_evaluations"))
    compiled = f", after {time_text(result.compile_time_s)} of compiling"
    if result.interpreted and not result.compile_time_s:
        compiled = " in plain Python, as no kernel is compiled for these effects yet (labbook sim warm)"
    return [
        f"{scene.name}: {scene.title}",
        f"{_NEVER_ROSE if jump.never_rose else OUTCOMES.get(outcome, outcome)} ({outcome}{which}){remedy}.",
        *warnings(result),
        "",
        *_table(result),
        *(_all_jumps(result) if which else []),
        "",
        *_notes(result),
        *set_by_user_line(scene),
        *assumed,
        f"{abs(jump.energy_residual_J):.1e} J are not accounted for, of {jump.energy_at_play_J:.3g} J that the energy "
        "book turns over.",
        f"{steps} steps, {evaluations} evaluations{_in_all_jumps(result)} for a relative error of "
        f"{result.finer_accuracy or result.accuracy:g}; {time_text(result.wall_time_s)}{compiled}.",
    ]


def which_jump(scene: Scene, number: int) -> str:
    """Say which jump of a scene with many is meant: ", jump 3 of 80"."""
    return f", jump {number} of {scene.jumps}" if scene.jumps > 1 else ""


def title_text(scene: Scene, which: str, outcome: str) -> str:
    """Return what heads a figure: the scene, which of its jumps is shown, and how that ended where it ended early."""
    ended = "" if outcome in _WHOLE else f"; {OUTCOMES.get(outcome, outcome)} ({outcome})"
    return f"{scene.name}{which}: {scene.title}{ended}"


def figure_title(result: SceneResult) -> str:
    """Return what heads the figure of a scene's last jump."""
    return title_text(result.scene, which_jump(result.scene, len(result.jumps)), result.jump.outcome)


def _digits(accuracy: float) -> int:
    """Return how many digits an accuracy justifies, and one more."""
    return min(13, max(3, 1 + math.ceil(-math.log10(accuracy))))


def _table(result: SceneResult) -> list[str]:
    """Set the jump's numbers in columns, those of the other branch beside them; what is 0 or absent is left out."""
    jump, digits = result.jump, _digits(max(result.accuracy, grown_rounding(result.jump, result.accuracy)))
    span = cost_span(result.scene.effects)
    others = {
        f"at {result.accuracy:g}": jump.coarser,
        "had it fallen otherwise": jump.other_branch if jump.ill_conditioned else None,
    }
    beside = {name: other for name, other in others.items() if other is not None}
    branches = [jump, *beside.values()]
    own = f"at {result.finer_accuracy:g}" if jump.coarser else "as decided"
    outcomes = (branch.outcome for branch in beside.values())
    rows = [("", own, "", *beside, ""), ("outcome", jump.outcome, "", *outcomes, "")] if beside else []
    for name, key, unit in ROWS:
        field = key.format(span=span)
        values = [getattr(branch, field) for branch in branches]
        if any(value not in (None, 0.0) for value in values) or key in _ALWAYS:
            shown = COST_SO_FAR if name == COST and jump.outcome not in _WHOLE else name
            error = None if jump.errors is None else jump.errors.get(field)
            number, bar = _with_error(values[0], error, digits, jump.ill_conditioned)
            rows.append((shown, number, bar, *(_number(value, digits) for value in values[1:]), unit))
    used = [any(cells) for cells in zip(*rows, strict=True)]
    head, *rest = ([cell for cell, shown in zip(row, used, strict=True) if shown] for row in rows)
    return columns(head, rest)


def _with_error(value: float | None, error: float | None, digits: int, unsettled: bool) -> tuple[str, str]:
    """Write a number to the digits that its error leaves, and the error; without one, to so many digits.

    Where simulations do not settle, the difference of two of them is the least that the error may be.
    """
    if value is None or error is None:
        return _number(value, digits), ""
    if error <= abs(value) * _ROUNDING:
        return _number(value, _MOST_DIGITS), "± rounding"
    return fixed_text(value, decimals_for(error)), f"± {'at least ' if unsettled else ''}{error:.1e}"


def _number(value: float | None, digits: int) -> str:
    return "-" if value is None else f"{value:.{digits}g}"


def _all_jumps(result: SceneResult) -> list[str]:
    """Sum up all jumps, and set each in a line: apex, cost, and how it ended where that is not by a touchdown."""
    apexes = [jump.apex_height_m for jump in result.jumps if jump.apex_height_m is not None]
    heights = f", apexes of {min(apexes):.4g} to {max(apexes):.4g} m" if apexes else ""
    edges, unclosed = (sum(getattr(jump, flag) for jump in result.jumps) for flag in ("ill_conditioned", "open_book"))
    flagged = f", {edges} of them ill-conditioned" if edges else ""
    flagged += f", {unclosed} with an energy book that does not close" if unclosed else ""
    made, digits, rows = len(result.jumps), _digits(result.accuracy), list[list[str]]()
    for number, jump in enumerate(result.jumps, 1):
        flags = (
            name for name in ("never_rose", "ill_conditioned", "under_surface", "open_book") if getattr(jump, name)
        )
        ended = ", ".join([*([jump.outcome] if jump.outcome != "touchdown" else []), *flags]).replace("_", " ")
        rows.append([str(number), _number(jump.apex_height_m, digits), _number(jump.cost_J, digits), ended])
    if made > _MOST_SHOWN:
        gap = ["...", "", "", f"{made - 2 * _SHOWN_AT_AN_END} more: --json"]
        rows = [*rows[:_SHOWN_AT_AN_END], gap, *rows[-_SHOWN_AT_AN_END:]]
    total = sum(jump.cost_J for jump in result.jumps)
    said = f"{_jumps_text(result)}{flagged}: {total:.6g} J{heights}."
    return ["", said, *columns(["jump", "apex m", "cost J", ""], rows)]


def _jumps_text(result: SceneResult) -> str:
    """Say how many jumps were simulated: "all 80 jumps", "3 of 80 jumps" where the third ended otherwise."""
    made, wanted = len(result.jumps), result.scene.jumps
    return f"all {wanted} jumps" if made == wanted else f"{made} of {wanted} jumps"


def _in_all_jumps(result: SceneResult) -> str:
    return f" in {_jumps_text(result)}" if result.scene.jumps > 1 else ""


def _notes(result: SceneResult) -> Iterator[str]:
    jump, scene = result.jump, result.scene
    drag_j = getattr(jump, f"{cost_span(scene.effects)}_drag_J")
    if drag_j > _MUCH_DRAG * jump.energy_at_play_J:
        yield (
            f"note: the motors' drag takes {drag_j:.3g} J, {drag_j / jump.energy_at_play_J:.2g} times all that the "
            "energy book turns over. It is the loss of motors that are short-circuited as they turn, and grows with "
            "the square of a gear's ratio: for motors that are driven leave it out, --effects -drag."
        )
    reach_m = scene["upper_link"] + scene["lower_link"]
    if jump.max_leg_length_m > reach_m and jump.outcome != "leg_straight":
        yield (
            f"note: in flight the leg would be {jump.max_leg_length_m:.4g} m long, more than its links reach "
            f"({reach_m:.4g} m)."
        )
    if jump.apex_foot_height_m is not None and jump.apex_foot_height_m < 0.0 and not jump.never_rose:
        yield (
            f"note: at the apex the foot is {-jump.apex_foot_height_m:.3g} m below the surface: it does not clear it, "
            "and the robot jumps within its own hole."
        )
    counted = {name: sum(item.counters.get(name, 0) for item in result.jumps) for name in jump.counters}
    if any(counted.values()):
        counts = ", ".join(f"{name.replace('_', ' ')} {count} times" for name, count in counted.items() if count)
        yield f"note: {counts}{_in_all_jumps(result)}."


def set_by_user_line(scene: Scene) -> list[str]:
    """Return a line with the parameters that were set by who uses the scene; none where none was."""
    texts = [_value_text(scene, name) for name in scene.set_by_user]
    return [f"set by you: {', '.join(texts)}."] if texts else []


def assumed_texts(scene: Scene) -> list[str]:
    """Return each assumed parameter that is in force with its value and why it was chosen."""
    return [f"{_value_text(scene, name)}: {scene.values[name].why}" for name in scene.assumed]


def _value_text(scene: Scene, name: str) -> str:
    return f"{name} = {scene[name]:g}{all_parameters()[name].unit_text}"
