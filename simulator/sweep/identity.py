"""What identifies a sweep: all that its numbers depend on, and in words what differs between two."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping

from simulator.effects.registry import EFFECTS
from simulator.scene_file import write_scene
from simulator.sweep.chunks import simulator_here
from simulator.sweep.sweep import Sweep

Identity = Mapping[str, str | float]
FORMAT = 2
"""Version of how sweeps are stored."""
_NAMED = 3
_FOLLOWING = ("swept values", "text of the scene", "outputs", "chunk")
"""What says nothing to a person, and differs for itself only where nothing readable does."""


def identity_of(sweep: Sweep) -> dict[str, str | float]:
    """Return all that a sweep's numbers depend on, readable; equal for equal commands and simulators."""
    scene, design = sweep.scene, sweep.design
    swept = {
        f"sweep of {axis.name}": (
            f"{len(axis.values)} values from {axis.coordinates.min():.9g} to {axis.coordinates.max():.9g}"
        )
        for axis in design.axes
    }
    return {
        "scene": scene.name,
        "effects": ", ".join(name for name in EFFECTS if name in scene.effects),
        "jumps": scene.jumps,
        **{name: value.value for name, value in scene.values.items()},
        "accuracy": sweep.accuracy,
        **({"error bars": sweep.error_bars} if sweep.error_bars else {}),
        "sampling": design.description,
        **swept,
        "swept values": design.content_hash()[:20],
        "text of the scene": hashlib.sha256(write_scene(scene).encode()).hexdigest()[:20],
        "chunk": sweep.chunks.rows_each,
        "outputs": hashlib.sha256(" ".join(output.name for output in sweep.outputs).encode()).hexdigest()[:20],
        "simulator": simulator_here(),
        "labbook": sweep.labbook,
        "format": FORMAT,
    }


def differences(there: Identity, now: Identity) -> str:
    """Return in words what differs, the first few things; empty where nothing does."""
    names = [name for name in dict.fromkeys((*now, *there)) if there.get(name) != now.get(name)]
    readable = [name for name in names if name not in _FOLLOWING]
    changed = [f"{name} ({_shown(there.get(name))} there, {_shown(now.get(name))} now)" for name in readable[:_NAMED]]
    return " and ".join(changed or names)


def _shown(value: str | float | None) -> str:
    if value is None:
        return "none"
    return f"{value:.9g}" if isinstance(value, float) else str(value)
