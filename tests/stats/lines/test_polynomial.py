from fractions import Fraction

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from data_schema.errors import InputRefused
from data_schema.vocabulary import Undefined
from stats.lines.fit import EXACT
from stats.lines.regression import fit_linear, fit_polynomial
from tests.helpers.exact_fit import exact, exact_fit, nist_data, nist_truth, relative_error, root

DEGREES = {
    "Norris": 1,
    "Pontius": 2,
    "Filip": 10,
    "Wampler1": 5,
    "Wampler2": 5,
    "Wampler3": 5,
    "Wampler4": 5,
    "Wampler5": 5,
}


@pytest.mark.parametrize("name", DEGREES)
def test_nist_sets_to_the_last_digit(name):
    """Filip: lstsq, statsmodels' pinv, pingouin and sklearn have no digit, polyfit 7.8 and none of the standard errors,
    Polynomial.fit 13.4."""
    y, x = nist_data(name)
    fit = fit_polynomial(x, y, DEGREES[name])
    truth = nist_truth(name)
    coefficient_bound, se_bound = (1e-12, 1e-10) if name == "Filip" else (1e-14, 1e-12)
    for power, (value, se) in enumerate(zip(fit.coefficients, fit.standard_errors, strict=True)):
        assert relative_error(value, truth[f"B{power}"]) < coefficient_bound
        assert relative_error(se, truth[f"se_B{power}"]) < se_bound
    assert relative_error(fit.r_squared, truth["r_squared"]) < 1e-14
    assert relative_error(fit.residual_sd, truth["residual_sd"]) < 1e-14
    if truth["ss_res"] != 0:
        assert relative_error(fit.f, truth["F"]) < 1e-14


def exact_polynomial(x, y, degree):
    points = [exact(value) for value in x]
    return exact_fit(y, [[point**power for point in points] for power in range(1, degree + 1)])


def assert_exact(fit, truth, ticks=1):
    for power, (value, true) in enumerate(zip(fit.coefficients, truth.coefficients, strict=True)):
        assert relative_error(value, true * ticks**power) < 1e-14
    for power, (se, variance) in enumerate(zip(fit.standard_errors, truth.variances, strict=True)):
        assert relative_error(se, root(variance * ticks ** (2 * power))) < 1e-12


@pytest.mark.parametrize("degree", [1, 2, 3])
def test_w17_polynomials_of_time_stamps(degree):
    """datetime64. Others: xarray's polyfit returns a linear term of 2e-18 at degree 2 and counts per nanosecond."""
    seconds = np.arange(40) * 30
    y = 4.2 - 3.0e-4 * seconds + 2e-8 * seconds**2 + np.random.default_rng(17).normal(0.0, 1e-3, 40)
    ticks = 1_700_000_000 * 10**9 + seconds * 10**9
    truth = exact_polynomial(ticks, y, degree)
    assert_exact(fit_polynomial(ticks.astype("datetime64[ns]"), y, degree), truth, 10**9)
    assert_exact(fit_polynomial(ticks, y, degree), truth)


@given(st.integers(0, 2**32 - 1), st.integers(1, 6), st.sampled_from([0.0, -3.0, 1e3, 1e6]))
def test_random_data_agree_with_rational_arithmetic(seed, degree, offset):
    rng = np.random.default_rng(seed)
    x = offset + rng.normal(size=degree + 2 + int(rng.integers(0, 20))) * 10.0 ** rng.uniform(-1, 2)
    y = rng.normal(size=x.size) * 10.0 ** rng.uniform(-6, 3)
    assert_exact(fit_polynomial(x, y, degree), exact_polynomial(x, y, degree))


@pytest.mark.parametrize("degree", [8, 15, 20])
def test_high_degrees_keep_their_digits(degree):
    x = np.arange(-8, 24) / 8.0  # few bits, so that exact arithmetic is quick
    y = np.round(1024.0 * (np.exp(x) + np.random.default_rng(2).normal(0.0, 0.01, x.size))) / 1024.0
    assert_exact(fit_polynomial(x, y, degree), exact_polynomial(x, y, degree))


def test_a_line_is_the_line_of_the_linear_fit():
    rng = np.random.default_rng(6)
    x, y = rng.normal(size=(2, 20))
    line, linear = fit_polynomial(x, y, 1), fit_linear(y, {"x": x})
    assert line.names == linear.names == ("intercept", "x")
    assert line.coefficients == pytest.approx(linear.coefficients, rel=1e-14)
    assert line.p == pytest.approx(linear.p, rel=1e-12)
    for place in (-5.0, 0.3):
        assert line.at(place).value == pytest.approx(linear.at({"x": place}).value, rel=1e-13)
        assert line.at(place).se == pytest.approx(linear.at({"x": place}).se, rel=1e-12)
        assert line.at(place).extrapolated is linear.at({"x": place}).extrapolated


def test_the_fit_is_evaluated_without_cancellation():
    y, x = nist_data("Filip")
    fit = fit_polynomial(x, y, 10)
    for place in (x[0], -5.0, max(x)):
        true = sum(exact(c) * exact(place) ** k for k, c in enumerate(fit.coefficients))
        assert fit.at(place).value == pytest.approx(float(true), abs=1e-9)
        assert 0.0 < fit.at(place).se < fit.residual_sd
    assert sum((fit.at(a).value - b) ** 2 for a, b in zip(x, y, strict=True)) == pytest.approx(
        fit.ss_residual, rel=1e-9
    )
    assert sum(fit.at(a).se ** 2 for a in x) == pytest.approx(11 * fit.residual_sd**2, rel=1e-9)


@pytest.mark.parametrize("degree", [2, 4, 20])
def test_coefficients_of_an_exact_fit_are_exact(degree):
    x = range(3, 40)
    fit = fit_polynomial(list(x), [Fraction(place**2, 3) for place in x], degree)
    assert fit.coefficients == (0.0, 0.0, 1 / 3, *[0.0] * (degree - 2))


def test_moments_of_any_kind_are_seconds():
    days = pd.date_range("2026-01-01", periods=5, tz="Europe/Berlin")
    truth = exact_polynomial([day.timestamp() for day in days], [1, 2, 3, 4, 6], 1)
    for kind in (days, pd.Series(days), list(days), [day.to_pydatetime() for day in days]):
        assert_exact(fit_polynomial(kind, [1, 2, 3, 4, 6], 1), truth)


def test_moments_as_response_are_seconds():
    x, seconds = [0.0, 1.0, 2.0, 3.5, 4.0], np.array([0, 10, 21, 30, 44])
    milliseconds = (seconds * 1000).astype("timedelta64[ms]")
    assert_exact(fit_polynomial(x, milliseconds, 2), exact_polynomial(x, seconds, 2))


def test_exact_and_saturated_fits():
    x = [0.0, 1.0, 2.0, 3.0, 5.0]
    exact_one = fit_polynomial(x, [1.0 - 2.0 * a + a**2 for a in x], 2)
    assert exact_one.coefficients == (1.0, -2.0, 1.0)
    assert exact_one.ss_residual == 0.0
    assert isinstance(exact_one.p, Undefined)
    full = fit_polynomial(x[:3], [1.0, 0.0, 5.0], 2)
    assert full.coefficients == pytest.approx((1.0, -4.0, 3.0), rel=1e-14)
    assert isinstance(full.at(0.5).se, Undefined)
    assert "x^2 3" in full.sentence()


@pytest.mark.parametrize(
    ("x", "degree", "sentence"),
    [
        ([1.0, 2.0, 3.0], 0, "the degree is 0"),
        ([1.0, 2.0, 3.0], 1.0, "the degree is 1.0"),
        ([1.0, 2.0, 3.0], 21, "from 1 to 20"),
        ([1.0, 2.0, 3.0], 3, "at least 4"),
        ([1.0, 2.0], 1, "give one y for each x"),
        ([2.0, 2.0, 2.0], 1, "x has 1 different value,"),
        ([1.0, 2.0, 2.0], 2, "x has 2 different values"),
        ([1.0, 2.0, np.nan], 1, "x holds 1 of 3"),
        ([1e-200, 2e-200, 4e-200], 2, "a coefficient exceeds 1.8e308"),
    ],
)
def test_what_cannot_be_fitted_is_refused(x, degree, sentence):
    with pytest.raises(InputRefused, match=sentence):
        fit_polynomial(x, [1.0, 2.0, 4.5], degree)


@pytest.mark.parametrize("degree", [4, 5, 8])
def test_wide_whole_numbers_are_fitted_to_the_last_bit(degree):
    """Powers of 50 bits have more than waves are shortened to."""
    x = [int(value) for value in np.random.default_rng(1).integers(0, 2**50, 12)]
    fit = fit_polynomial(x, [value**degree for value in x], degree)
    assert fit.coefficients == (*[0.0] * degree, 1.0)
    assert fit.ss_residual == 0.0
    assert fit.t is EXACT
    for y in ([value**degree + row % 3 for row, value in enumerate(x)], [value ** (degree + 1) for value in x]):
        fit = fit_polynomial(x, y, degree)
        assert fit.ss_residual > 0.0
        assert_exact(fit, exact_polynomial(x, y, degree))


def test_doubles_of_many_sizes_that_fit_exactly():
    x = 2.0 ** np.arange(61)
    fit = fit_polynomial(x, x**4, 4)
    assert (fit.coefficients, fit.ss_residual, fit.t) == ((0.0, 0.0, 0.0, 0.0, 1.0), 0.0, EXACT)
