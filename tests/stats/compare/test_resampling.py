"""Shuffling and redrawing within days: exact counts, ties by decimals, seeds, coverage."""

from __future__ import annotations

from decimal import Decimal
from fractions import Fraction
from itertools import combinations, product

import numpy as np
import pytest
import scipy.stats

from benchmarks.stats_evidence.weaknesses.days import TENTHS_A, TENTHS_B, by_fractions
from data_schema.errors import InputRefused
from data_schema.vocabulary import Undefined
from stats.compare.resampling import bootstrap_difference, permutation_test
from stats.compare.two_sample import compare_two
from stats.exact.numbers import on_tied_scale
from tests.helpers.wording import says


def tenths(offset: int) -> tuple[list[float], list[float]]:
    a, b = ([float(Decimal(x) + offset) for x in each] for each in (TENTHS_A, TENTHS_B))
    return a, b


@pytest.mark.parametrize("offset", [0, 1000, 1_000_000, 1_000_000_000])
def test_w21_ties_are_those_of_the_decimals(offset):
    """W21: scipy takes ties for differences, so that its p depends on the offset: 0.0996 for 0.1082 at +1e6."""
    found = permutation_test(*tenths(offset))
    assert found.exact
    assert found.arrangements == 924
    assert found.p == by_fractions() == pytest.approx(0.10823, abs=5e-6)


def test_within_days_every_arrangement_of_each_day_counts():
    a, day_a = [3.0, 4.0, 7.5, 9.0], [1, 1, 2, 2]
    b, day_b = [1.0, 2.5, 8.0, 6.0, 5.0], [1, 1, 2, 2, 2]
    days = [([3.0, 4.0], [1.0, 2.5]), ([7.5, 9.0], [8.0, 6.0, 5.0])]
    sums = []
    for one, two in product(combinations(range(4), 2), combinations(range(5), 2)):
        total = 0.0
        for chosen, (first, second) in zip((one, two), days, strict=True):
            pooled = np.array(first + second)
            total += np.sum(pooled[list(chosen)] - pooled.mean())
        sums.append(total)
    sums = np.array(sums)
    found = permutation_test(a, b, day_a, day_b)
    assert found.arrangements == 60
    assert found.p == np.mean(np.abs(sums) >= abs(sums[0]) - 1e-9)
    assert found.p_greater == np.mean(sums >= sums[0] - 1e-9)
    assert found.p_less == np.mean(sums <= sums[0] + 1e-9)
    weights = 1.0, 1.2
    assert found.difference == pytest.approx((1.0 * 1.75 + 1.2 * (8.25 - 19.0 / 3.0)) / sum(weights))
    assert "within 2 days" in found.sentence()


def test_days_do_not_pass_for_effects():
    """Values that differ by day only: shuffled over days they look significant, within days they do not."""
    rng = np.random.default_rng(3)
    a = np.concatenate([rng.normal(10.0, 0.1, 8), rng.normal(0.0, 0.1, 2)])
    b = np.concatenate([rng.normal(10.0, 0.1, 2), rng.normal(0.0, 0.1, 8)])
    assert permutation_test(a, b).p < 0.05
    assert permutation_test(a, b, [1] * 8 + [2] * 2, [1] * 2 + [2] * 8).p > 0.05


def test_draws_are_seeded_and_near_the_count():
    a, b = tenths(0)
    drawn = permutation_test(a, b, exact_limit=100, seed=7)
    assert not drawn.exact
    assert drawn == permutation_test(a, b, exact_limit=100, seed=7)
    assert drawn.seed == 7
    assert drawn.p == pytest.approx(permutation_test(a, b).p, abs=4 * 0.0022)
    far = permutation_test(np.arange(30.0) + 100.0, np.arange(30.0), resamples=999)
    assert far.p == 1 / 1000
    assert "999 random arrangements" in far.sentence()


def test_the_scale_of_ties():
    scores, tolerance = on_tied_scale([np.array([0.1, 0.7, 0.3]), np.array([1000000.5, 1000000.1])])
    assert tolerance == 0.0
    assert [score.tolist() for score in scores] == [[-16, 20, -4], [12, -12]]
    scores, tolerance = on_tied_scale([np.array([np.pi, np.e, 1.0 / 3.0])])
    assert 0.0 < tolerance < 1e-14


@pytest.mark.parametrize(
    ("a", "b"),
    [
        ([1e17, -1e17, 3.0, 4.0], [1.0, 2.0, 3.0, 5.0]),
        ([1e9, -1e9, 3.1, 4.0], [1.0, 2.0, 3.0, 5.3]),
        ([Decimal("1e17"), Decimal("-1e17"), Decimal("3.1"), Decimal(4)], [1, 2, 3, Decimal("5.3")]),
        ([1e300, -1e300, 3.0, 4.0], [1.0, 2.0, 3.0, 5.0]),
    ],
)
def test_values_that_cancel_leave_the_difference_exact(a, b):
    difference = compare_two(a, b).difference
    assert permutation_test(a, b).difference == difference
    assert bootstrap_difference(a, b, resamples=100).difference == difference
    days = ["mon"] * 4
    assert permutation_test(a, b, days, days).difference == difference
    assert bootstrap_difference(a, b, days, days, resamples=100).difference == difference


@pytest.mark.parametrize("far", [1e17, 1e300])
def test_values_that_cancel_are_shuffled_without_rounding(far):
    """Oracle: all arrangements in fractions; a drawn test comes near it."""
    a, b = [far, -far, 3.0, 4.0], [1.0, 2.0, 3.0, 5.5]
    pooled = [Fraction(value) for value in a + b]
    middle = sum(pooled) / 2
    sums = [sum(chosen) - middle for chosen in combinations(pooled, 4)]
    found = permutation_test(a, b)
    assert found.p == sum(abs(each) >= abs(sums[0]) for each in sums) / 70 < 1.0
    assert found.p_greater == sum(each >= sums[0] for each in sums) / 70
    assert found.p_less == sum(each <= sums[0] for each in sums) / 70
    assert permutation_test(a, b, exact_limit=10, seed=1).p == pytest.approx(found.p, abs=4 * 0.0036)


def test_nothing_to_shuffle():
    empty = permutation_test([], [1.0, 2.0])
    says(empty.sentence(), "group a is")
    apart = permutation_test([1.0, 2.0], [3.0, 4.0], ["mon", "mon"], ["tue", "tue"])
    assert isinstance(apart.p, Undefined)
    says(apart.sentence(), "no day holds")
    assert permutation_test([0.1] * 3, [0.1] * 7).p == 1.0
    assert "no day" in bootstrap_difference([1.0, 2.0], [3.0, 4.0], ["mon", "mon"], ["tue", "tue"]).sentence()
    for days in ((["mon"], None), (["mon"] * 3, ["mon"] * 2)):
        with pytest.raises(InputRefused):
            permutation_test([1.0, 2.0], [3.0, 4.0], *days)


def test_bootstrap_is_scipys_bca():
    rng = np.random.default_rng(11)
    a, b = rng.exponential(2.0, 30), rng.normal(1.0, 1.0, 25)
    found = bootstrap_difference(a, b, resamples=40_000, seed=1)
    other = scipy.stats.bootstrap(
        (a, b),
        lambda x, y, axis: np.mean(x, axis) - np.mean(y, axis),
        n_resamples=40_000,
        method="BCa",
        vectorized=True,
        rng=np.random.default_rng(2),
    )
    assert found.difference == pytest.approx(a.mean() - b.mean())
    assert found.se == pytest.approx(other.standard_error, rel=0.02)
    ends = other.confidence_interval
    assert found.bca_interval == pytest.approx((ends.low, ends.high), abs=0.05 * found.se)
    assert found == bootstrap_difference(a, b, resamples=40_000, seed=1)
    assert "studentised bootstrap" in found.sentence("a", "b", "J")


def test_the_studentised_interval_is_efrons_and_not_its_mirror_image():
    """By the definition on draws of its own: difference - t* se at both quantiles of t*; a is skewed."""
    a = -2.0 * np.log1p(-(np.arange(12) + 0.5) / 12.0)  # quantiles of an exponential distribution
    b = np.linspace(0.5, 1.5, 10)
    rng = np.random.default_rng(5)
    drawn_a, drawn_b = a[rng.integers(0, 12, (40_000, 12))], b[rng.integers(0, 10, (40_000, 10))]
    se = (a.var(ddof=1) / 12 + b.var(ddof=1) / 10) ** 0.5
    errors = (drawn_a.var(axis=1, ddof=1) / 12 + drawn_b.var(axis=1, ddof=1) / 10) ** 0.5
    difference = a.mean() - b.mean()
    low, high = np.quantile((drawn_a.mean(axis=1) - drawn_b.mean(axis=1) - difference) / errors, [0.025, 0.975])
    found = bootstrap_difference(a, b, resamples=40_000, seed=1)
    assert found.interval == pytest.approx((difference - high * se, difference - low * se), abs=0.1 * se)
    assert high + low < -0.8  # the mirror image lies further off than the draws differ


def test_bootstrap_within_days_leaves_out_what_days_differ_by():
    rng = np.random.default_rng(4)
    day = np.repeat([1, 2, 3], 10)
    a, b = rng.normal(1.0, 1.0, 30) + 100.0 * day, rng.normal(0.0, 1.0, 30) + 100.0 * day
    found = bootstrap_difference(a, b, day, day)
    assert found.se == pytest.approx((2.0 / 30.0) ** 0.5, rel=0.3)
    assert found.interval[0] < found.difference < found.interval[1]
    scaled = bootstrap_difference(np.ldexp(a, -300), np.ldexp(b, -300), day, day)
    assert np.ldexp(scaled.interval, 300) == pytest.approx(found.interval, rel=1e-12)


def test_bootstrap_of_constants_has_a_difference_only():
    found = bootstrap_difference([0.3] * 4, [0.6] * 4)
    assert found.difference == pytest.approx(-0.3)
    assert isinstance(found.interval, Undefined)
    says(found.sentence(), "no bootstrap interval")
    by_day = bootstrap_difference([0.3] * 4, [0.6] * 4, [1] * 4, [1] * 4)
    says(by_day.sentence(), "do not scatter")


@pytest.mark.parametrize("test", [permutation_test, bootstrap_difference])
def test_values_of_days_that_one_group_has_enter_nothing_and_are_counted(test):
    days = list("1122")
    shared = test([1, 2, 4, 5], [2, 3, 7, 8], days, days)
    found = test([1, 2, 4, 5], [2, 3, 7, 8, 100, 200], days, [*days, "3", "3"])
    assert (found.n_a, found.n_b, found.unused_a, found.unused_b) == (4, 6, 0, 2)
    assert (found.n_days, found.difference) == (2, shared.difference)
    says(found.sentence(), "n = 4", "6", "0", "2", "and not used")
    says(shared.sentence(), "n = 4", "and")
    nothing = test([1, 2], [3, 4, 5], [1, 1], [2, 2, 2])
    assert (nothing.unused_a, nothing.unused_b) == (2, 3)
    says(nothing.sentence(), "n = 2", "3", "no day holds")


def test_one_drawn_arrangement_is_told_in_the_singular():
    found = permutation_test([1, 2, 3], [4, 5, 7], resamples=1, exact_limit=1)
    says(found.sentence(), "1 random")
