"""A set of effects, chosen where a scene stands, at the corners of a sweep."""

from __future__ import annotations

import pytest

from data_schema.vocabulary import Undefined
from simulator.ablation.corners import MOST_CORNERS, compare_at_corners
from simulator.gains import stiffness_n_m
from simulator.jump import simulate
from simulator.scene_file import load_scene
from simulator.sweep.axes import axes_of

FULL = load_scene("sim2")
CHOSEN = FULL.changed(effects_off=["added_mass"])
ACCURACY = 1e-6
pytestmark = pytest.mark.soak  # two kernels of their own; tests/cli/test_sim_effects.py looks at corners without any


def test_every_corner_is_what_two_simulations_give() -> None:
    axes = axes_of(["b_ad=0,50,300", "gain=600,300"], FULL.effects)
    found = compare_at_corners(FULL, CHOSEN, axes, ACCURACY)
    assert found.refused == 0
    assert [dict(corner.at) for corner in found.compared] == [
        {"b_ad": damping, "gain": gain} for damping in (0.0, 300.0) for gain in (300.0, 600.0)
    ]
    for corner in found.compared:
        values = {"b_ad": corner.at["b_ad"], "k_extension": stiffness_n_m(corner.at["gain"])}
        full, chosen = (simulate(scene.changed(values), ACCURACY).jump for scene in (FULL, CHOSEN))
        assert corner.difference.cost == pytest.approx(chosen.cost_J / full.cost_J - 1.0, abs=1e-12)
        assert corner.difference.depth == pytest.approx(chosen.max_depth_m / full.max_depth_m - 1.0, abs=1e-12)
    assert found.worst is not None
    assert found.worst.difference.largest == max(corner.difference.largest for corner in found.compared) > 0.0


def test_a_corner_where_the_jump_ends_otherwise_is_the_worst() -> None:
    plate = load_scene("force_plate").changed(jumps=1)
    axes = axes_of(["k_extension=100,800"], plate.effects)
    same = compare_at_corners(plate, plate, axes, ACCURACY)
    assert [corner.difference.largest for corner in same.compared] == [0.0, 0.0]  # at 100 none jumps, and none should
    found = compare_at_corners(plate, plate.changed(effects_off=["leg_damping"]), axes, ACCURACY)
    assert found.worst is not None
    assert found.worst.at == {"k_extension": 800.0}
    assert isinstance(found.worst.difference.cost, Undefined)


def test_with_more_than_four_ranges_each_end_is_looked_at_alone() -> None:
    words = ["b_ad=0,300", "gain=300,600", "foot_radius=0.02,0.04", "kg_scale=1,2", "body_mass=1.5,2"]
    four = compare_at_corners(FULL, CHOSEN, axes_of(words[:4], FULL.effects), 1e-3)
    assert len(four.compared) == MOST_CORNERS
    five = compare_at_corners(FULL, CHOSEN, axes_of(words, FULL.effects), 1e-3)
    assert [list(corner.at) for corner in five.compared] == [[word.split("=")[0]] for word in words for _ in range(2)]


def test_corners_that_cannot_be_are_counted_and_a_lone_value_is_one_end() -> None:
    axes = axes_of(["upper_link=0.12,0.22", "lower_link=0.2", "b_ad=0,300"], FULL.effects)
    told: list[str] = []
    found = compare_at_corners(FULL, CHOSEN, axes, 1e-3, told.append)
    assert (len(found.compared), found.refused, len(told)) == (2, 2, 4)
    none = compare_at_corners(FULL, CHOSEN, axes_of(["upper_link=0.22,0.25", "lower_link=0.2"], FULL.effects), 1e-3)
    assert (none.compared, none.worst) == ((), None)


def test_of_many_jumps_as_many_are_made_as_to_measure() -> None:
    plate = load_scene("force_plate")
    found = compare_at_corners(plate, plate, axes_of(["gain=300,400"], plate.effects), 1e-3)
    assert [corner.difference.largest for corner in found.compared] == [0.0, 0.0]
