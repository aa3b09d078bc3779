"""Contact after lift-off: what becomes of a foot that the gains of flight press down; and the leg may pass straight."""

from __future__ import annotations

import math

import pytest

from simulator.jump import simulate
from simulator.scene import Scene
from simulator.scene_file import load_scene
from tests.helpers.kernels import interpreted, relative_error
from tests.helpers.scenes import with_set

SIM1, SIM2 = load_scene("sim1"), load_scene("sim2")
SOFT = SIM2.changed(effects_off=("held_gains_in_flight",))
PRESSED = with_set(
    SOFT,
    "k_compression=437.7 k_extension=1091 b_compression=2.707 b_extension=16.27 foot_radius=0.03557 "
    "kg_scale=0.7852 b_ad=250.1",
)
"""The gains of flight press the lifted foot 2.00657 mm down: a rule that let 2 mm pass made it hang on the step."""


def at_the_print(scene: Scene) -> Scene:
    """The scene by the other rule."""
    return scene.changed(effects_off=("contact_once_risen",))


@pytest.mark.parametrize("accuracy", [1e-4, 1e-6, 1e-7, 1e-9])
def test_once_risen_a_pressed_foot_gives_the_same_at_every_accuracy(accuracy: float) -> None:
    jump = simulate(PRESSED, accuracy).jump
    assert relative_error(jump.liftoff_time_s, 0.2567511036) < max(accuracy, 1e-9)
    assert relative_error(jump.max_depth_m, 0.0489635645) < max(accuracy, 1e-9)
    assert jump.unresisted_sink_m == pytest.approx(2.00657e-3, rel=1e-5)
    assert jump.counters["cancelled_liftoff"] == 0
    assert abs(jump.energy_residual_J) < accuracy * jump.energy_at_play_J


@pytest.mark.parametrize("accuracy", [1e-4, 1e-6, 1e-9])
def test_at_the_print_the_gains_of_flight_take_a_lift_off_back_once(accuracy: float) -> None:
    jump = interpreted(simulate, at_the_print(PRESSED), accuracy).jump
    assert relative_error(jump.liftoff_time_s, 0.2693666820) < max(accuracy, 1e-9)
    assert relative_error(jump.max_depth_m, 0.0489635645) < max(accuracy, 1e-9)
    assert jump.counters["cancelled_liftoff"] == 1
    assert jump.unresisted_sink_m == 0.0
    assert [change.after for change in jump.mode_changes].count("flight") == 1
    assert abs(jump.energy_residual_J) < accuracy * jump.energy_at_play_J


def test_at_the_print_the_second_set_with_soft_gains_in_flight() -> None:
    jump = interpreted(simulate, at_the_print(SOFT), 1e-9).jump
    assert relative_error(jump.liftoff_time_s, 0.322330346) < 1e-8
    assert relative_error(jump.liftoff_body_velocity_m_s, 1.553778759) < 1e-8
    assert relative_error(jump.apex_height_m, 0.303625277) < 1e-8


@pytest.mark.parametrize("initial_velocity", [-0.6, -1.4, -2.0])
def test_drag_is_not_counted_while_the_leg_is_past_straight(initial_velocity: float) -> None:
    """The joint's speed has a pole where the leg is straight; on grains the cost of flight is not asked for."""
    jump = simulate(SIM1.changed({"initial_velocity": initial_velocity, "b_ad": 0.0}), 1e-7).jump
    assert jump.max_leg_length_m > SIM1["upper_link"] + SIM1["lower_link"]
    assert math.isfinite(jump.jump_drag_J)
    assert 0.0 < jump.stance_drag_J <= jump.jump_drag_J < 10.0
