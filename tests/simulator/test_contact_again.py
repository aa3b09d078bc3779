"""Contact after lift-off: a foot is pressed back before it has cleared the surface; and the leg may pass straight."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from simulator.jump import simulate
from simulator.kernel.layout import MODES
from simulator.kernel.limits import DEEPEST_DIP_M
from simulator.scene import Scene
from simulator.scene_file import load_scene

SIM1 = load_scene("sim1")
SCENES = {
    "sim1, much active damping": SIM1.changed({"k_extension": 1000.0, "b_ad": 1000.0}),
    "sim1 as shipped": SIM1,
    "sim1, none": SIM1.changed({"b_ad": 0.0}),
    "sim2, chattering": load_scene("sim2").changed({"k_extension": 1091.36, "b_ad": 5000.0}),
}


def largest_dip_m(scene: Scene, accuracy: float) -> float:
    """How far below the deepest point that it has stood at a flying foot ever lies."""
    result = simulate(scene, accuracy, trajectory=True)
    assert result.trajectory is not None
    motion: Any = result.trajectory
    flies, height_m = motion["mode"].values == MODES.index("flight"), motion["foot_height"].values
    print_m = np.minimum.accumulate(np.where(flies, 0.0, height_m))
    return float(np.max((print_m - height_m)[flies]))


@pytest.mark.parametrize("accuracy", [1e-3, 1e-5, 1e-7])
@pytest.mark.parametrize("name", SCENES)
def test_a_lifted_foot_is_not_pressed_far_below_its_print(name: str, accuracy: float) -> None:
    assert largest_dip_m(SCENES[name], accuracy) < DEEPEST_DIP_M + 1e-4 * accuracy


def test_a_foot_pressed_far_enough_is_in_contact_again_and_the_book_closes() -> None:
    jump = simulate(SCENES["sim1, much active damping"], 1e-7).jump
    lifts = [change.time_s for change in jump.mode_changes if change.after == "flight"]
    assert len(lifts) > 3
    assert jump.liftoff_time_s == lifts[-1]
    assert abs(jump.energy_residual_J) < 1e-11
    assert largest_dip_m(SCENES["sim1, much active damping"], 1e-7) > 0.999 * DEEPEST_DIP_M


def test_the_published_dip_of_nine_tenths_of_a_millimetre_is_let_pass() -> None:
    jump = simulate(SCENES["sim1, none"], 1e-7).jump
    assert [change.after for change in jump.mode_changes].count("flight") == 1
    assert largest_dip_m(SCENES["sim1, none"], 1e-7) == pytest.approx(0.875e-3, abs=1e-6)


def test_a_foot_that_dips_as_it_lifts_off_has_not_cleared_its_print() -> None:
    """At lift-off it stands in its print to the last digit: rounding must not say that it is out of it."""
    scene = SIM1.changed(
        {
            "k_compression": 279.75637865530973,
            "k_extension": 1222.352369169063,
            "b_compression": 6.013399016973324,
            "b_extension": 19.772970675141707,
            "b_ad": 23.732707491427973,
            "foot_radius": 0.03656603196486795,
            "kg_scale": 8.527944046988168,
            "bg_scale": 2.4841587626966017,
            "body_mass": 1.0511917919460596,
            "foot_mass": 0.22552978236616894,
            "initial_velocity": -0.24921551486047622,
        }
    )
    fine = simulate(scene, 1e-12).jump
    for accuracy in (1e-4, 1e-6, 1e-8):
        jump = simulate(scene, accuracy).jump
        assert [change.after for change in jump.mode_changes].count("flight") == 1
        assert jump.cost_J == pytest.approx(fine.cost_J, rel=accuracy)
        assert jump.apex_height_m == pytest.approx(fine.apex_height_m, rel=accuracy)


@pytest.mark.parametrize("initial_velocity", [-0.6, -1.4, -2.0])
def test_drag_is_not_counted_while_the_leg_is_past_straight(initial_velocity: float) -> None:
    """The joint's speed has a pole where the leg is straight; on grains the cost of flight is not asked for."""
    jump = simulate(SIM1.changed({"initial_velocity": initial_velocity, "b_ad": 0.0}), 1e-7).jump
    assert jump.max_leg_length_m > SIM1["upper_link"] + SIM1["lower_link"]
    assert math.isfinite(jump.jump_drag_J)
    assert 0.0 < jump.stance_drag_J <= jump.jump_drag_J < 10.0
