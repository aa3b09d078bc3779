"""One policy for missing values: refused, or left out by rows and counted; and input of any type that holds numbers."""

from __future__ import annotations

import math
from collections.abc import Callable
from decimal import Decimal
from fractions import Fraction
from typing import Any

import numpy as np
import pandas as pd
import pytest
from stats.compare.resampling import bootstrap_difference, permutation_test
from stats.days.blocked import blocked_by_day

from data_schema.errors import InputRefused, UnknownName
from stats.compare.equivalence import equivalence
from stats.compare.savings import percent_savings
from stats.compare.shared_error import SharedError, describe_shared
from stats.compare.summary import describe
from stats.compare.two_sample import compare_two
from stats.groups.anova import one_way_anova, welch_anova
from stats.groups.dunnett import dunnett
from stats.groups.residuals import additive_residuals, residuals_of_groups, rmse_over_iqr
from stats.groups.tukey import compare_all_pairs
from stats.groups.variances import bartlett, brown_forsythe, f_test, levene
from stats.lines.passive_drain import fit_passive_drain
from stats.lines.regression import fit_linear, fit_polynomial
from stats.lines.stiffness import fit_gain_line, fit_stiffness
from stats.results import Result
from tests.helpers.wording import refuses, says
from tests.stats.test_all_results import OF_CHECKED_INPUT, functions

A, B = [42.1, 39.8, 44.0, 41.2, 40.7, 43.3], [36.9, 38.2, 35.1, 37.7, 39.9, 34.0]
DAYS = ["mon", "tue", "wed", "mon", "tue", "wed"]
LONG = np.random.default_rng(3).normal(size=(3, 300)).tolist()
Values = Any
Call = Callable[..., Any]
TWO: dict[str, Call] = {
    "describe": lambda a, _b, **policy: describe(a, **policy),
    "compare_two": compare_two,
    "f_test": f_test,
    "bartlett": lambda a, b, **policy: bartlett({"a": a, "b": b}, **policy),
    "levene": lambda a, b, **policy: levene({"a": a, "b": b}, **policy),
    "brown_forsythe": lambda a, b, **policy: brown_forsythe({"a": a, "b": b}, **policy),
    "one_way_anova": lambda a, b, **policy: one_way_anova({"a": a, "b": b}, **policy),
    "welch_anova": lambda a, b, **policy: welch_anova({"a": a, "b": b}, **policy),
    "compare_all_pairs": lambda a, b, **policy: compare_all_pairs({"a": a, "b": b}, **policy),
    "dunnett": lambda a, b, **policy: dunnett(a, {"b": b}, **policy),
    "equivalence": lambda a, b, **policy: equivalence(a, b, low=-9.0, high=9.0, **policy),
    "percent_savings": percent_savings,
    "describe_shared": lambda a, _b, **policy: describe_shared(a, SharedError(), **policy),
    "permutation_test": permutation_test,
    "bootstrap_difference": bootstrap_difference,
    "residuals_of_groups": lambda a, b, **policy: residuals_of_groups({"a": a, "b": b}, **policy),
}
"""Functions of independent samples."""
ROWS: dict[str, Call] = {
    "blocked_by_day": lambda a, b, **policy: blocked_by_day(
        a, np.asarray(b, dtype=float) > 37.0, DAYS[: len(a)], **policy
    ),
    "fit_linear": lambda a, b, **policy: fit_linear(a, {"b": b}, **policy),
    "fit_polynomial": lambda a, b, **policy: fit_polynomial(a, b, 2, **policy),
    "fit_passive_drain": lambda a, b, **policy: fit_passive_drain(a, b, **policy),
    "fit_gain_line": lambda a, b, **policy: fit_gain_line(a, b, **policy),
    "rmse_over_iqr": rmse_over_iqr,
    "additive_residuals": lambda a, b, **policy: additive_residuals(
        a, np.asarray(b, dtype=float) > 37.0, DAYS[: len(a)], **policy
    ),
}
"""Functions of values that belong together by rows."""
NO_SAMPLES = {
    "autocorrelation",
    "bayes_factor",
    "difference_with_shared",
    "force_points",
    "holm",
    "normal_quantiles",
    "power_anova",
    "power_equivalence",
    "power_by_day",
    "power_equivalence_by_day",
    "power_percent_equivalence",
    "power_t",
    "power_welch",
    "sample_size",
}
"""Functions of single numbers, of plans, of residuals, and of a series in time, whose gaps are no missing values."""


def test_every_function_of_samples_has_the_policy():
    public = {name for name, _kind in functions()} - OF_CHECKED_INPUT
    assert public - NO_SAMPLES == set(TWO) | set(ROWS) | {"fit_stiffness"}


def left_out(result: Any) -> int:
    if hasattr(result, "missing"):
        return int(result.missing)
    if hasattr(result, "fit"):
        return left_out(result.fit)
    if hasattr(result, "scatter"):
        return left_out(result.scatter)
    return int(result.missing_a + result.missing_b)


def without_count(result: Any) -> dict[str, Any]:
    data = dict(result.to_dict())
    for name in ("fit", "scatter"):
        data[name] = {key: value for key, value in data.get(name, {}).items() if not key.startswith("missing")}
    return {name: value for name, value in data.items() if not name.startswith("missing")}


def by_turns(a: Values, b: Values, **policy: Any) -> Any:
    return blocked_by_day([*a, *b], ["a"] * 6 + ["b"] * 6, DAYS * 2, **policy)


def left_by_turns(a: Values, b: Values, **policy: Any) -> Any:
    return additive_residuals([*a, *b], ["a"] * 6 + ["b"] * 6, DAYS * 2, **policy)


BY_TURNS: dict[str, Call] = {"blocked_by_day": by_turns, "additive_residuals": left_by_turns}


@pytest.mark.parametrize("name", TWO)
def test_samples_are_refused_or_left_out_and_counted(name):
    function, gap = TWO[name], math.nan
    with refuses(InputRefused, "1", "7 values"):
        function([*A[:2], gap, *A[2:]], B)
    found = function([*A[:2], gap, *A[2:]], B, missing="drop")
    assert left_out(found) == 1
    assert without_count(found) == without_count(function(A, B))
    says(found.sentence(), "1 missing")


@pytest.mark.parametrize("name", [name for name in ROWS if name not in BY_TURNS])
def test_rows_are_refused_or_left_out_and_counted(name):
    function, gap = ROWS[name], None
    a, b = [*A[:2], gap, *A[2:], 50.0], [*B[:2], 30.0, *B[2:], gap]
    with pytest.raises(InputRefused, match="NaN"):
        function(a, b)
    found = function(a, b, missing="drop")
    assert left_out(found) == 2
    assert without_count(found) == without_count(function(A, B))
    assert isinstance(found, Result)
    says(found.sentence(), "2 missing")


@pytest.mark.parametrize("name", [*TWO, *ROWS])
def test_infinite_values_are_refused_whatever_is_done_with_missing_ones(name):
    function = {**TWO, **ROWS}[name]
    for policy in ("refuse", "drop"):
        with pytest.raises(InputRefused):
            function([*A[:5], -math.inf], B, missing=policy)
    with refuses(UnknownName, "'drop'"):
        function(A, B, missing="drpp")


def test_planes():
    x, v, force = (list(column) for column in LONG)
    clean = fit_stiffness(x[1:], v[1:], force[1:])
    x[0] = math.nan
    assert without_count(fit_stiffness(x, v, force, missing="drop")) == without_count(clean)
    assert fit_stiffness(x, v, force, missing="drop").missing == 1


@pytest.mark.parametrize(
    "gap", [None, math.nan, pd.NA, math.inf, -np.float32("inf"), Decimal("inf"), "", " "], ids=repr
)
def test_labels_that_are_missing_are_no_day_of_their_own(gap):
    values, condition, run = [*A, *B], ["ad"] * 6 + ["ce"] * 6, [1, 1, 1, 2, 2, 2] * 2
    clean = blocked_by_day(values, condition, DAYS * 2, run)
    for place in range(3):
        labels = [[*condition, "ad"], [*DAYS, *DAYS, "mon"], [*run, 1]]
        labels[place][-1] = gap
        with refuses(InputRefused, "13 labels", "position 13", "missing="):
            blocked_by_day([*values, 99.0], *labels)
        found = blocked_by_day([*values, 99.0], *labels, missing="drop")
        assert (found.missing, found.n) == (1, 12)
        assert without_count(found) == without_count(clean)
        says(found.sentence(), "n = 12", "1 missing")
        if place < 2:
            left = additive_residuals([*values, 99.0], *labels[:2], missing="drop")
            assert without_count(left) == without_count(additive_residuals(values, condition, DAYS * 2))
            says(left.sentence(), "n = 12", "1 missing")
    for function in (permutation_test, bootstrap_difference):
        with refuses(InputRefused, "that are missing"):
            function([*A, 99.0], B, [*DAYS, gap], DAYS)
        found = function([*A, 99.0], B, [*DAYS, gap], DAYS, missing="drop")
        assert without_count(found) == without_count(function(A, B, DAYS, DAYS))
        assert found.missing == 1


def test_labels_that_are_masked_or_no_time():
    values, days = [*A, *B, 99.0], [*DAYS, *DAYS, "mon"]
    clean = blocked_by_day([*A, *B], ["ad"] * 6 + ["ce"] * 6, DAYS * 2)
    masked = np.ma.masked_array(["ad"] * 6 + ["ce"] * 6 + ["xy"], mask=[0] * 12 + [1])
    assert without_count(blocked_by_day(values, masked, days, missing="drop")) == without_count(clean)
    times = np.array(["2024-05-06"] * 12 + ["NaT"], dtype="datetime64[ns]")
    with refuses(InputRefused, "13 labels"):
        blocked_by_day(values, ["ad"] * 6 + ["ce"] * 7, times)


def test_masks_and_frames():
    masked = np.ma.masked_array([*A, 1.0], mask=[0] * 6 + [1])
    assert compare_two(masked, B, missing="drop").missing_a == 1
    frame = pd.DataFrame({"y": pd.array([*B, None], dtype="Float64"), "x": [*A, 7.0]})
    assert fit_linear(frame["y"], {"x": frame["x"]}, missing="drop") == fit_linear(
        [*B, None], {"x": [*A, 7.0]}, missing="drop"
    )
    assert fit_linear(masked, {"x": [*B, 3.0]}, missing="drop").coefficients == fit_linear(A, {"x": B}).coefficients


@pytest.mark.parametrize("name", [*TWO, "rmse_over_iqr"])
@pytest.mark.parametrize(
    "bad", [[True, False, True], [1.0, "two", 3.0], [1j, 2.0, 3.0]], ids=["truth", "text", "complex"]
)
def test_what_is_no_real_number_is_refused(name, bad):
    with pytest.raises(InputRefused):
        {**TWO, **ROWS}[name](bad, B[:3])


OFFSET = 10**15
TENTHS_A, TENTHS_B = [4, 13, 26, 9, 31, 17], [22, 8, 45, 33, 51, 40]


def shares(result: Any) -> list[float]:
    """What an offset does not change of a result."""
    names = ("p", "welch_p", "f", "statistic", "ratio", "r_squared", "se", "sd")
    result = getattr(result, "scatter", result)
    found = [getattr(result, name) for name in names if isinstance(getattr(result, name, None), float)]
    for pairs in ("pairs", "comparisons"):
        found += [each.p for each in getattr(result, pairs, ())]
    return found


OF_A_MEAN = ("percent_savings", "fit_gain_line", "fit_passive_drain")
"""Shares of a mean, or of values that are near 0 by their nature."""


@pytest.mark.parametrize("kind", [Decimal, Fraction])
@pytest.mark.parametrize("name", [name for name in [*TWO, *ROWS] if name not in OF_A_MEAN])
def test_decimals_keep_their_digits_at_an_offset(name, kind):
    """As doubles, tenths at 1e15 are multiples of 1/8."""
    function = BY_TURNS.get(name) or {**TWO, **ROWS}[name]
    near, far = (
        function(*([kind(offset) + kind(x) / 10 for x in tenths] for tenths in (TENTHS_A, TENTHS_B)))
        for offset in (0, OFFSET)
    )
    assert shares(near)
    assert shares(far) == pytest.approx(shares(near), rel=1e-13)


def test_whole_numbers_beyond_doubles():
    a, b = np.array(TENTHS_A) + 2**61, np.array(TENTHS_B) + 2**61
    assert by_turns(a, b).p == pytest.approx(by_turns(TENTHS_A, TENTHS_B).p, rel=1e-13)
    for function in (permutation_test, compare_two):
        assert function(a, b).p == function(TENTHS_A, TENTHS_B).p
    assert rmse_over_iqr(a, b).ratio == pytest.approx(rmse_over_iqr(TENTHS_A, TENTHS_B).ratio, rel=1e-14)
