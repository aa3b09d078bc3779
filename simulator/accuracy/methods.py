"""The methods that are compared, each with its name, its settings and how to run it; other modules implement them."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from simulator.accuracy import fixed_step_euler
from simulator.accuracy.peers import METHODS as SOLVE_IVP
from simulator.accuracy.peers import peer_run, system_for
from simulator.jump import limits_for, parameter_row
from simulator.kernel.build import kernel_for
from simulator.kernel.layout import OUTCOMES
from simulator.kernel.limits import JUMPS_WANTED, STOP_AFTER_APEX, STOP_AFTER_LIFTOFF, STOP_AFTER_TOUCHDOWN
from simulator.kernel.rows import COLUMN, COLUMNS, COST_PARTS
from simulator.scene import Scene

NAMES = ("max_depth_m", "liftoff_time_s", "apex_height_m", "cost_J")
"""Deepest point of the foot, time of lift-off since touchdown, apex of the body, cost."""


@dataclass(frozen=True, slots=True)
class Outputs:
    """A jump's outcome and its four numbers; None: not reached. The cost is the motors', without passive draw."""

    outcome: str
    values: Mapping[str, float | None]


def outputs_of(scene: Scene, row: NDArray[np.float64]) -> Outputs:
    """Read the outputs from a row of the kernel, shape (columns,)."""
    span = "jump" if "cost_of_whole_jump" in scene.effects else "stance"
    values = {name: _number(float(row[COLUMN[name]])) for name in NAMES[:-1]}
    cost_j = sum(float(row[COLUMN[f"{span}_{part}_J"]]) for part in COST_PARTS)
    return Outputs(OUTCOMES[int(row[COLUMN["outcome"]])], {**values, NAMES[-1]: _number(cost_j)})


def relative_errors(found: Outputs, truth: Mapping[str, float | None]) -> dict[str, float | None]:
    """Relative error of each output: None where there is no true number or it is 0, infinite where `found` lacks it."""
    errors: dict[str, float | None] = {}
    for name in NAMES:
        true, value = truth[name], found.values[name]
        if true is None or true == 0.0:
            errors[name] = None
        else:
            errors[name] = math.inf if value is None else abs(value / true - 1.0)
    return errors


def _number(value: float) -> float | None:
    return value if math.isfinite(value) else None


Row = NDArray[np.float64]


class KernelRun:
    """A scene's kernel with everything it needs; `run()` simulates, `row()` is that of the last jump made."""

    def __init__(
        self,
        scene: Scene,
        accuracy: float,
        stop_after: int = STOP_AFTER_TOUCHDOWN,
        *,
        fixed_step_s: float = 0.0,
        parameters: Row | None = None,
    ) -> None:
        """Prepare `scene.jumps` jumps; `parameters`, in the order that the kernel reads, stand in for the scene's."""
        self.kernel = kernel = kernel_for(scene.effects)
        table = (parameter_row(kernel, scene) if parameters is None else parameters)[np.newaxis, :]
        limits = limits_for(accuracy, stop_after, fixed_step_s)
        limits[JUMPS_WANTED] = scene.jumps
        self._rows = np.zeros((1, scene.jumps, len(COLUMNS)))
        self._counts = np.zeros(1, np.int64)
        changes, trace = np.zeros((0, 4)), np.zeros((0, 0))
        arguments = (table, limits, self._rows, self._counts, changes, trace)
        self.run: Callable[[], None] = lambda: kernel.batch(*arguments)

    @property
    def jumps_made(self) -> int:
        """How many jumps were made."""
        return int(self._counts[0])

    def row(self) -> Row:
        """Return the row of the last jump that was made, shape (columns,)."""
        last: Row = self._rows[0, self.jumps_made - 1]
        return last

    def evaluations(self) -> int:
        """Return how often the forces were evaluated, over all jumps."""
        return int(self._rows[0, : self.jumps_made, COLUMN["rhs_evaluations"]].sum())

    def steps(self) -> int:
        """Return how many steps were taken, over all jumps."""
        return int(self._rows[0, : self.jumps_made, COLUMN["steps"]].sum())

    def time_s(self) -> float:
        """Return how long all jumps took the robot, s."""
        return float(self._rows[0, : self.jumps_made, COLUMN["jump_time_s"]].sum())


LABBOOK = "labbook"
EULER = "explicit Euler (thesis)"


@dataclass(frozen=True, slots=True)
class Found:
    """What one run gave: the outputs of the last jump, and evaluations of the forces over all jumps."""

    outputs: Outputs
    evaluations: int


class Attempt(Protocol):
    """One method at one setting, ready to run as often as it takes to time it."""

    def run(self) -> None:
        """Do all the work; raises `PeerGaveUp` where the method does not come to an end."""

    def found(self) -> Found:
        """Return what the last run gave."""


@dataclass(frozen=True, slots=True)
class Method:
    """A method: what its setting is called, the settings tried from coarse to fine, and what it does not cover.

    `prepare(scene, setting, stop_after)` gets it ready to run; `why_not(scene)` is None where it covers a scene.
    """

    name: str
    setting: str
    settings: tuple[float, ...]
    prepare: Callable[[Scene, float, int], Attempt]
    unit: str = ""
    why_not: Callable[[Scene], str | None] = lambda _scene: None


def stops_after(scene: Scene, stance: bool = False) -> int:
    """Return what a comparison of this scene ends with: the apex, or the touchdown where jumps follow each other."""
    if stance:
        return STOP_AFTER_LIFTOFF
    return STOP_AFTER_APEX if "hydrostatic_stiffness" in scene.effects else STOP_AFTER_TOUCHDOWN


class _Labbook:
    def __init__(self, scene: Scene, setting: float, stop_after: int) -> None:
        self._scene, self._kernel = scene, KernelRun(scene, setting, stop_after)
        self.run = self._kernel.run

    def found(self) -> Found:
        return Found(outputs_of(self._scene, self._kernel.row()), self._kernel.evaluations())


class _Euler:
    def __init__(self, scene: Scene, setting: float, stop_after: int) -> None:
        self._scene = scene
        run, p, self._row = fixed_step_euler.fixed_step_euler_run(scene)
        to_liftoff = stop_after == STOP_AFTER_LIFTOFF
        self.run = partial(run, p, setting, to_liftoff, self._row)

    def found(self) -> Found:
        return Found(outputs_of(self._scene, self._row), int(self._row[COLUMN["steps"]]))


class SolveIvpAttempt:
    """A method of `solve_ivp` (`simulator.accuracy.peers.peer_run`) at one setting."""

    def __init__(self, method: str, scene: Scene, setting: float, stop_after: int) -> None:
        """Prepare `scene.jumps` jumps."""
        self._scene = scene
        system = system_for(scene.effects)
        parameters = np.array([scene[parameter.name] for parameter in system.composition.parameters])
        self._integrate = partial(peer_run, system, parameters, method, setting, scene.jumps, stop_after)

    def run(self) -> None:
        """Integrate all jumps."""
        self._last = self._integrate()

    def found(self) -> Found:
        """Return the last jump of the last run."""
        return Found(outputs_of(self._scene, self._last.rows[-1]), self._last.evaluations)


def _tenths(first: int, last: int) -> tuple[float, ...]:
    """10^-first to 10^-last."""
    return tuple(float(f"1e-{power}") for power in range(first, last + 1))


METHODS: dict[str, Method] = {
    method.name: method
    for method in (
        Method(EULER, "step", _tenths(3, 7), _Euler, "s", fixed_step_euler.why_not),
        *(Method(f"solve_ivp {name}", "rtol", _tenths(3, 12), partial(SolveIvpAttempt, name)) for name in SOLVE_IVP),
        Method(LABBOOK, "accuracy", _tenths(2, 12), _Labbook),
    )
}
"""By name, in the order they are shown."""
