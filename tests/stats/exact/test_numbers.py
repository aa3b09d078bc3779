"""Exact sums and moments, and the root between two places: to the last digits, however values and functions lie."""

import math
from collections.abc import Callable
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stats.exact.numbers import common_shift, exact_root, exact_sum, moments, root_between, to_120_bits

NUMBERS = st.lists(st.floats(-1e6, 1e6), min_size=1, max_size=100)


@given(NUMBERS)
def test_moments_agree_with_exact_arithmetic(numbers):
    values = np.array(numbers)
    exact = [Fraction(x) for x in numbers]
    mean = sum(exact) / len(exact)
    squares = sum((x - mean) ** 2 for x in exact)
    found = moments(values)
    spread = float(np.ptp(values)) + 1e-300
    assert abs(Fraction(found.mean) - mean) <= Fraction(2e-15 * max(abs(float(mean)), spread))
    assert float(found.exact_sum_squares) == pytest.approx(float(squares), rel=1e-12, abs=1e-28 * spread**2)


@given(st.floats(-1e12, 1e12), st.integers(1, 200))
def test_a_constant_sample_has_squares_of_exactly_zero(value, n):
    values = np.full(n, value)
    found = moments(values)
    assert found.exact_sum_squares == 0
    assert found.mean == value


def test_a_large_offset_costs_no_digit():
    small = np.array([1.0, 2.0, 4.0, 8.0])
    offset = small + 2.0**40
    assert moments(offset).exact_sum_squares == moments(small).exact_sum_squares


def test_the_shift_is_one_of_the_values():
    assert common_shift(np.array([3.0, 1.0]), np.array([2.0, 9.0])) == 2.0
    assert common_shift(np.empty(0)) == 0.0


FINITE = st.lists(st.floats(allow_nan=False, allow_infinity=False), min_size=0, max_size=40)


@settings(deadline=None)
@given(FINITE)
def test_sums_have_100_bits(numbers):
    right = sum(map(Fraction, numbers), Fraction(0))
    assert abs(exact_sum(np.array(numbers, dtype=np.float64)) - right) <= abs(right) * Fraction(2) ** -100


def test_sums_of_many_values_that_cancel():
    rng = np.random.default_rng(2)
    half = rng.normal(size=20_000) * 10.0 ** rng.integers(-200, 200, 20_000)
    values = np.concatenate([half, [3e-250], -half])
    rng.shuffle(values)
    assert exact_sum(values) == Fraction(3e-250)
    assert exact_sum(np.full(10_001, 1.7e308)) == 10_001 * Fraction(1.7e308)
    assert exact_sum(np.full(7, 5e-324)) == 7 * Fraction(5e-324)


@pytest.mark.parametrize(
    "value", [Fraction(2), Fraction(1, 3), Fraction(7) * Fraction(2) ** 3001, Fraction(5, 2**2999)]
)
def test_roots_and_short_forms_of_any_size(value):
    root = exact_root(value)
    assert abs(root * root / value - 1) < Fraction(1, 2**115)
    assert abs(to_120_bits(value) / value - 1) < Fraction(1, 2**115)
    assert abs(to_120_bits(-value) / value + 1) < Fraction(1, 2**115)
    assert exact_root(Fraction(0)) == to_120_bits(Fraction(0)) == 0


BENDS: dict[str, Callable[[float], float]] = {
    "straight": lambda x: x,
    "cubic": lambda x: x**3,
    "flat at its root": lambda x: math.copysign(math.sqrt(abs(x)), x),
    "steps": lambda x: math.copysign(1.0, x),
    "infinite on one side": lambda x: math.inf if x > 0.25 else x,
}


@pytest.mark.parametrize("bend", BENDS)
@given(root=st.floats(0.05, 0.95), rising=st.booleans(), turned=st.booleans())
def test_the_root_is_found_to_the_last_digits(bend: str, root: float, rising: bool, turned: bool) -> None:
    def function(x: float) -> float:
        return BENDS[bend](x - root) * (1.0 if rising else -1.0)

    ends = [(place, function(place)) for place in ((1.0, 0.0) if turned else (0.0, 1.0))]
    # A cube below the smallest double is 0 over some width
    assert root_between(function, *ends) == pytest.approx(root, rel=1e-15, abs=1e-107 if bend == "cubic" else 0.0)


@given(st.integers(1, 300))
def test_a_root_many_decades_below_the_ends_keeps_its_digits(decades: int) -> None:
    root = 10.0**-decades
    found = root_between(lambda x: math.log(x / root) if x > 0.0 else -math.inf, (0.0, -math.inf), (1.0, 700.0), 5000)
    assert found == pytest.approx(root, rel=1e-14, abs=0.0)
