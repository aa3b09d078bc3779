"""Scenes: every legal value makes one, or is refused in a sentence that says what to give; rules between parameters."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from data_schema.errors import UnknownName, UsageError
from simulator.declared import parameters_read
from simulator.parameter import GRAVITY_M_S2
from simulator.scene import DEEPEST_M, Scene, Value, least_bearing_ratio
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
    ("values", "on", "off", "said"),
    [
        ({"foot_radius": 0.0}, "", "", "foot_radius = 0 m is outside what can be simulated: give 0.001 to 0.2 m."),
        ({"body_mass": math.nan}, "", "", "body_mass = nan is not a finite number: give one from"),
        ({"k_sh": math.inf}, "", "", "k_sh = inf is not a finite number"),
        ({"foot_radios": 0.03}, "", "", "'foot_radios' is not a known parameter: did you mean 'foot_radius'?"),
        ({"rest_length": 0.3}, "", "", "rest_length = 0.3 m is out of the leg's reach, which is between 0.1 m"),
        ({"upper_link": 0.2}, "", "", "upper_link = 0.2 m is not shorter than lower_link = 0.2 m"),
        ({"kg_scale": 0.018}, "", "", "(K < m_a g): give at least kg_scale = 0.0182, or leave out added_mass."),
        ({"platform_travel": 0.05}, "", "", "only emulated_ground reads it and is off: switch it on, or leave"),
        ({}, "dragg", "", "'dragg' is not a known effect: did you mean 'drag'?"),
        ({}, "drag", "drag", "drag is to be both on and off: name it once."),
        ({}, "", "hydrostatic_stiffness inertial_drag added_mass", "a scene without a ground has nothing to jump"),
        ({}, "torque_cap", "", "cannot be on together, since the leg's force has one cap: leave out"),
        ({}, "rigid_ground", "", "cannot be on together, since a foot stands on one ground: leave out"),
        ({}, "held_force", "sampled_control", "held_force needs sampled_control, which is off: switch that on too, or"),
    ],
)
def test_what_makes_no_scene_is_refused(values: dict[str, float], on: str, off: str, said: str) -> None:
    with refuses(UsageError, said) as refusal:
        SIM2.changed(values, on.split(), off.split())
    assert is_sentence(str(refusal.value))


@pytest.mark.parametrize(("name", "jumps"), [("force_plate", 0), ("force_plate", 2_000_000), ("sim2", -1)])
def test_refused_numbers_of_jumps(name: str, jumps: int) -> None:
    with refuses(UsageError, f"jumps = {jumps}"):
        SHIPPED[name].changed(jumps=jumps)


def test_a_parameter_that_an_effect_reads_has_to_have_a_value() -> None:
    values = {name: value for name, value in SIM2.values.items() if name != "velocity_constant"}
    bare = replace(SIM2, values=values)
    with refuses(UsageError, "velocity_constant"):
        bare.changed(effects_on=("drag",))
    with refuses(UsageError, "body_mass"):
        replace(SIM2, values={name: value for name, value in SIM2.values.items() if name != "body_mass"})
    with refuses(UnknownName, "parameter of this"):
        bare["velocity_constant"]
    with refuses(UsageError, "-1 m", "is outside"):  # of an effect that is off, too
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


SIM2 = load_scene("sim2")
EMULATOR = load_scene("emulator")
NOMINAL = {name: SIM2[name] for name in SIM2.read}


def ratios(p: dict[str, float], n_depths: int = 4000) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """K / (m_a g) at many depths, as the functions stand in the thesis's code."""
    radius, q = p["foot_radius"], p["mu"] / math.tan(p["cone_angle"])
    z = np.concatenate(
        [np.geomspace(1e-9, DEEPEST_M, n_depths), np.linspace(1e-6, min(radius / q, DEEPEST_M), n_depths)]
    )
    s = np.minimum(z, radius / q)
    volume = math.pi * (radius**2 * s - q * radius * s**2 + q**2 * s**3 / 3)
    area = math.pi * radius**2
    k = p["kg_scale"] * (p["k_sh"] * volume / area + p["sigma"] * z * (area + volume) / math.cos(p["cone_angle"]))
    added = p["phi"] * p["rho"] * p["mu"] * volume + p["added_mass_constant"] * z
    found: np.ndarray[tuple[int], np.dtype[np.float64]] = k / (added * GRAVITY_M_S2)
    return found


BOX = {
    "foot_radius": st.floats(0.001, 0.2),
    "cone_angle": st.floats(0.2, 1.4),
    "mu": st.floats(0.05, 20.0),
    "k_sh": st.floats(0.0, 1e5),
    "sigma": st.floats(1.0, 1e7),
    "rho": st.floats(10.0, 2e4),
}


@given(st.fixed_dictionaries(BOX), st.floats(0.0, 20.0))
def test_the_least_bearing_ratio_is_that_of_all_depths(ground: dict[str, float], constant: float) -> None:
    p = NOMINAL | ground | {"added_mass_constant": constant}
    assert least_bearing_ratio(p) <= ratios(p).min() * (1 + 1e-9)
    assert least_bearing_ratio(p) == pytest.approx(ratios(p).min(), rel=1e-3)


def test_a_ground_that_cannot_carry_its_grains_is_refused_and_the_sentence_gives_the_scale_that_can() -> None:
    limit = 1.0 / least_bearing_ratio(NOMINAL)
    assert limit == pytest.approx(0.0182, abs=1e-4)  # "below about 0.018"
    SIM2.changed({"kg_scale": 1.0001 * limit})
    with refuses(UsageError, "m_a") as refusal:
        SIM2.changed({"kg_scale": 0.5 * limit})
    scale = float(str(refusal.value).split("kg_scale = ")[2].split(",")[0])
    SIM2.changed({"kg_scale": scale})
    SIM2.changed({"kg_scale": 0.5 * limit}, effects_off=("added_mass",))


def test_a_soft_surface_over_firm_depth_is_judged_by_its_surface() -> None:
    p = NOMINAL | {"k_sh": 0.0, "kg_scale": 0.05}
    assert least_bearing_ratio(p) == pytest.approx(ratios(p).min(), rel=1e-6)
    with refuses(UsageError, "m_a"):
        SIM2.changed({"k_sh": 0.0, "kg_scale": 0.05})


def test_a_guard_that_never_acts_is_refused_on_hard_ground() -> None:
    with refuses(UsageError, "guard_length = 0.101", "never acts"):
        SHIPPED["force_plate"].changed({"guard_length": 0.101})
    SHIPPED["force_plate"].changed({"guard_length": 0.1011})
    SHIPPED["force_plate"].changed({"guard_length": 0.11, "upper_link": 0.1, "lower_link": 0.205})


@pytest.mark.parametrize("name", ["release_tolerance", "switch_compression"])
def test_release_and_switching_come_before_the_leg_turns_soft(name: str) -> None:
    with refuses(UsageError, "rest_tolerance"):
        EMULATOR.changed({name: 0.004})
    equal = EMULATOR.changed({"release_tolerance": EMULATOR["rest_tolerance"]})  # the release goes first
    assert equal["release_tolerance"] == equal["rest_tolerance"]
