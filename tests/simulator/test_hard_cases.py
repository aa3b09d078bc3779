"""Hard cases end in bounded work, the energy book closed, with a named outcome; and feet that are pressed down."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest

from simulator.error_bars import simulate_with_errors
from simulator.jump import simulate
from simulator.parameter import GRAVITY_M_S2
from simulator.result import JumpResult
from simulator.scene import Scene
from simulator.scene_file import load_scene
from tests.helpers.kernels import interpreted, relative_error
from tests.helpers.scenes import with_set

FEW_STEPS = 40_000


def _jump(accuracy: float = 1e-6, **changes: float) -> JumpResult:
    return simulate(load_scene("sim2").changed(changes), accuracy).jump


def _closes(jump: JumpResult, accuracy: float = 1e-6) -> None:
    """Measured: 4e-8 of what is turned over, at accuracy 1e-6."""
    assert abs(jump.energy_residual_J) < 0.1 * accuracy * (abs(jump.leg_work_J) + jump.ground_loss_J)
    assert jump.steps < FEW_STEPS


@pytest.mark.parametrize(
    ("name", "values"), [("kg_scale", (1e-1, 1e2, 1e4, 1e5, 1e6, 1e7, 1e8)), ("foot_mass", (1e-3, 1e-4, 1e-5, 1e-6))]
)
def test_ever_stiffer_ground_and_a_foot_down_to_a_milligram_tend_to_a_limit(
    name: str, values: tuple[float, ...]
) -> None:
    jumps = [_jump(**{name: value}) for value in values]
    for jump in jumps:
        assert jump.outcome == "touchdown"
        _closes(jump)
    if name == "kg_scale":
        changes = np.abs(np.diff([jump.liftoff_time_s or 0.0 for jump in jumps[2:]]))
        assert all(later < earlier for earlier, later in pairwise(changes))
        assert changes[-1] < 2e-6
    else:
        changes = np.abs(np.diff([jump.apex_height_m or 0.0 for jump in jumps]))
        assert all(later < 0.2 * earlier for earlier, later in pairwise(changes))


def test_start_at_rest_on_the_surface() -> None:
    at_rest, almost = _jump(initial_velocity=0.0), _jump(initial_velocity=-1e-9)
    assert at_rest.outcome == "touchdown"
    assert at_rest.apex_height_m == pytest.approx(almost.apex_height_m, rel=1e-6)
    assert len(at_rest.mode_changes) < 10
    _closes(at_rest)


def test_an_event_on_a_tick() -> None:
    """The mass that jams the foot on a tick exactly: a little less and a little more give the same jump."""
    jam = next(c.time_s for c in _jump(accuracy=1e-10).mode_changes if c.after == "jammed")
    rate = 270 / jam  # the 270th tick at that instant
    before, at, after = (_jump(accuracy=1e-9, control_rate=rate * factor) for factor in (1 - 1e-9, 1.0, 1 + 1e-9))
    assert at.outcome == before.outcome == after.outcome == "touchdown"
    assert at.cost_J == pytest.approx(before.cost_J, rel=2e-9)
    assert at.cost_J == pytest.approx(after.cost_J, rel=2e-9)


@pytest.mark.parametrize(
    ("scene", "words", "outcome"),
    [
        ("sim2", "initial_velocity=-5", "leg_folded"),
        ("sim2", "b_extension=1e4", "no_liftoff"),
        ("sim2", "k_compression=1", "leg_folded"),
        ("force_plate", "k_extension=650 k_compression=250 b_compression=0.5 b_extension=5", "leg_straight"),
    ],
)
def test_what_cannot_jump_has_a_named_outcome(scene: str, words: str, outcome: str) -> None:
    jump = simulate(with_set(load_scene(scene), words)).jump
    assert jump.outcome == outcome
    assert jump.apex_height_m is None
    assert np.isfinite(jump.cost_J)


@pytest.mark.parametrize(
    ("words", "outcome", "jumps"),
    [
        ("k_extension=323.36 k_compression=180", "no_liftoff", 1),
        ("k_extension=323.36 k_compression=160", "carried", 1),
        ("reset_time=0.02", "touchdown", 100),
        ("release_time=0", "touchdown", 100),
    ],
)
def test_the_emulators_ways_to_fail(words: str, outcome: str, jumps: int) -> None:
    result = simulate(with_set(load_scene("emulator"), words))
    assert (result.jump.outcome, len(result.jumps)) == (outcome, jumps)


@pytest.mark.parametrize("many", [1000, pytest.param(10_000, marks=pytest.mark.soak)])
def test_many_jumps_in_a_row_do_not_drift(many: int) -> None:
    result = simulate(load_scene("emulator").changed(jumps=many), 1e-9)
    apexes = np.array([jump.apex_height_m for jump in result.jumps])
    assert len(apexes) == many
    assert abs(apexes[-1] - apexes[99]) < 1e-9
    assert max(abs(jump.energy_residual_J) for jump in result.jumps) < 1e-7
    assert max(jump.max_depth_m for jump in result.jumps) <= 0.07


GRAZES_FROM_M = (1e-6, 1e-10, 1e-14, 1e-16, 5e-20)
"""Heights of a drop: the foot meets the ground at 4 mm/s down to 1e-9 m/s."""
MET = ("liftoff_time_s", "apex_height_m", "cost_J")


@pytest.mark.parametrize("name", ["bed", "force_plate", "emulator"])
def test_contact_is_met_however_slow_the_foot_is(name: str) -> None:
    """As a jump that starts on the ground with the speed of that drop, or rounding of heights is told."""
    scene = load_scene(name)
    for height_m in GRAZES_FROM_M:
        speed_m_s = -math.sqrt(2.0 * GRAVITY_M_S2 * height_m)
        on_ground = scene.changed({"initial_height": 0.0, "initial_velocity": speed_m_s}, jumps=1)
        dropped = scene.changed({"initial_height": height_m, "initial_velocity": 0.0}, jumps=1)
        wanted = simulate(on_ground, 1e-11).jump
        for accuracy in (1e-4, 1e-6, 1e-7, 1e-10):
            jump = simulate_with_errors(dropped, accuracy).jump
            errors = [abs(getattr(jump, one) / getattr(wanted, one) - 1.0) for one in MET]
            assert jump.ill_conditioned if accuracy == 1e-10 and height_m < 1e-13 else max(errors) < accuracy
            assert accuracy < 1e-9 or not jump.ill_conditioned


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


HELD = (
    "k_compression=228.82629 k_extension=1933.44639 b_compression=15.2393 b_extension=12.91257 foot_radius=0.02047 "
    "kg_scale=1.02813 bg_scale=1.15292 body_mass=2.37046 foot_mass=0.10245 initial_velocity=-0.71576 b_ad=541.4215"
)
CHATTERING = (
    "k_compression=121.227631 k_extension=1850.346804 b_compression=3.015164 b_extension=3.19522 body_mass=1.99361 "
    "foot_mass=0.222445 foot_radius=0.013872 kg_scale=0.958647 bg_scale=1.325107 initial_velocity=-0.49661 "
    "b_ad=224.844888"
)


def test_a_held_force_that_lets_errors_grow_is_noticed() -> None:
    """Two parts in a billion of the gain change its apex from 0.13 to 0.17 m."""
    held = load_scene("sim2").changed(effects_on=("held_force",))
    jump = interpreted(simulate, with_set(held, HELD), 1e-6).jump
    assert jump.error_growth > 1e15
    assert jump.ill_conditioned
    assert not interpreted(simulate, held, 1e-6).jump.ill_conditioned


def test_a_controller_without_a_clock_that_chatters_is_noticed() -> None:
    """Its switches are 247 at 1e-6 and 2014 at 1e-13, and its lift-off is 243 times the goal off."""
    continuous = load_scene("sim2").changed(effects_off=("sampled_control",))
    jump = interpreted(simulate, with_set(continuous, CHATTERING), 1e-6).jump
    assert jump.counters["guard_switch"] > 100
    assert jump.ill_conditioned
    assert not interpreted(simulate, continuous, 1e-6).jump.ill_conditioned


def test_a_cost_that_is_a_small_difference_is_noticed() -> None:
    """Without heat in the motors, at a leg damping at which they nearly take up as much work as they do."""
    scene = load_scene("sim2").changed(effects_off=("motor_heat", "cost_of_commanded_force"))
    usual, small = (
        interpreted(simulate, scene.changed({"b_extension": damping_kg_s}), 1e-4).jump for damping_kg_s in (5.0, 36.0)
    )
    assert usual.cost_J > 0.4 * usual.energy_at_play_J
    assert not usual.ill_conditioned
    assert 0.0 < small.cost_J < 0.05 * small.energy_at_play_J
    assert small.ill_conditioned


def test_a_switch_as_the_leg_has_nearly_come_to_rest_is_simulated_finer() -> None:
    """Its lift-off was 4 times the goal off, as the leg turns at some 0.003 m/s^2."""
    words = "body_mass=0.7 b_compression=37.7 k_compression=300 k_extension=1500 kg_scale=20"
    scene = with_set(load_scene("sim2").changed(effects_off=("sampled_control",)), words)
    found, truth = (interpreted(simulate, scene, accuracy).jump for accuracy in (1e-6, 1e-12))
    assert not found.ill_conditioned
    assert found.liftoff_time_s == pytest.approx(truth.liftoff_time_s, rel=1e-6)
