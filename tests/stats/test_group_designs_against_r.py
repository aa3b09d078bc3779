"""One-way designs, balanced and clearly unbalanced, by car, emmeans, multcomp and effectsize: r/group_designs.R.

effectsize searches its noncentralities by a simplex that may stop some digits before the tails do: its ends hold to
`SIMPLEX`. Those that R finds by `uniroot` at 1e-13 on sums and integrals of its own hold to `SEARCH`.
"""

import csv
import math
from collections import defaultdict
from functools import lru_cache
from pathlib import Path

import pytest

from stats.compare.effect_size import hedges_factor
from stats.compare.two_sample import compare_two
from stats.groups.anova import one_way_anova, welch_anova
from stats.groups.dunnett import ALTERNATIVES, dunnett
from stats.groups.tukey import compare_all_pairs
from stats.groups.variances import bartlett, brown_forsythe, levene

DATA: dict[str, dict[str, list[float]]] = defaultdict(lambda: defaultdict(list))
R: dict[tuple[str, str], dict[str, float]] = defaultdict(dict)
with (Path(__file__).parent / "r" / "group_designs.csv").open() as rows:
    for row in csv.DictReader(rows):
        if row["method"] == "data":
            DATA[row["case"]][row["name"]].append(float(row["value"]))
        else:
            R[row["case"], row["method"]][row["name"]] = float(row["value"])
EACH = pytest.mark.parametrize("case", DATA)
DIGITS = 1e-11
SEARCH = 2e-11
SIMPLEX = 1e-5


@lru_cache
def pairs_of(case):
    return compare_all_pairs(DATA[case])


def noncentralities(interval, n):
    """Return lambda from the ends of shares lambda / (lambda + n)."""
    return [end * n / (1.0 - end) for end in interval]


def test_the_designs_are_balanced_and_clearly_unbalanced():
    sizes = {case: sorted(map(len, groups.values())) for case, groups in DATA.items()}
    assert sum(each[0] == each[-1] for each in sizes.values()) == 4
    assert [3, 5, 7, 9, 12] in sizes.values()
    assert len(sizes) == 12


@EACH
@pytest.mark.parametrize(("test", "method"), [(levene, "levene_mean"), (brown_forsythe, "levene_median")])
def test_spreads_are_those_of_car(case, test, method):
    found, r = test(DATA[case]), R[case, method]
    assert (found.statistic, found.p) == pytest.approx((r["f"], r["p"]), rel=DIGITS)


@EACH
def test_bartlett(case):
    """R's statistic is a difference of large logarithms: its last digits are not right."""
    found, r = bartlett(DATA[case]), R[case, "bartlett"]
    assert (found.statistic, found.p) == pytest.approx((r["chi_squared"], r["p"]), rel=DIGITS)


@EACH
def test_anova_is_that_of_car(case):
    found, r = one_way_anova(DATA[case]), R[case, "car_type_2"]
    assert found.df_within == r["df_within"]
    assert (found.ss_between, found.ss_within) == pytest.approx((r["ss_between"], r["ss_within"]), rel=DIGITS)
    assert (found.f, found.p) == pytest.approx((r["f"], r["p"]), rel=DIGITS)


@EACH
def test_shares_of_variance_are_those_of_effectsize(case):
    """effectsize divides lambda by lambda + df_within, not by lambda + n."""
    found, r = one_way_anova(DATA[case]), R[case, "shares"]
    assert found.eta_squared == pytest.approx(r["eta_squared"], rel=DIGITS)
    assert found.omega_squared == pytest.approx(r["omega_squared"], rel=DIGITS)
    ends = noncentralities(found.eta_squared_ci, sum(found.group_ns))
    assert found.omega_squared_ci == found.eta_squared_ci
    assert ends == pytest.approx([r["noncentrality_low"], r["noncentrality_high"]], rel=SEARCH)
    shown = [end / (end + found.df_within) for end in ends]
    assert shown == pytest.approx([r["eta_low"], r["eta_high"]], rel=SIMPLEX, abs=SIMPLEX)


@EACH
def test_welch_and_its_shares_of_variance(case):
    """effectsize takes Welch's df_within for what the classic formulas call n - k; both ways are compared."""
    found, r = welch_anova(DATA[case]), R[case, "welch"]
    f, between, within, n = found.f, found.df_between, found.df_within, sum(found.group_ns)
    assert (f, within, found.p) == pytest.approx((r["f"], r["df_within"], r["p"]), rel=DIGITS)
    assert found.eta_squared == pytest.approx(r["eta_squared"], rel=DIGITS)
    assert found.omega_squared == pytest.approx(r["omega_squared"], rel=DIGITS)
    ends = noncentralities(found.eta_squared_ci, n)
    assert found.omega_squared_ci == found.eta_squared_ci
    assert ends == pytest.approx([r["noncentrality_low"], r["noncentrality_high"]], rel=SEARCH)
    classic = found.eta_squared / (1.0 - found.eta_squared) * (n - between - 1)
    assert classic / (classic + within) == pytest.approx(r["effectsize_eta"], rel=DIGITS)
    above_chance = found.omega_squared / (1.0 - found.omega_squared) * n
    shown = above_chance / (above_chance + between + within + 1.0)
    assert shown == pytest.approx(r["effectsize_omega"], rel=DIGITS)
    assert [end / (end + within) for end in ends] == pytest.approx(
        [r["effectsize_low"], r["effectsize_high"]], rel=SIMPLEX, abs=SIMPLEX
    )


@EACH
def test_all_pairs_are_those_of_emmeans(case):
    """Tukey and Kramer, by R's ptukey and by `uniroot` on it."""
    within = sum(map(len, DATA[case].values())) - len(DATA[case])
    residual_sd = one_way_anova(DATA[case]).residual_sd
    for pair in pairs_of(case).pairs:
        name = f"{pair.a}-{pair.b}"
        assert pair.df == within
        assert pair.difference == pytest.approx(R[case, "emmeans_difference"][name], rel=DIGITS)
        assert pair.q == pytest.approx(math.sqrt(2.0) * abs(R[case, "emmeans_t"][name]), rel=DIGITS)
        assert pair.p == pytest.approx(R[case, "emmeans_p"][name], rel=1e-7, abs=1e-10)
        half = R[case, "emmeans_tukey"]["critical"] * residual_sd * math.sqrt((1 / pair.n_a + 1 / pair.n_b) / 2.0)
        low, high = pair.difference_ci
        assert (high - low) / 2.0 == pytest.approx(half, rel=1e-7)


@EACH
@pytest.mark.parametrize("alternative", ALTERNATIVES)
def test_dunnett_is_that_of_multcomp(case, alternative):
    """multcomp's p to its own estimate of its error, its ends to 0.001 of their level; R's double integral tightly."""
    control, *rest = DATA[case]
    found = dunnett(
        DATA[case][control],
        {name: DATA[case][name] for name in rest},
        control_name=control,
        alternative=alternative,
    )
    side = alternative.replace("_", ".")
    error = 3.0 * R[case, "dunnett_error"][side] + 1e-6
    for each in found.comparisons:
        name = f"{each.treatment} - {control}"
        assert each.t == pytest.approx(R[case, "dunnett_t"][name], rel=DIGITS)
        assert each.p == pytest.approx(R[case, f"dunnett_{side}"][name], abs=error)
        assert each.p == pytest.approx(R[case, f"integrated_{side}"][name], rel=1e-9, abs=1e-13)
        if alternative == "two_sided":
            assert found.critical == pytest.approx(R[case, "integrated"]["critical"], rel=1e-11)
            width = each.ci_high - each.ci_low
            assert each.ci_low == pytest.approx(R[case, "dunnett_low"][name], abs=1e-3 * width)
            assert each.ci_high == pytest.approx(R[case, "dunnett_high"][name], abs=1e-3 * width)


@EACH
def test_the_effect_of_two_groups_is_that_of_effectsize(case):
    control, *rest = DATA[case]
    for name in rest:
        a, b = DATA[case][name], DATA[case][control]
        found, r = compare_two(a, b, route="student"), {key: R[case, key][name] for key in HEDGES}
        factor = hedges_factor(len(a) + len(b) - 2)
        assert found.hedges_g == pytest.approx(r["hedges_g"], rel=DIGITS)
        assert found.hedges_g / factor == pytest.approx(r["cohens_d"], rel=DIGITS)
        per_noncentrality = factor * math.sqrt(1 / len(a) + 1 / len(b))
        ends = [end / per_noncentrality for end in found.hedges_g_ci]
        assert ends == pytest.approx([r["noncentrality_low"], r["noncentrality_high"]], rel=SEARCH, abs=SEARCH)
        assert found.hedges_g_ci == pytest.approx((r["hedges_low"], r["hedges_high"]), rel=SIMPLEX, abs=SIMPLEX)


HEDGES = ("cohens_d", "hedges_g", "hedges_low", "hedges_high", "noncentrality_low", "noncentrality_high")
