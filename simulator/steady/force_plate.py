"""Experiments on the force plate (thesis 3.2.2), simulated: compression-extension at four gains on rigid ground."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from simulator.gains import stiffness_n_m
from simulator.scene import Scene
from simulator.scene_file import load_scene
from simulator.steady.steady_jump import SteadyJump, steady_jump

GAINS = (300.0, 400.0, 500.0, 600.0)
ESTIMATED_OVER_MEASURED = 1.35
"""Slope of the joules estimated from the plate's forces over those that the battery gave (thesis 3.2.2)."""


@dataclass(frozen=True, slots=True)
class PlateRow:
    """An extension gain."""

    gain: float
    jump: SteadyJump

    @property
    def battery_j(self) -> float:
        """Return the joules of a jump that the battery would give, were the published slope that of the simulation."""
        return self.jump.cost_j / ESTIMATED_OVER_MEASURED


@dataclass(frozen=True, slots=True)
class PlateTable:
    """The experiments at every gain; `scene` is the one they change."""

    scene: Scene
    rows: tuple[PlateRow, ...]


def plate_table(accuracy: float, done: Callable[[str], None]) -> PlateTable:
    """Simulate the experiments; `done` is told of each gain."""
    scene = load_scene("force_plate")
    rows = []
    for gain in GAINS:
        rows.append(PlateRow(gain, steady_jump(scene.changed({"k_extension": stiffness_n_m(gain)}), accuracy)))
        done(f"force plate, gain {gain:g}")
    return PlateTable(scene, tuple(rows))
