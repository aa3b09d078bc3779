import math

import numpy as np
import pytest
import scipy.stats

from data_schema.errors import InputRefused, UnknownName
from data_schema.vocabulary import Undefined
from stats.compare.two_sample import compare_two
from stats.groups.tukey import (
    VARIANCES,
    compare_all_pairs,
    log_range_chance,
    log_range_tails,
    range_critical,
    range_criticals,
    range_tail,
    range_tails,
)

GROUPS = {"0": [42.1, 39.8, 44.0], "50": [36.9, 38.2, 35.1, 37.7], "100": [37.0, 39.5]}


def upper(q, k, df):
    return range_tail(q, k, df).p


@pytest.mark.parametrize(("q", "df"), [(20.0, 30), (15.0, 20), (40.0, 60)])
def test_the_integral_that_serves_many_means_keeps_the_far_tail_of_two(q, df):
    """W9: scipy gives 3.7e-15 for 8.3e-15, and 3.6e-15 for 2.2e-36; two means have the tail of t."""
    (integral,) = log_range_tails(np.array([q]), 2, np.array([df]))
    assert math.exp(integral) == pytest.approx(range_tail(q, 2, df).p, rel=1e-13)


def by_gauss(q, k, df):
    """The definition by other nodes: Gauss and Legendre over s and z, the difference of powers taken as it stands."""
    nodes, widths = np.polynomial.legendre.leggauss(160)
    s, s_weights = 2.5 * (nodes + 1.0), 2.5 * widths
    density = 2.0 * (df / 2.0) ** (df / 2.0) / math.gamma(df / 2.0) * s ** (df - 1.0) * np.exp(-df * s * s / 2.0)
    z = q * s[:, None] / 2.0 + 10.0 * nodes
    phi, cdf = scipy.stats.norm.pdf, scipy.special.ndtr
    inner = k * phi(z) * (cdf(z) ** (k - 1) - (cdf(z) - cdf(z - q * s[:, None])) ** (k - 1))
    return float(s_weights @ (density * (inner @ (10.0 * widths))))


@pytest.mark.parametrize(("q", "k", "df"), [(3.5, 3, 4), (1.0, 5, 20), (4.5, 10, 7), (6.0, 30, 60)])
def test_the_range_agrees_with_its_definition(q, k, df):
    assert upper(q, k, df) == pytest.approx(by_gauss(q, k, df), rel=1e-12)


def test_one_value_by_forty_digits():
    """From mpmath's nested quadrature of the definition: 0.139553991358530 for q = 3.5, k = 3, df = 4."""
    assert upper(3.5, 3, 4) == pytest.approx(0.13955399135853046, rel=1e-13)


@pytest.mark.parametrize(("k", "df"), [(3, 30), (5, 60), (20, 8)])
def test_the_far_tail_of_many_means_lies_within_bounds(k, df):
    """Of all pairs' tails the sum is an upper bound, close in the far tail: scipy has lost all digits there."""
    q = 40.0 if df > 8 else 2000.0
    pairs = k * (k - 1) / 2.0 * upper(q, 2, df)
    assert pairs * (0.5 if df > 8 else 0.05) < upper(q, k, df) < pairs


@pytest.mark.parametrize(
    ("tail", "k", "df", "table"), [(0.05, 3, 10, 3.877), (0.01, 5, 20, 5.294), (0.05, 2, 5, 3.635)]
)
def test_critical_values_are_those_of_the_tables(tail, k, df, table):
    critical = range_critical(tail, k, df)
    assert critical == pytest.approx(table, abs=1e-3)
    assert upper(critical, k, df) == pytest.approx(tail, rel=1e-12)


@pytest.mark.parametrize("variances", VARIANCES)
def test_two_groups_are_the_t_test(variances):
    a, b = GROUPS["0"], GROUPS["50"]
    (pair,) = compare_all_pairs({"a": a, "b": b}, variances=variances).pairs
    test = compare_two(a, b, route="student" if variances == "equal" else "welch")
    assert (pair.p, pair.df, pair.difference) == pytest.approx((test.p, test.df, test.difference), rel=1e-13)
    assert pair.q == pytest.approx(math.sqrt(2.0) * abs(test.t))
    assert pair.difference_ci == pytest.approx(test.difference_ci, rel=1e-11)


@pytest.mark.parametrize("variances", VARIANCES)
def test_the_interval_excludes_0_just_where_p_is_below_alpha(variances):
    found = compare_all_pairs(GROUPS, variances=variances, level=0.9)
    for pair in found.pairs:
        assert (pair.difference_ci[0] > 0.0 or pair.difference_ci[1] < 0.0) == (pair.p < 0.1)
        assert pair.log10_p == pytest.approx(math.log10(pair.p), abs=1e-13)
    assert [(pair.a, pair.b) for pair in found.pairs] == [("0", "50"), ("0", "100"), ("50", "100")]
    assert found.method == ("Tukey-Kramer" if variances == "equal" else "Games-Howell")
    assert f"All pairs by {found.method}" in found.sentence("J")


@pytest.mark.parametrize("k", [2, *(pytest.param(k, marks=pytest.mark.soak) for k in (3, 40))])
def test_pairs_integrated_together_are_those_integrated_alone(k):
    """Games and Howell's pairs have their own degrees of freedom each: none leans on which others stand beside it."""
    dfs = (*np.geomspace(1.0, 1e6, 150).tolist(), math.inf)
    qs = [0.0, *np.geomspace(1e-3, 1e5, 148), 1e200, 4.0]
    tails, criticals = range_tails(qs, k, dfs), range_criticals(0.05, k, dfs)
    for q, df, tail, critical in list(zip(qs, dfs, tails, criticals, strict=True))[::7]:
        alone = range_tail(q, k, df)
        assert (tail.p, tail.log10_p) == pytest.approx((alone.p, alone.log10_p), rel=1e-14)
        assert critical == pytest.approx(range_critical(0.05, k, df), rel=1e-14)
        assert upper(critical, k, df) == pytest.approx(0.05, rel=1e-12)


@pytest.mark.parametrize("variances", VARIANCES)
def test_constants_have_no_test(variances):
    """W3: scipy's tukey_hsd gives p = 0.020 for groups of 0.1 alone."""
    found = compare_all_pairs({"a": [0.1] * 3, "b": [0.1] * 7, "c": [0.1] * 5}, variances=variances)
    assert all(isinstance(pair.p, Undefined) and pair.difference == 0.0 for pair in found.pairs)
    apart = compare_all_pairs({"a": [0.3] * 3, "b": [0.6] * 3}, variances=variances).pairs[0]
    assert apart.difference == pytest.approx(-0.3)
    assert "scatter" in apart.q.reason


def test_wrong_input():
    with pytest.raises(InputRefused, match="group 'b'"):
        compare_all_pairs({"a": [1.0, 2.0], "b": [1.0, float("inf")]})
    with pytest.raises(UnknownName, match="equal"):
        compare_all_pairs(GROUPS, variances="equl")
    empty = compare_all_pairs({**GROUPS, "150": []})
    assert all("'150' is empty" in pair.p.reason for pair in empty.pairs)
    assert "No pairs" in compare_all_pairs({"a": [1.0]}).sentence()
    single = compare_all_pairs({"a": [1.0], "b": [1.0, 2.0, 4.0]}, variances="unequal").pairs[0]
    assert "single value" in single.p.reason
    assert compare_all_pairs({"a": [1.0], "b": [1.0, 2.0, 4.0]}).pairs[0].df == 2.0


@pytest.mark.parametrize("k", [2, 30, 100, 1000, 100_000])
def test_the_range_of_many_normals(k):
    """Gauss's rule on stretches of a quarter, where the trapezoidal rule at 0.2 lost seven digits for 1000 normals."""
    w = np.array([0.6, 1.5, 3.0, 4.4, 6.0, 9.0])
    nodes, widths = np.polynomial.legendre.leggauss(20)
    z = (np.arange(-9.5, 20.0, 0.25)[:, None] + 0.125 * (1.0 + nodes)).ravel()[:, None]
    phi, cdf = np.exp(-0.5 * z * z) / math.sqrt(2.0 * math.pi), scipy.special.ndtr(z)
    inside = np.log1p(-np.minimum(scipy.special.ndtr(z - w) / cdf, 1.0 - 2.0**-53))
    f = k * phi * np.exp((k - 1) * scipy.special.log_ndtr(z)) * -np.expm1((k - 1) * inside)
    g = 0.125 * np.tile(widths, 118) @ f
    np.testing.assert_allclose(np.exp(log_range_chance(w, k)), g, rtol=1e-13)
