"""The published experiments in which jumps follow each other, simulated."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from simulator.steady.emulator import GAINS as EMULATOR_GAINS
from simulator.steady.emulator import EmulatorTable, emulator_table
from simulator.steady.force_plate import GAINS as PLATE_GAINS
from simulator.steady.force_plate import PlateTable, plate_table

STEPS = len(EMULATOR_GAINS) + len(PLATE_GAINS)
"""How often `steady_tables` says that it is done with something."""


@dataclass(frozen=True, slots=True)
class SteadyTables:
    """Steady jumps on the ground emulator (thesis ch. 4) and the force plate (3.2.2), at one accuracy."""

    emulator: EmulatorTable
    force_plate: PlateTable
    accuracy: float


def steady_tables(accuracy: float = 1e-6, done: Callable[[str], None] = lambda _what: None) -> SteadyTables:
    """Simulate all experiments; `done` is told of each gain. Raises `UsageError` for an accuracy that cannot be had."""
    return SteadyTables(emulator_table(accuracy, done), plate_table(accuracy, done), accuracy)
