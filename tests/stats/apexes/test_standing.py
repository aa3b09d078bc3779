"""Where a signal is at rest, and a height whose zero is off: all flights are found, and how far it is off."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from stats.apexes.detectors import find_jumps
from stats.apexes.standing import rests
from tests.helpers.standing_log import REST_LENGTH_M, standing_log


@pytest.mark.parametrize("detector", ["robust", "published"])
@pytest.mark.parametrize("zero_m", [0.0, 0.008, 0.047, 0.059, 0.084, 0.2, 2.5])
def test_every_flight_is_found_whatever_the_zero_and_its_height_is_as_measured(detector: str, zero_m: float) -> None:
    time_s, height_m, apexes_m = standing_log(seed=3, jumps=25, zero_m=zero_m)
    found = find_jumps(time_s, height_m, rest_length_m=REST_LENGTH_M, detector=detector)
    assert len(found.with_apex) == 25
    assert found.apex_heights_m == pytest.approx(apexes_m + zero_m, abs=0.002)
    flagged = sum("zero_doubtful" in jump.flags for jump in found.jumps)
    if zero_m <= 0.01:
        assert (found.zero_m, flagged) == (0.0, 0)
    else:
        assert found.zero_m == pytest.approx(zero_m, abs=0.01)


def test_a_leg_length_tells_the_zero_from_the_foot_on_the_ground() -> None:
    time_s, height_m, _apexes_m = standing_log(seed=4, jumps=12)
    leg_m = np.minimum(height_m, REST_LENGTH_M)
    found = find_jumps(time_s, height_m + 0.05, rest_length_m=REST_LENGTH_M, leg_length_m=leg_m)
    assert found.zero_m == pytest.approx(0.05, abs=0.01)
    assert len(found.with_apex) == 12
    assert find_jumps(time_s, height_m, rest_length_m=REST_LENGTH_M, leg_length_m=leg_m).zero_m == 0.0


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
