"""The methods that are compared, each with its name, its settings and how to run it; other modules implement them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from simulator.accuracy import fixed_step_euler
from simulator.accuracy.hybrid import system_for
from simulator.accuracy.labbook_runs import KernelRun
from simulator.accuracy.outputs import Outputs, outputs_of
from simulator.accuracy.peers import METHODS as SOLVE_IVP
from simulator.accuracy.peers import peer_run
from simulator.kernel.limits import STOP_AFTER_APEX, STOP_AFTER_LIFTOFF, STOP_AFTER_TOUCHDOWN
from simulator.kernel.rows import COLUMN
from simulator.scene import Scene

Row = NDArray[np.float64]
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
