"""Repeated jumps computed anew: stored digits, independence of the order, and named outcomes."""

from dataclasses import replace
from decimal import Decimal
from fractions import Fraction

import pytest

from benchmarks.reference_simulator.cases import CASES
from benchmarks.reference_simulator.hopping import reference_jumps
from benchmarks.reference_simulator.leg import HoppingParameters
from benchmarks.reference_simulator.storage import agreeing_digits, stored


def hopping(scene: str, index: int = 0) -> HoppingParameters:
    parameters = CASES[scene][index].parameters
    assert isinstance(parameters, HoppingParameters)
    return parameters


@pytest.mark.parametrize("order", [pytest.param(26, marks=pytest.mark.soak), 40])
def test_a_jump_on_rigid_ground_is_the_same_at_any_order(order: int) -> None:
    computed = reference_jumps(hopping("force_plate"), 1, digits=32, order=order)
    assert agreeing_digits(computed, stored("force_plate")[0].jumps[:1]) >= 30
    assert abs(computed[0].energy_residual_j) < Decimal("1e-35")


@pytest.mark.soak
def test_a_jump_with_active_damping_on_the_emulator_is_the_stored_one() -> None:
    computed = reference_jumps(hopping("emulator", 3), 1, digits=32)
    assert agreeing_digits(computed, stored("emulator")[3].jumps[:1]) >= 30
    assert [change.mode for change in computed[0].mode_changes] == ["moving", "held", "moving", "held", "free"]


def test_the_gains_of_the_simulations_straighten_the_leg_on_rigid_ground() -> None:
    published = replace(
        hopping("force_plate"),
        compression_damping_kg_s=Fraction("0.5"),
        extension_damping_kg_s=Fraction(5),
        extension_stiffness_n_m=Fraction(650),
    )
    jumps = reference_jumps(published, 4, digits=12)
    assert jumps[-1].outcome == "leg_straight"


def test_the_gains_of_the_emulator_fold_the_leg_on_rigid_ground_at_the_second_jump() -> None:
    jumps = reference_jumps(replace(hopping("emulator", 2), platform=None), 4, digits=12)
    assert [jump.outcome for jump in jumps] == ["touchdown", "leg_folded"]


def test_at_the_lowest_gain_a_stiffer_compression_keeps_the_foot_down() -> None:
    jumps = reference_jumps(replace(hopping("emulator"), compression_stiffness_n_m=Fraction(180)), 1, digits=12)
    assert jumps[0].outcome == "no_liftoff"
    assert jumps[0].liftoff_time_s is None


@pytest.mark.soak
def test_at_the_lowest_gain_the_rising_platform_carries_a_foot_that_cannot_fly() -> None:
    jumps = reference_jumps(replace(hopping("emulator"), compression_stiffness_n_m=Fraction(160)), 1, digits=12)
    assert jumps[0].outcome == "carried"
