"""Every number of 60 random tables is that of scipy, statsmodels or R's formulas, to 1e-9."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import pytest
import scipy.stats
import statsmodels.api as sm
from numpy.typing import NDArray
from statsmodels.stats.inter_rater import cohens_kappa, to_table
from statsmodels.stats.multitest import multipletests
from statsmodels.stats.power import FTestAnovaPower, TTestIndPower

import stats
from data_schema.vocabulary import Undefined

SAME = {"rel": 1e-9, "abs": 1e-300}


@dataclass(frozen=True)
class Table:
    """Groups of a size and scatter of their own, far from 0 or near it."""

    groups: dict[str, NDArray[np.float64]]

    @classmethod
    def drawn(cls, seed: int) -> Table:
        rng = np.random.default_rng(seed)
        offset = float(rng.choice([0.0, 40.0, 1e4, 1e6]))
        unit = float(10.0 ** rng.integers(-6, 6))
        sizes = rng.integers(3, 15, size=int(rng.integers(2, 6)))
        return cls(
            {
                f"g{place}": unit * (offset + rng.normal(rng.normal(0.0, 1.0), rng.uniform(0.5, 3.0), n))
                for place, n in enumerate(sizes)
            }
        )

    @property
    def samples(self) -> list[NDArray[np.float64]]:
        return list(self.groups.values())

    @property
    def centred(self) -> list[NDArray[np.float64]]:
        """Libraries are given what is about 0, where their sums keep their digits."""
        middle = float(np.concatenate(self.samples).mean())
        return [values - middle for values in self.samples]


TABLES = pytest.mark.parametrize("table", [Table.drawn(seed) for seed in range(60)], ids=range(60))


@TABLES
def test_t_and_f_of_two_groups(table: Table) -> None:
    (a, b), (x, y) = table.samples[:2], table.centred[:2]
    for route, equal in (("student", True), ("welch", False)):
        found, right = stats.compare_two(a, b, route), scipy.stats.ttest_ind(x, y, equal_var=equal)
        assert (found.t, found.df, found.p) == pytest.approx((right.statistic, right.df, right.pvalue), **SAME)
        assert found.difference_ci == pytest.approx(tuple(right.confidence_interval(0.95)), **SAME)
    thesis = stats.compare_two(a, b, "f_then_t")
    ratio = float(x.var(ddof=1) / y.var(ddof=1))
    one_side = scipy.stats.f(a.size - 1, b.size - 1)
    p = 2.0 * min(one_side.sf(ratio), one_side.cdf(ratio))
    assert (thesis.f, thesis.f_p) == pytest.approx((ratio, p), **SAME)
    assert thesis.test == ("Student" if p >= 0.05 else "Welch")
    pooled = math.sqrt(((a.size - 1) * x.var(ddof=1) + (b.size - 1) * y.var(ddof=1)) / (a.size + b.size - 2))
    half = (a.size + b.size - 2) / 2.0
    factor = math.exp(math.lgamma(half) - math.lgamma(half - 0.5)) / math.sqrt(half)
    assert thesis.hedges_g == pytest.approx(factor * (x.mean() - y.mean()) / pooled, **SAME)


@TABLES
def test_analyses_of_variance(table: Table) -> None:
    for analyse, equal in ((stats.one_way_anova, True), (stats.welch_anova, False)):
        found, right = analyse(table.groups), scipy.stats.f_oneway(*table.centred, equal_var=equal)
        assert (found.f, found.p) == pytest.approx((right.statistic, right.pvalue), **SAME)
    dummies = np.repeat(np.eye(len(table.samples)), [values.size for values in table.samples], axis=0)[:, 1:]
    model = sm.OLS(np.concatenate(table.centred), sm.add_constant(dummies)).fit()
    classic = stats.one_way_anova(table.groups)
    assert classic.eta_squared == pytest.approx(model.rsquared, **SAME)
    assert classic.ss_within == pytest.approx(model.ssr, **SAME)
    assert classic.residual_sd == pytest.approx(math.sqrt(model.mse_resid), **SAME)


@TABLES
def test_equal_variances(table: Table) -> None:
    found, right = stats.brown_forsythe(table.groups), scipy.stats.levene(*table.centred, center="median")
    assert (found.statistic, found.p) == pytest.approx((right.statistic, right.pvalue), **SAME)


@pytest.mark.parametrize("seed", [*(pytest.param(seed, marks=pytest.mark.soak) for seed in range(0, 60, 6)), 3, 17])
def test_all_pairs(seed: int) -> None:
    """In a soak of more tables: scipy integrates a quarter of a second for each end of each interval."""
    table = Table.drawn(seed)
    for variances, equal in (("equal", True), ("unequal", False)):
        right = scipy.stats.tukey_hsd(*table.centred, equal_var=equal)
        found = stats.compare_all_pairs(table.groups, variances=variances).pairs
        for pair in found:
            at = int(pair.a[1:]), int(pair.b[1:])
            assert (pair.difference, pair.p) == pytest.approx(
                (right.statistic[at], right.pvalue[at]), rel=1e-9, abs=1e-12
            )
        first = found[0]
        half = scipy.stats.studentized_range.ppf(0.95, len(table.samples), first.df) * abs(first.difference) / first.q
        assert first.difference_ci == pytest.approx((first.difference - half, first.difference + half), rel=1e-9)


@TABLES
def test_holm_describe_and_lines(table: Table) -> None:
    control, *others = table.samples
    p = {str(place): stats.compare_two(values, control).p for place, values in enumerate(others)}
    family = stats.holm(p, "against the control")
    assert family.adjusted_p == pytest.approx(tuple(multipletests(list(p.values()), method="holm")[1]), **SAME)
    summary, (low, high) = stats.describe(control), scipy.stats.t.interval(0.95, control.size - 1)
    se = scipy.stats.sem(table.centred[0])
    assert (summary.mean, summary.sd, summary.se) == pytest.approx((control.mean(), control.std(ddof=1), se), **SAME)
    assert summary.ci_high - summary.ci_low == pytest.approx((high - low) * se, **SAME)
    y, x = table.centred[0], np.linspace(0.0, 3.0, control.size) ** 2
    z = np.sin(np.arange(control.size) * 1.7)
    line, right = stats.fit_linear(y, {"x": x}), scipy.stats.linregress(x, y)
    assert (line.coefficients[1], line.standard_errors[1], line.p[1]) == pytest.approx(
        (right.slope, right.stderr, right.pvalue), **SAME
    )
    if control.size > 4:
        plane, model = stats.fit_linear(y, {"x": x, "z": z}), sm.OLS(y, sm.add_constant(np.column_stack([x, z]))).fit()
        assert plane.coefficients == pytest.approx(model.params.tolist(), **SAME)
        assert plane.standard_errors == pytest.approx(model.bse.tolist(), **SAME)
        assert plane.p == pytest.approx(model.pvalues.tolist(), **SAME)
        assert plane.r_squared == pytest.approx(model.rsquared, **SAME)
        assert [end for ends in plane.ci for end in ends] == pytest.approx(model.conf_int().ravel().tolist(), **SAME)
        there, at = model.get_prediction([[1.0, 2.0, 0.3]]), plane.at({"x": 2.0, "z": 0.3})
        assert (at.value, at.se) == pytest.approx((there.predicted_mean[0], there.se_mean[0]), **SAME)


@pytest.mark.parametrize("seed", range(60))
def test_power(seed: int) -> None:
    rng = np.random.default_rng(seed)
    difference, sd, alpha = float(rng.uniform(0.2, 2.0)), float(rng.uniform(0.5, 2.0)), float(rng.choice([0.05, 0.01]))
    n_a, n_b = (int(n) for n in rng.integers(2, 40, 2))
    for sides, alternative in ((2, "two-sided"), (1, "larger")):
        found = stats.power_t(difference, sd, n_a, n_b, alpha, sides).power
        right = TTestIndPower().power(difference / sd, n_a, alpha, n_b / n_a, alternative=alternative)
        assert found == pytest.approx(right, rel=1e-9)
    assert stats.power_welch(difference, sd, sd, n_a, n_a, alpha).power == pytest.approx(
        stats.power_t(difference, sd, n_a, n_a, alpha).power, rel=1e-9
    )
    means = rng.normal(0.0, 0.5, 4)
    found = stats.power_anova(means, sd, n_a, alpha).power
    effect = math.sqrt(float(np.mean((means - means.mean()) ** 2))) / sd
    assert found == pytest.approx(FTestAnovaPower().power(effect, 4 * n_a, alpha, 4), rel=1e-9)


@pytest.mark.parametrize("seed", range(60))
def test_the_kappa_of_two_people_is_that_of_statsmodels(seed: int) -> None:
    rng = np.random.default_rng(seed)
    answers = np.array(["accept", "reject", "move", "add"][: int(rng.integers(2, 5))])
    n = int(rng.integers(len(answers), 200))
    first = np.concatenate([np.arange(answers.size), rng.integers(0, answers.size, n)])  # each answer is given
    second = np.where(rng.random(first.size) < rng.random(), first, rng.integers(0, answers.size, first.size))
    found = stats.cohen_kappa(answers[first].tolist(), answers[second].tolist(), level=0.9)
    right = cohens_kappa(to_table(np.column_stack([first, second]), bins=answers.size)[0], return_results=True)
    assert found.kappa == pytest.approx(right.kappa, **SAME)
    assert found.n == first.size == sum(map(sum, found.counts))
    if isinstance(found.se, Undefined):
        assert right.std_kappa == pytest.approx(0.0, abs=1e-7)
        return
    assert found.se == pytest.approx(right.std_kappa, rel=1e-7)
    half_width = scipy.stats.norm.ppf(0.95) * right.std_kappa
    ends = (max(right.kappa - half_width, -1.0), min(right.kappa + half_width, 1.0))
    assert found.ci == pytest.approx(ends, rel=1e-7)


def test_what_kappa_does_not_tell() -> None:
    never = stats.cohen_kappa([], [])
    once = stats.cohen_kappa(["accept"] * 5, ["accept"] * 5)
    all_alike = stats.cohen_kappa(["accept", "reject"], ["accept", "reject"])
    none_alike = stats.cohen_kappa(["accept", "reject"], ["reject", "accept"])
    assert isinstance(never.kappa, Undefined)
    assert isinstance(once.kappa, Undefined)  # chance agrees as well
    assert (once.agreed, once.expected) == (1.0, 1.0)
    assert (all_alike.kappa, none_alike.kappa) == (1.0, -1.0)
    assert isinstance(all_alike.ci, Undefined)
    assert isinstance(none_alike.ci, Undefined)
