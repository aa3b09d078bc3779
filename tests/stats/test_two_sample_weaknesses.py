"""Two groups on inputs where other programs err, beyond the numbers that `test_weaknesses.py` asks for.

The truth is rational arithmetic on the doubles given, with tails by mpmath.
"""

import math
from fractions import Fraction

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import special

from data_schema.vocabulary import Undefined
from stats.compare.two_sample import compare_two
from tests.helpers.exact_tests import t_test
from tests.helpers.wording import says


def assert_exact(a, b):
    found = compare_two(a, b, route="student")
    for pooled, (t, df, p, ends) in (
        (True, (found.t, found.df, found.p, found.difference_ci)),
        (False, (found.welch_t, found.welch_df, found.welch_p, found.welch_ci)),
    ):
        right = t_test(a, b, pooled=pooled)
        assert t == pytest.approx(right.t, rel=1e-15)
        assert df == pytest.approx(right.df, rel=1e-15)
        if right.p > 1e-290:
            assert p == pytest.approx(float(right.p), rel=1e-14)
        half = float(special.stdtrit(right.df, 0.975)) * float(right.se)
        assert ends == pytest.approx((float(right.difference) - half, float(right.difference) + half), abs=1e-12 * half)
    log10_p = float(mpmath.log10(t_test(a, b, pooled=True).p))
    assert found.log10_p == pytest.approx(log10_p, rel=1e-14, abs=1e-15)
    return found


@pytest.mark.parametrize(
    ("a", "b", "wrong"),
    [
        pytest.param([0.04] * 10, [0.04] * 30, 4.6e-6, id="W1: scipy and pingouin 4.6e-6, statsmodels 7.5e-5"),
        pytest.param([0.1] * 3, [0.1] * 7, 0.032, id="W2: 0.032 from all three"),
        pytest.param([0.3] * 5, [0.6] * 5, 0.0, id="W4: pingouin t = -7e15, d = 3e15"),
    ],
)
def test_constant_groups_have_a_difference_and_no_test(a, b, wrong):
    found = compare_two(a, b)
    assert found.difference == a[0] - b[0]
    for value in (
        found.t,
        found.p,
        found.log10_p,
        found.f,
        found.f_p,
        found.welch_p,
        found.hedges_g,
        found.hedges_g_ci,
    ):
        assert isinstance(value, Undefined)
        assert value != wrong
    assert "no test" in found.sentence()
    row = found.to_frame().iloc[0]
    assert math.isnan(row["p"])
    says(row["p_reason"], "neither group has")


INTEGERS = st.lists(st.integers(-(2**20), 2**20), min_size=3, max_size=12).filter(lambda values: len(set(values)) > 1)
INVARIANT = (
    "t",
    "df",
    "p",
    "log10_p",
    "f",
    "f_p",
    "brown_forsythe_p",
    "welch_t",
    "welch_df",
    "welch_p",
    "hedges_g",
    "test",
)


@given(INTEGERS, INTEGERS, st.integers(-(2**50), 2**50), st.integers(-500, 500), st.randoms())
def test_shift_scale_and_order_leave_every_statistic_as_it_is(a, b, shift, exponent, random):
    """The shift is exact (whole numbers below 2^51), so that the same p is due: to the last digit, not to 1e-13."""
    one = compare_two(a, b)
    moved = [[math.ldexp(x + shift, exponent) for x in group] for group in (a, b)]
    for group in moved:
        random.shuffle(group)
    other = compare_two(*moved)
    for name in INVARIANT:
        assert getattr(other, name) == getattr(one, name), name


@given(st.data())
def test_random_data_at_offsets_to_1e15_agree_with_exact_arithmetic(data):
    offset = data.draw(st.sampled_from([0.0, 1e3, 1e6, 1e9, 1e12, 1e14, 1e15]))
    seed = data.draw(st.integers(0, 2**32 - 1))
    rng = np.random.default_rng(seed)
    n_a, n_b = rng.integers(3, 30, 2)
    a = (rng.normal(0.0, 1.0, n_a) + offset).tolist()
    b = (rng.normal(rng.choice([0.0, 1.0, 30.0]), rng.choice([1.0, 4.0]), n_b) + offset).tolist()
    if (
        len(set(a)) > 1
        and len(set(b)) > 1
        and Fraction(sum(map(Fraction, a))) / len(a) != sum(map(Fraction, b)) / len(b)
    ):
        assert_exact(a, b)
