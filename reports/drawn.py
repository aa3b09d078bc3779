"""A run's log as its figure draws it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True)
class LogJump:
    """One detected jump; times in s from the log's start, None where an event was not found.

    `excluded` is the reason why the jump is not used, "" where it is: a rule of the protocol or a person's verdict.
    `at_s` is where a jump without an apex stands, such as a misfire, and `apex_height_m` is None then.
    """

    number: int
    at_s: float
    apex_height_m: float | None
    touchdown_s: float | None = None
    lift_off_s: float | None = None
    excluded: str = ""
    misfire: bool = False


@dataclass(frozen=True, slots=True)
class LogGap:
    """A stretch without samples: dropped packets, a pause of the logger, or a restart between two logs.

    Where `length_known` is false nobody knows how long it was: the axis is broken there, and its times begin again.
    """

    start_s: float
    end_s: float
    kind: str
    length_known: bool = True


@dataclass(frozen=True, slots=True, eq=False)
class RunLog:
    """A run's log: `time_s` and `body_height_m` are arrays of shape (n_samples,), the jumps in order of time.

    `leg_length_m` has the same shape, NaN where it was not recorded; None where it nowhere was. `panel_jump` is the
    number of the jump shown enlarged; None takes the first that is used.
    """

    run: str
    title: str
    time_s: NDArray[np.float64]
    body_height_m: NDArray[np.float64]
    jumps: tuple[LogJump, ...] = ()
    gaps: tuple[LogGap, ...] = ()
    panel_jump: int | None = None
    leg_length_m: NDArray[np.float64] | None = None
