"""Estimated errors: each output's difference to a simulation a hundred times finer, which is the result."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from simulator.error_bars import JUDGED, differences, largest_share, simulate_with_errors
from simulator.jump import close_decision, simulate
from simulator.scene_file import load_scene
from tests.helpers.kernels import interpreted, relative_error
from tests.helpers.scenes import with_set

SIM2 = load_scene("sim2")
SOFT = SIM2.changed(effects_off=("held_gains_in_flight",))
GOAL = 1e-4
VARIED = {"k_extension": 0.7, "k_compression": 0.7, "foot_radius": 0.4, "kg_scale": 0.7, "b_extension": 0.7}
"""Realistic scenes: the logarithm of each parameter by at most so much."""


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

GRAZING = (
    "body_mass=0.0788642 foot_mass=1.33656 rest_length=0.734304 upper_link=0.197984 lower_link=0.799776 "
    "k_compression=42576.7 k_extension=10.726 initial_velocity=-2.02902 initial_height=1.38574 foot_radius=0.0179379 "
    "cone_angle=1.05496 mu=18.2055 k_sh=52944200 sigma=4761600000000 kg_scale=108103 phi=0.245001 rho=43.2895 "
    "added_mass_constant=14.02 b_g=108.934 c_g=25.4799 bg_scale=12.9037 b_compression=152.378 b_extension=247.507 "
    "b_ad=25507.4 control_rate=4338.57 guard_length=0.175274 force_cap=151.54 torque_constant=0.879624 "
    "motor_resistance=21.7074"
)
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


@pytest.mark.parametrize("accuracy", [1e-3, 1e-4])
def test_which_of_two_events_comes_first_is_told_where_they_lie_closer_than_their_errors(accuracy: float) -> None:
    """A heavy foot sinks back to its print, 0.2 um deep, within 1 us of the apex of a light body on stiff ground."""
    scene = with_set(SIM2, GRAZING)
    coarse, found = simulate(scene, accuracy).jump, simulate_with_errors(scene, accuracy).jump
    assert coarse.liftoff_time_s == pytest.approx(0.002996379, rel=1e-6)
    assert found.liftoff_time_s == pytest.approx(0.004379323, rel=1e-6)  # as from 1e-7 on
    assert close_decision(simulate(scene, accuracy / 100.0).jump)
    assert found.ill_conditioned


def test_what_follows_a_jump_that_is_not_known_is_not_known() -> None:
    emulator = load_scene("emulator").changed(
        {"k_compression": 131.1975, "k_extension": 1228.978, "b_extension": 0.370042, "b_compression": 15.7589},
        effects_on=("sampled_control",),
        jumps=20,
    )
    flags = [jump.ill_conditioned for jump in interpreted(simulate_with_errors, emulator, 1e-3).jumps]
    assert any(flags)
    assert flags == sorted(flags)


def test_what_has_no_second_number_has_no_error() -> None:
    jump = simulate(SIM2, 1e-6).jump
    assert largest_share(jump, differences(jump, replace(jump, apex_height_m=None))) == math.inf
    assert simulate_with_errors(SIM2, 1e-13).jump.errors is None


@pytest.mark.soak
def test_of_realistic_scenes_few_are_flagged_and_the_others_keep_their_goal() -> None:
    """At most 5 %, where the margins of decisions alone flag 28 % of them."""
    flagged, chance = 0, np.random.default_rng(20)
    for _ in range(200):
        values = {name: SOFT[name] * float(np.exp(chance.uniform(-width, width))) for name, width in VARIED.items()}
        scene = SOFT.changed({**values, "b_ad": float(chance.uniform(0.0, 300.0))})
        jump, truth = simulate_with_errors(scene, GOAL).jump, simulate(scene, 1e-11).jump
        if jump.ill_conditioned:
            flagged += 1
            continue
        assert jump.outcome == truth.outcome
        for name in JUDGED:
            value, true = getattr(jump, name), getattr(truth, name)
            assert value is true is None or relative_error(value, true) < GOAL
    assert flagged <= 10
