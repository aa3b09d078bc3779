"""Linear regression against NIST and exact fits, and the line through the origin over groups with errors all share."""

from __future__ import annotations

import csv
import datetime as dt
import math
from decimal import Decimal
from fractions import Fraction
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import scipy.stats

from data_schema.errors import InputRefused, UnknownName
from data_schema.reasons import Reason
from data_schema.vocabulary import Undefined
from stats.compare.shared_error import SharedError
from stats.lines.columns import as_column
from stats.lines.regression import fit_linear, fit_polynomial, slope_through_origin
from tests.helpers.exact_fit import assert_exact, exact_fit, nist_data, nist_truth, relative_error
from tests.helpers.wording import refuses, says

DEGREES = {"Norris": 1, "Pontius": 2, "Wampler1": 5, "Wampler2": 5, "Wampler3": 5, "Wampler4": 5, "Wampler5": 5}
SETS = ("Norris", "Pontius", "NoInt1", "NoInt2", "Longley", *list(DEGREES)[2:])


def nist_columns(name):
    """The powers of Norris, Pontius and Wampler's x are whole numbers or themselves: exact in doubles."""
    y, *columns = nist_data(name)
    if name in DEGREES:
        columns = [[x**k for x in columns[0]] for k in range(1, DEGREES[name] + 1)]
    return y, {f"x{number}": column for number, column in enumerate(columns, 1)}


@pytest.mark.parametrize("name", SETS)
def test_nist_sets_to_the_last_digit(name):
    """np.linalg.lstsq has 5.8 to 12.3 of these digits, sklearn none of Pontius' and Wampler's."""
    y, columns = nist_columns(name)
    with_intercept = not name.startswith("NoInt")
    fit = fit_linear(y, columns, intercept=with_intercept)
    truth = nist_truth(name)
    first = 0 if with_intercept else 1
    for number, (value, se) in enumerate(zip(fit.coefficients, fit.standard_errors, strict=True), first):
        assert relative_error(value, truth[f"B{number}"]) < 1e-14
        assert relative_error(se, truth[f"se_B{number}"]) < 1e-12
    assert relative_error(fit.r_squared, truth["r_squared"]) < 1e-14
    assert relative_error(fit.residual_sd, truth["residual_sd"]) < 1e-12
    assert relative_error(fit.ss_residual, truth["ss_res"]) < 1e-12
    assert (fit.df_model, fit.df) == (int(truth["df_reg"]), int(truth["df_res"]))
    if truth["ss_res"] == 0:
        assert isinstance(fit.f, Undefined)
        assert isinstance(fit.t, Undefined)
    else:
        assert relative_error(fit.f, truth["F"]) < 1e-12
        assert fit.f_p == pytest.approx(float(truth["p"]), rel=1e-9)


def test_whole_numbers_and_decimals_beyond_doubles_stay_exact():
    y = [Decimal("1000000000000.1"), Decimal("1000000000000.3"), Decimal("1000000000000.2"), Decimal("1000000000000.7")]
    x = [2**70 + 1, 2**70 + 2, 2**70 + 4, 2**70 + 7]
    truth = exact_fit(y, [x])
    assert_exact(fit_linear(y, {"x": x}), truth)
    huge = np.array([2**63 + 1, 2**63 + 3, 2**63 + 4, 2**63 + 9], dtype=np.uint64)
    assert_exact(fit_linear(y, {"x": huge}), exact_fit(y, [huge]))
    thirds = [Fraction(1, 3), Fraction(2, 3), Fraction(1), Fraction(7, 3)]
    assert_exact(fit_linear(y, {"x": thirds}), exact_fit(y, [thirds]))


def test_an_exact_fit_has_no_t_and_no_p():
    fit = fit_linear([1.0, 3.0, 5.0, 7.0], {"x": [0.0, 1.0, 2.0, 3.0]})
    assert (fit.coefficients, fit.standard_errors) == ((1.0, 2.0), (0.0, 0.0))
    assert (fit.ss_residual, fit.residual_sd, fit.r_squared) == (0.0, 0.0, 1.0)
    for undefined in (fit.t, fit.p, fit.f, fit.f_p):
        assert isinstance(undefined, Undefined)
        assert "exact" in undefined.reason


@pytest.mark.parametrize(
    ("y", "columns", "truth"),
    [
        ([1, 2, 3], {"x": [1, 2, 3]}, (0.0, 1.0)),
        ([2.0, 4.0, 6.0, 8.0, 3.0], {"a": [1.0, 2.0, 3.0, 4.0, 1.5], "b": [1.0, 5.0, 2.0, 9.0, 0.0]}, (0.0, 2.0, 0.0)),
        ([Decimal(k) / 10 for k in range(3, 9)], {"x": [Decimal(k) for k in range(3, 9)]}, (0.0, 0.1)),
        ([Fraction(k, 3) - 7 for k in range(3, 9)], {"x": list(range(3, 9))}, (-7.0, 1 / 3)),
        ([k + Fraction(1, 10**30) for k in range(3, 9)], {"x": list(range(3, 9))}, (1e-30, 1.0)),
    ],
)
def test_coefficients_of_an_exact_fit_are_exact(y, columns, truth):
    """Two doubles leave 1e-31 of an intercept of 0. Nothing measures the scatter: no interval, as no test."""
    fit = fit_linear(y, columns)
    assert fit.coefficients == truth
    assert fit.ci == fit.t == Undefined(Reason.FIT_EXACT)
    assert set(fit.standard_errors) == {0.0}
    assert f"no intervals, because {fit.ci.reason}" in fit.sentence()
    assert fit.at(dict.fromkeys(columns, 4.5)).ci == fit.ci


def test_moments_as_response_are_seconds_too():
    """One clock against another: the unit in which a moment is kept is no unit of the results."""
    seconds = np.array([0, 10, 20, 30])
    other = {"x": [0.0, 1.0, 2.0, 3.5]}
    truth = exact_fit(seconds, [other["x"]])
    for unit, ticks in (("s", 1), ("ms", 10**3), ("ns", 10**9)):
        durations = (seconds * ticks).astype(f"timedelta64[{unit}]")
        assert_exact(fit_linear(durations, other), truth)
    since_1970 = exact_fit(seconds + 10**9, [other["x"]])
    stamps = ((seconds + 10**9) * 10**9).astype("datetime64[ns]")
    assert_exact(fit_linear(stamps, other), since_1970)


def test_the_sentence_says_what_time_is_counted_in():
    start = pd.date_range("2020-01-01", periods=5, tz="Europe/Berlin")
    took = pd.to_timedelta([1, 2, 3, 5, 4], unit="min")
    fit = fit_linear([1.0, 2.0, 3.0, 4.0, 6.0], {"start": start, "took": took, "x": [1.0, 0.0, 0.0, 2.0, 1.0]})
    says(fit.sentence(), "n = 5", "start in s", "1970 UTC")
    moments = [np.datetime64("2020-01-01"), np.datetime64("2020-01-03"), np.datetime64("2020-01-04")]
    of_response = fit_linear(moments, {"y": [1.0, 2.0, 4.0]})
    assert (of_response.times, of_response.response_time) == ((), "s since 1970 UTC")
    says(of_response.sentence("take-off"), "n = 3", "take-off in s", "1970 UTC")
    assert fit_linear([1.0, 2.0, 4.0], {"y": moments}).times == ("y in s since 1970 UTC",)
    assert fit_polynomial(moments, [1.0, 2.0, 4.0], 1).times == ("x in s since 1970 UTC",)
    numbers = fit_linear([1.0, 2.0, 4.0], {"x": [1, 2, 3]})
    assert (numbers.times, numbers.response_time) == ((), None)


def test_durations_of_python_and_of_pandas_are_seconds():
    seconds, y = [1.0, 2.0, 4.5], [3.0, 5.0, 9.0]
    plain = fit_linear(y, {"took": seconds})
    for kind in (dt.timedelta, pd.Timedelta):
        fit = fit_linear(y, {"took": [kind(seconds=one) for one in seconds]})
        assert fit.coefficients == pytest.approx(plain.coefficients, rel=1e-14)
        assert fit.times == ("took in s",)


def test_an_interval_beyond_doubles_is_missed_with_its_reason():
    fit = fit_linear([1e308, -1e308, 1.2e308, 1.5e308], {"x": [1, 2, 3, 4]})
    assert isinstance(fit.ci, Undefined)
    assert f"no intervals, because {fit.ci.reason}" in fit.sentence()


@pytest.mark.parametrize("shift", [0, 1])
def test_the_columns_that_are_collinear_are_named(shift):
    x = list(range(8))
    columns = {"x": x, "z": [2 * value + shift for value in x], "w": [3, 1, 4, 1, 5, 9, 2, 6]}
    with refuses(InputRefused, "the columns", "'x'", "'z'"):
        fit_linear([1, 2, 4, 8, 3, 5, 9, 11], columns)


def test_as_many_values_as_coefficients_have_no_standard_error():
    fit = fit_linear([1.0, 4.0], {"x": [0.0, 1.0]})
    assert fit.coefficients == (1.0, 3.0)
    assert fit.df == 0
    for undefined in (fit.standard_errors, fit.ci, fit.covariance, fit.residual_sd, fit.t, fit.p, fit.f, fit.f_p):
        assert isinstance(undefined, Undefined)
    says(fit.sentence(), "values as coefficients")
    assert isinstance(fit.at({"x": 0.5}).se, Undefined)


def test_a_constant_response_has_no_r_squared():
    fit = fit_linear([0.1] * 5, {"x": [1.0, 2.0, 3.0, 4.0, 6.0]})
    assert fit.coefficients == (0.1, 0.0)
    assert isinstance(fit.r_squared, Undefined)
    assert isinstance(fit.p, Undefined)


@pytest.mark.parametrize(
    ("y", "columns", "sentence"),
    [
        ([1.0, 2.0], {"x": [1.0, 2.0], "z": [2.0, 1.0]}, "3 coefficients were asked of 2 values"),
        ([], {"x": []}, "2 coefficients were asked of 0 values"),
        ([1.0, 2.0], {}, "at least one column"),
        ([1.0, 2.0, 3.0], {"x": [1.0, 2.0]}, r"the column 'x' has the shape \(2,\)"),
        ([1.0, 2.0, np.nan], {"x": [1.0, 2.0, 3.0]}, "y holds 1 of 3 values that are NaN"),
        ([1.0, 2.0, 4.0], {"x": [1.0, np.inf, 3.0]}, "the column 'x' holds 1 of 3 values that are infinite"),
        ([1.0, 2.0, 4.0], {"x": ["a", "b", "c"]}, "the column 'x' holds something that is not a number"),
        ([1.0, 2.0, 4.0], {"x": [1j, 2, 3]}, "the column 'x'"),
        ([1.0, 2.0, 4.0], {"intercept": [1.0, 2.0, 3.0]}, "name it otherwise"),
        ([1.0, 2.0, 4.0], {"x": np.array(["2020-01-01", "NaT", "2020-01-03"], "datetime64[D]")}, "NaT"),
        ([[1.0, 2.0, 4.0]], {"x": [[1.0, 2.0, 3.0]]}, "2 dimensions"),
        ([1.0, 2.0, 4.0], {"x": [10**400, 1, 2]}, "beyond 1.8e308"),
    ],
)
def test_wrong_input_is_refused_with_its_name(y, columns, sentence):
    with pytest.raises(InputRefused, match=sentence):
        fit_linear(y, columns)


def test_vif_and_condition_are_those_of_their_definitions():
    rng = np.random.default_rng(8)
    a, b, c = rng.normal(size=(3, 50))
    c = c + a
    fit = fit_linear(a + b, {"a": a, "b": b, "c": c})
    for number, (one, others) in enumerate([(a, [b, c]), (b, [a, c]), (c, [a, b])]):
        on_others = fit_linear(one, {str(k): other for k, other in enumerate(others)})
        assert fit.vif[number] == pytest.approx(1.0 / (1.0 - on_others.r_squared), rel=1e-12)
    centred = np.column_stack([np.ones(50), a - a.mean(), b - b.mean(), c - c.mean()])
    assert fit.condition == pytest.approx(np.linalg.cond(centred / np.linalg.norm(centred, axis=0)), rel=1e-12)


def test_the_response_at_a_place_has_the_error_of_the_mean_response():
    sm = pytest.importorskip("statsmodels.api")
    rng = np.random.default_rng(9)
    a, b = rng.normal(size=(2, 30)) + 3.0
    y = 1.0 + a - 2.0 * b + rng.normal(size=30)
    fit = fit_linear(y, {"a": a, "b": b})
    model = sm.OLS(y, sm.add_constant(np.column_stack([a, b]))).fit()
    prediction = model.get_prediction([[1.0, 2.5, 9.0]])
    found = fit.at({"a": 2.5, "b": 9.0})
    assert found.value == pytest.approx(prediction.predicted_mean[0], rel=1e-12)
    assert found.se == pytest.approx(prediction.se_mean[0], rel=1e-10)
    assert found.ci == pytest.approx(tuple(prediction.conf_int()[0]), rel=1e-10)
    assert found.extrapolated
    assert not fit.at({"a": 2.5, "b": 3.0}).extrapolated
    assert np.array(fit.covariance) == pytest.approx(model.cov_params(), rel=1e-10)
    assert fit.ci == tuple(pytest.approx(tuple(row), rel=1e-9) for row in model.conf_int())
    assert fit.p == pytest.approx(tuple(model.pvalues), rel=1e-8)
    assert fit.f_p == pytest.approx(model.f_pvalue, rel=1e-8)
    through_origin = fit_linear(y, {"a": a, "b": b}, intercept=False)
    origin = sm.OLS(y, np.column_stack([a, b])).fit()
    assert through_origin.r_squared == pytest.approx(origin.rsquared, rel=1e-12)
    assert through_origin.at({"a": 1.0, "b": 1.0}).se == pytest.approx(
        origin.get_prediction([[1.0, 1.0]]).se_mean[0], rel=1e-10
    )
    with refuses(UnknownName, "'c'", "not a known"):
        fit.at({"a": 1.0, "b": 1.0, "c": 1.0})
    with refuses(InputRefused, "no value was", "'b'"):
        fit.at({"a": 1.0})


def test_the_sentence_says_what_was_fitted():
    seconds = np.arange(26) * 60
    charge = 4.2 - 3.0e-4 * seconds + np.random.default_rng(16).normal(0.0, 2e-3, 26)
    sentence = fit_linear(charge, {"time": seconds}).sentence("the charge", "Ah")
    says(sentence, "Least squares of", "4")
    assert "time -0.0003" in sentence
    assert "t(24) = -" in sentence
    assert "p < .001" in sentence
    assert "95 % CI" in sentence
    says(sentence, "n = 26")


def test_what_leaves_the_range_of_doubles_is_never_infinite():
    x = np.array([1.0, 2.0, 3.0, 5.0])
    y = np.array([1.0, 3.0, 2.0, 4.0])
    large, small = fit_linear(1e300 * y, {"x": x}), fit_linear(1e-300 * y, {"x": x})
    for fit in (large, small):
        assert isinstance(fit.ss_residual, Undefined)
        assert fit.r_squared == pytest.approx(fit_linear(y, {"x": x}).r_squared, rel=1e-13)
    assert isinstance(large.covariance, Undefined)
    assert isinstance(large.at({"x": 2.0}).se, Undefined)
    with pytest.raises(InputRefused, match="a coefficient exceeds"):
        fit_linear(1e200 * y, {"x": 1e-200 * x})


@pytest.mark.parametrize("size", [2.0**-1060, 2.0**1000])
def test_numbers_near_the_ends_of_doubles(size):
    x, y = np.arange(1.0, 9.0), np.array([2.0, 1.0, 4.0, 3.0, 6.0, 5.0, 9.0, 7.0])
    near, far = fit_linear(y, {"x": x}), fit_linear(size * y, {"x": size * x})
    assert far.coefficients[1] == near.coefficients[1]
    assert far.standard_errors[1] == near.standard_errors[1]
    assert far.p == near.p


def test_columns_of_doubles_are_whole_numbers_of_their_finest_digit():
    rng = np.random.default_rng(6)
    for values in ([5e-324, 1e308, -1e-310, 0.0], [0.0, 0.0], [3.0, -1e300], rng.normal(size=50), [0.25, -0.75]):
        column = as_column("x", np.array(values))
        finest = max(float(value).as_integer_ratio()[1] for value in values)
        assert column.unit == Fraction(1, finest)
        assert column.counts == [Fraction(float(value)) * finest for value in values]


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
    x, y = (
        np.array([45.0, 57.0, 63.0, 67.0] * 3),
        np.array([48.0, 60.0, 67.0, 72.0, 47.0, 61.0, 66.0, 71.0, 47.5, 60.5, 67.0, 71.0]),
    )
    days = np.repeat(range(3), 4).tolist()
    shared = [SharedError({("drain", "level"): 0.3}, {"drain": 6.0})] * 12
    alone, both = slope_through_origin(x, y, days), slope_through_origin(x, y, days, shared)
    step = 1e-6
    moved = slope_through_origin(x + 0.3 * step, y, days).slope - alone.slope
    assert both.shared_se == pytest.approx(abs(moved) / step, rel=1e-4)
    assert not isinstance(both.ci, Undefined)
    assert not isinstance(alone.ci, Undefined)
    assert both.ci[0] < alone.ci[0] < alone.ci[1] < both.ci[1]


def test_a_single_group_has_no_interval() -> None:
    found = slope_through_origin([2.0, 4.0], [3.0, 6.1], ["one", "one"])
    assert found.slope == pytest.approx((6.0 + 24.4) / 20.0)
    assert isinstance(found.ci, Undefined)


def test_a_group_that_alone_tells_the_slope_leaves_no_interval() -> None:
    found = slope_through_origin([1e9, 1.0, 1.0], [1e9, 1.1, 0.9], ["a", "b", "c"])
    assert isinstance(found.ci, Undefined)
    assert isinstance(found.se, Undefined)


def test_points_on_the_line_have_an_interval_without_width() -> None:
    assert slope_through_origin([1.0, 2.0], [2.0, 4.0], [0, 1]).ci == (2.0, 2.0)


def test_what_has_no_slope_is_refused() -> None:
    with pytest.raises(InputRefused, match="no slope"):
        slope_through_origin([0.0, 0.0], [1.0, 2.0], [0, 1])
    with pytest.raises(InputRefused, match="as many"):
        slope_through_origin([1.0], [1.0, 2.0], [0, 1])
    assert math.isfinite(slope_through_origin([1.0], [1.0], [0]).slope)
