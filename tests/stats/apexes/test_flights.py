"""Flights: parabolas through apexes, without bias and exact where they are, and where a hand ends the window of one."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stats.apexes.flights import FlightWindowParameters, fit_parabolas, window_ends

GRAVITY = 9.80665
HALF_WINDOW_S = 0.055


def fit(time_s, height_m, around_s):
    return fit_parabolas(time_s, height_m, around_s, around_s - HALF_WINDOW_S, around_s + HALF_WINDOW_S)


@given(st.floats(0.2, 0.6), st.floats(5.0, 15.0), st.floats(-0.01, 0.01), st.floats(0.0, 1e6))
def test_an_exact_parabola_is_returned_exactly(height, curvature, apex, origin):
    time_s = np.round(np.arange(-0.06, 0.06, 1 / 300), 9) + round(origin)
    apex_s = round(origin) + apex
    found = fit(time_s, height - 0.5 * curvature * (time_s - apex_s) ** 2, np.array([float(round(origin))]))
    assert found[0].height_m == pytest.approx(height, abs=1e-9)
    assert found[0].apex_s == pytest.approx(apex_s, abs=1e-7)
    assert found[0].curvature_m_s2 == pytest.approx(curvature, rel=1e-5)
    assert found[0].height_se_m < 1e-9


def test_least_squares_is_the_limit_without_outliers():
    """Bisquare keeps 95 % of the precision of least squares on normal noise; numpy's polyfit is the second method."""
    rng = np.random.default_rng(2)
    time_s = np.arange(-0.055, 0.055, 0.001)
    height_m = 0.4 - 0.5 * GRAVITY * time_s**2 + rng.normal(0.0, 0.001, time_s.size)
    found = fit(time_s, height_m, np.array([0.0]))
    square, linear, constant = np.polyfit(time_s, height_m, 2)
    assert found[0].height_m == pytest.approx(constant - linear**2 / (4 * square), abs=0.05e-3)
    assert found[0].curvature_m_s2 == pytest.approx(-2 * square, abs=0.2)
    assert found[0].before + found[0].after == time_s.size


def test_what_is_no_maximum_or_has_too_few_samples_is_not_defined():
    time_s = np.arange(0.0, 1.0, 0.01)
    valley = fit(time_s, 0.3 + (time_s - 0.5) ** 2, np.array([0.5]))
    assert valley == [None]
    assert fit(time_s[:3], np.array([0.3, 0.4, 0.3]), np.array([0.01])) == [None]
    assert fit(time_s, np.full(time_s.size, 0.3), np.array([99.0])) == [None]
    assert fit(time_s, time_s, np.empty(0)) == []


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


@pytest.mark.parametrize(
    ("rate_hz", "less_gravity", "share"), [(300.0, 0.0, 0.95), (1000.0, 0.0, 0.95), (300.0, 0.05, 0.9)]
)
def test_a_free_flight_keeps_its_whole_window_under_a_gravity_that_friction_changed_too(rate_hz, less_gravity, share):
    time_s, height_m, apex_s = flights(400, rate_hz, 1.0, 0.0, np.random.default_rng(7))
    height_m += less_gravity * 0.5 * GRAVITY * (time_s - np.rint(time_s)) ** 2
    assert np.mean(np.isclose(ends(time_s, height_m, apex_s), 0.08)) > share


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
