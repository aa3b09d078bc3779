"""scipy's integrators drive the same hybrid system to the same jumps, here in plain Python."""

from __future__ import annotations

import numpy as np
import pytest

from simulator.accuracy import peers
from simulator.accuracy.methods import outputs_of, stops_after
from simulator.accuracy.peers import METHODS, PeerGaveUp, PeerRun, peer_run, system_for
from simulator.jump import simulate
from simulator.kernel.limits import STOP_AFTER_APEX, STOP_AFTER_LIFTOFF
from simulator.scene import Scene
from simulator.scene_file import load_scene
from tests.helpers.kernels import interpreted
from tests.helpers.moving_platform import X_B, Stance

SCENE = load_scene("sim2")
TRUE = {
    "max_depth_m": 0.0707555505702115,
    "liftoff_time_s": 0.31374130706118,
    "apex_height_m": 0.303334225186479,
    "cost_J": 30.5311630882527,
}


def integrated(
    method: str,
    rtol: float,
    stop_after: int = STOP_AFTER_APEX,
    most_evaluations: int = peers.MOST_EVALUATIONS,
) -> PeerRun:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(peers, "MOST_EVALUATIONS", most_evaluations)
        return run_of(SCENE, method, rtol, stop_after)


def run_of(scene: Scene, method: str, rtol: float, stop_after: int) -> PeerRun:
    system = system_for(scene.effects)
    parameters = np.array([scene[parameter.name] for parameter in system.composition.parameters])
    return peer_run(system, parameters, method, rtol, scene.jumps, stop_after)


def largest_error(scene: Scene, run: PeerRun) -> float:
    values = outputs_of(scene, run.rows).values
    return max(abs((values[name] or 0.0) / true - 1.0) for name, true in TRUE.items())


@pytest.mark.parametrize("method", METHODS)
def test_a_finer_tolerance_gives_a_smaller_error_for_more_evaluations(method: str) -> None:
    coarse, fine = interpreted(integrated, method, 1e-4), interpreted(integrated, method, 1e-10)
    assert largest_error(SCENE, coarse) < 1e-2
    assert largest_error(SCENE, fine) < 1e-8
    assert largest_error(SCENE, fine) < 0.01 * largest_error(SCENE, coarse)
    assert fine.evaluations > coarse.evaluations


@pytest.mark.soak
@pytest.mark.parametrize("method", METHODS)
def test_compiled_functions_give_the_same(method: str) -> None:
    compiled, plain = integrated(method, 1e-10), interpreted(integrated, method, 1e-10)
    assert compiled.rows == pytest.approx(plain.rows, rel=1e-9, abs=1e-9, nan_ok=True)
    assert largest_error(SCENE, compiled) < 1e-8


def test_the_stance_alone_ends_at_lift_off() -> None:
    stance = outputs_of(SCENE, interpreted(integrated, "RK45", 1e-8, STOP_AFTER_LIFTOFF).rows)
    assert stance.outcome == "liftoff"
    assert stance.values["apex_height_m"] is None
    assert stance.values["cost_J"] == pytest.approx(TRUE["cost_J"], rel=1e-6)


def test_giving_up_says_where() -> None:
    with pytest.raises(PeerGaveUp, match="than 100 evaluations"):
        interpreted(integrated, "RK45", 1e-8, STOP_AFTER_APEX, 100)


def last_jump(scene: Scene) -> dict[str, float | None]:
    """Outputs of the last of a scene's jumps, all of which came to an end."""
    run = interpreted(run_of, scene, "DOP853", 1e-9, stops_after(scene))
    assert len(run.rows) == scene.jumps
    return dict(outputs_of(scene, run.rows).values)


def test_another_scene_on_grains() -> None:
    found = last_jump(load_scene("bed"))
    assert found["max_depth_m"] == pytest.approx(0.0321924367940498, rel=1e-7)
    assert found["apex_height_m"] == pytest.approx(0.314088991750599, rel=1e-7)
    assert found["cost_J"] == pytest.approx(46.2331186691549, rel=1e-7)


@pytest.mark.parametrize(("name", "values"), [("emulator", {"k_extension": 1091.36}), ("force_plate", {})])
def test_other_grounds_and_jumps_that_follow_each_other(name: str, values: dict[str, float]) -> None:
    found = last_jump(load_scene(name).changed(values, jumps=2))
    apex_m, cost_j = second_jump(name)
    assert found["apex_height_m"] == pytest.approx(apex_m, rel=1e-7)
    assert found["cost_J"] == pytest.approx(cost_j, rel=1e-7)


def test_events_that_fall_together_both_happen() -> None:
    """At an apex the body falls, and dry friction turns round."""
    scene = load_scene("force_plate").changed({"rail_friction_force": 3.0}, ("rail_friction",), jumps=2)
    run = interpreted(run_of, scene, "DOP853", 1e-10, stops_after(scene))
    jumps = interpreted(simulate, scene, 1e-10).jumps
    for row, jump in zip(run.rows, jumps, strict=True):
        assert outputs_of(scene, row[np.newaxis]).values["apex_height_m"] == pytest.approx(jump.apex_height_m, rel=1e-8)


def test_a_platform_with_a_mass() -> None:
    heavy = load_scene("emulator").changed({"platform_mass": 0.8, "initial_height": 0.1}, ("platform_mass",), jumps=1)
    found, by_hand = last_jump(heavy), Stance(heavy).run()
    assert found["apex_height_m"] == pytest.approx(float(by_hand.y[X_B]), rel=1e-7)
    assert found["max_depth_m"] == pytest.approx(by_hand.deepest_m, rel=1e-7)


def second_jump(name: str) -> tuple[float, float]:
    """Apex and cost of the second jump, as stored."""
    from benchmarks.reference_simulator.storage import stored

    case = {"emulator": "gain 400", "force_plate": "gain 300"}[name]
    jump = next(found for found in stored(name) if found.name == case).jumps[1]
    assert jump.apex_height_m is not None
    drag = jump.drag_j if name == "force_plate" else 0
    return float(jump.apex_height_m), float(jump.cost_j + drag)
