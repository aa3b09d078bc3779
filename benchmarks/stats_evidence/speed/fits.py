"""Lines, planes and polynomials: beside calls that give standard errors, intervals and p too, and bare solvers."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pingouin
import scipy.stats
import statsmodels.api as sm

from benchmarks.stats_evidence.speed.case import BARE, PINGOUIN, SCIPY, STATSMODELS, Call, Case, Floats, Inputs, Peer
from stats.lines.regression import fit_linear, fit_polynomial


def _linregress(x: Floats, y: Floats) -> object:
    fit = scipy.stats.linregress(x, y)
    half = scipy.stats.t.ppf(0.975, x.size - 2)
    return fit, fit.slope - half * fit.stderr, fit.intercept + half * fit.intercept_stderr


def _exact_line(it: Inputs) -> Call:
    x, y = it.tenths, 3.0 * it.tenths - 7.0
    return lambda: fit_linear(y, {"a": x})


def _exact_linregress(it: Inputs) -> Call:
    x, y = it.tenths, 3.0 * it.tenths - 7.0
    return lambda: _linregress(x, y)


def _everything(fit: Any) -> object:
    """Ask statsmodels for what labbook's result holds: it computes nothing before it is asked."""
    return (
        (fit.params, fit.bse, fit.conf_int(), fit.tvalues, fit.pvalues, fit.cov_params()),
        (fit.rsquared, fit.fvalue, fit.f_pvalue, fit.mse_resid, fit.ssr, fit.condition_number),
    )


def _ols(*columns: Callable[[Inputs], np.ndarray]) -> Callable[[Inputs], Call]:
    def prepared(it: Inputs) -> Call:
        design = np.column_stack([np.ones(it.n), *(column(it) for column in columns)])
        return lambda: _everything(sm.OLS(it.y, design).fit())

    return prepared


def _three(it: Inputs) -> dict[str, np.ndarray]:
    return it.groups


def _pingouin(it: Inputs) -> Call:
    design = np.column_stack(list(_three(it).values()))
    return lambda: pingouin.linear_regression(design, it.y)


def _lstsq(it: Inputs) -> Call:
    design = np.column_stack([np.ones(it.n), *_three(it).values()])
    return lambda: np.linalg.lstsq(design, it.y, rcond=None)


def _polynomial_by_numpy(it: Inputs, degree: int) -> object:
    """Intervals, t, p, R squared and residual SD from what polyfit returns."""
    found, covariance = np.polyfit(it.a, it.y, degree, cov=True)
    df = it.n - degree - 1
    errors = np.sqrt(np.diag(covariance))
    half = scipy.stats.t.ppf(0.975, df) * errors
    p = 2.0 * scipy.stats.t.sf(np.abs(found / errors), df)
    residuals = it.y - np.polyval(found, it.a)
    squares, total = residuals @ residuals, ((it.y - it.y.mean()) ** 2).sum()
    f = (total - squares) / degree / (squares / df)
    return (
        found - half,
        found + half,
        p,
        1.0 - squares / total,
        np.sqrt(squares / df),
        f,
        scipy.stats.f.sf(f, degree, df),
    )


def _polynomial(degree: int) -> Case:
    return Case(
        f"fit_polynomial, degree {degree}",
        lambda it: lambda: fit_polynomial(it.a, it.y, degree),
        (
            Peer(
                SCIPY,
                "polyfit(cov=True), t.ppf, t.sf, f.sf, residuals",
                lambda it: lambda: _polynomial_by_numpy(it, degree),
            ),
            Peer(
                STATSMODELS,
                "OLS of the powers, every field asked for",
                lambda it: lambda: _everything(sm.OLS(it.y, np.vander(it.a, degree + 1)).fit()),
            ),
            Peer(BARE, "polyfit(cov=True)", lambda it: lambda: np.polyfit(it.a, it.y, degree, cov=True)),
        ),
    )


CASES = (
    Case(
        "fit_linear, one column",
        lambda it: lambda: fit_linear(it.y, {"a": it.a}),
        (
            Peer(SCIPY, "linregress, t.ppf", lambda it: lambda: _linregress(it.a, it.y)),
            Peer(STATSMODELS, "OLS, every field asked for", _ols(lambda it: it.a)),
        ),
    ),
    Case("fit_linear, one column, exact", _exact_line, (Peer(SCIPY, "linregress, t.ppf", _exact_linregress),)),
    Case(
        "fit_linear, three columns",
        lambda it: lambda: fit_linear(it.y, _three(it)),
        (
            Peer(
                STATSMODELS,
                "OLS, every field asked for",
                _ols(*(lambda it, name=name: it.groups[name] for name in "abc")),
            ),
            Peer(PINGOUIN, "linear_regression", _pingouin),
            Peer(BARE, "lstsq", _lstsq),
        ),
    ),
    *(_polynomial(degree) for degree in (2, 5)),
)
