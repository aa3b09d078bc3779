"""Estimated errors: each output's difference to a simulation a hundred times finer, which is the result."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from data_schema.errors import UsageError
from simulator.error_bars import JUDGED, differences, largest_share, simulate_with_errors
from simulator.jump import close_decision, simulate
from simulator.scene import Scene
from simulator.scene_file import load_scene
from tests.helpers.kernels import interpreted, relative_error
from tests.helpers.wording import refuses

SIM2 = load_scene("sim2")
SOFT = SIM2.changed(effects_off=("held_gains_in_flight",))
GOAL = 1e-4
VARIED = {"k_extension": 0.7, "k_compression": 0.7, "foot_radius": 0.4, "kg_scale": 0.7, "b_extension": 0.7}
"""Realistic scenes: the logarithm of each parameter by at most so much."""


def realistic(count: int) -> list[Scene]:
    """Soft scenes drawn around the shipped one, with active damping."""
    chance = np.random.default_rng(20)
    found = []
    for _ in range(count):
        values = {name: SOFT[name] * float(np.exp(chance.uniform(-width, width))) for name, width in VARIED.items()}
        found.append(SOFT.changed({**values, "b_ad": float(chance.uniform(0.0, 300.0))}))
    return found


def test_the_finer_values_are_the_result_and_their_difference_the_error() -> None:
    found, coarse, fine = simulate_with_errors(SIM2, GOAL), simulate(SIM2, GOAL), simulate(SIM2, GOAL / 100.0)
    assert found.accuracy == GOAL
    assert found.jump.errors is not None
    assert found.finer_accuracy == GOAL / 100.0
    for name in JUDGED:
        assert getattr(found.jump, name) == getattr(fine.jump, name)
        assert found.jump.errors[name] == abs(getattr(fine.jump, name) - getattr(coarse.jump, name))
        assert 0.0 < found.jump.errors[name] < GOAL * getattr(fine.jump, name)
    assert not found.jump.ill_conditioned
    assert found.jump.coarser is None


CRITICAL_N_M = 628.336056852
"""Stiffness in compression above which the force that lifts the foot has its peak below zero, at 1e-11."""

GRAZING = {
    "body_mass": 0.0788642,
    "foot_mass": 1.33656,
    "rest_length": 0.734304,
    "upper_link": 0.197984,
    "lower_link": 0.799776,
    "k_compression": 42576.7,
    "k_extension": 10.726,
    "initial_velocity": -2.02902,
    "initial_height": 1.38574,
    "foot_radius": 0.0179379,
    "cone_angle": 1.05496,
    "mu": 18.2055,
    "k_sh": 52944200.0,
    "sigma": 4761600000000.0,
    "kg_scale": 108103.0,
    "phi": 0.245001,
    "rho": 43.2895,
    "added_mass_constant": 14.02,
    "b_g": 108.934,
    "c_g": 25.4799,
    "bg_scale": 12.9037,
    "b_compression": 152.378,
    "b_extension": 247.507,
    "b_ad": 25507.4,
    "control_rate": 4338.57,
    "guard_length": 0.175274,
    "force_cap": 151.54,
    "torque_constant": 0.879624,
    "motor_resistance": 21.7074,
}
"""Drawn over the legal box of `sim2`."""


def test_a_jump_that_ends_otherwise_a_hundred_times_finer_is_flagged_with_both() -> None:
    scene = SOFT.changed({"k_compression": CRITICAL_N_M * (1.0 - 1e-6)})
    jump = interpreted(simulate_with_errors, scene, 1e-4).jump
    assert (jump.outcome, jump.coarser and jump.coarser.outcome) == ("touchdown", "no_liftoff")
    assert jump.ill_conditioned


def test_where_the_finer_simulation_hangs_on_a_decision_still_finer_ones_tell() -> None:
    scene = SOFT.changed({"k_compression": CRITICAL_N_M * (1.0 - 1e-8)})
    found, finer = interpreted(simulate_with_errors, scene, 1e-4), interpreted(simulate, scene, 1e-6).jump
    assert (finer.outcome, close_decision(finer)) == (interpreted(simulate, scene, 1e-4).jump.outcome, True)
    assert (found.finer_accuracy, found.jump.outcome) == (pytest.approx(1e-10), "touchdown")
    assert found.jump.ill_conditioned


@pytest.mark.parametrize("accuracy", [1e-3, 1e-4, 1e-5, 1e-6, 1e-8])
def test_a_lift_off_between_nodes_is_met_and_its_margin_says_how_nearly_it_was_missed(accuracy: float) -> None:
    """The force that lifts the foot rises over zero for some milliseconds, by 1e-4 of what it is before."""
    jump = interpreted(simulate, SOFT.changed({"k_compression": 628.3333}), accuracy).jump
    truth_s, flagged = 0.2950635131, accuracy >= 1e-5
    assert jump.outcome == "touchdown"
    assert close_decision(jump) == jump.ill_conditioned == flagged
    assert flagged or jump.liftoff_time_s == pytest.approx(truth_s, rel=accuracy)
    assert (jump.decision_tick is None) == flagged


@pytest.mark.parametrize("accuracy", [1e-3, 1e-4])
def test_which_of_two_events_comes_first_is_told_where_they_lie_closer_than_their_errors(accuracy: float) -> None:
    """A heavy foot sinks back to its print, 0.2 um deep, within 1 us of the apex of a light body on stiff ground."""
    scene = load_scene("sim2").changed(GRAZING)
    coarse, found = simulate(scene, accuracy).jump, simulate_with_errors(scene, accuracy).jump
    assert coarse.liftoff_time_s == pytest.approx(0.002996379, rel=1e-6)
    assert found.liftoff_time_s == pytest.approx(0.004379323, rel=1e-6)  # as from 1e-7 on
    assert close_decision(simulate(scene, accuracy / 100.0).jump)
    assert found.ill_conditioned


TOUCHING_M = 0.13844136086911463
"""Largest compression of the bed's leg without a clock, at 1 m/s: it ends as the leg begins to lengthen."""
SHARES = (1.0 - 1e-12, 1.0, 1.0 + 1e-12)


def of_conjunction(share: float) -> Scene:
    """A jump whose leg extends from this share of the largest compression on."""
    values = {"initial_velocity": -1.0, "switch_compression": TOUCHING_M * share}
    return load_scene("bed").changed(values, effects_off=("sampled_control",))


def true_outcome(share: float) -> str:
    return "touchdown" if share < 1.0 else "no_liftoff"


@pytest.mark.parametrize(
    ("accuracy", "share"),
    [
        pytest.param(accuracy, share, marks=[pytest.mark.soak] if (accuracy, share) != (1e-6, 1.0) else [])
        for accuracy in (1e-4, 1e-6, 1e-9)
        for share in SHARES
    ],
)
def test_a_conjunction_that_holds_for_no_time_is_told(accuracy: float, share: float) -> None:
    """Compression and lengthening must hold together: here one ends at the instant at which the other begins."""
    found = interpreted(simulate_with_errors, of_conjunction(share), accuracy).jump
    assert found.outcome == true_outcome(share) or found.ill_conditioned


@pytest.mark.soak
def test_a_conjunction_ends_as_it_should_at_the_finest_accuracy() -> None:
    for share in SHARES:
        assert interpreted(simulate, of_conjunction(share), 1e-13).jump.outcome == true_outcome(share)


HOLDS_AT_TOUCHDOWN_S = 0.21539993802082688
"""Time that the pawl takes to fall, at which the platform yields from the second touchdown on, at 1e-12."""


@pytest.mark.parametrize("later_s", [-1e-9, -1e-11, 0.0, 1e-11])
def test_a_touchdown_as_the_platform_begins_to_yield_is_told(later_s: float) -> None:
    """A moment before it the foot stops at once, and its energy is lost."""
    scene = load_scene("emulator").changed(
        {"k_extension": 579.36, "engage_time": HOLDS_AT_TOUCHDOWN_S + later_s}, jumps=3
    )
    truth = simulate(scene, 1e-13).jumps
    assert close_decision(simulate(scene, 1e-6).jumps[1])
    assert not close_decision(simulate(scene, 1e-6).jumps[0])
    for accuracy in (1e-4, 1e-6, 1e-9):
        for jump, wanted in zip(simulate_with_errors(scene, accuracy).jumps, truth, strict=True):
            assert jump.ill_conditioned or relative_error(jump.cost_J, wanted.cost_J) < accuracy
            assert jump.ill_conditioned or relative_error(jump.apex_height_m, wanted.apex_height_m) < accuracy


HELD_S = 0.5621346418888018
"""Shortest hold that ends as the leg turns soft in the third flight, at 1e-13."""


@pytest.mark.parametrize("later_s", [-1e-9, -1e-11, 0.0, 1e-11, 1e-9])
def test_a_hold_that_ends_as_the_leg_turns_soft_is_told(later_s: float) -> None:
    """A moment later the platform is not released, and the next jump starts from below."""
    scene = load_scene("emulator").changed({"shortest_hold": HELD_S + later_s}, jumps=4)
    truth = simulate(scene, 1e-13).jumps
    assert [close_decision(jump) for jump in simulate(scene, 1e-6).jumps] == [False, False, True, False]
    for accuracy in (1e-4, 1e-6, 1e-9):
        for jump, wanted in zip(simulate_with_errors(scene, accuracy).jumps, truth, strict=True):
            assert jump.ill_conditioned or relative_error(jump.cost_J, wanted.cost_J) < accuracy
            assert jump.ill_conditioned or relative_error(jump.apex_height_m, wanted.apex_height_m) < accuracy


@pytest.mark.parametrize("values", [{"shortest_hold": HELD_S + 1e-5}, {"release_tolerance": 0.005}])
def test_a_release_that_hangs_on_nothing_is_not_flagged(values: dict[str, float]) -> None:
    """The hold ends 10 us later than the leg turns soft, or long before it and the release at one length."""
    assert not any(map(close_decision, simulate(load_scene("emulator").changed(values, jumps=4), 1e-6).jumps))


def test_two_runs_that_take_the_same_steps_are_known_to_what_rounding_grows_to() -> None:
    """Sampled damping of set 1 multiplies rounding by 1e11; both simulations are repeated to the same finest steps."""
    jump = simulate_with_errors(load_scene("sim1"), 1e-6).jump
    nearby = simulate(load_scene("sim1").changed({"initial_velocity": -1.0 + 1e-15}), 1e-6).jump
    assert jump.errors is not None
    assert abs(nearby.cost_J - jump.cost_J) < jump.errors["cost_J"]
    assert jump.ill_conditioned


def test_what_follows_a_jump_that_is_not_known_is_not_known() -> None:
    emulator = load_scene("emulator").changed(
        {"k_compression": 131.1975, "k_extension": 1228.978, "b_extension": 0.370042, "b_compression": 15.7589},
        effects_on=("sampled_control",),
        jumps=20,
    )
    flags = [jump.ill_conditioned for jump in interpreted(simulate_with_errors, emulator, 1e-3).jumps]
    assert any(flags)
    assert flags == sorted(flags)


def test_a_number_that_only_one_simulation_has_is_not_known() -> None:
    jump = simulate(SIM2, 1e-6).jump
    assert largest_share(jump, differences(jump, replace(jump, apex_height_m=None))) == math.inf


def test_at_the_finest_accuracy_nothing_is_finer() -> None:
    assert simulate_with_errors(SIM2, 1e-13).jump.errors is None


@pytest.mark.soak
def test_of_realistic_scenes_few_are_flagged_and_the_others_keep_their_goal() -> None:
    """At most 5 %, where the margins of decisions alone flag 28 % of them."""
    flagged = 0
    for scene in realistic(200):
        jump, truth = simulate_with_errors(scene, GOAL).jump, simulate(scene, 1e-11).jump
        if jump.ill_conditioned:
            flagged += 1
            continue
        assert jump.outcome == truth.outcome
        for name in JUDGED:
            value, true = getattr(jump, name), getattr(truth, name)
            assert value is true is None or relative_error(value, true) < GOAL
    assert flagged <= 10


@pytest.mark.parametrize("accuracy", [0.2, 1e-14])
def test_an_accuracy_that_cannot_be_had_is_refused(accuracy: float) -> None:
    with refuses(UsageError, "accuracy", f"{accuracy:g}"):
        simulate_with_errors(SIM2, accuracy)
