"""What a contact mode is called on the ground of a scene: the kernel's names are those of grains."""

from __future__ import annotations

from collections.abc import Mapping

from simulator.scene import Scene

MODE_NAMES: Mapping[str, Mapping[str, str]] = {
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
    on_its_ground = (names for ground, names in MODE_NAMES.items() if ground in scene.effects)
    return next(on_its_ground, {}).get(mode, mode)
