"""A simulated motion as it is drawn: heights and force over one time, the modes of its ground, and how it ended."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from functools import partial

import pytest

from labbook.presenting.simulation.simulated import OUTCOMES, figure_title, mode_name
from reports.figures.kind import svg_bytes
from reports.figures.trajectory import draw_trajectory
from simulator.changes import changed_by_words
from simulator.jump import simulate
from simulator.scene_file import load_scene


@pytest.mark.parametrize(
    ("name", "modes"),
    [
        ("sim2", {"intruding", "jammed", "surface"}),
        ("emulator", {"platform yields", "platform held"}),
        ("force_plate", {"stands"}),
    ],
)
def test_heights_and_force_over_one_time_with_every_mode_of_the_ground_named_once(name: str, modes: set[str]) -> None:
    scene = load_scene(name)
    result = simulate(scene.changed(jumps=min(scene.jumps, 2)), trajectory=True)
    figure = draw_trajectory(result, "own: one jump", partial(mode_name, scene))
    heights, force = figure.axes
    assert heights.get_title("left") == "own: one jump"
    assert (heights.get_ylabel(), force.get_ylabel(), force.get_xlabel()) == ("Height (m)", "Leg force (N)", "Time (s)")
    names = [text.get_text() for text in figure.legends[0].get_texts()]
    assert sorted(names) == sorted([*modes, "body", "foot", "ground", "lift-off", "apex", "leg's push"])
    assert max(heights.get_lines()[0].get_ydata()) == pytest.approx(result.jump.apex_height_m, rel=1e-6)
    ElementTree.fromstring(svg_bytes(figure))


def test_the_surface_of_grains_is_drawn_where_the_foot_has_left_it() -> None:
    result = simulate(load_scene("sim2"), trajectory=True)
    lines = {line.get_label(): line for line in draw_trajectory(result, "one jump", str).axes[0].get_lines()}
    assert set(lines["surface"].get_ydata()) == {0.0}
    assert min(lines["ground"].get_ydata()) == pytest.approx(-result.jump.max_depth_m)


@pytest.mark.parametrize(
    ("sets", "which", "ended"),
    [
        (["k_compression=160", "gain=100"], "jump 1 of 100", "; {sentence} ({outcome})"),
        (["jumps=3"], "jump 3 of 3", ""),
    ],
)
def test_the_title_names_the_jump_that_is_drawn_and_how_it_ended(sets: list[str], which: str, ended: str) -> None:
    scene = load_scene("emulator")
    result = simulate(changed_by_words(scene, sets), 1e-4)
    title, outcome = figure_title(result), result.jump.outcome
    assert title.startswith(f"emulator, {which}: {scene.title}, but with {', '.join(sets)}")
    assert title.endswith(ended.format(sentence=OUTCOMES[outcome], outcome=outcome) or sets[-1])
