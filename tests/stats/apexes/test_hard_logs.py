"""Logs with lost stances, legs that fly short, or a zero that is off: all flights are found; and signals at rest."""

import io
import itertools

import numpy as np
import pytest

from data_schema.reasons import Reason
from data_schema.vocabulary import Undefined
from stats.apexes.detectors import find_jumps
from stats.apexes.standing import rests
from tests.helpers.hopping_log import FLIGHT_S, REST_LENGTH_M, STANCE_S, apex_s, hopping_log, landing_s
from tests.helpers.standing_log import REST_LENGTH_M as STANDING_M
from tests.helpers.standing_log import standing_log


@pytest.mark.parametrize("short_m", [0.0, 0.004])
def test_a_leg_that_flies_shorter_than_its_rest_length_still_lifts_off(bed_log, short_m):
    log = bed_log(4)
    found = find_jumps(log.time_s, log.height_m, rest_length_m=REST_LENGTH_M, leg_length_m=log.leg_m - short_m)
    assert [jump.liftoff_s for jump in found.jumps] == pytest.approx(list(log.liftoff_s), abs=0.005)


def test_a_log_that_ends_in_stance_says_so(bed_log):
    log = bed_log(2)
    n = int(np.searchsorted(log.time_s, log.touchdown_s[1] + 0.1))
    last = find_jumps(log.time_s[:n], log.height_m[:n], rest_length_m=REST_LENGTH_M).jumps[-1]
    assert last.apex_s == Undefined(Reason.LOG_ENDS_IN_STANCE)


@pytest.mark.parametrize("detector", ["published", "robust"])
@pytest.mark.parametrize(
    ("lost_s", "first_s"),
    [
        ((landing_s(4) - 0.01, landing_s(4) + STANCE_S + 0.01), 0.0),
        ((landing_s(4) - 0.06, landing_s(4) + STANCE_S + 0.01), 0.0),
        ((0.0, 0.0), landing_s(1) + STANCE_S / 2),
    ],
    ids=["a stance is lost", "a stance and the fall before it are lost", "the log begins in a stance"],
)
def test_a_flight_is_found_though_its_stance_was_not_seen(
    detector: str, lost_s: tuple[float, float], first_s: float
) -> None:
    """Its samples were all there, and it was passed over without a word."""
    rows = np.loadtxt(io.BytesIO(hopping_log(6, lost_s=[lost_s])), delimiter=",", skiprows=1)
    time_s, height_m = rows[:, 0] / 1000, rows[:, 1]
    seen = time_s >= first_s
    found = find_jumps(time_s[seen], height_m[seen], rest_length_m=REST_LENGTH_M, detector=detector)
    assert found.apex_times_s == pytest.approx([apex_s(number) for number in range(1, 7)], abs=0.005)
    if detector == "robust":
        times_s = [jump.flight_time_s for jump in found.with_apex if not isinstance(jump.flight_time_s, Undefined)]
        assert times_s == pytest.approx([FLIGHT_S] * len(times_s), abs=0.02)
        assert len(times_s) >= 5


@pytest.mark.parametrize("detector", ["published", "robust"])
def test_samples_lost_in_flight_or_in_stance_alone_make_no_jump_more(detector: str) -> None:
    for middle_s in (apex_s(3) - 0.1, apex_s(3), apex_s(3) + 0.1, landing_s(3) + STANCE_S / 2):
        lost_s = (middle_s - 0.015, middle_s + 0.015)
        rows = np.loadtxt(io.BytesIO(hopping_log(6, lost_s=[lost_s])), delimiter=",", skiprows=1)
        found = find_jumps(rows[:, 0] / 1000, rows[:, 1], rest_length_m=REST_LENGTH_M, detector=detector)
        assert len(found.jumps) == 7


@pytest.mark.parametrize("detector", ["robust", "published"])
@pytest.mark.parametrize("zero_m", [0.0, 0.008, 0.047, 0.059, 0.084, 0.2, 2.5])
def test_every_flight_is_found_whatever_the_zero_and_its_height_is_as_measured(detector: str, zero_m: float) -> None:
    time_s, height_m, apexes_m = standing_log(seed=3, jumps=25, zero_m=zero_m)
    found = find_jumps(time_s, height_m, rest_length_m=STANDING_M, detector=detector)
    assert len(found.with_apex) == 25
    assert found.apex_heights_m == pytest.approx(apexes_m + zero_m, abs=0.002)
    flagged = sum("zero_doubtful" in jump.flags for jump in found.jumps)
    if zero_m <= 0.01:
        assert (found.zero_m, flagged) == (0.0, 0)
    else:
        assert found.zero_m == pytest.approx(zero_m, abs=0.01)


def test_a_leg_length_tells_the_zero_from_the_foot_on_the_ground() -> None:
    time_s, height_m, _apexes_m = standing_log(seed=4, jumps=12)
    leg_m = np.minimum(height_m, STANDING_M)
    found = find_jumps(time_s, height_m + 0.05, rest_length_m=STANDING_M, leg_length_m=leg_m)
    assert found.zero_m == pytest.approx(0.05, abs=0.01)
    assert len(found.with_apex) == 12
    assert find_jumps(time_s, height_m, rest_length_m=STANDING_M, leg_length_m=leg_m).zero_m == 0.0


def test_rests_are_found_with_their_levels() -> None:
    rng = np.random.default_rng(5)
    levels = [812.0, 1507.0, 2202.0, 3071.0]
    pieces = [np.full(900, levels[0])]
    for before, after in itertools.pairwise(levels):
        pieces += [np.linspace(before, after, 250), np.full(900, after)]
    values = np.concatenate(pieces)
    found = rests(np.arange(values.size) / 500, values + rng.normal(0, 1.5, values.size))
    assert [rest.mean for rest in found] == pytest.approx(levels, abs=0.5)
    assert [rest.sd for rest in found] == pytest.approx([1.5] * 4, rel=0.2)
    assert rests(np.arange(100) / 500, np.zeros(100)) == ()
    assert rests(np.array([]), np.array([])) == ()
