"""The two controllers that ch. 3 compares, and what is computed for both."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Generic, TypeVar

from simulator.scene import Scene

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Pair(Generic[T]):
    """The same thing with compression-extension (CE) and with active damping (AD)."""

    ce: T
    ad: T


def both_controllers(scene: Scene) -> Pair[Scene]:
    """Return the scene of set 1 without and with active damping; it is shipped with (thesis 3.2)."""
    return Pair(ce=scene.changed({"b_ad": 0.0}), ad=scene)
