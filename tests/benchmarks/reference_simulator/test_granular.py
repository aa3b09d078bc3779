"""Jumps on granular ground computed anew: stored digits, a closed energy book, and named outcomes."""

from dataclasses import replace
from decimal import Decimal
from fractions import Fraction

import pytest

from benchmarks.reference_simulator.cases import CASES
from benchmarks.reference_simulator.granular import reference_jump
from benchmarks.reference_simulator.leg import GranularParameters
from benchmarks.reference_simulator.storage import agreeing_digits, stored


def granular(scene: str, index: int) -> GranularParameters:
    parameters = CASES[scene][index].parameters
    assert isinstance(parameters, GranularParameters)
    return parameters


@pytest.mark.soak
def test_a_stored_jump_comes_out_again_at_other_precision_and_order() -> None:
    """On stiff ground, the cheapest of the stored ones."""
    names = [case.name for case in CASES["sim2"]]
    index = names.index("kg_scale = 100")
    computed = reference_jump(granular("sim2", index), digits=32, order=26)
    assert agreeing_digits((computed,), stored("sim2")[index].jumps) >= 30
    assert abs(computed.energy_residual_j) < Decimal("1e-35")


def test_with_little_damping_the_leg_of_the_bed_folds_in_compression() -> None:
    loose = replace(granular("bed", 3), compression_damping_kg_s=Fraction("0.5"))
    jump = reference_jump(loose, digits=12)
    assert jump.outcome == "leg_folded"
    assert jump.liftoff_time_s is None
    assert jump.apex_height_m is None


def test_a_leg_too_weak_to_leave_the_ground_ends_its_stance_without_lift_off() -> None:
    """As stiff in extension as in compression, and strongly damped."""
    weak = replace(
        granular("sim2", 0),
        extension_stiffness_n_m=Fraction(250),
        extension_damping_kg_s=Fraction(40),
        compression_damping_kg_s=Fraction(40),
        tick_s=Fraction("0.05"),
    )
    jump = reference_jump(weak, digits=12)
    assert jump.outcome == "no_liftoff"
    assert jump.duration_s >= 2
    assert abs(jump.energy_residual_j) < Decimal("1e-20")
