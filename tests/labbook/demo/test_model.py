import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from labbook.demo.model import Wobble, carry_duration_s, carry_m, catch_duration_s, catch_m


@given(st.floats(0.2, 1.0), st.floats(0.1, 0.5), st.floats(0.1, 0.5))
def test_carrying_begins_and_ends_at_rest(duration_s: float, start_m: float, end_m: float) -> None:
    height_m = carry_m(np.array([0.0, 1e-6, duration_s - 1e-6, duration_s]), duration_s, start_m, end_m)
    assert height_m[0] == start_m
    assert height_m[-1] == pytest.approx(end_m, abs=1e-15)
    assert abs(height_m[1] - height_m[0]) < 1e-12
    assert abs(height_m[-1] - height_m[-2]) < 1e-12


@given(st.floats(0.3, 1.2), st.floats(0.002, 0.03))
def test_a_catch_takes_the_fall_over_at_its_speed_and_stops_it(speed_m_s: float, distance_m: float) -> None:
    duration_s = catch_duration_s(speed_m_s, distance_m)
    height_m = catch_m(np.array([0.0, 1e-9, duration_s, duration_s + 1]), 0.3, speed_m_s, distance_m)
    assert (height_m[0] - height_m[1]) / 1e-9 == pytest.approx(speed_m_s, rel=1e-4)
    assert height_m[2:] == pytest.approx(0.3 - distance_m, abs=1e-12)


@given(st.floats(0.5, 5.0), st.floats(0, 6.3))
def test_wobble_stays_within_a_few_millimetres_and_is_still_at_the_end(frequency_hz: float, phase: float) -> None:
    wobble = Wobble(0.004, frequency_hz, phase)
    height_m = wobble.height_m(np.linspace(0, 0.7, 500), 0.7)
    assert np.abs(height_m).max() < 0.007
    assert height_m[0] == height_m[-1] == 0.0
    assert abs(height_m[-2]) < 1e-6


@given(st.floats(0.01, 0.3), st.floats(1.0, 8.0))
def test_a_carry_accelerates_no_more_than_asked(distance_m: float, acceleration_m_s2: float) -> None:
    duration_s = carry_duration_s(distance_m, acceleration_m_s2)
    time_s = np.linspace(0, duration_s, 2001)
    second_m_s2 = np.diff(carry_m(time_s, duration_s, 0.2, 0.2 + distance_m), 2) / (time_s[1] ** 2)
    assert np.abs(second_m_s2).max() == pytest.approx(acceleration_m_s2, rel=1e-3)
