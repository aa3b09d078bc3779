"""What figures are drawn from that stand in no report: a run's log, a simulated jump, error against time."""

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


FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class ModeSpan:
    """A stretch of time in one contact mode, s; `name` is what the mode is called on this ground."""

    start_s: float
    end_s: float
    mode: str
    name: str


@dataclass(frozen=True, slots=True, eq=False)
class Trajectory:
    """A simulated motion; arrays of shape (n_samples,), heights above the undisturbed surface, in order of time.

    `leg_force_n` is the force that pushes body and foot apart. `ground_height_m` is where the ground under the foot
    is: pressed down by the foot, or led back up. `marks` are named instants, such as lift-off.
    """

    title: str
    time_s: FloatArray
    body_height_m: FloatArray
    foot_height_m: FloatArray
    leg_force_n: FloatArray
    ground_height_m: FloatArray
    spans: tuple[ModeSpan, ...] = ()
    marks: tuple[tuple[str, float], ...] = ()


@dataclass(frozen=True, slots=True)
class Mark:
    """One method at one setting: how long it took, s, and the relative error that it made."""

    setting: str
    seconds: float
    error: float


@dataclass(frozen=True, slots=True)
class Curve:
    """One method's marks, from its coarsest setting to its finest; `setting` says what is set."""

    method: str
    setting: str
    marks: tuple[Mark, ...]


@dataclass(frozen=True, slots=True)
class Panel:
    """One output; under `floor`, a relative error, nothing is claimed."""

    output: str
    floor: float
    curves: tuple[Curve, ...]


@dataclass(frozen=True, slots=True)
class WorkPrecision:
    """All panels of a scene.

    `methods` names all, in the order of their looks; `notes` say against what errors are, on what machine times were
    taken, and which methods or settings are not drawn, and why.
    """

    title: str
    methods: tuple[str, ...]
    panels: tuple[Panel, ...]
    notes: tuple[str, ...] = ()
