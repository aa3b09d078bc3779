"""The published experiments in which jumps follow each other, simulated once a process."""

from __future__ import annotations

import functools

from simulator.steady.tables import SteadyTables
from simulator.steady.tables import steady_tables as simulated


@functools.cache
def steady_tables() -> SteadyTables:
    """Emulator and force plate as `labbook sim published` has them."""
    return simulated()
