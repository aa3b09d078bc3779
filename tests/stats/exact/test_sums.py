from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stats.exact.sums import common_shift, moments

NUMBERS = st.lists(st.floats(-1e6, 1e6), min_size=1, max_size=30)


@given(NUMBERS)
def test_moments_agree_with_exact_arithmetic(numbers):
    values = np.array(numbers)
    exact = [Fraction(x) for x in numbers]
    mean = sum(exact) / len(exact)
    squares = sum((x - mean) ** 2 for x in exact)
    found = moments(values, common_shift(values))
    spread = float(np.ptp(values)) + 1e-300
    assert abs(Fraction(found.mean) - mean) <= Fraction(2e-15 * max(abs(float(mean)), spread))
    assert found.sum_squares == pytest.approx(float(squares), rel=1e-12, abs=1e-28 * spread**2)


@given(st.floats(-1e12, 1e12), st.integers(1, 50))
def test_a_constant_sample_has_squares_of_exactly_zero(value, n):
    values = np.full(n, value)
    found = moments(values, common_shift(values))
    assert found.sum_squares == 0.0
    assert found.mean == value


def test_a_large_offset_costs_no_digit():
    small = np.array([1.0, 2.0, 4.0, 8.0])
    offset = small + 2.0**40
    assert moments(offset, common_shift(offset)).sum_squares == moments(small, common_shift(small)).sum_squares


def test_the_shift_is_one_of_the_values():
    assert common_shift(np.array([3.0, 1.0]), np.array([2.0, 9.0])) == 2.0
    assert common_shift(np.empty(0)) == 0.0
