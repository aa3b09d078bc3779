"""Random designs against rational arithmetic, and what must not change a fit."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stats.lines.regression import fit_linear
from tests.helpers.exact_fit import assert_exact, exact_fit


def designs(offsets, most_columns=4):
    """y and columns as doubles, of any size and offset, with independent scatter."""

    @st.composite
    def draw_design(draw):
        rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
        p = draw(st.integers(1, most_columns))
        n = draw(st.integers(p + 2, 30))
        columns = [rng.normal(0.0, 10.0 ** rng.uniform(2, 4), n) + draw(offsets) for _ in range(p)]
        noise = 10.0 ** draw(st.integers(-12, 3))
        y = draw(offsets) + rng.normal(0.0, noise, n)
        for column in columns:
            y = y + rng.normal() * column * draw(st.sampled_from([0.0, 1.0, 1e-6]))
        return y, columns, draw(st.booleans())

    return draw_design()


@given(designs(st.sampled_from([0.0, 1.0, -1e6, 1e9, 1e12, -1e15])))
def test_random_designs_agree_with_rational_arithmetic(design):
    y, columns, with_intercept = design
    if not with_intercept:
        columns = [column - 0.999 * np.mean(column) for column in columns]
    truth = exact_fit(y, columns, intercept=with_intercept)
    fit = fit_linear(y, {str(number): column for number, column in enumerate(columns)}, intercept=with_intercept)
    if truth.ss_residual == 0:
        assert fit.ss_residual == 0.0
    assert_exact(fit, truth)


@pytest.mark.parametrize("closeness", [1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 1e-14])
def test_nearly_collinear_columns_keep_their_digits(closeness):
    """Condition up to 2e14: a QR solution in doubles has 16 - log10(condition) digits, in standard errors, too."""
    rng = np.random.default_rng(5)
    a, b, other = rng.normal(size=(3, 40))
    close = a + closeness * b
    y = a + 2.0 * close - other + rng.normal(0.0, 0.1, 40)
    fit = fit_linear(y, {"a": a, "close": close, "other": other})
    assert 0.5 / closeness < fit.condition < 4.0 / closeness
    assert_exact(fit, exact_fit(y, [a, close, other]))


@given(designs(st.just(0.0)), st.integers(-500, 500), st.integers(-400, 400), st.integers(0, 2**32 - 1))
def test_scale_and_order_change_nothing(design, y_power, x_power, seed):
    y, columns, with_intercept = design
    named = {str(number): column for number, column in enumerate(columns)}
    fit = fit_linear(y, named, intercept=with_intercept)
    scaled = fit_linear(
        np.ldexp(y, y_power),
        {name: np.ldexp(column, x_power) for name, column in named.items()},
        intercept=with_intercept,
    )
    assert (scaled.t, scaled.p, scaled.f, scaled.r_squared) == (fit.t, fit.p, fit.f, fit.r_squared)
    order = np.random.default_rng(seed).permutation(y.size)
    mixed = fit_linear(y[order], {name: named[name][order] for name in reversed(named)}, intercept=with_intercept)
    assert mixed.r_squared == pytest.approx(fit.r_squared, rel=1e-13)
    assert dict(zip(mixed.names, mixed.coefficients, strict=True)) == pytest.approx(
        dict(zip(fit.names, fit.coefficients, strict=True)), rel=1e-14
    )


@given(st.integers(-(2**50), 2**50), st.integers(0, 1000))
def test_a_shift_changes_the_intercept_only(shift, seed):
    rng = np.random.default_rng(seed)
    x, y = rng.integers(0, 1000, (2, 12)).astype(np.float64)
    x[:2] = 0.0, 1.0
    near, far = fit_linear(y, {"x": x}), fit_linear(y + shift, {"x": x + 2.0 * shift})
    assert far.coefficients[1] == pytest.approx(near.coefficients[1], rel=1e-14)
    assert far.standard_errors[1] == pytest.approx(near.standard_errors[1], rel=1e-13)
    assert far.p[1] == pytest.approx(near.p[1], rel=1e-12)
    assert far.r_squared == pytest.approx(near.r_squared, rel=1e-13)
