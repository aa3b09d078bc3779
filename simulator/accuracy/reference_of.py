"""The result that errors are measured against: a stored one of more than thirty digits, or one that confirms itself.

A stored one is of a scene with the same effects and the same numbers: `references/SCENE.toml` hold results of more
than thirty digits by an independent program, which writes them (`benchmarks/reference_simulator` of the source tree).
"""

from __future__ import annotations

import importlib.resources
import math
import sys
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from simulator.accuracy.methods import NAMES, KernelRun, Outputs, outputs_of, relative_errors
from simulator.jump import parameter_row
from simulator.kernel.build import kernel_for
from simulator.kernel.rows import COLUMN
from simulator.scene import Scene

SAME = 1e-14
"""Relative difference under which a double stands for a rational number."""
_BESIDE = frozenset({"drag", "passive_draw"})
"""Effects that change no motion: drag is stored apart, the passive draw is not compared."""


@dataclass(frozen=True, slots=True)
class Reference:
    """True values of the outputs of a scene's last jump, where they are from, and which errors they cannot resolve.

    `round_off` is how far each output moves, relatively, when the last bit of every parameter does: no program that
    computes with doubles knows it better. `doubt` is the relative uncertainty of the true values themselves. None where
    an output does not exist or is 0.
    """

    source: str
    stored: bool
    outcome: str
    values: Mapping[str, float | None]
    doubt: Mapping[str, float | None]
    round_off: Mapping[str, float | None] = field(default_factory=dict)

    @property
    def floor(self) -> dict[str, float | None]:
        """Relative error of each output under which nothing is claimed."""
        return {name: _larger(self.round_off[name], self.doubt[name]) for name in NAMES}


def stored_reference(scene: Scene) -> Reference | None:
    """Find the stored result of a scene's last jump, without its round-off.

    None where no case has its effects and its numbers.
    """
    for name, case in _cases():
        if len(case["jump"]) < scene.jumps or not _is_of(scene, case["scene"]):
            continue
        jump = case["jump"][scene.jumps - 1]
        cost_j = Fraction(jump["cost_j"]) + (Fraction(jump["drag_j"]) if "drag" in scene.effects else 0)
        numbers = {**jump, "cost_J": cost_j}
        values = {output: float(numbers[output]) if output in numbers else None for output in NAMES}
        return Reference(
            source=f"stored case “{case['name']}” of {name}, Taylor series to {case['agreeing_digits']} digits",
            stored=True,
            outcome=jump["outcome"],
            values=values,
            doubt={output: 10.0 ** -case["agreeing_digits"] if value else None for output, value in values.items()},
        )
    return None


@cache
def _cases() -> tuple[tuple[str, dict[str, Any]], ...]:
    folder = importlib.resources.files("simulator.accuracy") / "references"
    files = sorted(folder.iterdir(), key=lambda file: file.name)
    documents = (tomllib.loads(file.read_text(encoding="utf-8")) for file in files)
    return tuple((found["scene"], case) for found in documents for case in found["case"] if "scene" in case)


def _is_of(scene: Scene, stored: Mapping[str, Any]) -> bool:
    numbers = stored["values"]
    beside = _BESIDE if Fraction(numbers["b_ad"]) else _BESIDE | {"active_damping"}
    return frozenset(stored["effects"]) - beside == scene.effects - beside and all(
        name in numbers and abs(scene[name] - float(Fraction(numbers[name]))) <= SAME * abs(scene[name])
        for name in scene.read
        if name != "passive_power"
    )


FINEST = 1e-13
PERTURBED_RUNS = 24
STEPS_FINER = 10.0
"""Fixed steps for each step that error control takes on average; the steps do not divide the controller's period."""

ORDER = 5
"""Order of the kernel's Runge-Kutta method."""


def reference_of(scene: Scene, stop_after: int) -> Reference:
    """Return the stored result of a scene where there is one; otherwise the simulator's own finest, confirmed.

    The confirmation is Richardson's: the same method at two fixed steps, extrapolated; its distance from the finest
    result is the doubt.
    """
    finest = _own(scene, stop_after)
    found = stored_reference(scene) or Reference(
        f"no stored result is that of this scene: labbook at {FINEST:g}, confirmed by Richardson extrapolation of "
        "fixed steps",
        False,
        finest.outcome,
        finest.values,
        _distance(scene, stop_after, finest),
    )
    return replace(found, round_off=_round_off(scene, stop_after, finest))


def _own(
    scene: Scene, stop_after: int, *, parameters: NDArray[np.float64] | None = None, fixed_step_s: float = 0.0
) -> Outputs:
    kernel = KernelRun(scene, FINEST, stop_after, parameters=parameters, fixed_step_s=fixed_step_s)
    kernel.run()
    return outputs_of(scene, kernel.rows)


def _round_off(scene: Scene, stop_after: int, finest: Outputs) -> dict[str, float | None]:
    """Largest move of each output among runs whose parameters are the neighbouring doubles, drawn up or down."""
    parameters = parameter_row(kernel_for(scene.effects), scene)
    draws = np.random.default_rng(0)
    moves: dict[str, float | None] = {
        name: sys.float_info.epsilon if value is not None and value != 0.0 else None
        for name, value in finest.values.items()
    }
    for _ in range(PERTURBED_RUNS):
        ends = np.where(draws.random(parameters.size) < 0.5, -math.inf, math.inf)
        moved = np.where(parameters == 0.0, 0.0, np.nextafter(parameters, ends))
        errors = relative_errors(_own(scene, stop_after, parameters=moved), finest.values)
        moves = {name: _larger(moves[name], errors[name]) for name in NAMES}
    return moves


def _distance(scene: Scene, stop_after: int, finest: Outputs) -> dict[str, float | None]:
    """How far the extrapolation of two runs at fixed steps lies from the finest run, relatively."""
    controlled = KernelRun(scene, FINEST, stop_after)
    controlled.run()
    time_s, steps = controlled.rows[:, [COLUMN["jump_time_s"], COLUMN["steps"]]].sum(axis=0).tolist()
    step_s = time_s / (STEPS_FINER * steps)
    coarse, fine = (_own(scene, stop_after, fixed_step_s=each_s) for each_s in (step_s, step_s / 2.0))
    distance: dict[str, float | None] = {}
    for name, true in finest.values.items():
        if true is None or true == 0.0:
            distance[name] = None
            continue
        first, second = coarse.values[name], fine.values[name]
        if first is None or second is None:
            distance[name] = math.inf
        else:
            distance[name] = abs((second + (second - first) / (2.0**ORDER - 1.0)) / true - 1.0)
    return distance


def _larger(first: float | None, second: float | None) -> float | None:
    return None if first is None or second is None else max(first, second)
