"""What errors are measured against, and which stored reference is whose."""

from __future__ import annotations

import pytest

from simulator.accuracy.methods import NAMES, KernelRun, outputs_of, relative_errors, stops_after
from simulator.accuracy.reference_of import FINEST, reference_of, stored_reference
from simulator.scene_file import load_scene
from tests.helpers.wording import says

SCENE = load_scene("sim2")


def test_a_stored_result_comes_first_and_the_finest_run_agrees_with_it() -> None:
    reference = reference_of(SCENE, stops_after(SCENE))
    assert reference.stored
    assert "36 digits" in reference.source
    assert reference.values["apex_height_m"] == pytest.approx(0.303334225186479, rel=1e-14)
    finest = KernelRun(SCENE, FINEST, stops_after(SCENE))
    finest.run()
    for name, error in relative_errors(outputs_of(SCENE, finest.rows), reference.values).items():
        assert error is not None
        assert error < 1e-11, name
    assert all(2e-16 <= (reference.floor[name] or 0.0) < 1e-12 for name in NAMES)


def test_a_scene_of_one_s_own_is_confirmed_by_fixed_steps() -> None:
    scene = SCENE.changed({"foot_radius": 0.0351})
    reference = reference_of(scene, stops_after(scene))
    assert not reference.stored
    says(reference.source, "confirmed by Richardson")
    assert all(0.0 <= (doubt or 0.0) < 1e-9 for doubt in reference.doubt.values())
    assert None not in reference.doubt.values()


def test_the_floor_is_high_where_a_scene_hangs_on_last_bits() -> None:
    """At this active damping the sampled leg chatters, and errors grow from tick to tick."""
    calm, chattering = (
        reference_of(SCENE.changed({"b_ad": b_ad}), stops_after(SCENE)).round_off["cost_J"] or 0.0
        for b_ad in (100.0, 650.0)
    )
    assert chattering > 100.0 * calm > 0.0


@pytest.mark.parametrize(
    ("name", "values", "case"),
    [
        ("sim2", {}, "defaults, held gains in flight"),
        ("sim2", {"foot_radius": 0.038, "k_extension": 1091.36}, None),  # stored with soft gains in flight only
        ("sim1", {}, "b_AD = 650"),
        ("sim1", {"b_ad": 0.0}, "defaults"),
        ("sim1", {"b_ad": 1.0}, None),
        ("bed", {}, "small foot, gain 400"),
        ("bed", {"foot_radius": 0.051, "k_extension": 835.36}, "large foot, gain 300"),
        ("bed", {"initial_height": 0.16}, None),
    ],
)
def test_granular_scenes(name: str, values: dict[str, float], case: str | None) -> None:
    match = stored_reference(load_scene(name).changed(values))
    if case is None:
        assert match is None
    else:
        assert match is not None
        assert f"“{case}” of {name}" in match.source
        assert match.doubt["apex_height_m"] <= 1e-30
        assert match.outcome == "apex"


def test_effects_count_unless_they_change_no_motion() -> None:
    assert stored_reference(SCENE.changed(effects_on=("drag", "passive_draw"))) is not None
    for off, known in (("held_gains_in_flight", True), ("active_damping", True), ("added_mass", False)):
        assert (stored_reference(SCENE.changed(effects_off=(off,))) is not None) == known, off


def test_of_jumps_that_follow_each_other_the_last_is_meant() -> None:
    one, four, five = (stored_reference(load_scene("force_plate").changed(jumps=jumps)) for jumps in (1, 4, 5))
    assert one is not None
    assert four is not None
    assert one.values != four.values
    assert five is None
