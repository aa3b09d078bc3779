"""Two groups on inputs where other programs err, beyond the numbers that `test_weaknesses.py` asks for.

The truth is rational arithmetic on the doubles given, with tails by mpmath.
"""

import json
import math
from decimal import Decimal
from fractions import Fraction

import mpmath
import numpy as np
import pandas as pd
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st

from data_schema.errors import InputRefused, UnknownName
from data_schema.vocabulary import Undefined
from stats.compare.summary import describe
from stats.compare.two_sample import compare_two
from stats.groups.variances import bartlett, brown_forsythe, f_test, levene
from tests.helpers.exact_tests import t_test
from tests.helpers.wording import refuses, says

A = [42.1, 39.8, 44.0, 41.2, 40.5, 43.3]
B = [36.9, 38.2, 35.1, 37.7, 36.0]


def assert_exact(a, b):
    found = compare_two(a, b, route="student")
    for pooled, (t, df, p) in (
        (True, (found.t, found.df, found.p)),
        (False, (found.welch_t, found.welch_df, found.welch_p)),
    ):
        right = t_test(a, b, pooled=pooled)
        assert t == pytest.approx(right.t, rel=1e-15)
        assert df == pytest.approx(right.df, rel=1e-15)
        if right.p > 1e-290:
            assert p == pytest.approx(float(right.p), rel=1e-14)
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


@pytest.mark.parametrize("exponent", [-600, -500, -300, 300, 500, 600])
def test_w6_w7_units_as_powers_of_two_change_nothing(exponent):
    """At 2^-300 scipy's Welch has 1 degree of freedom and another p; at 2^-600 p = 0, at 2^600 p = 1."""
    one = compare_two(A, B)
    other = compare_two([math.ldexp(x, exponent) for x in A], [math.ldexp(x, exponent) for x in B])
    for name in (
        "t",
        "df",
        "p",
        "log10_p",
        "f",
        "f_p",
        "brown_forsythe_p",
        "welch_p",
        "welch_df",
        "hedges_g",
        "hedges_g_ci",
    ):
        assert getattr(other, name) == getattr(one, name), name
    assert other.difference == math.ldexp(one.difference, exponent)
    assert other.difference_ci == pytest.approx(
        tuple(math.ldexp(end, exponent) for end in one.difference_ci), rel=1e-15
    )


def test_w8_p_far_below_the_smallest_double():
    """Other programs print p = 0 and log p = -inf for t = 1464 at n = 400; the true p is near 1e-1000 and beyond."""
    a = [1e6 + (k % 7) * 2.0**-10 for k in range(400)]
    found = assert_exact(a, [x + 2.0**-4 for x in a])
    assert found.p == 0.0
    assert found.log10_p < -500.0
    assert "p < .001" in found.sentence()


def test_w10_missing_values_are_refused_or_counted():
    """scipy returns NaN, pingouin drops them without a word, Dunnett's test of scipy returns p = 1."""
    with refuses(InputRefused, "1", "7 values"):
        compare_two([*A, math.nan], B)
    found = compare_two([*A, math.nan], [None, *B, math.nan], missing="drop")
    assert (found.missing_a, found.missing_b, found.n_a) == (1, 2, 6)
    assert found.p == compare_two(A, B).p
    says(found.sentence(), "3 missing")
    with refuses(UnknownName, "'drop'"):
        compare_two(A, B, missing="dropp")


@pytest.mark.parametrize("missing", ["refuse", "drop"])
def test_w11_infinite_values_are_refused_whatever_is_done_with_missing_ones(missing):
    """pingouin's Welch ANOVA prints F = 2.11, p = 0.155 with an infinite value."""
    with pytest.raises(InputRefused, match="infinite"):
        compare_two([*A, -math.inf], B, missing=missing)


def test_w12_an_empty_group_is_said():
    """scipy returns NaN, pingouin fails with ZeroDivisionError."""
    found = compare_two([math.nan], B, missing="drop")
    for value in (found.mean_a, found.difference, found.t, found.p, found.f, found.hedges_g_ci, found.brown_forsythe_p):
        assert isinstance(value, Undefined)
        assert "group" in value.reason


@pytest.mark.parametrize(
    "values",
    [
        pytest.param(np.array([200, -150, 120, -160], dtype=np.int16), id="W25: int16 squares overflow to NaN"),
        pytest.param(np.array([1e200, 2e200, 4e200]), id="W25: squares of 1e200 are infinite"),
        pytest.param(np.array([100, -100, 27], dtype=np.int8), id="int8"),
        pytest.param(np.array([255, 0, 254], dtype=np.uint8), id="uint8: differences below 0"),
    ],
)
def test_w25_narrow_integers_and_huge_numbers_do_not_overflow(values):
    exact = [Fraction(x) for x in values.tolist()]
    mean = sum(exact) / len(exact)
    variance = sum((x - mean) ** 2 for x in exact) / (len(exact) - 1)
    assert Fraction(describe(values).sd) ** 2 / variance == pytest.approx(1.0, rel=1e-15)


DTYPES = ["int8", "int16", "int32", "int64", "uint8", "uint16", "uint32", "uint64", "float16", "float32", "longdouble"]


@given(
    st.lists(st.integers(0, 120), min_size=3, max_size=10).filter(lambda values: len(set(values)) > 1),
    st.lists(st.integers(0, 120), min_size=3, max_size=10).filter(lambda values: len(set(values)) > 1),
    st.sampled_from(DTYPES),
)
def test_every_type_gives_the_same_result(a, b, dtype):
    one = compare_two([float(x) for x in a], [float(x) for x in b])
    typed = np.array(a, dtype=dtype), np.array(b, dtype=dtype)
    assert compare_two(*typed) == one
    for kind in (pd.Series, lambda x: pd.Series(x, dtype="Int64"), xr.DataArray, list, tuple):
        assert compare_two(kind(a), kind(b)) == one
    for exact in (Decimal, Fraction):
        assert compare_two([exact(x) for x in a], [exact(x) for x in b]) == one


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


def test_decimals_at_an_offset_keep_their_digits():
    """Rounded to doubles, .1 at 1e12 has 4 digits; counts and decimals have all."""
    a = [Decimal("1000000000000.4"), Decimal("1000000000000.3"), Decimal("1000000000000.1")]
    b = [Decimal("1000000000000.7"), Decimal("1000000000000.9"), Decimal("1000000000000.5")]
    found = compare_two(a, b)
    small = compare_two(
        [Decimal("0.4"), Decimal("0.3"), Decimal("0.1")], [Decimal("0.7"), Decimal("0.9"), Decimal("0.5")]
    )
    assert found.p == small.p
    assert (found.t, found.hedges_g) == (small.t, small.hedges_g)
    assert found.t == pytest.approx(t_test(a, b, pooled=True).t, rel=1e-15)
    big = [2**60 + x for x in (1, 2, 4)], [2**60 + x for x in (7, 8, 12)]
    assert compare_two(*big).p == compare_two([1, 2, 4], [7, 8, 12]).p


@pytest.mark.soak
@pytest.mark.parametrize("n", [3, 5, 10, 25])
def test_students_size_and_coverage_are_exact_for_normal_values_of_one_variance(n):
    """4000 simulated pairs of groups, 99 % binomial band."""
    rng = np.random.default_rng(23)
    found = [
        compare_two(a, b, route="student")
        for a, b in zip(rng.normal(5.0, 2.0, (4000, n)), rng.normal(5.0, 2.0, (4000, n)), strict=True)
    ]
    band = 2.58 * math.sqrt(0.95 * 0.05 / 4000)
    assert abs(np.mean([one.p < 0.05 for one in found]) - 0.05) < band
    assert abs(np.mean([one.difference_ci[0] <= 0.0 <= one.difference_ci[1] for one in found]) - 0.95) < band
    assert abs(np.mean([one.f_p < 0.05 for one in found]) - 0.05) < band


def test_values_of_any_size_give_numbers_or_reasons_never_nan_or_infinity():
    """Constants, denormals, the largest doubles and offsets of 1e300, in groups of 0 to 5 and 60."""
    rng = np.random.default_rng(0)
    makers = [
        lambda n: np.round(rng.normal(size=n)),
        lambda n: np.clip(rng.normal(size=n) * 10.0 ** rng.integers(-320, 308), -1.7e308, 1.7e308),
        lambda n: np.full(n, rng.normal()) * 10.0 ** rng.integers(-300, 308),
        lambda n: rng.normal(size=n) + 10.0 ** rng.integers(0, 300),
        lambda n: rng.choice([-1.7e308, 1.7e308], n),
    ]
    for turn in range(120):
        a, b = (makers[rng.integers(5)](rng.integers(0, 6) + 60 * (turn % 10 == 0)) for _ in range(2))
        groups = {"a": a, "b": b}
        results = [
            compare_two(a, b),
            describe(a),
            f_test(a, b),
            *(test(groups) for test in (bartlett, levene, brown_forsythe)),
        ]
        for result in results:
            assert result.sentence()
            json.loads(result.to_json())
            for name, value in result.to_dict().items():
                assert value is not None or result.to_dict()[f"{name}_reason"] not in ("infinite", "not a number"), name
