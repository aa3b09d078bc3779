"""Sampled control on rigid ground: it tends to continuous control as its clock quickens, and makes no ghost jumps."""

from __future__ import annotations

import math

import pytest

from simulator.gains import stiffness_n_m
from simulator.jump import ILL_CONDITIONED_BELOW, simulate
from simulator.result import JumpResult
from simulator.scene_file import load_scene
from tests.helpers.kernels import interpreted
from tests.helpers.once import made_once

PLATE = load_scene("force_plate")
SECOND_AT_400 = 0.363848, 50.034
"""Apex (m) and cost (J) of the second jump at gain 400, control continuous."""


def jumps_of(gain: float, jumps: int, accuracy: float, rate: float = 0.0) -> tuple[JumpResult, ...]:
    """Jumps on the plate, controlled at ticks of a rate (Hz), or continuously (0)."""
    scene = PLATE.changed({"k_extension": stiffness_n_m(gain)}, jumps=jumps)
    if rate:
        scene = scene.changed({"control_rate": rate}, ("sampled_control",))
    return simulate(scene, accuracy).jumps


RATES = ((1e3, 1.5e-4, 0.05), (1e4, 1.2e-5, 0.003))
"""Rates (Hz), and how far apex (m) and cost (J) may be from those of continuous control."""
Found = dict[str, tuple[JumpResult, ...]]


def simulated() -> Found:
    """What is looked at below; to simulate this little takes less time than to compile a kernel for it."""
    found = {f"{rate:g} Hz": jumps_of(400, 4, 1e-9, rate) for rate in (0.0, 1e3, 1e4)}
    return found | {"coarse": simulate(PLATE.changed(effects_on=("sampled_control",)), 5e-4).jumps}


@pytest.fixture(scope="module")
def found() -> Found:
    return made_once("sampled-on-hard-ground", lambda _folder: interpreted(simulated))


def test_a_quicker_clock_tends_to_continuous_control(found: Found) -> None:
    continuous = found["0 Hz"]
    assert continuous[1].apex_height_m == pytest.approx(SECOND_AT_400[0], abs=1e-6)
    assert continuous[1].cost_J == pytest.approx(SECOND_AT_400[1], abs=1e-3)
    for rate, most_m, most_j in RATES:
        for sampled, exact in zip(found[f"{rate:g} Hz"], continuous, strict=True):
            assert sampled.apex_height_m == pytest.approx(exact.apex_height_m, abs=most_m)
            assert sampled.cost_J == pytest.approx(exact.cost_J, abs=most_j)


def test_the_leg_decides_in_flight_too(found: Found) -> None:
    """There it turns soft at its rest length, at the next tick; else it would meet the plate stiff."""
    sampled, continuous = found["1000 Hz"][2], found["0 Hz"][2]
    assert sampled.min_leg_length_m == pytest.approx(continuous.min_leg_length_m, abs=2e-6)
    assert sampled.max_leg_length_m == pytest.approx(continuous.max_leg_length_m, abs=3e-4)
    assert sampled.stance_heat_J == pytest.approx(continuous.stance_heat_J, rel=4e-4)


@pytest.mark.soak
@pytest.mark.parametrize("gain", [300, 400, 600])
def test_a_force_held_between_ticks_makes_no_jump_that_is_none(gain: float) -> None:
    """A held force that pulls at lift-off once gave contacts of a microsecond, each counted as a jump."""
    scene = PLATE.changed({"k_extension": stiffness_n_m(gain)}, ("sampled_control", "held_force"))
    result = simulate(scene, 1e-7)
    continuous = jumps_of(gain, scene.jumps, 1e-7)
    assert len(result.jumps) == scene.jumps
    for held, exact in zip(result.jumps, continuous, strict=True):
        assert held.outcome == "touchdown"
        assert (held.next_touchdown_time_s or 0.0) > 0.1
        assert held.next_touchdown_time_s == pytest.approx(exact.next_touchdown_time_s, rel=0.02)
        assert held.apex_height_m == pytest.approx(exact.apex_height_m, abs=0.01)
        assert abs(held.energy_residual_J) < 1e-7
        assert len(held.mode_changes) == 2


def test_what_follows_a_flagged_jump_is_flagged(found: Found) -> None:
    """Its start is not better known. At a coarse accuracy one decision of the second jump is close, and no other."""
    jumps = found["coarse"]
    close = [(jump.decision_margin or math.inf) < ILL_CONDITIONED_BELOW for jump in jumps]
    assert close.index(True) == 1
    assert sum(close) < 3
    assert [jump.ill_conditioned for jump in jumps] == [False] + [True] * (len(jumps) - 1)
