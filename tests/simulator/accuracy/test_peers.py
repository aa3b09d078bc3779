"""scipy's integrators drive the same hybrid system to the same jumps, here in plain Python."""

from __future__ import annotations

import numpy as np
import pytest

from simulator.accuracy import peers
from simulator.accuracy.methods import outputs_of, relative_errors, stops_after
from simulator.accuracy.peers import METHODS, PeerGaveUp, PeerRun, peer_run, system_for
from simulator.accuracy.reference_of import stored_reference
from simulator.jump import simulate
from simulator.scene import Scene
from simulator.scene_file import load_scene
from tests.helpers.kernels import interpreted

SCENE = load_scene("sim2")


def run_of(scene: Scene, method: str, rtol: float, most_evaluations: int = peers.MOST_EVALUATIONS) -> PeerRun:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(peers, "MOST_EVALUATIONS", most_evaluations)
        system = system_for(scene.effects)
        parameters = np.array([scene[parameter.name] for parameter in system.composition.parameters])
        return peer_run(system, parameters, method, rtol, scene.jumps, stops_after(scene))


def largest_error(scene: Scene, run: PeerRun) -> float:
    """Of the last jump's outputs, relative to the stored ones of thirty digits."""
    assert len(run.rows) == scene.jumps
    reference = stored_reference(scene)
    assert reference is not None
    found = relative_errors(outputs_of(scene, run.rows), reference.values)
    return max(error for error in found.values() if error is not None)


@pytest.mark.parametrize("method", METHODS)
def test_a_finer_tolerance_gives_a_smaller_error_for_more_evaluations(method: str) -> None:
    coarse, fine = interpreted(run_of, SCENE, method, 1e-4), interpreted(run_of, SCENE, method, 1e-10)
    assert largest_error(SCENE, coarse) < 1e-2
    assert largest_error(SCENE, fine) < min(1e-8, 0.01 * largest_error(SCENE, coarse))
    assert fine.evaluations > coarse.evaluations


@pytest.mark.soak
@pytest.mark.parametrize("method", METHODS)
def test_compiled_functions_give_the_same(method: str) -> None:
    compiled, plain = run_of(SCENE, method, 1e-10), interpreted(run_of, SCENE, method, 1e-10)
    assert compiled.rows == pytest.approx(plain.rows, rel=1e-9, abs=1e-9, nan_ok=True)


def test_giving_up_says_where() -> None:
    with pytest.raises(PeerGaveUp, match="than 100 evaluations"):
        interpreted(run_of, SCENE, "RK45", 1e-8, 100)


@pytest.mark.parametrize(
    ("name", "values", "jumps"),
    [("bed", {}, 1), ("emulator", {"k_extension": 1091.36}, 2), ("force_plate", {}, 2)],
)
def test_other_grounds_and_jumps_that_follow_each_other(name: str, values: dict[str, float], jumps: int) -> None:
    scene = load_scene(name).changed(values, jumps=jumps)
    assert largest_error(scene, interpreted(run_of, scene, "DOP853", 1e-9)) < 1e-7


def test_events_that_fall_together_both_happen() -> None:
    """At an apex the body falls, and dry friction turns round."""
    scene = load_scene("force_plate").changed({"rail_friction_force": 3.0}, ("rail_friction",), jumps=2)
    run, jumps = interpreted(run_of, scene, "DOP853", 1e-10), interpreted(simulate, scene, 1e-10).jumps
    for row, jump in zip(run.rows, jumps, strict=True):
        assert outputs_of(scene, row[np.newaxis]).values["apex_height_m"] == pytest.approx(jump.apex_height_m, rel=1e-8)
