"""What a scene does without its effects: a table and sentences for people, data for programs."""

from __future__ import annotations

from typing import Any

from data_schema.vocabulary import Undefined
from labbook.presenting.simulation.simulated import scene_data, which_jump
from labbook.terminal import columns
from simulator.ablation import COMPARED, STEPS_MORE, Ablation, Without, most_steps
from simulator.result import SceneResult
from simulator.scene import Scene


def as_lines(scene: Scene, ablation: Ablation) -> list[str]:
    """Return what is compared, the table of effects, why others stay, and which are enough."""
    head, *rows = alone_table(ablation)
    return [*heading(scene, ablation), "", *columns(head, rows), "", *_footnotes(ablation), "", *verdict(ablation)]


def heading(scene: Scene, ablation: Ablation) -> list[str]:
    """Say what is compared with what."""
    full, which = ablation.full.jump, which_jump(scene, ablation.scene.jumps)
    return [
        f"{scene.name}: {scene.title}",
        f"All {len(scene.effects)} effects{which}: cost {full.cost_J:.5g} J, apex {full.apex_height_m:.5g} m, "
        f"depth {full.max_depth_m:.5g} m ({full.outcome}).",
        *([f"warning: this jump is {_ILL_CONDITIONED}"] if full.ill_conditioned else []),
    ]


_ILL_CONDITIONED = "ill-conditioned, and less accurate than asked for: see labbook sim run."


def alone_table(ablation: Ablation) -> list[list[str]]:
    """Return the head and a row for each effect that may be left out, the one that changes most first."""
    rows = [
        [
            name + ("*" if item.result.jump.ill_conditioned else ""),
            *(_change(item.changes[name], ablation.accuracy) for name in COMPARED),
            _share(item.result.jump.rhs_evaluations / ablation.full.jump.rhs_evaluations - 1.0, 0.005),
        ]
        for name, item in sorted(ablation.alone.items(), key=lambda pair: -pair[1].largest)
    ]
    return [["without", *COMPARED, "evaluations"], *rows]


def verdict(ablation: Ablation) -> list[str]:
    """Name the effects that are enough, what is left out and what that changes."""
    gone = ablation.left_out
    share = f"{_digits(100.0 * ablation.tolerance)} %"
    share += f" in jump {len(ablation.full.jumps)}" if ablation.scene.jumps > 1 else ""
    if not gone.effects:
        return [f"Within {share}, none of the effects can be left out."]
    changed = ", ".join(f"{name} by {_change(gone.changes[name], ablation.accuracy)}" for name in COMPARED)
    beyond = [
        name for name in gone.effects if name in ablation.alone and ablation.alone[name].largest > ablation.tolerance
    ]
    unsure = ablation.full.jump.ill_conditioned or gone.result.jump.ill_conditioned
    return [
        f"Within {share}, {len(ablation.enough)} of {len(ablation.scene.effects)} effects are enough: "
        f"{', '.join(ablation.enough)}.",
        f"Left out, one after the other, those that change least: {', '.join(gone.effects)}; together that changes "
        f"{changed}. To simulate so: --effects {','.join(f'-{name}' for name in gone.effects)}",
        *([f"warning: one of these jumps is {_ILL_CONDITIONED}"] if unsure else []),
        *(
            [f"note: {', '.join(beyond)} alone would change more; here what else is left out makes up for it."]
            if beyond
            else []
        ),
    ]


def as_data(scene: Scene, ablation: Ablation) -> dict[str, Any]:
    """Return what leaving out each effect does, and the effects that are enough."""
    return {
        **scene_data(scene),
        "accuracy": ablation.accuracy,
        "jumps_measured": ablation.scene.jumps,
        "full": _last_jump(ablation.full),
        "alone": [
            {"without": item.effects, **_changes(item), "undefined": _undefined(item), **_last_jump(item.result)}
            for item in ablation.alone.values()
        ],
        "stay": dict(ablation.needed),
        "within": ablation.tolerance,
        "smallest_set": ablation.enough,
        "effects_left_out": ablation.left_out.effects,
        "change": _changes(ablation.left_out),
    }


def _undefined(item: Without) -> str | None:
    return next((value.reason for value in item.changes.values() if isinstance(value, Undefined)), None)


def _last_jump(result: SceneResult) -> dict[str, Any]:
    keys = ("outcome", "cost_J", "apex_height_m", "max_depth_m", "rhs_evaluations", "ill_conditioned")
    data = {key: getattr(result.jump, key) for key in keys}
    return {**data, "jumps": len(result.jumps), "most_steps": most_steps(result)}


def _changes(item: Without) -> dict[str, float | None]:
    return {name: None if isinstance(value, Undefined) else value for name, value in item.changes.items()}


def _footnotes(ablation: Ablation) -> list[str]:
    found = [item.result.jump for item in ablation.alone.values()]
    limit = f"step_limit: given up after {STEPS_MORE} times the steps of a jump with all effects."
    return [
        *(["* an ill-conditioned jump: see labbook sim run."] if any(one.ill_conditioned for one in found) else []),
        *([limit] if any(one.outcome == "step_limit" for one in found) else []),
        *(f"{name} stays: {sentence}" for name, sentence in ablation.needed.items()),
    ]


def _change(value: float | Undefined, accuracy: float) -> str:
    return value.reason if isinstance(value, Undefined) else _share(value, accuracy)


def _share(value: float, least: float = 0.0) -> str:
    return "0" if abs(value) <= least else f"{_digits(100.0 * value, '+')} %"


def _digits(value: float, sign: str = "-") -> str:
    return format(value, f"{sign}.3g" if abs(value) < 1000.0 else f"{sign}.0f")
