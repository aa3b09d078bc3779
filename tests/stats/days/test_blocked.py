"""Conditions over days, against R's lmerTest, emmeans and lm on thirty designs, and where others go wrong."""

from __future__ import annotations

import csv
from collections import defaultdict
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import statsmodels.api as sm
from hypothesis import given
from hypothesis import strategies as st

from data_schema.vocabulary import Undefined
from stats.compare.two_sample import compare_two
from stats.days.blocked import blocked_by_day
from stats.days.blocked_result import BlockedByDay, ExactTest
from tests.helpers.shared_days import crossed
from tests.helpers.wording import says

R = Path(__file__).parents[1] / "r"


def read(name: str) -> dict[str, list[dict[str, str]]]:
    rows: dict[str, list[dict[str, str]]] = defaultdict(list)
    with (R / name).open() as file:
        for row in csv.DictReader(file):
            rows[row["design"]].append(row)
    return rows


DATA, EXPECTED, OF_LINEAR_MODELS = read("blocked_data.csv"), read("blocked.csv"), read("blocked_by_others.csv")
ROUNDING_ONLY = "zero_both"
"""Its run means differ by the rounding of its values alone: car refuses them."""
WITH_EXACT = (
    "balanced",
    "unbalanced",
    "nested_balanced",
    "nested_one_run",
    "nested_shared_runs",
    "confounded_balanced",
)


@cache
def fitted(design: str) -> BlockedByDay:
    rows = DATA[design]
    runs = [row["run"] for row in rows]
    return blocked_by_day(
        [float(row["value"]) for row in rows],
        [row["condition"] for row in rows],
        [row["day"] for row in rows],
        runs if any(runs) else None,
    )


def numbers(found: BlockedByDay) -> dict[tuple[str, str], float]:
    told = {
        ("variance", "day"): found.day_variance,
        ("variance", "run"): found.run_variance,
        ("variance", "residual"): found.residual_variance,
        ("criterion", ""): found.reml_criterion,
        ("f", ""): found.mixed.f,
        ("df_within", ""): found.mixed.lmertest_df_within,
        ("p_of_f", ""): found.mixed.lmertest_p,
    }
    for each in found.mixed.contrasts:
        of = each.condition
        told |= {
            ("difference", of): each.difference,
            ("difference_se", of): each.se,
            ("difference_df", of): each.df,
            ("t", of): each.t,
            ("p", of): each.p,
            ("difference_low", of): each.interval[0],
            ("difference_high", of): each.interval[1],
        }
    for mean in found.conditions:
        of = mean.condition
        told |= {
            ("mean", of): mean.estimate,
            ("mean_se", of): mean.se,
            ("mean_df", of): mean.df,
            ("mean_low", of): mean.interval[0],
            ("mean_high", of): mean.interval[1],
        }
    return told


@pytest.mark.parametrize("design", DATA)
def test_agrees_with_lmertest(design):
    told = numbers(fitted(design))
    for row in EXPECTED[design]:
        key = row["quantity"], row["of"]
        assert told[key] == pytest.approx(float(row["value"]), rel=1e-6, abs=1e-12), key


@pytest.mark.parametrize("design", DATA)
def test_the_exact_test_is_that_of_a_linear_model(design):
    """With what it holds fixed as a factor."""
    exact = fitted(design).exact
    if isinstance(exact, Undefined) or design == ROUNDING_ONLY:
        assert not design.startswith(WITH_EXACT)
        return
    r = {(row["quantity"], row["of"]): float(row["value"]) for row in OF_LINEAR_MODELS[design]}
    layout = f"{exact.unit}/{exact.block}"
    assert exact.df_within == r["exact_df", layout]
    assert (exact.f, exact.p) == pytest.approx((r["exact_f", layout], r["exact_p", layout]), rel=1e-11)
    for each in exact.contrasts:
        of = f"{layout}:{each.condition}"
        assert each.t == pytest.approx(r["exact_t", of], rel=1e-11, abs=1e-12)
        assert each.p == pytest.approx(r["exact_p_of_t", of], rel=1e-11)
        assert each.interval == pytest.approx((r["exact_low", of], r["exact_high", of]), rel=1e-11, abs=1e-12)


def test_thirty_designs():
    assert len(DATA) == len(EXPECTED) == 30


def test_zero_day_variance_pools_days_and_keeps_the_exact_test_beside():
    found = fitted("zero_day_balanced")
    assert (found.day_variance, found.singular) == (0.0, True)
    assert found.mixed.df_within == pytest.approx(57.0)
    assert isinstance(found.exact, ExactTest)
    assert found.exact.df_within == found.df_within == 54
    assert found.exact.f == found.f < found.mixed.f


@pytest.mark.parametrize(("days", "times"), [(5, 4), (3, 5)])
def test_w23_few_days_are_not_infinitely_many(days, times):
    """W23: MixedLM's z-test gives a p of less than 0.6 of the true one, as if there were infinitely many days."""
    rng = np.random.default_rng(days)
    condition, day = crossed(2, days, times)
    values = rng.normal(size=condition.size) + 1.2 * condition + rng.normal(0.0, 2.0, days)[day]
    found = blocked_by_day(values, condition, day)
    design = sm.add_constant(condition.astype(float))
    other = sm.MixedLM(values, design, groups=day).fit(reml=True)
    assert isinstance(found.exact, ExactTest)
    assert found.p == found.exact.p == pytest.approx(found.mixed.p, rel=1e-8)
    assert found.mixed.contrasts[0].difference == pytest.approx(other.fe_params[1], rel=1e-6)


def test_w23_days_that_do_not_differ_are_no_failure():
    """W23: MixedLM does not converge, or its matrix is singular, where the days' variance is 0."""
    condition, day = crossed(2, 3, 4)
    values = np.tile([1.0, 2.0, 3.0, 5.0, 2.0, 4.0, 3.5, 5.5], 3)
    found = blocked_by_day(values, condition, day)
    assert found.day_variance == 0.0
    assert found.mixed.df_within == pytest.approx(22.0)


def test_w24_every_value_of_every_day_counts():
    """W24: rm_anova averages replicates (df 10 for 54 values) and drops a day for one missing cell (df 8)."""
    rng = np.random.default_rng(1)
    condition, day = crossed(3, 6, 3)
    values = rng.normal(size=54) + rng.normal(size=6)[day]
    whole = blocked_by_day(values, condition, day)
    assert (whole.n, whole.mixed.df_within) == (54, pytest.approx(46.0))
    kept = ~((condition == 2) & (day == 4))
    found = blocked_by_day(values[kept], condition[kept], day[kept])
    assert (found.n, found.n_days) == (51, 6)
    assert isinstance(found.exact, ExactTest)
    assert found.exact.df_within == 43
    assert found.df_within == pytest.approx(43.0, abs=1.0)


def test_conditions_on_their_own_days_are_compared_by_day_means():
    found = fitted("confounded_balanced")
    assert isinstance(found.exact, ExactTest)
    assert (found.exact.unit, found.exact.df_within) == ("day mean", 6)
    rows = DATA["confounded_balanced"]
    means = {
        label: [
            np.mean([float(r["value"]) for r in rows if r["day"] == d])
            for d in sorted({r["day"] for r in rows if r["condition"] == label})
        ]
        for label in "ab"
    }
    student = compare_two(means["b"], means["a"], route="student")
    assert found.exact.contrasts[0].p == pytest.approx(student.p, rel=1e-10)
    assert found.mixed.p == pytest.approx(student.p, rel=1e-8)
    says(found.sentence(), "each day counts")
    alone = blocked_by_day([1.0, 1.2, 1.5, 1.6, 2.0, 2.3], list("aaaabb"), [1, 1, 2, 2, 3, 3])
    says(alone.confounding.text, "had one day")
    assert alone.contrasts[0].df < 2.0


@given(st.integers(0, 29), st.integers(-500, 500), st.integers(-(2**20), 2**20), st.integers(0, 99))
def test_shift_scale_and_order_leave_p_as_it_is(number, exponent, shift, seed):
    rows = DATA[list(DATA)[number]]
    values = np.round(np.array([float(row["value"]) for row in rows]) * 1024.0)
    named = [name for name in ("condition", "day", "run") if rows[0][name]]
    labels = np.array([[row[name] for name in named] for row in rows])
    order = np.random.default_rng(seed).permutation(len(rows))
    one = blocked_by_day(values, *labels.T)
    other = blocked_by_day(np.ldexp(values + shift, exponent)[order], *labels[order].T)
    assert (other.f, other.df_within, other.p) == pytest.approx((one.f, one.df_within, one.p), rel=1e-13)
    assert other.mixed.p == pytest.approx(one.mixed.p, rel=1e-13)
    for kind in ("contrasts", "paired"):
        for a, b in zip(getattr(one, kind), getattr(other, kind), strict=True):
            if not isinstance(a.t, Undefined):
                assert (b.t, b.df, b.p) == pytest.approx((a.t, a.df, a.p), rel=1e-13)
