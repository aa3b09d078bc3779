"""Two groups, their variances and effects as R has them (`tests/stats/r/two_groups.R`)."""

import csv
import math
from pathlib import Path

import pytest
from scipy import special

from stats.compare.effect_size import eta_squared_ci, noncentral_f_interval
from stats.compare.two_sample import compare_two
from stats.groups.variances import bartlett, brown_forsythe, f_test, levene

with (Path(__file__).parent / "r" / "two_groups.csv").open(newline="") as file:
    ROWS = list(csv.DictReader(file))
CASES = [name for name in dict.fromkeys(row["case"] for row in ROWS) if not name.startswith("F:")]
F_CASES = [name for name in dict.fromkeys(row["case"] for row in ROWS) if name.startswith("F:")]


def numbers(case, quantity):
    return [float(row["value"]) for row in ROWS if (row["case"], row["quantity"]) == (case, quantity)]


def number(case, quantity):
    (found,) = numbers(case, quantity)
    return found


@pytest.mark.parametrize("case", CASES)
def test_the_tests_of_two_groups(case):
    a, b = numbers(case, "a"), numbers(case, "b")
    student = compare_two(a, b, route="student")
    for name, found in (
        ("student_t", student.t),
        ("student_p", student.p),
        ("student_low", student.difference_ci[0]),
        ("student_high", student.difference_ci[1]),
        ("welch_t", student.welch_t),
        ("welch_df", student.welch_df),
        ("welch_p", student.welch_p),
        ("welch_low", student.welch_ci[0]),
        ("welch_high", student.welch_ci[1]),
        ("f", student.f),
        ("f_p", student.f_p),
        ("f_low", f_test(a, b).ratio_ci[0]),
        ("f_high", f_test(a, b).ratio_ci[1]),
        ("brown_forsythe_p", student.brown_forsythe_p),
        ("hedges_g", student.hedges_g),
    ):
        assert found == pytest.approx(number(case, name), rel=1e-9), name


@pytest.mark.parametrize("case", CASES)
def test_the_tests_of_spread(case):
    groups = {"a": numbers(case, "a"), "b": numbers(case, "b")}
    assert brown_forsythe(groups).statistic == pytest.approx(number(case, "brown_forsythe_f"), rel=1e-9)
    assert levene(groups).p == pytest.approx(number(case, "levene_p"), rel=1e-9)
    # R's statistic is a difference of large logarithms: its last digits are not right.
    assert bartlett(groups).statistic == pytest.approx(number(case, "bartlett"), rel=1e-8)
    assert bartlett(groups).p == pytest.approx(number(case, "bartlett_p"), rel=1e-9)


def test_the_interval_of_hedges_g_at_a_huge_t():
    """R's search fails at t = 6400 (10 % off). There Z no longer counts: the ends are t times quantiles of S."""
    found = compare_two(numbers("far", "a"), numbers("far", "b"))
    ends = [end / found.hedges_g for end in found.hedges_g_ci]
    right = [math.sqrt(float(special.chdtri(7, tail)) / 7) for tail in (0.975, 0.025)]
    assert ends == pytest.approx(right, rel=1e-6)


@pytest.mark.parametrize("case", [name for name in CASES if name != "far"])
def test_the_interval_of_hedges_g(case):
    """R finds the noncentrality by minimising, to four to eight digits."""
    found = compare_two(numbers(case, "a"), numbers(case, "b"))
    right = (number(case, "hedges_g_low"), number(case, "hedges_g_high"))
    assert found.hedges_g_ci == pytest.approx(right, rel=1e-4)


@pytest.mark.parametrize("case", F_CASES)
def test_the_noncentrality_of_f(case):
    """effectsize divides lambda by lambda + df_within; its noncentrality is compared, the share is Steiger's."""
    f, df_between, df_within = map(float, case.split(":")[1:])
    low, high = noncentral_f_interval(f, df_between, df_within, 0.95)
    for found, name in ((low, "effectsize_low"), (high, "effectsize_high")):
        assert found / (found + df_within) == pytest.approx(number(case, name), rel=1e-4, abs=1e-9)
    share = eta_squared_ci(f, df_between, df_within)
    n = df_between + df_within + 1
    assert share == pytest.approx((low / (low + n), high / (high + n)), rel=1e-15)
