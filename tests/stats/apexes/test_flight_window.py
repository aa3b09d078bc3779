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
