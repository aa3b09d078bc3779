"""A simulated motion as the pictures draw it, and what they say above it."""

from __future__ import annotations

import pytest

from labbook.presenting.simulation.simulated import OUTCOMES
from labbook.presenting.simulation.trajectory import drawn_trajectory
from simulator.changes import changed_by_words
from simulator.jump import simulate
from simulator.scene_file import load_scene


@pytest.mark.parametrize(
    ("name", "names"),
    [
        ("sim2", {"intruding", "jammed", "flight"}),
        ("emulator", {"platform yields", "platform held", "flight"}),
        ("force_plate", {"stands", "flight"}),
    ],
)
def test_modes_have_the_names_of_their_ground(name: str, names: set[str]) -> None:
    scene = load_scene(name)
    drawn = drawn_trajectory(simulate(scene.changed(jumps=min(scene.jumps, 2)), trajectory=True))
    assert {span.name for span in drawn.spans} == names


@pytest.mark.parametrize(
    ("sets", "which", "ended"),
    [
        (["k_compression=160", "gain=100"], "jump 1 of 100", "; {sentence} ({outcome})"),
        (["jumps=3"], "jump 3 of 3", ""),
    ],
)
def test_the_title_names_the_jump_that_is_drawn_and_how_it_ended(sets: list[str], which: str, ended: str) -> None:
    scene = load_scene("emulator")
    result = simulate(changed_by_words(scene, sets), 1e-4, trajectory=True)
    title = drawn_trajectory(result).title
    assert title.startswith(f"emulator, {which}: {scene.title}, but with {', '.join(sets)}")
    outcome = result.jump.outcome
    assert title.endswith(ended.format(sentence=OUTCOMES[outcome], outcome=outcome) or sets[-1])
