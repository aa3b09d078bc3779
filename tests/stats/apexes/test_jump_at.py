"""The jump that a person sees at a time: the detector's own where that has it, one that it missed, or why none."""

from __future__ import annotations

import io

import numpy as np
import pytest

import stats
from data_schema.errors import InputRefused
from data_schema.reasons import Reason
from data_schema.vocabulary import Undefined
from stats.apexes.detectors import find_jumps, jump_at
from tests.helpers.hopping_log import REST_LENGTH_M, RISE_M, apex_s, hopping_log, landing_s
from tests.helpers.standing_log import REST_LENGTH_M as STANDING_M
from tests.helpers.standing_log import standing_log


def samples(content: bytes) -> tuple[np.ndarray, np.ndarray]:
    rows = np.loadtxt(io.BytesIO(content), delimiter=",", skiprows=1)
    return rows[:, 0] / 1e3, rows[:, 1]


@pytest.mark.parametrize("leg", [True, False])
@pytest.mark.parametrize("off_s", [0.0, -0.02, 0.02])
def test_near_an_apex_that_was_found_it_is_that_apex(bed_log, emulator_log, leg, off_s):
    for log in (bed_log(6), emulator_log(20)):
        height_m = log.height_m + np.random.default_rng(1).normal(0.0, 0.001, log.height_m.size)
        about = {"rest_length_m": REST_LENGTH_M, "leg_length_m": log.leg_m if leg else None}
        for jump in find_jumps(log.time_s, height_m, **about).with_apex:
            seen = jump_at(log.time_s, height_m, jump.apex_s + off_s, **about)
            both_se_m = np.hypot(seen.apex_height_se_m, jump.apex_height_se_m)
            assert seen.apex_height_m == pytest.approx(jump.apex_height_m, abs=5 * both_se_m)
            assert seen.apex_s == pytest.approx(jump.apex_s, abs=0.005)
            assert seen.touchdown_s == jump.touchdown_s
            assert seen.undefined_reason is None


def test_a_jump_out_of_a_stance_that_no_detector_sees_is_measured():
    time_s, height_m = samples(hopping_log(6, shallow=[4]))
    found = find_jumps(time_s, height_m, rest_length_m=REST_LENGTH_M)
    assert not any(abs(jump.apex_s - apex_s(4)) < 0.1 for jump in found.with_apex)
    seen = stats.jump_at(time_s, height_m, apex_s(4) + 0.01, rest_length_m=REST_LENGTH_M)
    assert seen.apex_height_m == pytest.approx(REST_LENGTH_M + RISE_M, abs=0.0005)
    assert seen.apex_s == pytest.approx(apex_s(4), abs=0.003)
    assert seen.touchdown_s == pytest.approx(landing_s(4), abs=0.01)
    assert not seen.gap_touched


def test_where_no_parabola_can_be_fitted_the_reason_is_given(bed_log):
    time_s, height_m = samples(hopping_log(4, lost_s=[(apex_s(3) - 0.1, apex_s(3) + 0.1)]))

    def why(at_s: float) -> Reason:
        found = jump_at(time_s, height_m, at_s, rest_length_m=REST_LENGTH_M)
        assert isinstance(found, Undefined)
        return found.code

    assert why(landing_s(2) + 0.1) is Reason.NOT_IN_FLIGHT
    assert [why(at_s) for at_s in (-1.0, 1e9)] == [Reason.TIME_NOT_IN_LOG] * 2
    assert why(apex_s(2) + 0.13) is Reason.TOO_FEW_BESIDE_APEX  # so late that the apex is before the samples
    assert why(apex_s(3)) is Reason.SAMPLES_MISSING_HERE
    log = bed_log(2)
    held_s = (log.apex_s[0] + log.touchdown_s[1]) / 2  # the robot hangs on its clamp
    assert jump_at(log.time_s, log.height_m, held_s, rest_length_m=REST_LENGTH_M).code is Reason.NO_FREE_FLIGHT
    with pytest.raises(InputRefused):
        jump_at(time_s, height_m, float("nan"), rest_length_m=REST_LENGTH_M)
    none = jump_at([], [], 1.0, rest_length_m=REST_LENGTH_M)
    assert isinstance(none, Undefined)


def test_heights_of_a_zero_too_high_are_as_measured():
    time_s, height_m, apexes_m = standing_log(seed=3, jumps=25, zero_m=0.05)
    found = find_jumps(time_s, height_m, rest_length_m=STANDING_M)
    for jump, true_m in zip(found.with_apex, apexes_m, strict=True):
        seen = jump_at(time_s, height_m, jump.apex_s, rest_length_m=STANDING_M)
        assert seen.apex_height_m == pytest.approx(true_m + 0.05, abs=0.002)
        assert "zero_doubtful" in seen.flags


def test_of_a_robot_that_was_held_before_it_fell_no_flight_is_longer_than_free_ones(bed_log):
    log = bed_log(3)
    height_m = log.height_m + np.random.default_rng(1).normal(0.0, 0.001, log.height_m.size)
    for touchdown_s in log.touchdown_s[1:]:
        tried = [
            jump_at(log.time_s, height_m, touchdown_s - s, rest_length_m=REST_LENGTH_M) for s in (0.11, 0.12, 0.13)
        ]
        dropped = [found for found in tried if not isinstance(found, Undefined)]
        assert dropped
        assert [found.apex_height_m for found in dropped] == pytest.approx([0.42] * len(dropped), abs=0.005)
        assert all(isinstance(found.flight_time_s, Undefined) or found.flight_time_s < 0.6 for found in dropped)
