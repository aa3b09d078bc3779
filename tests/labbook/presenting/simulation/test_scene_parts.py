"""What scenes are made of, as it is shown: nothing is left out, and docs/scenes.md says the same."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from labbook.presenting.simulation.scene_parts import part_data, part_lines, parts_data, parts_markdown, parts_tables
from simulator.changes import WORDS, changed_by_words
from simulator.declared import all_parameters, readers
from simulator.effects.registry import EFFECTS
from simulator.jump import simulate
from simulator.scene_file import load_scene, parse_scene, shipped_scenes

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


def test_the_scene_of_the_document_can_be_simulated() -> None:
    (text,) = re.findall(r"```toml\n(.*?)```", DOCUMENT, re.DOTALL)
    scene = parse_scene(text, "own")
    assert set(scene.values) == set(scene.read)  # neither more nor less than is needed
    assert scene.effects == load_scene("force_plate").effects  # whose kernel other tests compile
    result = simulate(scene)
    assert [jump.outcome for jump in result.jumps] == ["touchdown", "touchdown"]
