"""What scenes are made of, as it is shown: nothing is left out, and docs/scenes.md says the same."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from labbook.presenting.simulation.scene_parts import part_data, part_lines, parts_data, parts_markdown, parts_tables
from simulator.changes import WORDS, changed_by_words
from simulator.declared import all_parameters, readers
from simulator.effects.registry import EFFECTS
from simulator.jump import simulate
from simulator.scene import Scene
from simulator.scene_file import load_scene, parse_scene, shipped_scenes
from tests.helpers.kernels import interpreted
from tests.helpers.wording import says

DOCUMENT = (Path(__file__).parents[4] / "docs" / "scenes.md").read_text(encoding="utf-8")


def test_every_effect_parameter_and_word_is_listed_once() -> None:
    every = {"effects": sorted(EFFECTS), "parameters": sorted(all_parameters()), "words": sorted(WORDS)}
    assert {name: sorted(row.cells[0].text for row in table.rows) for name, table in parts_tables().items()} == every
    assert {name: sorted(part) for name, part in parts_data().items()} == every


@pytest.mark.parametrize("name", [*EFFECTS, *all_parameters(), *WORDS])
def test_one_of_them_is_told_in_words_and_for_programs(name: str) -> None:
    data, lines = part_data(name), part_lines(name)
    assert lines[0] == f"{name} ({data['kind']}): {data['meaning']}."
    text = " ".join(lines)
    if data["kind"] == "effect":
        assert all(f"not with {other}: {why}." in text for other, why in EFFECTS[name].excludes.items())
        assert all(item.name in text for item in EFFECTS[name].parameters)
        assert all(other in text for alternatives in EFFECTS[name].needs for other in alternatives)
    if data["kind"] == "parameter":
        assert all(effect in text for effect in readers(name))
        for scene in map(load_scene, shipped_scenes()):
            assert any(line.startswith(f"{scene.name}: ") for line in lines) == (name in scene.read)


@pytest.mark.parametrize(("word", "value"), [("gain", 300.0), ("damping_gain", 0.0), ("damping_gain", 150.0)])
def test_what_a_word_is_said_to_set_is_what_it_sets(word: str, value: float) -> None:
    for scene in ("bed", "emulator"):
        given = load_scene(scene)
        effects = "+active_damping,-scaled_active_damping"
        found = changed_by_words(given, [f"{word}={value}"], effects)
        slope, offset = map(float, re.findall(r"([\d.]+) gain \+ ([\d.]+)", WORDS[word].meaning)[0])
        if word == "damping_gain":
            offset = 0.0 if value == 0.0 or scene == "emulator" else offset
        assert found["k_extension" if word == "gain" else "b_ad"] == pytest.approx(slope * value + offset)


def test_the_document_has_these_tables() -> None:
    missing = [line for line in parts_markdown().splitlines() if line not in DOCUMENT.splitlines()]
    assert missing == []  # docs/scenes.md lacks these lines: paste what `labbook sim parts --markdown` prints
    for part in parts_markdown().split("\n\n"):
        assert part.strip() in DOCUMENT  # lines that are gone: paste what `labbook sim parts --markdown` prints


@pytest.mark.parametrize(
    ("name", "facts"),
    [
        ("k_sh", ("K(z)", "k_sh", "sigma", "cone_angle")),
        ("b_g", ("D(z)", "b_g", "c_g")),
        ("hydrostatic_stiffness", ("cohesion", "depth", "Bekker")),
        ("linear_leg", ("inertia", "friction", "efficiency", "gear_ratio / pinion_radius")),
        ("linear_leg", ("two motors",)),
        ("motor_resistance", ("two motors",)),
        ("motor_heat", ("two motors", "R I^2 / 2")),
    ],
)
def test_what_a_part_computes_and_leaves_out_is_told(name: str, facts: tuple[str, ...]) -> None:
    assert says(part_lines(name), *facts)


def own_scene() -> Scene:
    (text,) = re.findall(r"```toml\n(.*?)```", DOCUMENT, re.DOTALL)
    return parse_scene(text, "own")


def test_the_scene_of_the_document_can_be_simulated() -> None:
    scene = own_scene()
    assert set(scene.values) == set(scene.read)  # neither more nor less than is needed
    jump = interpreted(simulate, scene, 1e-3).jump
    assert (jump.outcome, jump.under_surface) == ("touchdown", False)
    assert jump.cost_J > 0.0


def ground_at(scene: Scene, depth_m: float) -> tuple[float, float, float]:
    """Resistance, drag and added mass of a scene's grains at a depth, as the effects compute them."""
    place: dict[str, int] = {name: number for number, name in enumerate(scene.read)}
    effects = [EFFECTS[name] for name in ("hydrostatic_stiffness", "inertial_drag", "added_mass")]
    made = [effect.functions(lambda name: place.setdefault(name, len(place))) for effect in effects]
    row = np.zeros(len(place))
    row[: len(scene.read)] = [scene[name] for name in scene.read]
    for functions in made:
        functions["prepare"](row)
    stiffness, drag, added = made
    found = stiffness["resistance_n"], drag["quadratic_drag_kg_m"], added["added_mass_kg"]
    return tuple(float(each(row, depth_m)) for each in found)  # type: ignore[return-value]


@pytest.mark.parametrize("depth_m", [0.0, 0.02, 0.3])
def test_the_formulas_of_the_document_are_those_of_the_ground(depth_m: float) -> None:
    """They are read as they stand there: a space is a product."""
    scene = own_scene().changed({"kg_scale": 1.3, "bg_scale": 0.7})
    known: dict[str, Any] = {name: scene[name] for name in scene.read}
    known |= {"z": depth_m, "R": known["foot_radius"], "C": known["added_mass_constant"]}
    known |= {"pi": math.pi, "tan": math.tan, "cos": math.cos, "min": min}
    for formula in re.findall(r"(?:^ {4}|, )((?:q|s|A|V|K|D|m_a) = .*?)(?=, [sV] = | {3})", DOCUMENT, re.MULTILINE):
        name, _, said = formula.translate(str.maketrans("[]", "()")).replace("^", "**").partition(" = ")
        known[name] = eval(re.sub(r"(?<=[\w)]) (?=[\w(])", " * ", said), {}, known)
    assert (known["K"], known["D"], known["m_a"]) == pytest.approx(interpreted(ground_at, scene, depth_m), rel=1e-12)


def test_the_ground_of_the_document_gives_the_pressures_of_its_plate_test() -> None:
    scene = own_scene()
    readings = re.findall(r"(\d+) kPa at (\d+) cm", DOCUMENT)
    assert len(readings) == 2
    for pressure, depth_cm in readings:
        force_n, _, _ = interpreted(ground_at, scene, 0.01 * float(depth_cm))
        assert force_n / (math.pi * scene["foot_radius"] ** 2) == pytest.approx(1e3 * float(pressure), rel=0.005)
