"""What a scene does without its effects: tables and sentences for people, data for programs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

from data_schema.vocabulary import Undefined
from reports.display import time_text
from simulator.ablation.kernel_time import KernelTime
from simulator.ablation.outputs import Difference
from simulator.ablation.smallest import LeftOut, in_order
from simulator.ablation.study import OUTPUTS, STEPS_MORE, Ablation, least_additive_pair
from simulator.scene import Scene

_FLAG = "*"
NOTHING = "-"
_GIVEN_UP = ("step_limit", "too_stiff")
_ILL_CONDITIONED = "is ill-conditioned, and less accurate than asked for: see labbook sim run."


def announcement(sets: int, kernels: int) -> str:
    """Say what will be done, before minutes go by without output."""
    tried = "1 set" if sets == 1 else f"{sets} sets"
    return (
        f"simulating without {tried} of effects, then compiling {kernels} kernels to time them: 10 to 30 s each, "
        "unless they were compiled before."
    )


def heading(scene: Scene, ablation: Ablation) -> list[str]:
    """Say what is compared with what."""
    jumps, full = ablation.scene.jumps, ablation.full
    which = f", jump {jumps} of {scene.jumps}" if scene.jumps > 1 else ""
    lines = [
        f"{scene.name}: {scene.title}",
        f"All {len(scene.effects)} effects{which}: cost {full.cost_J:.5g} J, apex "
        f"{_metres(full.apex_height_m)}, depth {_metres(full.max_depth_m)} ({full.outcome}).",
    ]
    if full.ill_conditioned:
        lines.append(f"warning: this jump {_ILL_CONDITIONED}")
    return lines


def alone_table(ablation: Ablation, times: Mapping[str, KernelTime], full_time: KernelTime | None) -> list[list[str]]:
    """Return the head and a row for each effect that may be left out, the one that changes most first.

    `times`: of the kernels without each effect, if they were measured.
    """
    head = ["without", *OUTPUTS, "evaluations", *(["time a jump"] if times else []), "most together with"]
    rows = []
    for name, item in sorted(ablation.alone.items(), key=lambda pair: -pair[1].difference.largest):
        cells = [name + _flag(item), *_changes(item, ablation)]
        cells.append(_share(item.outputs.rhs_evaluations / ablation.full.rhs_evaluations - 1.0, 0.005))
        if times and full_time is not None:
            cells.append(_share(times[name].time_per_jump_s / full_time.time_per_jump_s - 1.0, 0.005))
        rows.append([*cells, _together(ablation, name)])
    return [head, *rows]


def pairs_table(ablation: Ablation) -> list[list[str]]:
    """Return the head and a row for each pair that may be left out, the one that changes most first."""
    pairs = [item for names, item in ablation.pairs.items() if item.effects == names]
    pairs.sort(key=lambda item: -item.difference.largest)
    return [
        ["without", *OUTPUTS],
        *([" and ".join(item.effects) + _flag(item), *_changes(item, ablation)] for item in pairs),
    ]


def footnotes(ablation: Ablation) -> list[str]:
    """Say what marks mean, and why some effects have no row."""
    flagged = any(item.outputs.ill_conditioned for item in (*ablation.alone.values(), *ablation.pairs.values()))
    together = "most together with: without both the change is this, not that of both factors multiplied."
    mark = f"{_FLAG} an ill-conditioned jump: labbook sim run shows what it hangs on."
    ended = {item.outputs.outcome for item in (*ablation.alone.values(), *ablation.pairs.values())}
    given_up = [outcome for outcome in _GIVEN_UP if outcome in ended]
    limit = f"{' and '.join(given_up)}: given up after {STEPS_MORE} times the steps of a jump with all effects."
    return [
        *([together] if any(least_additive_pair(ablation, name) for name in ablation.alone) else []),
        *([mark] if flagged else []),
        *([limit] if given_up else []),
        *(f"{name} stays: {sentence}" for name, sentence in ablation.needed.items()),
    ]


def verdict(ablation: Ablation) -> list[str]:
    """Name the smallest set, what it leaves out and what that changes, and how it was searched."""
    found = ablation.smallest
    flagged = ablation.full.ill_conditioned or found.left_out.outputs.ill_conditioned
    share = percent(ablation.tolerance) + (f" in jump {ablation.full.jumps}" if ablation.scene.jumps > 1 else "")
    if not found.left_out.effects:
        return [f"Within {share}, none of the effects can be left out. {_search(ablation)}"]
    return [
        f"Within {share}, {len(found.effects)} of {len(ablation.scene.effects)} effects are enough: "
        f"{', '.join(found.effects)}.",
        f"Left out: {', '.join(found.left_out.effects)}; that changes "
        f"{difference_text(found.left_out.difference, ablation)}.",
        *([f"warning: one of these jumps {_ILL_CONDITIONED}"] if flagged else []),
        *_made_up_for(ablation),
        *_checked(ablation),
        _search(ablation),
    ]


def difference_text(difference: Difference, ablation: Ablation) -> str:
    """Write the changes of cost, apex and depth in a line, as 0 where they are below the accuracy."""
    changes = zip(OUTPUTS, difference.changes, strict=True)
    return ", ".join(f"{output} by {_change(value, ablation.accuracy)}" for output, value in changes)


def percent(share: float) -> str:
    """Write a share in percent."""
    return f"{_digits(100.0 * share)} %"


def time_lines(full: KernelTime, smallest: KernelTime) -> list[str]:
    """Say what a jump takes in both compiled kernels, and what compiling took."""
    ratio = smallest.time_per_jump_s / full.time_per_jump_s
    how = "" if full.compiled else " in plain Python (NUMBA_DISABLE_JIT is set)"
    jump, ready = [
        f"{time_text(first)} with all effects and {time_text(second)} with these"
        for first, second in (
            (full.time_per_jump_s, smallest.time_per_jump_s),
            (full.compile_time_s, smallest.compile_time_s),
        )
    ]
    return [f"A jump takes{how} {jump} ({percent(ratio)}); to compile or load the kernel took {ready}."]


def ablation_data(scene: Scene, ablation: Ablation) -> dict[str, Any]:
    """Return what leaving out each effect and each two does, and the smallest set."""
    return {
        "scene": scene.name,
        "title": scene.title,
        "effects": in_order(scene.effects),
        "set_by_user": {name: scene[name] for name in scene.set_by_user},
        "accuracy": ablation.accuracy,
        "jumps_measured": ablation.scene.jumps,
        "full": asdict(ablation.full),
        "alone": [_left_out(item) for item in ablation.alone.values()],
        "stay": dict(ablation.needed),
        "pairs": [
            _left_out(item) for (first, second), item in ablation.pairs.items() if item.effects == (first, second)
        ],
        **_smallest_data(ablation),
    }


def chosen_data(ablation: Ablation | None) -> dict[str, Any]:
    """Return the smallest set where one was chosen, and that nothing is left out where none was."""
    return {"effects_left_out": []} if ablation is None else _smallest_data(ablation)


def _smallest_data(ablation: Ablation) -> dict[str, Any]:
    """Return the smallest set: what it leaves out, what that changes, and how it was searched."""
    found = ablation.smallest
    return {
        "within": ablation.tolerance,
        "smallest_set": found.effects,
        "effects_left_out": found.left_out.effects,
        "change": difference_data(found.left_out.difference),
        "checked": {"jumps": ablation.checked.outputs.jumps, **difference_data(ablation.checked.difference)},
        "searched_within": ablation.searched_within,
        "candidates": found.candidates,
        "exhaustive": found.exhaustive,
    }


def difference_data(difference: Difference) -> dict[str, float | None]:
    """Return the relative changes, None where one is undefined."""
    return {
        name: None if isinstance(value, Undefined) else value
        for name, value in zip(OUTPUTS, difference.changes, strict=True)
    }


def _made_up_for(ablation: Ablation) -> list[str]:
    """Name the effects that are left out though they change too much alone."""
    beyond = [
        name
        for name in ablation.smallest.left_out.effects
        if name in ablation.alone and not ablation.alone[name].difference.within(ablation.tolerance)
    ]
    if not beyond:
        return []
    return [
        f"note: {', '.join(beyond)} alone would change more; only in this scene does what else is left out make up "
        "for it."
    ]


def _checked(ablation: Ablation) -> list[str]:
    """Say what the smallest set changes in later jumps than were measured."""
    if ablation.checked.outputs.jumps == ablation.full.jumps:
        return []
    changed = difference_text(ablation.checked.difference, ablation)
    lines = [f"In jump {ablation.checked.outputs.jumps} that changes {changed}."]
    if ablation.searched_within < ablation.tolerance:
        lines.append(
            f"The set was searched for {percent(ablation.searched_within)}, because differences grow from jump to jump."
        )
    return lines


def _search(ablation: Ablation) -> str:
    candidates = len(ablation.smallest.candidates)
    if not candidates:
        return "No effect can go, alone or with one other."
    if ablation.smallest.exhaustive:
        return f"All sets were tried of the {candidates} effects that can go alone or with one other."
    return (
        f"{candidates} effects can go alone or with one other; not all of their sets were tried, but none of the "
        "effects that remain can go."
    )


def _together(ablation: Ablation, effect: str) -> str:
    found = least_additive_pair(ablation, effect)
    if found is None:
        return NOTHING
    if isinstance(found.change, Undefined):
        return f"{found.partner}: {found.change.reason}"
    return f"{found.partner}: {found.output} {_share(found.change)}, not {_share(found.expected)}"


def _changes(item: LeftOut, ablation: Ablation) -> list[str]:
    return [_change(value, ablation.accuracy) for value in item.difference.changes]


def _flag(item: LeftOut) -> str:
    return _FLAG if item.outputs.ill_conditioned else ""


def _change(value: float | Undefined, accuracy: float) -> str:
    return value.reason if isinstance(value, Undefined) else _share(value, accuracy)


def _share(value: float, least: float = 0.0) -> str:
    return "0" if abs(value) <= least else f"{_digits(100.0 * value, '+')} %"


def _digits(value: float, sign: str = "-") -> str:
    return format(value, f"{sign}.3g" if abs(value) < 1000.0 else f"{sign}.0f")


def _metres(value: float | None) -> str:
    return "none" if value is None else f"{value:.5g} m"


def _left_out(item: LeftOut) -> dict[str, Any]:
    return {
        "without": item.effects,
        **difference_data(item.difference),
        "undefined": next((value.reason for value in item.difference.changes if isinstance(value, Undefined)), None),
        **asdict(item.outputs),
    }
