import math
from fractions import Fraction

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stats.exact.tails import df_of_arrays, df_of_doubles, exact_df

PARTS = st.lists(st.tuples(st.floats(1e-30, 1e30), st.integers(1, 1000)), min_size=1, max_size=4)


def by_definition(parts):
    """Of the chi-squared whose multiple has the mean and variance of the sum of the parts, by 50 digits."""
    with mpmath.workdps(50):
        mean = mpmath.fsum(variance for variance, _df in parts)
        # An estimated variance v of df degrees of freedom is v / df times a chi-squared, whose variance is 2 df.
        variance = mpmath.fsum(2 * df * (mpmath.mpf(v) / df) ** 2 for v, df in parts)
        return 2 * mean * mean / variance


@given(PARTS)
def test_all_arithmetics_are_the_definition(parts):
    truth = by_definition(parts)
    exact = exact_df([(Fraction(variance), df) for variance, df in parts])
    with mpmath.workdps(50):
        assert mpmath.almosteq(mpmath.mpf(exact.numerator) / exact.denominator, truth, rel_eps=1e-45, abs_eps=0)
    assert df_of_doubles(parts) == pytest.approx(float(truth), rel=1e-15, abs=0.0)
    least, most = min(df for _variance, df in parts), sum(df for _variance, df in parts)
    assert least <= exact <= most
    if len(parts) == 2:
        (part_a, df_a), (part_b, df_b) = parts
        found = df_of_arrays(np.array([part_a]), np.array([part_b]), df_a, df_b)
        assert found == pytest.approx([float(truth)], rel=1e-15, abs=0.0)


@pytest.mark.parametrize("unit", [5e-324, 1e-300, 1e-170, 1.0, 1e170, 1e307])
def test_variances_whose_squares_are_no_doubles_keep_their_degrees_of_freedom(unit):
    parts = [(3.0 * unit, 4), (6.0 * unit, 9)]
    truth = 81.0 / (9.0 / 4.0 + 36.0 / 9.0)
    assert df_of_doubles(parts) == pytest.approx(truth, rel=1e-15, abs=0.0)
    found = df_of_arrays(np.array([3.0 * unit]), np.array([6.0 * unit]), 4.0, 9.0)
    assert found == pytest.approx([truth], rel=1e-15, abs=0.0)
    exact = exact_df([(3 * Fraction(unit), 4), (6 * Fraction(unit), 9)])
    assert float(exact) == pytest.approx(truth, rel=1e-15, abs=0.0)


def test_what_is_known_exactly_adds_no_doubt():
    assert df_of_doubles([]) == df_of_doubles([(0.0, 3.0)]) == df_of_doubles([(2.0, math.inf)]) == math.inf
    assert df_of_doubles([(2.0, 5.0), (0.0, 3.0)]) == 5.0
    assert df_of_doubles([(1.0, 5.0), (1.0, math.inf)]) == 20.0
    assert exact_df([(Fraction(2), 5), (Fraction(0), 3)]) == 5
