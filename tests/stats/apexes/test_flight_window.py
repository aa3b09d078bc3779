import numpy as np
import pytest

from stats.apexes.flights import FlightWindowParameters, window_ends

GRAVITY = 9.80665


def flights(n, rate_hz, caught_s, push_m_s2, rng):
    """n flights from 0.07 s before their apex; from `caught_s` after it a hand pushes upward."""
    at = np.arange(-0.07, 0.13, 1.0 / rate_hz)
    after = np.maximum(at - caught_s, 0.0)
    one = 0.33 - 0.5 * GRAVITY * at**2 + 0.5 * push_m_s2 * after**2
    time_s = np.concatenate([at + k for k in range(n)])
    return time_s, np.tile(one, n) + rng.normal(0.0, 0.001, time_s.size), np.arange(float(n))


def ends(time_s, height_m, apex_s):
    found = window_ends(
        time_s, height_m, apex_s, apex_s - 0.07, apex_s + 0.08, 0.001, GRAVITY, FlightWindowParameters()
    )
    return found - apex_s


@pytest.mark.parametrize("rate_hz", [300.0, 1000.0])
@pytest.mark.parametrize("caught_s", [0.025, 0.04, 0.06])
def test_a_window_ends_where_the_hand_begins(rate_hz, caught_s):
    found = ends(*flights(200, rate_hz, caught_s, 25.0, np.random.default_rng(6)))
    assert np.median(found) == pytest.approx(caught_s, abs=0.008)
    assert np.mean(found > caught_s + 0.015) < 0.05


@pytest.mark.parametrize("rate_hz", [300.0, 1000.0])
def test_a_free_flight_keeps_its_whole_window(rate_hz):
    found = ends(*flights(400, rate_hz, 1.0, 0.0, np.random.default_rng(7)))
    assert np.mean(np.isclose(found, 0.08)) > 0.95


def test_a_gravity_that_friction_changed_is_no_catch():
    rng = np.random.default_rng(8)
    time_s, height_m, apex_s = flights(300, 300.0, 1.0, 0.0, rng)
    height_m += 0.05 * 0.5 * GRAVITY * (time_s - np.rint(time_s)) ** 2
    assert np.mean(np.isclose(ends(time_s, height_m, apex_s), 0.08)) > 0.9


def test_no_flight_has_no_window():
    assert ends(np.arange(3.0), np.full(3, 0.3), np.empty(0)).shape == (0,)


@pytest.mark.parametrize("gap_s", [(0.237, 0.277), (0.251, 0.281), (0.262, 0.302)])
@pytest.mark.parametrize("seed", range(5))
def test_where_a_push_in_a_gap_begins_does_not_hang_on_the_last_bit(seed, gap_s):
    """With one sample after the gap, a push from anywhere in the gap explains it as well."""
    time_s = np.arange(0.0, 0.4, 1.0 / 300.0)
    height_m = 0.3 - GRAVITY / 2.0 * (time_s - 0.2) ** 2
    height_m += np.random.default_rng(seed).normal(0.0, 2e-4, time_s.size) + 0.003 * (time_s > gap_s[1])
    seen = ((time_s < gap_s[0]) | (time_s > gap_s[1])) & (time_s < gap_s[1] + 0.005)
    last_bits = np.random.default_rng(2)
    ends = []
    for _ in range(10):
        heights = height_m[seen] * (1.0 + last_bits.integers(-2, 3, seen.sum()) * 2.0**-53)
        bounds = [np.array([bound]) for bound in (0.2, 0.12, 0.28)]
        ends += window_ends(time_s[seen], heights, *bounds, 2e-4, GRAVITY, FlightWindowParameters()).tolist()
    assert max(ends) - min(ends) < 1e-9
