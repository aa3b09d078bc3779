"""What the effects of a scene are worth, as data for programs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

from data_schema.vocabulary import Undefined
from simulator.ablation.kernel_time import KernelTime
from simulator.ablation.leaving_out import LeftOut, in_order
from simulator.ablation.measure import Ablation
from simulator.ablation.outputs import Difference
from simulator.ablation.together import OUTPUTS
from simulator.scene import Scene


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
        **smallest_data(ablation),
    }


def chosen_data(ablation: Ablation | None) -> dict[str, Any]:
    """Return the smallest set where one was chosen, and that nothing is left out where none was."""
    return {"effects_left_out": []} if ablation is None else smallest_data(ablation)


def smallest_data(ablation: Ablation) -> dict[str, Any]:
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


def time_data(time: KernelTime) -> dict[str, float]:
    """Return a kernel's times."""
    return asdict(time)


def times_data(times: Mapping[str, KernelTime]) -> dict[str, dict[str, float]]:
    """Return the times of the kernels without each effect."""
    return {name: time_data(time) for name, time in times.items()}


def _left_out(item: LeftOut) -> dict[str, Any]:
    return {
        "without": item.effects,
        **difference_data(item.difference),
        "undefined": next((value.reason for value in item.difference.changes if isinstance(value, Undefined)), None),
        **asdict(item.outputs),
    }
