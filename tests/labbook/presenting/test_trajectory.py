"""A simulated motion as the pictures draw it."""

from __future__ import annotations

from dataclasses import replace

import pytest

from labbook.presenting.trajectory import trajectory_of
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
    drawn = trajectory_of(simulate(scene.changed(jumps=min(scene.jumps, 2)), trajectory=True))
    assert {span.name for span in drawn.spans} == names


def test_a_scene_whose_ground_asks_for_no_radius_has_a_foot_all_the_same() -> None:
    plate = load_scene("force_plate").changed(jumps=1)
    bare = replace(plate, values={name: plate.values[name] for name in plate.read})
    assert "foot_radius" not in bare.values
    assert trajectory_of(simulate(bare, trajectory=True)).leg.foot_radius_m > 0.0
