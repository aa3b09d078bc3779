"""Words that change a scene: parameters, gains, effects, and what is refused."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from data_schema.errors import UsageError
from simulator.changes import changed_by_words
from simulator.declared import all_parameters, parameters_read
from simulator.scene_file import load_scene, shipped_scenes
from tests.helpers.scenes import is_sentence, scene_or_sentence
from tests.helpers.wording import refuses, says

SIM2, EMULATOR, BED, PLATE = (load_scene(name) for name in ("sim2", "emulator", "bed", "force_plate"))


@given(st.sampled_from(sorted(parameters_read(SIM2.effects))), st.floats(0.0, 1.0))
def test_any_parameter_can_be_set(name: str, share: float) -> None:
    parameter = all_parameters()[name]
    value = parameter.low + share * (parameter.high - parameter.low)
    changed = scene_or_sentence(changed_by_words, SIM2, [f"{name}={value!r}"])
    assert is_sentence(changed) if isinstance(changed, str) else changed[name] == value


def test_nothing_said_changes_nothing() -> None:
    for name in shipped_scenes():
        assert changed_by_words(load_scene(name)) == load_scene(name)
        assert changed_by_words(load_scene(name), [], "") == load_scene(name)


def test_effects_by_their_signs_and_the_leg_in_flight() -> None:
    changed = changed_by_words(SIM2, ["velocity_constant=0.1"], " +drag, -added_mass ,-inertial_drag")
    assert changed.effects == (SIM2.effects | {"drag"}) - {"added_mass", "inertial_drag"}
    assert changed["velocity_constant"] == 0.1
    held, massless = "held_gains_in_flight", "massless_leg_in_flight"
    assert held not in changed_by_words(SIM2, ["flight=soft"]).effects
    assert changed_by_words(SIM2, ["flight=held"]) == SIM2
    assert changed_by_words(SIM2, ["flight=massless"]).effects == (SIM2.effects - {held}) | {massless}
    assert changed_by_words(BED, ["flight=soft"]) == BED


def test_gains_and_drop_heights_in_physical_units() -> None:
    assert changed_by_words(BED, ["drop_height=0.5", "rest_length=0.25"])["initial_height"] == pytest.approx(0.25)
    assert changed_by_words(BED, ["gain=300"])["k_extension"] == pytest.approx(835.36)
    assert changed_by_words(BED, ["damping_gain=150"])["b_ad"] == pytest.approx(3.32 * 150 + 19.67)
    assert changed_by_words(BED, ["damping_gain=0"])["b_ad"] == 0.0
    assert changed_by_words(EMULATOR, ["damping_gain=50"])["b_ad"] == pytest.approx(166.0)
    assert changed_by_words(PLATE, ["gain=600", "damping_gain=0"], "+active_damping")["b_ad"] == 0.0


def test_the_title_tells_what_was_changed() -> None:
    changed = changed_by_words(BED, ["gain=300", " b_ad=517.67"], "+drag, -added_mass")
    says(changed.title, BED.title, "gain=300", "b_ad=517.67", "added_mass")
    assert changed_by_words(changed, ["mu=1"]).title == f"{changed.title}, mu=1"
    three = changed_by_words(EMULATOR, ["jumps=3"])
    says(three.title, EMULATOR.title, "jumps=3")
    assert three.jumps == 3
    assert changed_by_words(SIM2, [], "+motor_heat").title == SIM2.title


def test_what_is_set_has_no_source_and_is_not_assumed() -> None:
    changed = changed_by_words(BED, ["kg_scale=2", "gain=300"])
    assert changed.set_by_user == ("k_extension", "kg_scale")
    assert changed.assumed == ("body_mass", "foot_mass")
    assert not any(changed.values[name].source for name in changed.set_by_user)


@pytest.mark.parametrize(
    ("sets", "effects", "said"),
    [
        (["foot_radius"], None, "'foot_radius' is not NAME=VALUE: write for example --set foot_radius=0.038."),
        (["foot_radius="], None, "is not NAME=VALUE"),
        (["foot_radus=0.03"], None, "'foot_radus' is not a known parameter: did you mean 'foot_radius'?"),
        (["gian=300"], None, "'gian' is not a known parameter: did you mean 'gain'?"),
        (["foot_radius=0.03m"], None, "foot_radius=0.03m is not a number: give a plain one in m, without its unit."),
        (["foot_radius=nan"], None, "foot_radius = nan is not a finite number"),
        (["mu=2", "mu=3"], None, "mu=2 and mu=3 both set mu: leave one of them out."),
        (["gain=300", "k_extension=650"], None, "gain=300 and k_extension=650 both set k_extension"),
        (["flight=held", "flight=soft"], None, "both set the leg in flight"),
        (["flight=hard"], None, "'hard' is not a known leg in flight"),
        (["jumps=many"], None, "jumps=many is not a whole number"),
        (["drop_height=0.2"], None, "starts with the foot in the ground: give the body's height"),
        (["drag=1"], None, "drag is an effect, not a parameter: switch it with --effects +drag or -drag."),
        (["flight=held"], "-held_gains_in_flight", "held_gains_in_flight is to be both on and off"),
        ([], "drag", "--effects 'drag' does not say on or off: write +drag or -drag."),
        ([], "+dragg", "'dragg' is not a known effect: did you mean 'drag'?"),
        ([], "+drag,-drag", "drag is to be both on and off"),
    ],
)
def test_refused_words(sets: list[str], effects: str | None, said: str) -> None:
    with refuses(UsageError, said) as refusal:
        changed_by_words(SIM2, sets, effects)
    assert is_sentence(str(refusal.value))
