"""Which stored reference is whose."""

from __future__ import annotations

import pytest

from simulator.accuracy.reference_of import stored_reference
from simulator.scene_file import load_scene


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
        assert match.agreeing_digits >= 30
        assert match.outcome == "apex"


def test_effects_count_unless_they_change_no_motion() -> None:
    scene = load_scene("sim2")
    assert stored_reference(scene.changed(effects_off=("held_gains_in_flight",))) is not None
    assert stored_reference(scene.changed(effects_on=("drag", "passive_draw"))) is not None
    assert stored_reference(scene.changed(effects_off=("active_damping",))) is not None
    assert stored_reference(scene.changed(effects_off=("added_mass",))) is None
    assert stored_reference(scene.changed(effects_off=("short_leg_guard",))) is None


def test_of_jumps_that_follow_each_other_the_last_is_meant() -> None:
    scene = load_scene("force_plate")
    matches = [stored_reference(scene.changed(jumps=jumps)) for jumps in (1, 4, 5)]
    assert matches[0] is not None
    assert matches[1] is not None
    assert matches[0].values != matches[1].values
    assert matches[2] is None
