"""The compiled peer of a stance comes to the stored reference, or is left out with a sentence."""

from __future__ import annotations

import importlib.util

import pytest

from benchmarks import stance
from simulator.accuracy.methods import METHODS, stops_after
from simulator.accuracy.outputs import relative_errors
from simulator.accuracy.reference_of import stored_reference
from simulator.scene_file import load_scene

SCENE = load_scene("sim2")


@pytest.mark.parametrize("every_tick", [False, True])
def test_a_stance_that_is_told_its_events_has_the_depth_and_cost_of_the_reference(every_tick: bool) -> None:
    pytest.importorskip("CyRK", reason="CyRK is not installed: pip install '.[benchmarks]'")
    from benchmarks.compiled_peer import methods

    match = stored_reference(SCENE)
    assert match is not None
    for method in methods(METHODS["solve_ivp RK45"], every_tick=every_tick):
        attempt = method.prepare(SCENE, 1e-10, stops_after(SCENE, stance=True))
        attempt.run()
        attempt.run()  # what it leaves does not change the next
        found = attempt.found()
        errors = relative_errors(found.outputs, match.values)
        assert max(errors[name] or 0.0 for name in stance.OUTPUTS) < 1e-7, method.name
        assert found.outputs.outcome == "liftoff"
        assert found.evaluations > 300


def test_without_cyrk_the_compiled_peer_is_left_out_with_a_sentence(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    assert all(what.startswith("solve_ivp") for what in stance._peers())
    assert "CyRK is not installed" in stance.WITHOUT_CYRK
