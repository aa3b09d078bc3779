"""scipy's integrators drive the same hybrid system to the same jumps."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from simulator.accuracy import peers
from simulator.accuracy.hybrid import system_for
from simulator.accuracy.outputs import outputs_of
from simulator.accuracy.peers import METHODS, PeerGaveUp, PeerRun, peer_run
from simulator.kernel.limits import STOP_AFTER_APEX, STOP_AFTER_LIFTOFF
from simulator.scene import Scene
from simulator.scene_file import load_scene
from tests.helpers.moving_platform import X_B, Stance

ROOT = Path(__file__).parents[3]
SCENE = load_scene("sim2")
TRUE = {
    "max_depth_m": 0.0707555505702115,
    "liftoff_time_s": 0.31374130706118,
    "apex_height_m": 0.303334225186479,
    "cost_J": 30.5311630882527,
}

IN_A_PROCESS = """
import json
import numpy as np
from simulator.accuracy.hybrid import system_for
from simulator.accuracy.methods import stops_after
from simulator.accuracy.outputs import outputs_of
from simulator.accuracy.peers import peer_run
from simulator.scene_file import load_scene

found = {}
for key, values, jumps in (
    ("bed", {}, 1),
    ("emulator", {"k_extension": 1091.36}, 2),
    ("force_plate", {}, 2),
    ("emulator, platform_mass", {"platform_mass": 0.8, "initial_height": 0.1}, 1),
):
    name, *on = key.split(", ")
    scene = load_scene(name).changed(values, on, jumps=jumps)
    system = system_for(scene.effects)
    parameters = np.array([scene[parameter.name] for parameter in system.composition.parameters])
    run = peer_run(system, parameters, "DOP853", 1e-9, jumps, stops_after(scene))
    found[key] = {"jumps": len(run.rows), **outputs_of(scene, run.rows[-1]).values}
print(json.dumps(found))
"""


def integrated(method: str, rtol: float, *, stop_after: int = STOP_AFTER_APEX, every_tick: bool = False) -> PeerRun:
    system = system_for(SCENE.effects)
    parameters = np.array([SCENE[parameter.name] for parameter in system.composition.parameters])
    return peer_run(system, parameters, method, rtol, 1, stop_after, every_tick=every_tick)


def largest_error(scene: Scene, run: PeerRun) -> float:
    values = outputs_of(scene, run.rows[-1]).values
    return max(abs((values[name] or 0.0) / true - 1.0) for name, true in TRUE.items())


@pytest.mark.parametrize("method", METHODS)
def test_a_finer_tolerance_gives_a_smaller_error_for_more_evaluations(method: str) -> None:
    coarse, fine = integrated(method, 1e-4), integrated(method, 1e-10)
    assert largest_error(SCENE, coarse) < 1e-2
    assert largest_error(SCENE, fine) < 1e-8
    assert largest_error(SCENE, fine) < 0.01 * largest_error(SCENE, coarse)
    assert fine.evaluations > coarse.evaluations


def test_starting_anew_at_every_tick_changes_nothing_but_the_work() -> None:
    skipping, ticking = integrated("DOP853", 1e-10), integrated("DOP853", 1e-10, every_tick=True)
    assert largest_error(SCENE, ticking) < 1e-8
    assert ticking.evaluations > 2 * skipping.evaluations


def test_the_stance_alone_ends_at_lift_off() -> None:
    stance = outputs_of(SCENE, integrated("RK45", 1e-8, stop_after=STOP_AFTER_LIFTOFF).rows[-1])
    assert stance.outcome == "liftoff"
    assert stance.values["apex_height_m"] is None
    assert stance.values["cost_J"] == pytest.approx(TRUE["cost_J"], rel=1e-6)


def test_giving_up_says_where(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(peers, "MOST_EVALUATIONS", 100)
    with pytest.raises(PeerGaveUp, match="than 100 evaluations"):
        integrated("RK45", 1e-8)


def test_other_grounds_and_jumps_that_follow_each_other() -> None:
    """Without compiling: four sets of effects would take a minute."""
    environment = {**os.environ, "NUMBA_DISABLE_JIT": "1", "PYTHONPATH": str(ROOT)}
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", IN_A_PROCESS],
        capture_output=True,
        text=True,
        check=False,
        env=environment,
        cwd=ROOT,
    )
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert found["bed"]["max_depth_m"] == pytest.approx(0.0321924367940498, rel=1e-7)
    assert found["bed"]["apex_height_m"] == pytest.approx(0.314088991750599, rel=1e-7)
    assert found["bed"]["cost_J"] == pytest.approx(46.2331186691549, rel=1e-7)
    reference = {name: second_jump(name) for name in ("emulator", "force_plate")}
    for name, (apex_m, cost_j) in reference.items():
        assert found[name]["jumps"] == 2
        assert found[name]["apex_height_m"] == pytest.approx(apex_m, rel=1e-7)
        assert found[name]["cost_J"] == pytest.approx(cost_j, rel=1e-7)
    heavy = load_scene("emulator").changed({"platform_mass": 0.8, "initial_height": 0.1}, ("platform_mass",))
    by_hand = Stance(heavy).run()
    assert found["emulator, platform_mass"]["apex_height_m"] == pytest.approx(float(by_hand.y[X_B]), rel=1e-7)
    assert found["emulator, platform_mass"]["max_depth_m"] == pytest.approx(by_hand.deepest_m, rel=1e-7)


def second_jump(name: str) -> tuple[float, float]:
    """Apex and cost of the second jump, as stored."""
    from benchmarks.reference_simulator.storage import stored

    case = {"emulator": "gain 400", "force_plate": "gain 300"}[name]
    jump = next(found for found in stored(name) if found.name == case).jumps[1]
    assert jump.apex_height_m is not None
    drag = jump.drag_j if name == "force_plate" else 0
    return float(jump.apex_height_m), float(jump.cost_j + drag)
