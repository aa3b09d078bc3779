"""What the demonstration campaign consists of: runs, corrections, and all of it together."""

from __future__ import annotations

import datetime as dt
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from data_schema.vocabulary import RunKind
from labbook.demo.truth import Condition, Truth


@dataclass(frozen=True, slots=True)
class Correction:
    """A fact that was written down wrong and put right later."""

    run: str
    field: str
    written: str
    right: str
    why: str


@dataclass(frozen=True, slots=True, eq=False)
class DemoRun:
    """One run as it truly was, with what the instruments measured of it.

    `apex_heights_m` and `misfired` have one element a jump made; the apex of a misfired jump was never reached.
    Idle and characterisation runs have no elements in either.
    """

    name: str
    date: dt.date
    position: int
    kind: RunKind
    condition: Condition | None
    battery: str
    started: dt.datetime
    duration_s: int
    jumps_made: int
    starts: int
    note: str
    charge_mah: int
    recharge_minutes: int
    recharge_ended: dt.datetime
    end_voltage_v: float
    apex_heights_m: NDArray[np.float64]
    misfired: NDArray[np.bool_]

    @property
    def reached_apexes_m(self) -> NDArray[np.float64]:
        """True apex heights of the jumps that left the ground, in order."""
        return self.apex_heights_m[~self.misfired]


@dataclass(frozen=True, slots=True, eq=False)
class Campaign:
    """The whole campaign: truth, runs in the order they were made, and the corrections to make."""

    seed: int
    truth: Truth
    runs: tuple[DemoRun, ...]
    corrections: tuple[Correction, ...]

    def of_kind(self, kind: RunKind) -> tuple[DemoRun, ...]:
        """Return the runs of one kind, in order."""
        return tuple(run for run in self.runs if run.kind is kind)
