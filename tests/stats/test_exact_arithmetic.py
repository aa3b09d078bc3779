"""Every statistic of random values at offsets up to 1e15 against rational arithmetic on the same doubles."""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from itertools import combinations, pairwise

import mpmath
import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy import special
from stats.compare.resampling import permutation_test
from stats.days.blocked import blocked_by_day

from stats.compare.equivalence import equivalence
from stats.compare.savings import percent_savings
from stats.compare.summary import autocorrelation, describe
from stats.groups.anova import welch_anova
from stats.groups.dunnett import dunnett
from stats.groups.residuals import rmse_over_iqr
from stats.groups.tukey import compare_all_pairs, range_tail
from stats.groups.variances import bartlett, brown_forsythe, f_test, levene

Exact = list[Fraction]
OFFSETS = st.sampled_from([0.0, 1e3, 1e6, 1e9, 1e12, 1e14, 1e15])


@st.composite
def three_groups(draw: st.DrawFn) -> list[list[float]]:
    offset, rng = draw(OFFSETS), np.random.default_rng(draw(st.integers(0, 2**32)))
    groups = [(rng.normal(place, rng.choice([1.0, 4.0]), rng.integers(3, 12)) + offset).tolist() for place in range(3)]
    assume(all(len(set(group)) > 2 for group in groups))
    return groups


def exact(values: Sequence[float]) -> Exact:
    return [Fraction(value) for value in values]


def mean(values: Exact) -> Fraction:
    return sum(values) / len(values)


def squares(values: Exact) -> Fraction:
    middle = mean(values)
    return sum((x - middle) ** 2 for x in values)


def variance(values: Exact) -> Fraction:
    return squares(values) / (len(values) - 1)


def root(value: Fraction) -> mpmath.mpf:
    with mpmath.workdps(50):
        return mpmath.sqrt(mpmath.mpf(value.numerator) / value.denominator)


def f_of(groups: Sequence[Exact]) -> Fraction:
    n, k = sum(map(len, groups)), len(groups)
    grand = sum(map(sum, groups)) / n
    between = sum(len(group) * (mean(group) - grand) ** 2 for group in groups)
    return between / (k - 1) / (sum(map(squares, groups)) / (n - k))


def same(found: object, right: Fraction | mpmath.mpf, rel: float = 1e-14) -> bool:
    return found == pytest.approx(float(right), rel=rel, abs=1e-300)


@given(three_groups())
def test_moments_and_series(groups):
    a = exact(groups[0])
    found, middle = describe(groups[0]), mean(a)
    assert found.mean == float(middle)
    assert same(found.sd, root(variance(a)))
    products = [(x - middle) * (y - middle) for x, y in pairwise(a)]
    off = Fraction(autocorrelation(groups[0]).r) - sum(products) / squares(a)
    assert abs(off) <= 1e-15 * float(sum(map(abs, products)) / squares(a))


@given(three_groups())
def test_variances(groups):
    parts = [exact(group) for group in groups]
    named = dict(zip("abc", groups, strict=True))
    assert same(f_test(*groups[:2]).statistic, variance(parts[0]) / variance(parts[1]))
    spreads = [[abs(x - mean(part)) for x in part] for part in parts]
    assert same(levene(named).statistic, f_of(spreads), rel=1e-13)
    medians = [(sorted(part)[(len(part) - 1) // 2] + sorted(part)[len(part) // 2]) / 2 for part in parts]
    spreads = [[abs(x - middle) for x in part] for part, middle in zip(parts, medians, strict=True)]
    assert same(brown_forsythe(named).statistic, f_of(spreads), rel=1e-13)
    dfs = [len(part) - 1 for part in parts]
    pooled = sum(map(squares, parts)) / sum(dfs)
    with mpmath.workdps(50):
        logs = [2 * mpmath.log(root(variance(part) / pooled)) for part in parts]
        top = -mpmath.fsum(df * log for df, log in zip(dfs, logs, strict=True))
        right = top / (1 + (mpmath.fsum(mpmath.mpf(1) / df for df in dfs) - mpmath.mpf(1) / sum(dfs)) / 6)
    assert same(bartlett(named).statistic, right, rel=1e-13)


@given(three_groups())
def test_several_groups(groups):
    parts = [exact(group) for group in groups]
    named = dict(zip("abc", groups, strict=True))
    weights = [len(part) / variance(part) for part in parts]
    total = sum(weights)
    grand = sum(w * mean(part) for w, part in zip(weights, parts, strict=True)) / total
    doubt = sum((1 - w / total) ** 2 / (len(part) - 1) for w, part in zip(weights, parts, strict=True))
    above = sum(w * (mean(part) - grand) ** 2 for w, part in zip(weights, parts, strict=True)) / 2
    found = welch_anova(named)
    assert same(found.f, above / (1 + doubt / 4), rel=1e-13)
    assert same(found.df_within, Fraction(8) / (3 * doubt), rel=1e-13)
    within = sum(map(squares, parts)) / (sum(map(len, parts)) - 3)
    for tukey, howell, (a, b) in zip(
        compare_all_pairs(named).pairs,
        compare_all_pairs(named, variances="unequal").pairs,
        combinations(parts, 2),
        strict=True,
    ):
        gap = abs(mean(a) - mean(b))
        assert same(tukey.q, gap / root(within * (Fraction(1, len(a)) + Fraction(1, len(b))) / 2))
        of_a, of_b = variance(a) / len(a), variance(b) / len(b)
        assert same(howell.q, gap / root((of_a + of_b) / 2))
        assert howell.p == pytest.approx(range_tail(howell.q, 3, howell.df).p, rel=1e-12)
        assert same(howell.df, (of_a + of_b) ** 2 / (of_a**2 / (len(a) - 1) + of_b**2 / (len(b) - 1)))
    for each, part in zip(dunnett(groups[0], {"b": groups[1], "c": groups[2]}).comparisons, parts[1:], strict=True):
        se = root(within * (Fraction(1, len(part)) + Fraction(1, len(parts[0]))))
        assert same(each.t, (mean(part) - mean(parts[0])) / se)


@given(three_groups())
def test_bounds_and_savings(groups):
    a, b = exact(groups[0]), exact(groups[1])
    of_a, of_b = variance(a) / len(a), variance(b) / len(b)
    found = equivalence(groups[0], groups[1], low=-1.5, high=2.0)
    difference = mean(a) - mean(b)
    assert same(found.welch.t_low, (difference + Fraction(3, 2)) / root(of_a + of_b), rel=1e-13)
    assert same(found.welch.t_high, (difference - 2) / root(of_a + of_b), rel=1e-13)
    percent = equivalence(groups[0], [x + 50.0 for x in groups[1]], low=-5.0, high=5.0, bounds="percent").welch
    control = mean(exact([x + 50.0 for x in groups[1]]))
    low = Fraction(-5.0 * 0.01)
    of_control = variance(exact([x + 50.0 for x in groups[1]])) / len(b)
    slope = 1 + low
    assert same(percent.t_low, (mean(a) - slope * control) / root(of_a + slope**2 * of_control), rel=1e-12)
    saved = percent_savings([x + 50.0 for x in groups[0]], [x + 50.0 for x in groups[1]])
    c, t = exact([x + 50.0 for x in groups[0]]), exact([x + 50.0 for x in groups[1]])
    assert same(saved.percent, 100 * (mean(c) - mean(t)) / mean(c))
    quantile = Fraction(-float(special.stdtrit(saved.df, 0.025)))
    of_c, of_t = quantile**2 * variance(c) / len(c), quantile**2 * variance(t) / len(t)
    bottom, middle = mean(c) ** 2 - of_c, mean(c) * mean(t)
    if bottom > 0:
        wide = root(middle**2 - bottom * (mean(t) ** 2 - of_t))
        with mpmath.workdps(60):
            ends = [100 * (1 - (middle + side * wide) / bottom) for side in (1, -1)]
        assert saved.percent_ci == pytest.approx([float(end) for end in ends], rel=1e-12, abs=1e-20)


@given(OFFSETS, st.integers(0, 2**32))
def test_days_held_fixed(offset, seed):
    """Three conditions twice on each of four days: the exact test's residual is that of an additive model."""
    rng = np.random.default_rng(seed)
    values = rng.normal(size=(4, 3, 2)) + 2.0 * rng.normal(size=(4, 1, 1)) + offset
    condition, day = np.tile(np.repeat(np.arange(3), 2), 4), np.repeat(np.arange(4), 6)
    numbers = [[exact(cell) for cell in each] for each in values.tolist()]
    flat = [x for each in numbers for cell in each for x in cell]
    grand = mean(flat)
    of_days = [mean([x for cell in each for x in cell]) for each in numbers]
    of_conditions = [mean([x for each in numbers for x in each[place]]) for place in range(3)]
    between = sum(8 * (middle - grand) ** 2 for middle in of_conditions)
    residual = sum((x - grand) ** 2 for x in flat) - between - sum(6 * (middle - grand) ** 2 for middle in of_days)
    assume(residual > 0)
    found = blocked_by_day(values.ravel(), condition, day).exact
    assert found.df_within == 18
    assert same(found.f, (between / 2) / (residual / 18), rel=1e-12)


@given(three_groups())
def test_errors_in_quartile_ranges(groups):
    n = min(map(len, groups))
    a, b = exact(groups[0][:n]), exact(groups[1][:n])
    ordered = sorted(a)
    ends = []
    for share in (Fraction(1, 4), Fraction(3, 4)):
        place = share * (n - 1)
        below = math.floor(place)
        ends.append(ordered[below] + (place - below) * (ordered[min(below + 1, n - 1)] - ordered[below]))
    assume(ends[1] > ends[0])
    rmse = root(sum((x - y) ** 2 for x, y in zip(a, b, strict=True)) / n)
    found = rmse_over_iqr(groups[0][:n], groups[1][:n])
    assert same(found.rmse, rmse)
    assert same(found.ratio, rmse / (ends[1] - ends[0]), rel=1e-13)


@given(st.lists(st.integers(-8, 8), min_size=8, max_size=8), st.integers(-(2**50), 2**50), st.integers(-40, 0))
def test_permutations(numbers, offset, exponent):
    values = [math.ldexp(x + offset, exponent) for x in numbers]
    found = permutation_test(values[:4], values[4:])
    centre = mean(exact(values))
    scores = [x - centre for x in exact(values)]
    sums = [abs(sum(chosen)) for chosen in combinations(scores, 4)]
    assert found.p == sum(each >= sums[0] for each in sums) / 70
