"""The simulator's guards as events of `scipy.integrate.solve_ivp`."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from simulator.accuracy.hybrid import HybridSystem

Row = NDArray[np.float64]
_JUST_BEFORE = -1e-300


@dataclass(slots=True)
class Event:
    """One guard as `solve_ivp` wants its events; at the start of a segment a guard at 0 is below it."""

    watched: Watched
    place: int
    armed: bool
    terminal: bool = True
    direction: float = 1.0

    def __call__(self, t: float, state: Row) -> float:
        """Return the guard at one instant, as `solve_ivp` asks for it."""
        value = float(self.watched.values(t, state)[self.place])
        return min(value, _JUST_BEFORE) if self.armed and t <= self.watched.start_s else value


class Watched:
    """All guards of a segment, evaluated once for each instant that `solve_ivp` asks about."""

    def __init__(self, system: HybridSystem, work: Row, start_s: float, state: Row) -> None:
        self._system, self._work, self.start_s, self._at = system, work, start_s, start_s
        self._first: Row = system.watch(start_s, work, state)
        self._values: Row = self._first

    def event(self, place: int) -> Event:
        """Return one guard of the segment as an event."""
        return Event(self, place, bool(self._first[place] <= 0.0))

    def values(self, t: float, state: Row) -> Row:
        """Return all guards at one instant, shape (guards,)."""
        if t != self._at:
            self._values = self._system.watch(t, self._work, np.ascontiguousarray(state))
            self._at = t
        return self._values
