"""Linear regression: what is refused, exact fits, and the line through the origin over groups with errors all share."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.stats

from data_schema.errors import InputRefused, UnknownName
from data_schema.reasons import Reason
from data_schema.vocabulary import Undefined
from stats.compare.shared_error import SharedError
from stats.lines.regression import fit_linear, slope_through_origin
from tests.helpers.wording import refuses


@pytest.mark.parametrize(
    ("y", "columns", "truth"),
    [
        ([1, 3, 5, 7], {"x": [0, 1, 2, 3]}, (1.0, 2.0)),
        ([2.0, 4.0, 6.0, 8.0, 3.0], {"a": [1.0, 2.0, 3.0, 4.0, 1.5], "b": [1.0, 5.0, 2.0, 9.0, 0.0]}, (0.0, 2.0, 0.0)),
        ([0.3, 0.4, 0.5, 0.6, 0.7], {"x": [1e6 + 3, 1e6 + 4, 1e6 + 5, 1e6 + 6, 1e6 + 7]}, (-99999.99999999999, 0.1)),
    ],
)
def test_of_an_exact_fit_nothing_measures_the_scatter(y: Any, columns: Any, truth: tuple[float, ...]) -> None:
    fit = fit_linear(y, columns)
    assert fit.coefficients == pytest.approx(truth, rel=1e-9, abs=1e-14)
    assert fit.exact
    assert fit.ci == fit.t == fit.p == Undefined(Reason.FIT_EXACT)
    assert set(fit.standard_errors) == {0.0}  # type: ignore[arg-type]
    assert fit.at(dict.fromkeys(columns, 4.5)).ci == fit.ci


@pytest.mark.parametrize("offset", [0.0, 1.7e9])
def test_an_offset_of_a_column_costs_a_slope_no_digit(offset: float) -> None:
    seconds = np.arange(26) * 64.0
    charge = 4.0 - 2.0**-11 * seconds + np.round(np.random.default_rng(16).normal(0.0, 2e-3, 26), 3)
    near, far = fit_linear(charge, {"t": seconds}), fit_linear(charge, {"t": seconds + offset})
    assert far.coefficients[1] == pytest.approx(near.coefficients[1], rel=1e-12)
    assert far.at({"t": offset + 100.0}).value == pytest.approx(near.at({"t": 100.0}).value, rel=1e-12)


@pytest.mark.parametrize("shift", [0.0, 1.0, 0.1])
def test_the_columns_that_are_collinear_are_named(shift: float) -> None:
    x = list(range(8))
    columns = {"x": x, "z": [2 * value + shift for value in x], "w": [3, 1, 4, 1, 5, 9, 2, 6]}
    with refuses(InputRefused, "the columns", "'x'", "'z'") as refusal:
        fit_linear([1, 2, 4, 8, 3, 5, 9, 11], columns)
    assert "'w'" not in str(refusal)


def test_as_many_values_as_coefficients_have_no_standard_error() -> None:
    fit = fit_linear([1.0, 4.0], {"x": [0.0, 1.0]})
    assert fit.coefficients == pytest.approx((1.0, 3.0))
    assert fit.df == 0
    for undefined in (fit.standard_errors, fit.ci, fit.covariance, fit.residual_sd, fit.t, fit.p):
        assert isinstance(undefined, Undefined)
    assert isinstance(fit.at({"x": 0.5}).se, Undefined)
    constant = fit_linear([0.1] * 5, {"x": [1.0, 2.0, 3.0, 4.0, 6.0]})
    assert constant.coefficients == (0.1, 0.0)
    assert isinstance(constant.r_squared, Undefined)


def test_rows_that_lack_a_value_are_refused() -> None:
    y, x = [1.0, 2.0, 4.0, np.nan, 7.0], [1.0, 2.0, 3.0, 4.0, None]
    with pytest.raises(InputRefused, match="NaN"):
        fit_linear(y, {"x": x})


@pytest.mark.parametrize(
    ("y", "columns", "sentence"),
    [
        ([1.0, 2.0], {"x": [1.0, 2.0], "z": [2.0, 1.0]}, "3 coefficients were asked of 2 values"),
        ([1.0, 2.0], {}, "at least one column"),
        ([1.0, 2.0, 3.0], {"x": [1.0, 2.0]}, "the column 'x' has 2 values"),
        ([1.0, 2.0, 4.0], {"x": [1.0, np.inf, 3.0]}, "the column 'x' holds 1 of 3 values"),
        ([1.0, 2.0, 4.0], {"x": ["a", "b", "c"]}, "the column 'x' holds something that is not a number"),
        ([1.0, 2.0, 4.0], {"x": [5.0, 5.0, 5.0]}, "is constant beside an intercept"),
        ([1.0, 2.0, 4.0], {"intercept": [1.0, 2.0, 3.0]}, "name it otherwise"),
        ([1.0, 2.0, 4.0], [[1.0, 2.0, 3.0]], "the columns have no names"),
        ([1e200, 3e200, 2e200], {"x": [1e-200, 2e-200, 3e-200]}, "a coefficient exceeds"),
    ],
)
def test_wrong_input_is_refused_with_its_name(y: Any, columns: Any, sentence: str) -> None:
    with pytest.raises(InputRefused, match=sentence):
        fit_linear(y, columns)


def test_the_response_is_asked_for_with_a_value_of_each_column() -> None:
    rng = np.random.default_rng(9)
    a, b = rng.normal(size=(2, 30)) + 3.0
    fit = fit_linear(1.0 + a - 2.0 * b + rng.normal(size=30), {"a": a, "b": b})
    with refuses(UnknownName, "'c'", "not a known"):
        fit.at({"a": 1.0, "b": 1.0, "c": 1.0})
    with refuses(InputRefused, "no value was", "'b'"):
        fit.at({"a": 1.0})


def test_equal_designs_give_the_mean_of_the_groups_slopes() -> None:
    x, slopes = [45.0, 57.0, 63.0, 67.0], [1.05, 1.07, 1.04, 1.08]
    curve = [1.02, 1.0, 0.99, 1.0]  # the same miss in each group is no scatter
    y = [slope * one * bent for slope in slopes for one, bent in zip(x, curve, strict=True)]
    found = slope_through_origin(x * 4, y, np.repeat(range(4), 4).tolist())
    squares = sum(one * one for one in x)
    of_groups = [slope * sum(b * a * a for a, b in zip(x, curve, strict=True)) / squares for slope in slopes]
    assert found.slope == pytest.approx(np.mean(of_groups))
    assert found.se == pytest.approx(scipy.stats.sem(of_groups))
    half = scipy.stats.t.ppf(0.975, 3) * scipy.stats.sem(of_groups)
    assert found.ci == pytest.approx((found.slope - half, found.slope + half))
    assert (found.groups, found.n, found.shared_se) == (4, 16, 0.0)


def test_slopes_over_groups_of_unequal_size_are_those_of_clubsandwich() -> None:
    """CR2 and Satterthwaite's degrees of freedom: r/slope_over_groups.R."""
    with (Path(__file__).parent.parent / "r" / "slope_over_groups.csv").open() as file:
        rows = list(csv.DictReader(file))
    for design in {row["design"] for row in rows}:
        of_it = [row for row in rows if row["design"] == design]
        data = [row for row in of_it if row["name"] == "data"]
        expected = {row["name"]: float(row["x"]) for row in of_it if row["name"] != "data"}
        x, y = ([float(row[name]) for row in data] for name in "xy")
        found = slope_through_origin(x, y, [row["group"] for row in data])
        assert not isinstance(found.ci, Undefined)
        got = {"slope": found.slope, "se": found.se, "df": found.df, "low": found.ci[0], "high": found.ci[1]}
        assert got == pytest.approx(expected, rel=1e-9), design


def test_an_error_that_all_x_share_widens_the_interval() -> None:
    x = np.array([45.0, 57.0, 63.0, 67.0] * 3)
    y = np.array([48.0, 60.0, 67.0, 72.0, 47.0, 61.0, 66.0, 71.0, 47.5, 60.5, 67.0, 71.0])
    days = np.repeat(range(3), 4).tolist()
    shared = [SharedError({("drain", "level"): 0.3}, {"drain": 6.0})] * 12
    alone, both = slope_through_origin(x, y, days), slope_through_origin(x, y, days, shared)
    step = 1e-6
    moved = slope_through_origin(x + 0.3 * step, y, days).slope - alone.slope
    assert both.shared_se == pytest.approx(abs(moved) / step, rel=1e-4)
    assert not isinstance(both.ci, Undefined)
    assert not isinstance(alone.ci, Undefined)
    assert both.ci[0] < alone.ci[0] < alone.ci[1] < both.ci[1]


@pytest.mark.parametrize(
    ("x", "y", "groups", "slope"),
    [
        ([2.0, 4.0], [3.0, 6.1], ["one", "one"], 30.4 / 20.0),
        ([1e9, 1.0, 1.0], [1e9, 1.1, 0.9], ["a", "b", "c"], 1.0),  # one group alone tells the slope
    ],
)
def test_what_one_group_tells_has_a_slope_and_no_interval(
    x: list[float], y: list[float], groups: list[str], slope: float
) -> None:
    found = slope_through_origin(x, y, groups)
    assert found.slope == pytest.approx(slope)
    assert isinstance(found.ci, Undefined)


def test_what_has_no_slope_is_refused() -> None:
    assert slope_through_origin([1.0, 2.0], [2.0, 4.0], [0, 1]).ci == (2.0, 2.0)  # on the line
    with pytest.raises(InputRefused, match="no slope"):
        slope_through_origin([0.0, 0.0], [1.0, 2.0], [0, 1])
    with pytest.raises(InputRefused, match="as many"):
        slope_through_origin([1.0], [1.0, 2.0], [0, 1])
