from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from data_schema.errors import InputRefused, UnknownName
from simulator.declared import all_parameters
from simulator.scene import Scene, Value
from simulator.scene_file import load_scene, parse_scene, shipped_scenes, write_scene
from tests.helpers.scenes import is_sentence
from tests.helpers.wording import refuses, says

GRAINS = {"hydrostatic_stiffness", "inertial_drag", "added_mass"}
WHOLE_JUMP = {"cost_of_whole_jump"}
FOR_EVERY_ROBOT = {"leg_damping", "motor_heat"}


def test_five_scenes_are_shipped() -> None:
    assert shipped_scenes() == ("bed", "emulator", "force_plate", "sim1", "sim2")


@pytest.mark.parametrize(
    ("name", "effects", "jumps"),
    [
        ("sim1", {"active_damping", "sampled_control", "short_leg_guard", "drag", "cost_torque_cap"}, 1),
        (
            "sim2",
            {"active_damping", "sampled_control", "short_leg_guard", "constant_force_cap", "cost_of_commanded_force"}
            | {"held_gains_in_flight"},
            1,
        ),
        ("bed", {"active_damping", "sampled_control", "latched_switching", "torque_cap"}, 1),
        ("emulator", {"active_damping", "latched_switching", "short_leg_guard", "torque_cap"} | WHOLE_JUMP, 100),
        ("force_plate", {"latched_switching", "short_leg_guard", "torque_cap", "drag"} | WHOLE_JUMP, 80),
    ],
)
def test_shipped_scenes_have_the_effects_they_call_for_and_no_others(name: str, effects: set[str], jumps: int) -> None:
    ground = {"emulator": {"emulated_ground"}, "force_plate": {"rigid_ground"}}.get(
        name, GRAINS | {"contact_once_risen"}
    )
    impact = set() if ground >= GRAINS else {"touchdown_impact"}
    scene = load_scene(name)
    assert scene.effects == effects | ground | impact | FOR_EVERY_ROBOT
    assert scene.jumps == jumps


@pytest.mark.parametrize("name", shipped_scenes())
def test_shipped_scenes_have_a_value_for_every_parameter_so_that_every_effect_can_be_switched_on(name: str) -> None:
    scene = load_scene(name)
    given = {parameter.name for parameter in all_parameters().values() if parameter.assumed is None}
    assert set(scene.values) >= given
    assert all(bool(value.source) != bool(value.why) for value in scene.values.values())


@pytest.mark.parametrize("name", shipped_scenes())
def test_shipped_files_read_back_as_written(name: str, tmp_path: Path) -> None:
    scene = load_scene(name)
    file = tmp_path / f"{name}.toml"
    file.write_text(write_scene(scene), encoding="utf-8")
    assert load_scene(file) == scene
    assert load_scene(str(file)) == scene


def test_published_values_stand_in_the_scenes() -> None:
    sim2 = load_scene("sim2")
    published = {
        "body_mass": 1.75,
        "foot_mass": 0.175,
        "rest_length": 0.27,
        "k_compression": 250,
        "b_compression": 0.5,
        "k_extension": 650,
        "b_extension": 5,
        "foot_radius": 0.03,
        "force_cap": 70,
        "initial_velocity": -1,
        "b_ad": 0,
    }
    assert {name: sim2[name] for name in published} == published
    assert load_scene("sim1")["b_ad"] == load_scene("sim1")["k_extension"] == 650
    bed = load_scene("bed")
    assert bed["initial_height"] + bed["rest_length"] == pytest.approx(0.42)
    assert bed["k_extension"] == pytest.approx(2.56 * 400 + 67.36)
    assert bed.assumed == ("body_mass", "foot_mass", "kg_scale")
    assert sim2.assumed == ()


ANY_TEXT = st.text(st.characters(codec="utf-8"))
TEXT = st.text(st.characters(codec="utf-8"), min_size=1)


@given(TEXT, ANY_TEXT, TEXT, TEXT, ANY_TEXT, st.floats(0.01, 100.0))
def test_any_words_and_numbers_read_back_as_written(
    title: str, description: str, source: str, why: str, study: str, mass: float
) -> None:
    plate = load_scene("force_plate")
    values = {**plate.values, "body_mass": Value(mass, source), "foot_mass": Value(0.1, "", why, fitted_to=study)}
    scene = Scene("own", title, plate.effects, values, 7, description)
    assert parse_scene(write_scene(scene), "own") == scene


def edited(old: str, new: str) -> str:
    text = write_scene(load_scene("sim2"))
    assert text.count(old) == 1
    return text.replace(old, new)


BODY = "body_mass = { value = 1.75,"


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("jumps = 1", "jumps = 1.5", "jumps = 1.5"),
        ("jumps = 1", "jumps = true", "jumps = True"),
        ("jumps = 1", "jmps = 1", "did you mean 'jumps'?"),
        ("jumps = 1", "jumps = ", "is not TOML"),
        ("jumps = 1", 'author = "x"', "'author'"),
        ("jumps = 1", "foot_radius = 0.03", "move it to [ground]"),
        ('  "motor_heat",', '  "motor_heats",', "did you mean 'motor_heat'?"),
        ('  "motor_heat",', "  3,", "effects"),
        ('  "motor_heat",', '  "motor_heat", "motor_heat",', "motor_heat twice"),
        ("body_mass = {", "body_mas = {", "did you mean 'body_mass'?"),
        ("[robot]", "[robots]", "did you mean 'robot'?"),
        ("[start]\n", "[start]\nbody_mass = 1\n", "move it to [robot]"),
        (BODY, "body_mass = { valu = 1.75,", "body_mass is not given"),
        *((BODY, f"body_mass = {{ value = {value},", "body_mass") for value in ('"1.75"', "true", "[1.75]", "{}")),
        (BODY, "body_mass = { value = 12:30:00,", "a date or a time"),
        (BODY, f"body_mass = {{ value = -1{'0' * 400},", "not a finite number"),
        (BODY, "body_mass = { value = nan,", "not a finite number"),
        (BODY, f'{BODY} assumed = "x",', "either a source or a reason"),
        (BODY, f'{BODY} sourc = "x",', "did you mean 'source'?"),
        *((BODY, f"{BODY} set_by_user = {value},", "either a source or a reason") for value in ("true", "1")),
        (BODY, "body_mass = { value = -1,", "body_mass = -1 kg is outside"),
    ],
)
def test_refused_files(old: str, new: str, said: str, tmp_path: Path) -> None:
    file = tmp_path / "own.toml"
    file.write_text(edited(old, new), encoding="utf-8")
    with pytest.raises(InputRefused) as refusal:
        load_scene(file)
    assert str(refusal.value).startswith(file.name)
    assert said in str(refusal.value)
    assert is_sentence(str(refusal.value))


def test_a_key_that_only_programs_write_is_not_offered_to_people() -> None:
    with refuses(InputRefused, "'set'", "body_mass", "'value'") as refusal:
        parse_scene(edited("body_mass = { value = 1.75,", "body_mass = { value = 1.75, set = 1,"), "own")
    assert "set_by_user" not in str(refusal.value)


def test_only_an_assumed_value_can_have_been_fitted() -> None:
    with refuses(InputRefused, "fitted_to", "body_mass"):
        parse_scene(edited("body_mass = { value = 1.75,", 'body_mass = { value = 1.75, fitted_to = "bed",'), "own")


def test_a_value_that_was_set_is_written_as_such_and_never_with_a_source() -> None:
    scene = load_scene("bed").changed({"kg_scale": 2.0})
    text = write_scene(scene)
    says(text, "kg_scale", "value = 2.0", "set_by_user")
    assert parse_scene(text, "bed") == scene


def test_a_number_alone_has_no_source(tmp_path: Path) -> None:
    with refuses(InputRefused, "body_mass"):
        parse_scene("title = 'x'\neffects = []\n[robot]\nbody_mass = 1.75\n", "own")


def test_a_title_is_needed() -> None:
    with refuses(InputRefused, "title is missing"):
        parse_scene("effects = []", "own")


def test_unknown_scenes_and_files(tmp_path: Path) -> None:
    with refuses(UnknownName, "'sim2'", "NAME.toml"):
        load_scene("sim3")
    with refuses(InputRefused, "no scene file", "own.toml"):
        load_scene(tmp_path / "own.toml")
    binary = tmp_path / "own.toml"
    binary.write_bytes(b"\xff\xfe\x00")
    with refuses(InputRefused, "not text in", "-8"):
        load_scene(binary)
    (tmp_path / "folder.toml").mkdir()
    with refuses(InputRefused, "folder.toml"):
        load_scene(tmp_path / "folder.toml")
    with refuses(InputRefused, "own.toml/sim2.toml"):
        load_scene(binary / "sim2.toml")
