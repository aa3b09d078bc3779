"""Two clocks from touchdowns that both have timed, moving averages, and the corner of a curve."""

from __future__ import annotations

import numpy as np
import pytest

from data_schema.errors import InputRefused
from stats.clocks import align_clocks, corner, leg_touchdowns, moving_average

OFFSET_S, DRIFT, ERROR_S = -0.31, -1.2e-4, 2e-4


def touchdowns(seed: int, n: int = 80, jitter_s: float = 0.004) -> tuple[np.ndarray, np.ndarray]:
    """Touchdowns of uneven hops by both clocks, with errors."""
    chance = np.random.default_rng(seed)
    first = 1.0 + np.cumsum(0.5 + chance.normal(0.0, jitter_s, n))
    return first, OFFSET_S + (1.0 + DRIFT) * first + chance.normal(0.0, ERROR_S, n)


def test_offset_and_drift_are_found() -> None:
    found = align_clocks(*touchdowns(1))
    assert found.at_zero_s == pytest.approx(OFFSET_S, abs=3e-4)
    assert found.drift == pytest.approx(DRIFT, abs=1e-5)
    assert found.residual_sd_s == pytest.approx(ERROR_S, rel=0.3)
    assert (found.n, found.left_out) == (80, 0)
    assert found.second_s([10.0])[0] == pytest.approx(OFFSET_S + (1.0 + DRIFT) * 10.0, abs=3e-4)


@pytest.mark.soak
def test_intervals_cover_both_in_95_of_100() -> None:
    covered = np.zeros(2)
    for seed in range(100):
        found = align_clocks(*touchdowns(seed))
        covered += [
            low <= true <= high for (low, high), true in ((found.at_zero_ci, OFFSET_S), (found.drift_ci, DRIFT))
        ]
    assert covered == pytest.approx([95, 95], abs=6)


def test_touchdowns_that_one_has_not_seen_or_misread_are_no_matter() -> None:
    first, second = touchdowns(2)
    found = align_clocks(np.delete(first, [0, 3, 40]), np.delete(second, [7, 8, 79]))
    assert found.at_zero_s == pytest.approx(OFFSET_S, abs=3e-4)
    assert found.n == 74
    second[0] += 0.04
    found = align_clocks(first, second)
    assert found.drift == pytest.approx(DRIFT, abs=1e-5)
    assert found.left_out == 1


def test_touchdowns_that_do_not_pair_are_refused() -> None:
    even, (first, second) = touchdowns(4, jitter_s=0.0), touchdowns(5, jitter_s=0.1)
    scattered = second + np.random.default_rng(6).normal(0.0, 0.012, second.size)
    for one, other, said in (
        (*even, "one hop further"),  # equal hops fit so as well
        (first, second.max() - second[::-1], "only"),
        (first[:3], second[:3], "of 3 touchdowns"),
        (first, scattered, "ms from one line"),
    ):
        with pytest.raises(InputRefused, match=said):
            align_clocks(one, other)


def test_averages_are_centred_and_a_corner_lies_furthest_below_the_line_of_the_ends() -> None:
    assert moving_average([0.0, 0.0, 3.0, 0.0, 0.0], 3) == pytest.approx([0.0, 1.0, 1.0, 1.0, 0.0])
    assert corner([3, 5, 7, 9, 11], [100.0, 40.0, 12.0, 10.0, 9.0]) == 7
    assert corner([3, 5, 7], [0.0, 0.0, 0.0]) == 3


def test_a_leg_that_begins_to_yield_has_touched_down() -> None:
    time_s = np.arange(0.0, 5.0, 0.003)
    down_s = np.arange(0.5003, 4.6, 0.5)
    length_m = np.full(time_s.size, 0.27)
    for one in down_s:
        length_m -= np.where((time_s > one) & (time_s < one + 0.2), 0.1 * np.sin(np.pi * (time_s - one) / 0.2), 0.0)
    length_m += np.random.default_rng(1).normal(0.0, 5e-5, time_s.size)
    assert leg_touchdowns(time_s, length_m) == pytest.approx(down_s, abs=6e-4)
    kept = np.abs(time_s - down_s[3]) > 0.01
    assert leg_touchdowns(time_s[kept], length_m[kept]) == pytest.approx(np.delete(down_s, 3), abs=6e-4)
