"""Time stamps of every unit and collinear columns of every kind, on which other programs err (W16 and W20)."""

from decimal import Decimal
from fractions import Fraction

import numpy as np
import pytest

from data_schema.errors import InputRefused
from stats.lines.regression import fit_linear
from tests.helpers.exact_fit import assert_exact, exact_fit, relative_error, root
from tests.helpers.wording import refuses


def drain(n=26):
    """Seconds since switching on, and a battery's charge as logged: slope -3.0e-4 a second."""
    rng = np.random.default_rng(16)
    seconds = np.arange(n) * 60
    return seconds, 4.2 - 3.0e-4 * seconds + rng.normal(0.0, 2e-3, n)


EPOCH_S = 1_700_000_000
TIMES = {
    "seconds": (lambda s: (EPOCH_S + s).astype(np.float64), 1),
    "whole seconds": (lambda s: EPOCH_S + s, 1),
    "milliseconds": (lambda s: 1000 * (EPOCH_S + s), 1000),
    "nanoseconds": (lambda s: 10**9 * (EPOCH_S + s), 10**9),
    "Python integers": (lambda s: [10**18 * (EPOCH_S + int(one)) for one in s], 10**18),
    "datetime64[ns]": (lambda s: (10**9 * (EPOCH_S + s)).astype("datetime64[ns]"), 1),
    "datetime64[ms]": (lambda s: (1000 * (EPOCH_S + s)).astype("datetime64[ms]"), 1),
    "datetime64[m]": (lambda s: ((EPOCH_S - EPOCH_S % 60 + s) // 60).astype("datetime64[m]"), 1),
    "timedelta64[us]": (lambda s: (10**6 * s).astype("timedelta64[us]"), 1),
}


@pytest.mark.parametrize("unit", TIMES)
def test_w16_time_stamps_cost_a_slope_no_digit(unit):
    """Others: np.linalg.lstsq, statsmodels' pinv and pingouin return 7e-9; polyfit's standard error is 21 to 350
    times too small; statsmodels' QR has two digits of it, nan at 100 Hz, a singular matrix at ns."""
    seconds, charge = drain()
    truth = exact_fit(charge, [seconds])
    stamps, per_second = TIMES[unit]
    fit = fit_linear(charge, {"time": stamps(seconds)})
    assert relative_error(fit.coefficients[1] * per_second, truth.coefficients[1]) < 1e-14
    assert relative_error(fit.standard_errors[1] * per_second, root(truth.variances[1])) < 1e-12
    assert fit.coefficients[1] * per_second != pytest.approx(7e-9, rel=0.5)
    assert fit.condition == pytest.approx(1.0, abs=1e-6)


def test_w16_at_a_hundred_hertz_in_nanoseconds():
    ticks = 10**9 * EPOCH_S + np.arange(500) * 10**7
    charge = 4.2 - 3.0e-13 * (ticks - ticks[0]) + np.random.default_rng(3).normal(0.0, 1e-3, 500)
    truth = exact_fit(charge, [ticks])
    fit = fit_linear(charge, {"time": ticks})
    assert relative_error(fit.coefficients[0], truth.coefficients[0]) < 1e-14
    assert relative_error(fit.coefficients[1], truth.coefficients[1]) < 1e-14
    assert relative_error(fit.standard_errors[0], root(truth.variances[0])) < 1e-12
    assert relative_error(fit.standard_errors[1], root(truth.variances[1])) < 1e-12


def test_w20_an_offset_hides_no_collinearity():
    """Others: statsmodels' QR returns -1.6e16."""
    rng = np.random.default_rng(18)
    x = rng.uniform(-0.02, 0.02, 300)
    force = 20000.0 * x + rng.normal(0.0, 2.0, 300)
    with refuses(InputRefused, "'x'", "'v'", "are collinear"):
        fit_linear(force, {"x": x, "v": -5.0 * (x - 1e3) + 0.3})


def test_only_the_columns_that_are_collinear_are_named():
    rng = np.random.default_rng(1)
    a, b, c = rng.normal(size=(3, 40)) + 1e4
    with refuses(InputRefused, "'a'", "'c'", "'sum'", "are collinear"):
        fit_linear(rng.normal(size=40), {"a": a, "b": b, "c": c, "sum": 0.1 * a + 3.0 * c})
    with refuses(InputRefused, "'a'", "'again'"):
        fit_linear(rng.normal(size=40), {"a": a, "b": b, "again": a / 3.0}, intercept=False)
    # Without an intercept, a constant column is one.
    assert fit_linear(a, {"one": np.full(40, 2.0)}, intercept=False).coefficients[0] == pytest.approx(a.mean() / 2.0)
    with refuses(InputRefused, "'b'", "holds only zeros"):
        fit_linear(a, {"b": np.zeros(40)}, intercept=False)


def test_a_column_that_varies_by_its_last_digit_is_taken_at_its_word():
    x = np.where(np.arange(20) % 3 == 0, 1.0, np.nextafter(1.0, 2.0))
    y = np.random.default_rng(2).normal(size=20)
    assert_exact(fit_linear(y, {"x": x}), exact_fit(y, [x]))
    far = 1e15 + np.arange(20) % 4
    assert_exact(fit_linear(y, {"x": far}), exact_fit(y, [far]))


def test_dummies_of_all_levels_are_collinear_with_the_intercept():
    levels = {f"level {k}": np.arange(30) % 3 == k for k in range(3)}
    y = np.random.default_rng(3).normal(size=30)
    with refuses(InputRefused, "'level 0'", "'level 1'", "'level 2'"):
        fit_linear(y, levels)
    means = fit_linear(y, levels, intercept=False)
    assert means.coefficients == pytest.approx([y[k::3].mean() for k in range(3)], rel=1e-13)


@pytest.mark.parametrize("common", [Fraction(2) ** 900, Fraction(10) ** 280])
def test_what_numbers_have_in_common_costs_no_digit(common):
    """In doubles the slope was garbage, with an R squared of 1."""
    steps, other = [Fraction(step, 10**9) for step in (1, 2, 4, 5, 7)], [1.0, 2.0, 3.0, 4.0, 6.0]
    for far, near in (
        (fit_linear([common + step for step in steps], {"x": other}), fit_linear(steps, {"x": other})),
        (fit_linear(other, {"x": [common + step for step in steps]}), fit_linear(other, {"x": steps})),
    ):
        assert (far.coefficients[1], far.standard_errors[1]) == (near.coefficients[1], near.standard_errors[1])
        assert (far.r_squared, far.t[1]) == (near.r_squared, near.t[1])


def test_decimals_far_below_all_doubles_keep_their_test():
    """Rounded to doubles they were all 0."""
    x, steps = [1.0, 2.0, 3.0, 4.0, 5.0, 7.0], [1, 2, 4, 5, 7, 9]
    tiny, plain = fit_linear([Decimal("1e-390") * step for step in steps], {"x": x}), fit_linear(steps, {"x": x})
    assert tiny.t == pytest.approx(plain.t, rel=1e-13)
    assert tiny.r_squared == pytest.approx(plain.r_squared, rel=1e-13)
    assert tiny.coefficients == (0.0, 0.0)
