"""What is simulated of conditions over days: with the day in the model, and by methods that know none."""

from __future__ import annotations

import math

import numpy as np
import pytest

from benchmarks.stats_evidence.sizes.method import standard_error
from data_schema.vocabulary import Undefined
from stats.days.blocked import blocked_by_day
from tests.helpers.recorded_rates import EVERY


def test_day_means_hold_the_level_that_pooled_values_do_not():
    for row in EVERY:
        if row.method == "blocked_by_day_exact" and row.sd_ratio == 1.0:
            assert abs(row.value - 0.05) < 4.0 * standard_error(0.05, row.runs)
    pooled = [
        (row.n[0] // row.days, row)
        for row in EVERY
        if row.days and row.method == "student" and row.layout == "own" and row.sd_ratio == 1.0
    ]
    assert all(row.value > 0.17 for times, row in pooled if times >= 3)
    assert all(abs(row.value - 0.05) < 4.0 * row.standard_error for times, row in pooled if times == 1)


def test_conditions_of_one_day_each_get_no_p_at_all():
    found = blocked_by_day(np.arange(8.0) ** 2, [0, 1] * 4, [0, 1] * 4)
    assert isinstance(found.p, Undefined)
    assert not [row for row in EVERY if row.method.startswith("blocked") and (row.days, row.layout) == (1, "own")]


def weak_by_sd_ratio(method, k, days, layout):
    """Return the weak shares of groups of five values a day."""
    design = (method, (5 * days,) * k, days, layout)
    return {row.sd_ratio: row for row in EVERY if (row.method, row.n, row.days, row.layout) == design and row.weak}


@pytest.mark.parametrize("method", ["equivalence", "equivalence_percent", "welch", "f_then_t", "one_way_anova"])
def test_one_day_in_common_leaves_a_test_that_errs_too_often(method):
    k = 3 if method == "one_way_anova" else 2
    for days in (2, 3, 6):
        partly, own = (weak_by_sd_ratio(method, k, days, layout) for layout in ("partly", "own"))
        assert set(partly) | {2.0} == set(own) == {1.0, 2.0}
        assert all(0.06 < partly[ratio].value < own[ratio].value for ratio in partly)


@pytest.mark.parametrize("method", ["equivalence", "equivalence_percent", "welch", "f_then_t", "one_way_anova"])
def test_one_day_that_is_not_in_common_still_tells_with_ten_values_a_day(method):
    k = 3 if method == "one_way_anova" else 2
    there = {
        (row.layout, row.days, row.n[0] // row.days): row.value
        for row in EVERY
        if (row.method, row.n, row.sd_ratio) == (method, row.n[:1] * k, 1.0) and row.layout in ("partly", "mostly")
    }
    for days in range(3, 7):
        for times in (3, 5, 10):
            assert there["mostly", days, times] < there["partly", days, times]
        assert there["mostly", days, 10] > 0.08
    assert max(there["mostly", days, 3] for days in (4, 5, 6)) < 0.06


@pytest.mark.parametrize(
    "method",
    [
        *("difference_ci_welch", "difference_ci_student", "difference_ci_f_then_t", "hedges_g_ci"),
        *("fieller", "delta", "log_ratio"),
    ],
)
def test_intervals_miss_the_truth_on_days_that_groups_do_not_share(method):
    for days in (2, 6):
        partly, own = (weak_by_sd_ratio(method, 2, days, layout) for layout in ("partly", "own"))
        assert set(partly) | {2.0} == set(own) == {1.0, 2.0}
        assert all(own[ratio].value < partly[ratio].value < 0.93 for ratio in partly)


def test_two_conditions_by_day_are_on_record_as_a_report_compares_them():
    there = {
        (row.kind, row.layout, row.days): row
        for row in EVERY
        if (row.n, row.sd_ratio) == ((10 * (row.days or 0),) * 2, 1.0)
        and row.method in ("blocked_by_day", "blocked_by_day_ci")
    }
    assert {key[1:] for key in there} == {
        *((layout, days) for layout in ("shared", "own", "partly") for days in range(2, 7)), ("shared", 1),
        *(("mostly", days) for days in range(3, 7)),
    }  # fmt: skip
    exact = {(row.layout, row.days) for row in EVERY if row.method == "blocked_by_day_exact" and len(row.n) == 2}
    assert exact == {key[1:] for key in there if key[1] in ("shared", "own")}
    for (kind, layout, days), row in there.items():
        if kind == "size":  # a condition's interval leaves out 0 where its test rejects
            interval = there["coverage", layout, days]
            error = math.hypot(row.standard_error, interval.standard_error)
            assert abs(row.value + interval.value - 1.0) < 4.0 * error


@pytest.mark.parametrize("method", ["tukey", "games_howell", "dunnett", "holm", "welch_anova", "eta_squared_ci"])
def test_methods_of_several_groups_take_days_for_groups_unless_all_share_them(method):
    there = {
        (row.layout, row.days, row.n[0] // row.days): abs(row.value - row.nominal) if row.weak else 0.0
        for row in EVERY
        if row.method == method and row.days and row.sd_ratio == 1.0 and len(set(row.n)) == 1
    }
    for days in range(2, 7):
        assert there["own", days, 5] > there["partly", days, 5] > 0.06
    many_a_day = method == "eta_squared_ci"  # days count as scatter of the values, and not of the means
    assert not any(
        off for (layout, _days, times), off in there.items() if layout == "shared" and not (many_a_day and times == 25)
    )


@pytest.mark.parametrize(
    ("method", "groups"),
    [("f_test", 2), ("bartlett", 2), ("bartlett", 3), ("brown_forsythe", 2), ("brown_forsythe", 3)],
)
def test_days_of_their_own_pass_for_unequal_variances(method, groups):
    there = {
        (row.layout, row.days): row
        for row in EVERY
        if row.method == method and row.days and row.n == (5 * row.days,) * groups and row.sd_ratio == 1.0
    }
    assert all(there["own", days].value > 0.09 for days in range(2, 7))
    assert not [row for (layout, days), row in there.items() if row.weak and (layout == "shared" or days == 1)]
