import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stats.exact.error_free import exact_root, exact_sum, ordered_two_sum, scaled, shortened, two_product, two_sum

FINITE = st.lists(st.floats(allow_nan=False, allow_infinity=False), min_size=0, max_size=40)
FACTORS = st.floats(-1e100, 1e100).filter(lambda x: x == 0.0 or abs(x) > 1e-100)


@given(FINITE)
def test_sums_have_no_error(numbers):
    assert exact_sum(np.array(numbers, dtype=np.float64)) == sum(map(Fraction, numbers), Fraction(0))


def test_sums_of_many_values_that_cancel():
    rng = np.random.default_rng(2)
    half = rng.normal(size=20_000) * 10.0 ** rng.integers(-200, 200, 20_000)
    values = np.concatenate([half, [3e-250], -half])
    rng.shuffle(values)
    assert exact_sum(values) == Fraction(3e-250)
    assert exact_sum(np.full(10_001, 1.7e308)) == 10_001 * Fraction(1.7e308)
    assert exact_sum(np.full(7, 5e-324)) == 7 * Fraction(5e-324)


@given(st.floats(-1e300, 1e300), st.floats(-1e300, 1e300))
def test_a_sum_and_its_error(a, b):
    total, error = two_sum(np.array([a]), b)
    assert Fraction(float(total[0])) + Fraction(float(error[0])) == Fraction(a) + Fraction(b)
    large, small = (a, b) if abs(a) >= abs(b) else (b, a)
    total, error = ordered_two_sum(np.array([large]), np.array([small]))
    assert Fraction(float(total[0])) + Fraction(float(error[0])) == Fraction(a) + Fraction(b)


@given(FACTORS, FACTORS)
def test_a_product_and_its_error(a, b):
    for one, two in ((a, b), (a, a)):
        first = np.array([one])
        product, error = two_product(first, first if one is two else np.array([two]))
        assert Fraction(float(product[0])) + Fraction(float(error[0])) == Fraction(one) * Fraction(two)


@pytest.mark.parametrize(
    "value", [Fraction(2), Fraction(1, 3), Fraction(7) * Fraction(2) ** 3001, Fraction(5, 2**2999)]
)
def test_roots_and_short_forms_of_any_size(value):
    root = exact_root(value)
    assert abs(root * root / value - 1) < Fraction(1, 2**115)
    assert abs(shortened(value) / value - 1) < Fraction(1, 2**115)
    assert abs(shortened(-value) / value + 1) < Fraction(1, 2**115)
    assert exact_root(Fraction(0)) == shortened(Fraction(0)) == 0


@pytest.mark.parametrize("exponent", [-1074, -600, 0, 600, 1060])
def test_scaling_by_powers_of_two(exponent):
    value = math.ldexp(1.5, -exponent) if exponent > 0 else 1.5
    assert scaled(np.array([value]), exponent)[0] == math.ldexp(value, exponent)
