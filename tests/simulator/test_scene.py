from __future__ import annotations

import math
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from data_schema.errors import UnknownName, UsageError
from simulator.declared import all_parameters, parameters_read
from simulator.effects.registry import EFFECTS
from simulator.scene import Scene, Value
from simulator.scene_file import load_scene, parse_scene, shipped_scenes, write_scene
from tests.helpers.scenes import is_sentence, scene_or_sentence
from tests.helpers.wording import refuses

SHIPPED = {name: load_scene(name) for name in shipped_scenes()}
SIM2 = SHIPPED["sim2"]


@st.composite
def changed_values(draw: st.DrawFn) -> tuple[Scene, dict[str, float]]:
    """A shipped scene, and values in their boxes for some of the parameters that it reads."""
    scene = SHIPPED[draw(st.sampled_from(shipped_scenes()))]
    read = parameters_read(scene.effects)
    names = draw(st.lists(st.sampled_from(sorted(read)), unique=True, max_size=6))
    return scene, {name: draw(st.floats(read[name].low, read[name].high)) for name in names}


@given(changed_values())
def test_values_in_their_boxes_make_a_scene_or_a_sentence(case: tuple[Scene, dict[str, float]]) -> None:
    scene, values = case
    new = scene_or_sentence(scene.changed, values)
    if isinstance(new, str):
        assert is_sentence(new)
        return
    assert all(new[name] == value for name, value in values.items())
    assert all(new[name] == scene[name] for name in scene.values if name not in values)
    assert set(new.set_by_user) == set(values)
    assert set(new.assumed) == set(scene.assumed) - set(values)
    assert parse_scene(write_scene(new), scene.name) == new


@pytest.mark.parametrize("name", shipped_scenes())
def test_every_legal_end_of_a_box_is_in_it_and_what_lies_beyond_is_not(name: str) -> None:
    scene = SHIPPED[name]
    for parameter in parameters_read(scene.effects).values():
        for end, beyond in ((parameter.low, -math.inf), (parameter.high, math.inf)):
            outside = math.nextafter(end, beyond)
            with refuses(UsageError, parameter.name, "outside what can"):
                scene.changed({parameter.name: outside})
            at_the_end = scene_or_sentence(scene.changed, {parameter.name: end})
            if isinstance(at_the_end, str):  # a rule between parameters, never the box
                assert "outside what can" not in at_the_end
            else:
                assert at_the_end[parameter.name] == end


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"foot_radius": 0.0}, "foot_radius = 0 m is outside what can be simulated: give 0.001 to 0.2 m."),
        ({"foot_radius": 1e-9}, "foot_radius = 1e-09 m is outside"),
        ({"foot_mass": -0.1}, "foot_mass = -0.1 kg is outside"),
        ({"body_mass": math.nan}, "body_mass = nan is not a finite number: give one from"),
        ({"k_sh": math.inf}, "k_sh = inf is not a finite number"),
        ({"foot_radios": 0.03}, "'foot_radios' is not a known parameter: did you mean 'foot_radius'?"),
        ({"rest_length": 0.3}, "rest_length = 0.3 m is out of the leg's reach, which is between 0.1 m (folded) and"),
        ({"rest_length": 0.1}, "is out of the leg's reach"),
        ({"upper_link": 0.2}, "upper_link = 0.2 m is not shorter than lower_link = 0.2 m"),
        ({"kg_scale": 0.018}, "(K < m_a g): give at least kg_scale = 0.0182, or leave out added_mass."),
        ({"platform_travel": 0.05}, "only emulated_ground reads it and is off: switch it on, or leave platform_travel"),
        ({"velocity_constant": 0.1}, "velocity_constant would change nothing, because only drag reads it"),
    ],
)
def test_refused_values(changes: dict[str, float], said: str) -> None:
    with pytest.raises(UsageError) as refusal:
        SIM2.changed(changes)
    assert said in str(refusal.value)
    assert is_sentence(str(refusal.value))


@pytest.mark.parametrize(
    ("on", "off", "said"),
    [
        (("dragg",), (), "'dragg' is not a known effect: did you mean 'drag'?"),
        (("drag",), ("drag",), "drag is to be both on and off: name it once."),
        ((), ("hydrostatic_stiffness", "inertial_drag", "added_mass"), "a scene without a ground has nothing to jump"),
        ((), ("hydrostatic_stiffness",), "a scene without a ground"),
        (("torque_cap",), (), "cannot be on together, since the leg's force has one cap: leave out"),
        (("rigid_ground",), (), "cannot be on together, since a foot stands on one ground: leave out"),
        (
            ("held_force",),
            ("sampled_control",),
            "held_force needs sampled_control, which is off: switch that on too, or",
        ),
    ],
)
def test_refused_effects(on: tuple[str, ...], off: tuple[str, ...], said: str) -> None:
    with pytest.raises(UsageError) as refusal:
        SIM2.changed(effects_on=on, effects_off=off)
    assert said in str(refusal.value)
    assert is_sentence(str(refusal.value))


def test_an_effect_that_is_on_already_may_be_switched_on_again_and_off_twice() -> None:
    assert SIM2.changed(effects_on=("motor_heat",), effects_off=("drag",)) == SIM2


def test_a_parameter_that_an_effect_reads_has_to_have_a_value() -> None:
    values = {name: value for name, value in SIM2.values.items() if name != "velocity_constant"}
    bare = replace(SIM2, values=values)
    with refuses(UsageError, "velocity_constant"):
        bare.changed(effects_on=("drag",))
    with refuses(UsageError, "body_mass"):
        replace(SIM2, values={name: value for name, value in SIM2.values.items() if name != "body_mass"})
    with refuses(UnknownName, "parameter of this"):
        bare["velocity_constant"]


def test_values_of_effects_that_are_off_are_checked_too() -> None:
    with refuses(UsageError, "-1 m", "is outside"):
        replace(SIM2, values={**SIM2.values, "platform_travel": Value(-1.0, "x")})


def test_effects_can_be_changed_together_with_the_values_they_read() -> None:
    changed = SIM2.changed({"stall_torque": 5.0}, effects_on=("torque_cap",), effects_off=("constant_force_cap",))
    assert changed["stall_torque"] == 5.0
    assert changed.values["stall_torque"] == Value(5.0, set_by_user=True)
    assert changed.set_by_user == ("stall_torque",)
    assert changed.changed(effects_on=("constant_force_cap",), effects_off=("torque_cap",)).set_by_user == ()


@pytest.mark.parametrize("name", shipped_scenes())
def test_assumed_are_the_parameters_without_source_that_are_read(name: str) -> None:
    scene = SHIPPED[name]
    read = set(scene.read)
    assert set(scene.assumed) == {name for name in read if scene.values[name].source == ""}
    assert {name for name in scene.values if scene.values[name].assumed} > set(scene.assumed)


@pytest.mark.parametrize("jumps", [0, -1, 2_000_000])
def test_refused_numbers_of_jumps(jumps: int) -> None:
    with refuses(UsageError, "not a number", "1"):
        SHIPPED["force_plate"].changed(jumps=jumps)


def test_a_granular_bed_is_levelled_between_jumps() -> None:
    with refuses(UsageError, "levelled after every", "1"):
        SIM2.changed(jumps=2)
    assert SHIPPED["emulator"].changed(jumps=4).jumps == 4


def test_all_parameters_belong_to_every_scene_or_to_an_effect() -> None:
    everything = parameters_read(EFFECTS)
    assert everything == all_parameters()
