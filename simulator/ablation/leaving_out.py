"""What a scene does without some of its effects."""

from __future__ import annotations

from dataclasses import dataclass

from data_schema.errors import UsageError
from simulator.ablation.interpreted import OutputsWithout
from simulator.ablation.outputs import Difference, Outputs, difference
from simulator.effects.registry import EFFECTS
from simulator.scene import Scene


@dataclass(frozen=True, slots=True)
class LeftOut:
    """Effects that are left out, in the registry's order, what the scene gives without them, and the difference."""

    effects: tuple[str, ...]
    outputs: Outputs
    difference: Difference


@dataclass(frozen=True, slots=True)
class LeavingOut:
    """A scene, the function that simulates it without some of its effects, and those that stay whatever they change."""

    scene: Scene
    outputs: OutputsWithout
    kept: frozenset[str] = frozenset()

    @property
    def full(self) -> Outputs:
        """What the scene gives with all its effects."""
        return self.outputs(frozenset())

    def measure(self, effects: frozenset[str]) -> LeftOut:
        """Simulate the scene without these effects; they must leave one that can be simulated."""
        found = self.outputs(effects)
        return LeftOut(in_order(effects), found, difference(found, self.full))


def in_order(effects: frozenset[str]) -> tuple[str, ...]:
    """Return effects in the registry's order."""
    return tuple(name for name in EFFECTS if name in effects)


def refusal(scene: Scene, effects: frozenset[str]) -> str | None:
    """Return the sentence that says why a scene cannot be without these effects, None where it can."""
    try:
        scene.changed(effects_off=effects)
    except UsageError as refused:
        return str(refused)
    return None
