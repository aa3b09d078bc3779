"""What errors are measured against."""

from __future__ import annotations

import pytest

from simulator.accuracy.labbook_runs import KernelRun
from simulator.accuracy.methods import stops_after
from simulator.accuracy.outputs import NAMES, outputs_of, relative_errors
from simulator.accuracy.reference_of import FINEST, reference_of
from simulator.scene_file import load_scene

SCENE = load_scene("sim2")


def test_a_stored_result_comes_first_and_the_finest_run_agrees_with_it() -> None:
    reference = reference_of(SCENE, stops_after(SCENE))
    assert reference.stored
    assert "36 digits" in reference.source
    assert reference.values["apex_height_m"] == pytest.approx(0.303334225186479, rel=1e-14)
    finest = KernelRun(SCENE, FINEST, stops_after(SCENE))
    finest.run()
    for name, error in relative_errors(outputs_of(SCENE, finest.row()), reference.values).items():
        assert error is not None
        assert error < 1e-11, name
    for name in NAMES:
        floor = reference.floor[name]
        assert floor is not None
        assert 2e-16 <= floor < 1e-12, name


def test_a_scene_of_one_s_own_is_confirmed_by_fixed_steps() -> None:
    scene = SCENE.changed({"foot_radius": 0.0351})
    reference = reference_of(scene, stops_after(scene))
    assert not reference.stored
    assert "confirmed by Richardson extrapolation" in reference.source
    for name in NAMES:
        doubt = reference.doubt[name]
        assert doubt is not None
        assert doubt < 1e-9, name


def test_the_floor_is_high_where_a_scene_hangs_on_last_bits() -> None:
    """At this active damping the sampled leg chatters, and errors grow from tick to tick."""
    calm = reference_of(SCENE.changed({"b_ad": 100.0}), stops_after(SCENE)).round_off["cost_J"]
    chattering = reference_of(SCENE.changed({"b_ad": 650.0}), stops_after(SCENE)).round_off["cost_J"]
    assert calm is not None
    assert chattering is not None
    assert chattering > 100.0 * calm
