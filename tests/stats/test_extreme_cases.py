"""Values from both ends of the range of doubles, each against exact arithmetic or the same values in another unit."""

from __future__ import annotations

import math
from fractions import Fraction
from itertools import combinations

import numpy as np
import pytest

import stats
from data_schema.errors import InputRefused
from data_schema.vocabulary import Undefined
from stats.exact.numbers import exact_root, moments
from stats.exact.quadrature import FAR
from stats.exact.tails import t_quantile
from stats.groups.tukey import range_tail
from tests.helpers.extremes import LEAST, MOST
from tests.helpers.wording import says

TINY, LARGE = [1e-310, 2e-310, 4e-310], [1e200, 3e200, 5e200]
GROUPS = {"tiny": TINY, "small": [3e-200, 5e-200, 9e-200], "large": LARGE, "larger": [1.0e300, 1.1e300, 1.3e300]}


def mean(values: list[float]) -> Fraction:
    return sum(map(Fraction, values)) / len(values)


def error(values: list[float]) -> Fraction:
    """Squared standard error of the mean."""
    middle, n = mean(values), len(values)
    return sum((Fraction(x) - middle) ** 2 for x in values) / (n * (n - 1))


def test_welchs_anova_of_groups_600_orders_apart():
    """It divided by a variance that was 0 beside the others."""
    groups = {**GROUPS, "tiny too": [1e-310, 3e-310, 5e-310]}
    weights = {name: 1 / error(values) for name, values in groups.items()}
    whole, k = sum(weights.values()), len(groups)
    distances = sum(
        weights[a] * weights[b] / whole * (mean(groups[a]) - mean(groups[b])) ** 2 for a, b in combinations(groups, 2)
    )
    doubt = sum((1 - weight / whole) ** 2 / 2 for weight in weights.values())
    f = distances / (k - 1) / (1 + 2 * (k - 2) * doubt / (k * k - 1))
    found = stats.welch_anova(groups)
    assert found.f == pytest.approx(float(f), rel=1e-15)
    assert found.df_within == pytest.approx(float((k * k - 1) / (3 * doubt)), rel=1e-15)
    apart = stats.welch_anova({"a": TINY, "b": [-x for x in TINY], "c": [LEAST * n for n in (1, 2, 4)]})
    assert 0.0 < apart.p < 1.0


@pytest.mark.parametrize("variances", ["equal", "unequal"])
def test_all_pairs_of_such_groups(variances):
    found = stats.compare_all_pairs(GROUPS, variances=variances)
    pooled = sum(error(values) * 6 for values in GROUPS.values()) / 8
    for pair, (a, b) in zip(found.pairs, combinations(GROUPS.values(), 2), strict=True):
        squared = error(a) + error(b) if variances == "unequal" else pooled * Fraction(2, 3)
        q = abs(mean(a) - mean(b)) / exact_root(squared / 2)
        assert pair.q == pytest.approx(float(q), rel=1e-15)
        assert pair.difference == float(mean(a) - mean(b))
        assert 0.0 <= pair.p <= 1.0


def test_a_difference_beyond_the_doubles_is_one_field_of_many():
    top, bottom = [MOST, MOST, 1.6e308], [-MOST, -1.7e308, -1.6e308]
    (pair,) = stats.compare_all_pairs({"a": top, "b": bottom}).pairs
    says(pair.difference.reason, "too large for")
    near = stats.compare_all_pairs({"a": np.ldexp(top, -9), "b": np.ldexp(bottom, -9)}).pairs[0]
    assert (pair.q, pair.p, pair.df) == (near.q, near.p, near.df)
    (against,) = stats.dunnett(bottom, {"a": top}).comparisons
    says(against.difference.reason, "too large for")
    assert against.p == pytest.approx(near.p, rel=1e-12)
    assert "undefined" in stats.dunnett(bottom, {"a": top}).sentence()
    both = stats.equivalence(top, bottom, low=-1.0, high=1.0)
    assert isinstance(both.estimate, Undefined)
    low, high = math.ldexp(-1.0, -9), math.ldexp(1.0, -9)
    assert both.p == stats.equivalence(np.ldexp(top, -9), np.ldexp(bottom, -9), low=low, high=high).p


def test_a_one_sided_comparison_far_on_the_other_side():
    """It asked for exabytes."""
    (found,) = stats.dunnett(
        [6755399441055746.0, 6755399441055744.0], {"b": [1.0, 2.0]}, alternative="greater"
    ).comparisons
    assert found.t == pytest.approx(-6755399441055743.5 / math.sqrt(1.25), rel=1e-14)
    assert found.p == 1.0


@pytest.mark.parametrize(("k", "df"), [(2, 3.0), (3, 1.0), (5, 7.5), (4, 200.0)])
def test_tails_far_out_are_powers(k, df):
    nearer, far, beyond = (range_tail(q, k, df).log10_p for q in (FAR / 2.0**100, FAR, Fraction(FAR) * 2**1200))
    assert beyond == pytest.approx(far - df * 1200 * math.log10(2.0), rel=1e-14)
    assert nearer - far == pytest.approx(df * 100 * math.log10(2.0), rel=1e-13)


def test_analysis_of_variance_at_the_top_of_the_range():
    top = {"a": [1.2e308, 1.5e308, -1e308], "b": [MOST, 1.1e308, 1.4e308], "c": [-1.7e308, 0.0, 1e308]}
    found, near = stats.one_way_anova(top), stats.one_way_anova({k: np.ldexp(v, -900) for k, v in top.items()})
    assert (found.f, found.p, found.eta_squared) == (near.f, near.p, near.eta_squared)
    assert found.residual_sd == math.ldexp(near.residual_sd, 900)
    assert isinstance(found.ss_within, Undefined)
    wide = stats.one_way_anova({"a": [MOST, -MOST], "b": [MOST, -MOST]})
    says(wide.residual_sd.reason, "too large for")


def test_savings_beyond_the_doubles_and_just_within():
    control, treated = [1e-310, 2e-310, 2e-310], [1e200, 2e200, 3e200]
    beyond = stats.percent_savings(control, treated)
    says(beyond.percent.reason, "too large for")
    assert isinstance(beyond.percent_ci, Undefined)
    of_control = (mean(treated) / mean(control)) ** 2 * error(control)
    df = (of_control + error(treated)) ** 2 / (of_control**2 / 2 + error(treated) ** 2 / 2)
    assert beyond.df == pytest.approx(float(df), rel=1e-15)
    control, treated = [3e-200, 5e-200, 4e-200], [1.1e-10, 1e-10, 1.3e-10]
    found = stats.percent_savings(control, treated)
    assert found.percent == pytest.approx(float(100 * (1 - mean(treated) / mean(control))), rel=1e-15)
    assert stats.percent_savings([1e200, 1.1e200, 1.2e200], TINY).percent == 100.0


def test_the_percent_interval_where_values_scatter_by_their_last_digit():
    """The search for its ends began at an estimate that was itself a rounding away."""
    a, b = [3.0, 3.0 + 2**-51, 3.0 + 2**-50], [1.0, 1.0 + 2**-52, 1.0 + 2**-51]
    found = stats.equivalence(a, b, low=-50.0, high=500.0, bounds="percent", route="student")
    squared = Fraction(t_quantile(0.9, 4)) ** 2 * (error(a) + error(b)) / 2
    of_a, of_b = mean(a), mean(b)
    quadratic = of_b**2 - squared
    root = exact_root((of_a * of_b) ** 2 - quadratic * (of_a**2 - squared))
    ends = [float(100 * ((of_a * of_b + side * root) / quadratic - 1)) for side in (-1, 1)]
    assert ends[0] < ends[1]
    assert found.estimate_ci == pytest.approx(ends, rel=3e-16)
    assert found.p == found.student.p_high < 1e-30


def test_shuffled_and_redrawn_at_the_top_of_the_range():
    a, b = [1.7e308, -1.5e308, 1.2e308, 1.6e308], [0.3e308, 1.1e308, 0.4e308, 0.6e308]
    near = [np.ldexp(values, -20) for values in (a, b)]
    found = stats.permutation_test(a, b)
    assert found.p == stats.permutation_test(*near).p
    assert found.difference == math.ldexp(stats.permutation_test(*near).difference, 20)
    drawn, of_near = stats.bootstrap_difference(a, b), stats.bootstrap_difference(*near)
    assert drawn.se == math.ldexp(of_near.se, 20)
    assert isinstance(drawn.interval, Undefined)
    assert drawn.percentile_interval[0] == math.ldexp(of_near.percentile_interval[0], 20)


def test_a_line_is_read_as_far_as_doubles_reach():
    fit = stats.fit_linear([1.0, 3.5, 4.5, 7.0], {"x": [0.0, 1.0, 2.0, 3.0]})
    near, far = fit.at({"x": 1e10}), fit.at({"x": 1e300})
    assert far.value == pytest.approx(1.9e300, rel=1e-13)
    assert far.se / 1e300 == pytest.approx(near.se / 1e10, rel=1e-9)
    beyond = fit.at({"x": MOST})
    assert isinstance(beyond.value, Undefined)
    assert beyond.se == pytest.approx(MOST * fit.standard_errors[1], rel=1e-13)
    parabola = stats.fit_polynomial([0.0, 1.0, 2.0, 3.0], [1.0, 3.5, 4.5, 9.0], 2).at(1e200)
    assert isinstance(parabola.value, Undefined)
    assert isinstance(parabola.ci, Undefined)


def test_quartiles_do_not_depend_on_the_size_of_predictions():
    """Scaled with the predictions, the measured values were all 0."""
    found = stats.rmse_over_iqr([1e-300, 2e-300, 3e-300, 5e-300, 7e-300], [1e100, 0.0, 0.0, 0.0, 0.0])
    assert found.iqr == 5e-300 - 2e-300
    assert found.rmse == pytest.approx(1e100 / math.sqrt(5.0), rel=1e-15)
    assert "too large" in found.ratio.reason
    assert found.quartile_low == 2e-300


def test_a_mean_of_values_that_cancel():
    values = np.array([MOST, -MOST] * 30 + [3e-310])
    assert moments(values).mean == 3e-310 / 61


@pytest.mark.parametrize(
    "call",
    [
        lambda: stats.fit_passive_drain([1.0, 2.0, 4.0], [1e200, 2e200, 5e200]),
        lambda: stats.fit_passive_drain([1.0, 2.0, 4.0], [1e-200, 2e-200, 5e-200]),
        lambda: stats.force_points([0.0, 1e-300], [0.0, 0.0], [0.0, 1e20], 1.0),
        lambda: stats.residuals_of_groups({"a": [MOST, -MOST, -MOST]}),
    ],
)
def test_what_is_whole_or_nothing_is_refused_with_a_sentence(call):
    with pytest.raises(InputRefused, match=r"change units\.$"):
        call()


def test_an_end_of_a_percent_interval_thirty_decades_from_its_first_guess_is_found():
    """At this level the quantile falls by as much between the degrees of freedom of one bound and of the next."""
    a, b, alpha = [0.5, 1.0], [2.0**52 * 1.5] * 3 + [2.0**52 * 1.5 + 1.0], 9e-44
    found = stats.equivalence(a, b, low=-5.0, high=5.0, bounds="percent", alpha=alpha).welch
    assert not isinstance(found.estimate_ci, Undefined)
    variances, dfs = [error(a), error(b)], (1, 3)
    for end, sign in zip(found.estimate_ci, (1, -1), strict=True):
        ratio = 1 + Fraction(end) / 100
        parts = variances[0], ratio**2 * variances[1]
        df = sum(parts) ** 2 / sum(part**2 / own for part, own in zip(parts, dfs, strict=True))
        t = (mean(a) - ratio * mean(b)) / exact_root(sum(parts))
        assert float(sign * t) == pytest.approx(t_quantile(1 - 2 * Fraction(alpha), float(df)), rel=1e-9)
