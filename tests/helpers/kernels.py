"""Kernels in tests: the stored reference cases as scenes, errors against them, and work done in other processes."""

from __future__ import annotations

import atexit
import functools
import os
import pickle
import subprocess
import sys
from collections.abc import Callable, Iterable
from decimal import Decimal
from pathlib import Path
from typing import ParamSpec, TypeVar

import numpy as np
from numpy.typing import NDArray

import simulator.jump
from benchmarks.reference_simulator.cases import CASES as REFERENCE_CASES
from benchmarks.reference_simulator.result import ReferenceResult
from benchmarks.reference_simulator.storage import stored
from simulator.compiled import Function, Row
from simulator.jump import MOST_STEPS_A_JUMP, limits_for
from simulator.kernel.limits import FLIP_TICK, JUMPS_WANTED, MOST_STEPS
from simulator.kernel.rows import COLUMNS
from simulator.result import JumpResult
from simulator.scene import Scene
from simulator.scene_file import load_scene

P = ParamSpec("P")
T = TypeVar("T")
ROOT = Path(simulator.jump.__file__).parents[1]
"""Folder of the packages under test."""


CASES = [(scene, case.name) for scene, cases in REFERENCE_CASES.items() for case in cases if case.is_scene]
"""Every stored case that the simulator's reading of contact can meet, by scene and name."""
CHANGES_NO_MOTION = frozenset({"drag", "passive_draw"})


def reference(scene: str, case: str) -> tuple[ReferenceResult, ...]:
    """The stored jumps of a case."""
    return next(found.jumps for found in stored(scene) if found.name == case)


def scene_of(scene: str, case: str) -> Scene:
    """A stored case as a scene, with as many jumps as are stored; what changes no motion is as shipped."""
    shipped = load_scene(scene)
    known = next(found for found in REFERENCE_CASES[scene] if found.name == case)
    beside = CHANGES_NO_MOTION if known.values["b_ad"] else CHANGES_NO_MOTION | {"active_damping"}
    on, off = known.effects - shipped.effects - beside, shipped.effects - known.effects - beside
    found = shipped.changed({}, on, off, jumps=len(reference(scene, case)))
    return found.changed({name: float(known.values[name]) for name in found.read if name in known.values})


def relative_error(found: float | None, wanted: Decimal | float | None) -> float:
    """Error relative to what is wanted, or as it stands where that is nothing."""
    assert found is not None
    assert wanted is not None
    return float(abs(Decimal(found) - Decimal(wanted)) / (abs(Decimal(wanted)) or 1))


def spent_j(jump: JumpResult, whole_jump: bool) -> tuple[float, float]:
    """Heat and mechanical energy, of the whole jump or of its stance."""
    if whole_jump:
        return jump.jump_heat_J, jump.jump_mechanical_J
    return jump.stance_heat_J, jump.stance_mechanical_J


def errors(scene: Scene, jump: JumpResult, wanted: ReferenceResult) -> dict[str, float]:
    """Relative errors of the outputs that an accuracy is promised for, and of the state at lift-off."""
    heat_j, mechanical_j = spent_j(jump, "cost_of_whole_jump" in scene.effects)
    return {
        "depth": relative_error(jump.max_depth_m, wanted.max_depth_m),
        "lift-off": relative_error(jump.liftoff_time_s, wanted.liftoff_time_s),
        "velocity": relative_error(jump.liftoff_body_velocity_m_s, wanted.liftoff_body_velocity_m_s),
        "apex": relative_error(jump.apex_height_m, wanted.apex_height_m),
        "cost": relative_error(heat_j + mechanical_j, wanted.cost_j),
    }


def batch_rows(
    batch: Function,
    table: Row,
    accuracy: float,
    jumps: int = 1,
    most_steps: int = MOST_STEPS_A_JUMP,
    step_s: float = 0.0,
    flip_tick: float = -1.0,
) -> tuple[Row, NDArray[np.int64]]:
    """Every column of every jump that a kernel's entry gives for a table of parameters, and how many jumps there are.

    `step_s` is the length of all steps; at 0 they are as long as the accuracy allows. `flip_tick` is the number of a
    tick whose decision is turned round.
    """
    rows, counts = np.full((len(table), jumps, len(COLUMNS)), np.nan), np.zeros(len(table), np.int64)
    limits, none = limits_for(accuracy, fixed_step_s=step_s), np.zeros((0, 4))
    limits[JUMPS_WANTED], limits[MOST_STEPS], limits[FLIP_TICK] = jumps, most_steps, flip_tick
    batch(table, limits, rows, counts, none, none)
    return rows, counts


def python(words: Iterable[str], given: bytes = b"", folder: Path = ROOT, **environment: str) -> bytes:
    """Run Python in a process of its own, with the packages in `folder`; returns what it prints."""
    surroundings = {name: value for name, value in os.environ.items() if not name.startswith("NUMBA_")}
    surroundings |= {"PYTHONPATH": str(folder), **environment}
    done = subprocess.run(
        [sys.executable, *words], input=given, cwd=folder, env=surroundings, capture_output=True, check=False
    )
    assert done.returncode == 0, done.stderr.decode()
    return done.stdout


_ANSWER_CALLS = """
import pickle, sys
calls, answers, sys.stdout = sys.stdin.buffer, sys.stdout.buffer, sys.stderr
while True:
    try:
        function, arguments = pickle.load(calls)
    except EOFError:
        break
    try:
        answer = True, function(*arguments)
    except Exception as error:
        answer = False, error
    pickle.dump(answer, answers)
    answers.flush()
"""


@functools.cache
def _interpreter() -> subprocess.Popen[bytes]:
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "NUMBA_DISABLE_JIT": "1"}
    process = subprocess.Popen(
        [sys.executable, "-c", _ANSWER_CALLS], stdin=subprocess.PIPE, stdout=subprocess.PIPE, cwd=ROOT, env=environment
    )
    atexit.register(process.communicate)  # it ends with its input
    return process


def interpreted(function: Callable[P, T], *arguments: P.args, **_: P.kwargs) -> T:
    """What a module's function returns in a process in which nothing is compiled, one for all calls.

    For effects that few jumps of a test have: a kernel takes 20 s to compile, a jump without it less than one.
    """
    process = _interpreter()
    assert process.stdin is not None
    assert process.stdout is not None
    process.stdin.write(pickle.dumps((function, arguments)))
    process.stdin.flush()
    answered, found = pickle.load(process.stdout)
    if not answered:
        raise found
    result: T = found
    return result
