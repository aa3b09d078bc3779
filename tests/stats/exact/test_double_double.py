import math
from fractions import Fraction

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from stats.exact.error_free import (
    fixed_point,
    multiply,
    nearest_double,
    product_of_halves,
    scaled,
    split,
    sum_pairs,
    two_sum,
)

numbers = st.floats(-1e100, 1e100).filter(lambda x: x == 0.0 or abs(x) > 1e-100)


def value(pair):
    return Fraction(float(pair[0])) + Fraction(float(pair[1]))


@given(numbers, numbers)
def test_sums_and_products_of_two_are_exact(a, b):
    first, second = np.array(a), np.array(b)
    assert value(two_sum(first, second)) == Fraction(a) + Fraction(b)
    assert value(split(first)) == Fraction(a)
    assert value(product_of_halves(first, split(first), second, split(second))) == Fraction(a) * Fraction(b)


@given(numbers, st.floats(-1.0, 1.0), numbers, st.floats(-1.0, 1.0))
def test_products_of_pairs_have_31_digits(a, low_a, b, low_b):
    pairs = [(np.array(x), np.array(x * low * 2.0**-53)) for x, low in ((a, low_a), (b, low_b))]
    true = value(pairs[0]) * value(pairs[1])
    assert abs(value(multiply(*pairs)) - true) <= abs(true) * Fraction(1, 10**31)


@given(st.lists(st.floats(-1.0, 1.0), max_size=200), st.integers(-300, 300))
def test_sums_over_an_axis_have_the_digits_of_pairs(terms, exponent):
    high = np.ldexp(np.array([terms, [-one for one in terms]]), exponent)
    high[np.abs(high) < 1e-200] = 0.0
    low = high * 2.0**-54
    found = sum_pairs(high, low)
    for row in range(2):
        true = sum((Fraction(x) for x in [*high[row].tolist(), *low[row].tolist()]), Fraction(0))
        bound = Fraction(float(np.abs(high[row]).max(initial=0.0))) * len(terms) / 10**30
        assert abs(value((found[0][row], found[1][row])) - true) <= bound


def test_sums_that_cancel():
    assert sum_pairs(np.array([1e30, 1.0, -1e30]), np.zeros(3))[0] == 1.0
    assert sum_pairs(np.zeros(5), np.zeros(5)) == (0.0, 0.0)


@given(st.floats(-1e9, 1e9).filter(lambda x: x == 0.0 or abs(x) > 1e-70), st.integers(-100, 100))
def test_fixed_point_and_back(number, exponent):
    assert nearest_double(fixed_point(number), exponent) == math.ldexp(number, exponent)
    assert nearest_double(fixed_point(number, number * 2.0**-60)) == number


def test_what_exceeds_doubles_is_infinite():
    assert nearest_double(fixed_point(-1.0), 2000) == -math.inf


@given(st.floats(-1.0, 1.0), st.integers(-1020, 1020))
def test_powers_of_two_round_nothing(number, exponent):
    assert scaled(np.array([number]), exponent)[0] == np.ldexp(number, exponent)
