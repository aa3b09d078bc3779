"""Scene files: they read back as written, and what is none is refused with what to write in its place."""

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


@pytest.mark.parametrize("name", shipped_scenes())
def test_shipped_files_read_back_as_written(name: str, tmp_path: Path) -> None:
    scene = load_scene(name)
    file = tmp_path / f"{name}.toml"
    file.write_text(write_scene(scene), encoding="utf-8")
    assert load_scene(file) == load_scene(str(file)) == scene


def test_shipped_scenes_have_a_sourced_or_assumed_value_for_every_parameter() -> None:
    given = {parameter.name for parameter in all_parameters().values() if parameter.assumed is None}
    for scene in map(load_scene, shipped_scenes()):
        assert set(scene.values) >= given  # so that every effect can be switched on
        assert all(bool(value.source) != bool(value.why) for value in scene.values.values())
    assert load_scene("bed").assumed == ("body_mass", "foot_mass", "kg_scale")
    assert load_scene("sim2").assumed == ()


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
        ("jumps = 1", "jumps = true", "jumps = True"),
        ("jumps = 1", "jmps = 1", "did you mean 'jumps'?"),
        ("jumps = 1", "jumps = ", "is not TOML"),
        ("jumps = 1", "foot_radius = 0.03", "move it to [ground]"),
        ('  "motor_heat",', '  "motor_heats",', "did you mean 'motor_heat'?"),
        ('  "motor_heat",', "  3,", "effects"),
        ('  "motor_heat",', '  "motor_heat", "motor_heat",', "motor_heat twice"),
        ("body_mass = {", "body_mas = {", "did you mean 'body_mass'?"),
        ("[robot]", "[robots]", "did you mean 'robot'?"),
        ("[start]\n", "[start]\nbody_mass = 1\n", "move it to [robot]"),
        (BODY, "body_mass = { valu = 1.75,", "body_mass is not given"),
        *((BODY, f"body_mass = {{ value = {value},", "body_mass") for value in ('"1.75"', "true", "{}")),
        (BODY, "body_mass = { value = 12:30:00,", "a date or a time"),
        (BODY, f"body_mass = {{ value = -1{'0' * 400},", "not a finite number"),
        (BODY, "body_mass = { value = nan,", "not a finite number"),
        (BODY, f'{BODY} assumed = "x",', "either a source or a reason"),
        (BODY, f'{BODY} sourc = "x",', "did you mean 'source'?"),
        (BODY, f"{BODY} set_by_user = true,", "either a source or a reason"),
        (BODY, f"{BODY} set = 1,", "'set'"),
        (BODY, f'{BODY} fitted_to = "bed",', "fitted_to"),
        (BODY, "body_mass = { value = -1,", "body_mass = -1 kg is outside"),
        ("[robot]\n", "[robot]\nrest_length = 0.27\n", "is not TOML"),
        ("title = ", "# ", "title is missing"),
    ],
)
def test_refused_files(old: str, new: str, said: str, tmp_path: Path) -> None:
    file = tmp_path / "own.toml"
    file.write_text(edited(old, new), encoding="utf-8")
    with refuses(InputRefused, said) as refusal:
        load_scene(file)
    assert str(refusal.value).startswith(file.name)
    assert is_sentence(str(refusal.value))


def test_all_that_a_file_lacks_is_named_at_once(tmp_path: Path) -> None:
    """Also what is assumed where an effect is switched on in another scene."""
    lines = write_scene(load_scene("bed").changed({"gear_ratio": 6.0}, ("linear_leg",))).splitlines()
    lacking = ("body_mass", "k_extension", "sigma", "gear_ratio")
    file = tmp_path / "own.toml"
    file.write_text("\n".join(line for line in lines if not line.startswith(lacking)), encoding="utf-8")
    with refuses(InputRefused, "4 parameters", *lacking, "N/m^3", "[ground]", "linear_leg") as refusal:
        load_scene(file)
    assert is_sentence(str(refusal.value))
    file.write_text("\n".join(line for line in lines if not line.startswith("gear_ratio")), encoding="utf-8")
    with refuses(InputRefused, "gear_ratio", "linear_leg"):
        load_scene(file)


def test_a_parameter_of_an_effect_that_is_not_there_leads_to_how_one_is_added() -> None:
    text = edited("[drive]\n", '[drive]\nefficiency = { value = 0.9, source = "data sheet" }\n')
    with refuses(InputRefused, "'efficiency'", "docs/add-an-effect.md"):
        parse_scene(text, "own")


def test_a_value_that_was_set_is_written_as_such_and_never_with_a_source() -> None:
    scene = load_scene("bed").changed({"kg_scale": 2.0})
    text = write_scene(scene)
    says(text, "kg_scale", "value = 2.0", "set_by_user")
    assert parse_scene(text, "bed") == scene


def test_unknown_scenes_and_files(tmp_path: Path) -> None:
    with refuses(UnknownName, "'sim2'", "NAME.toml"):
        load_scene("sim3")
    with refuses(InputRefused, "no scene file", "own.toml"):
        load_scene(tmp_path / "own.toml")
    binary, folder = tmp_path / "own.toml", tmp_path / "folder.toml"
    binary.write_bytes(b"\xff\xfe\x00")
    folder.mkdir()
    for path, said in ((binary, "not text in"), (folder, "folder.toml"), (binary / "sim2.toml", "own.toml/sim2.toml")):
        with refuses(InputRefused, said):
            load_scene(path)
