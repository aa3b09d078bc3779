"""First jumps in plain Python: the same bits, a kernel where they take long, and no process that outlives its use."""

from __future__ import annotations

import json
import os
from pathlib import Path

import numpy as np
import pytest

from simulator.jump import limits_for, parameter_row, simulate
from simulator.kernel.build import kernel_for
from simulator.kernel.interpreter import Interpreter, _Interpreted
from simulator.kernel.rows import COLUMNS
from simulator.scene_file import load_scene
from tests.helpers.kernels import python

FIRST = """
import json, sys
import simulator.kernel.interpreter as interpreter
from simulator.jump import simulate
from simulator.kernel.build import is_compiled
from simulator.scene_file import load_scene

interpreter.PATIENCE_S = float(sys.argv[1])
scene = load_scene("sim2").changed(effects_off=sys.argv[2:])
found = simulate(scene)
print(json.dumps([found.interpreted, is_compiled(scene.effects), found.compile_time_s > 0.0, repr(found.jump)]))
"""


FORKED = """
import os, sys
from simulator.jump import simulate
from simulator.scene_file import load_scene

scene = load_scene("sim2").changed(effects_off=["motor_heat", "inertial_drag"])
jump, child = simulate(scene).jump, os.fork()
same = simulate(scene).jump == jump
if child:
    same &= os.waitpid(child, 0)[1] == 0
sys.exit(not same)
"""


def first(cache: Path, patience_s: float, *off: str) -> tuple[list[bool], str]:
    """Where a scene was simulated (interpreted, compiled now, told so), and its jump, in a process of its own."""
    *where, jump = json.loads(python(["-c", FIRST, f"{patience_s}", *off], LABBOOK_CACHE=str(cache)))
    return where, jump


def test_a_first_jump_is_interpreted_with_the_bits_of_a_compiled_one(tmp_path: Path) -> None:
    where, interpreted = first(tmp_path, 600.0)
    assert where == [True, False, False]
    kernel_for(load_scene("sim2").effects)
    assert interpreted == repr(simulate(load_scene("sim2")).jump)


def test_what_takes_long_is_left_to_the_kernel() -> None:
    scene = load_scene("sim2")
    kernel, impatient = kernel_for(scene.effects), _Interpreted(scene.effects, 1e-6)
    table = parameter_row(kernel, scene)[np.newaxis]
    filled = set()
    for batch in (kernel.batch, impatient, impatient):
        rows, counts = np.zeros((1, 1, len(COLUMNS))), np.zeros(1, np.int64)
        batch(table, limits_for(1e-6), rows, counts, np.zeros((0, 4)), np.zeros((0, 0)))
        filled.add((rows.tobytes(), counts.tobytes()))
    assert len(filled) == 1
    assert impatient.lost_s > 0.0
    assert impatient.left_s == 0.0


@pytest.mark.soak
def test_a_first_jump_is_interpreted_and_a_long_one_compiled_with_the_same_bits(tmp_path: Path) -> None:
    off = ("motor_heat", "inertial_drag", "added_mass")
    plain, impatient, again = (first(tmp_path, patience_s, *off) for patience_s in (600.0, 0.01, 600.0))
    assert [plain[0], impatient[0], again[0][:2]] == [[True, False, False], [True, True, True], [False, True]]
    assert plain[1] == impatient[1] == again[1]


def test_a_process_that_is_killed_or_slow_gives_no_answer_and_is_replaced() -> None:
    running, effects = Interpreter(), load_scene("sim2").effects
    filled = np.zeros((0, 1, 99)), np.zeros(0), np.zeros((0, 4)), np.zeros((0, 0))
    no_scenes = (np.zeros((0, 99)), limits_for(1e-6), *filled)
    try:
        assert running.ask(effects, no_scenes, 600.0) is not None
        assert running.process is not None
        running.process.kill()
        assert running.ask(effects, no_scenes, 600.0) is None
        assert running.ask(effects, no_scenes, 1e-6) is None
        assert running.process is None
        assert running.ask(effects, no_scenes, 600.0) is not None
    finally:
        running.end()


@pytest.mark.soak
@pytest.mark.skipif(not hasattr(os, "fork"), reason="no processes are forked here")
def test_a_forked_process_has_an_interpreter_of_its_own(tmp_path: Path) -> None:
    python(["-c", FORKED], LABBOOK_CACHE=str(tmp_path))
