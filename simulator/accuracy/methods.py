"""The methods that are compared, each with its name, its settings and how to run it; other modules implement them."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial

import numpy as np

from simulator.accuracy import fixed_step_euler
from simulator.accuracy.peers import METHODS as SOLVE_IVP
from simulator.accuracy.peers import PeerRun, peer_run, system_for
from simulator.compiled import Row
from simulator.jump import cost_span, limits_for, parameter_row
from simulator.kernel.build import kernel_for
from simulator.kernel.layout import OUTCOMES
from simulator.kernel.limits import JUMPS_WANTED, STOP_AFTER_APEX, STOP_AFTER_LIFTOFF, STOP_AFTER_TOUCHDOWN
from simulator.kernel.rows import COLUMN, COLUMNS, COST_PARTS
from simulator.scene import Scene

TITLES = {
    "max_depth_m": "Deepest foot",
    "liftoff_time_s": "Lift-off time",
    "apex_height_m": "Apex height",
    "cost_J": "Cost in joules",
}
"""Outputs that are compared, and their titles; times are since touchdown."""
NAMES = tuple(TITLES)


@dataclass(frozen=True, slots=True)
class Outputs:
    """A jump's outcome and its four numbers; None: not reached. The cost is the motors', without passive draw.

    `evaluations` of the forces are those of all jumps up to it.
    """

    outcome: str
    values: Mapping[str, float | None]
    evaluations: int


def outputs_of(scene: Scene, rows: Row, evaluations: int | None = None) -> Outputs:
    """Read the last jump's outputs from rows of the kernel, shape (jumps, columns)."""
    row, span = rows[-1], cost_span(scene.effects)
    values = {name: _number(float(row[COLUMN[name]])) for name in NAMES[:-1]}
    cost_j = sum(float(row[COLUMN[f"{span}_{part}_J"]]) for part in COST_PARTS)
    if evaluations is None:
        evaluations = int(rows[:, COLUMN["rhs_evaluations"]].sum())
    return Outputs(OUTCOMES[int(row[COLUMN["outcome"]])], {**values, NAMES[-1]: _number(cost_j)}, evaluations)


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


class KernelRun:
    """A scene's kernel with everything it needs; `run()` simulates, `rows` are then what it gave."""

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
    def rows(self) -> Row:
        """The rows of the jumps that were made, shape (jumps, columns)."""
        made: Row = self._rows[0, : self._counts[0]]
        return made


LABBOOK = "labbook"
EULER = "explicit Euler (thesis)"


@dataclass(frozen=True, slots=True)
class Attempt:
    """One method at one setting, ready to run as often as it takes to time it.

    `run` does all the work, and raises `PeerGaveUp` where the method does not come to an end; `found` returns what the
    last run gave.
    """

    run: Callable[[], None]
    found: Callable[[], Outputs]


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


def _labbook(scene: Scene, setting: float, stop_after: int) -> Attempt:
    kernel = KernelRun(scene, setting, stop_after)
    return Attempt(kernel.run, lambda: outputs_of(scene, kernel.rows))


def _euler(scene: Scene, setting: float, stop_after: int) -> Attempt:
    run, work, row = fixed_step_euler.fixed_step_euler_run(scene)
    run_once = partial(run, work, setting, stop_after == STOP_AFTER_LIFTOFF, row)
    return Attempt(run_once, lambda: outputs_of(scene, row[np.newaxis], int(row[COLUMN["steps"]])))


def _solve_ivp(method: str, scene: Scene, setting: float, stop_after: int) -> Attempt:
    system = system_for(scene.effects)
    parameters = np.array([scene[parameter.name] for parameter in system.composition.parameters])
    last: list[PeerRun] = []

    def run() -> None:
        last[:] = [peer_run(system, parameters, method, setting, scene.jumps, stop_after)]

    return Attempt(run, lambda: outputs_of(scene, last[0].rows, last[0].evaluations))


def _tenths(first: int, last: int) -> tuple[float, ...]:
    """10^-first to 10^-last."""
    return tuple(float(f"1e-{power}") for power in range(first, last + 1))


METHODS: dict[str, Method] = {
    method.name: method
    for method in (
        Method(EULER, "step", _tenths(3, 7), _euler, "s", fixed_step_euler.why_not),
        *(Method(f"solve_ivp {name}", "rtol", _tenths(3, 12), partial(_solve_ivp, name)) for name in SOLVE_IVP),
        Method(LABBOOK, "accuracy", _tenths(2, 12), _labbook),
    )
}
"""By name, in the order they are shown."""
