"""Coefficients and standard errors of NIST's eleven sets for linear regression, by each program."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pingouin
import scipy.linalg
import scipy.optimize
import scipy.stats
import statsmodels.api as sm
from mpmath import mpf
from numpy.typing import NDArray

from benchmarks.stats_evidence.digits.lre import Row, row, tried, worst
from stats.lines.regression import fit_linear, fit_polynomial
from tests.helpers.exact_fit import nist_data, nist_truth

Floats = NDArray[np.float64]
Fitted = tuple[Any, Any]
"""Coefficients and standard errors, from the constant upward; errors None where there are none."""

DEGREES = {"Norris": 1, "Pontius": 2, "Filip": 10, **{f"Wampler{number}": 5 for number in range(1, 6)}}
SETS = ("Norris", "Pontius", "NoInt1", "NoInt2", "Longley", "Filip", *(f"Wampler{number}" for number in range(1, 6)))


class Problem:
    """One set as every program wants it."""

    def __init__(self, name: str) -> None:
        y, *columns = nist_data(name)
        self.y = np.array(y)
        self.degree = DEGREES.get(name)
        self.x = np.array(columns)
        self.intercept = not name.startswith("NoInt")
        powers = [self.x[0] ** power for power in range(1, self.degree + 1)] if self.degree else list(self.x)
        self.design = np.column_stack([*([np.ones_like(self.y)] if self.intercept else []), *powers])
        truth = nist_truth(name)
        numbers = range(0 if self.intercept else 1, len(powers) + 1)
        self.coefficients = [mpf(str(truth[f"B{number}"])) for number in numbers]
        self.errors = [mpf(str(truth[f"se_B{number}"])) for number in numbers]


def _labbook(it: Problem) -> Fitted:
    if it.degree:
        fit: Any = fit_polynomial(it.x[0], it.y, it.degree)
    else:
        named = {str(number): column for number, column in enumerate(it.x)}
        fit = fit_linear(it.y, named, intercept=it.intercept)
    return fit.coefficients, fit.standard_errors


def _linregress(it: Problem) -> Fitted | None:
    if it.degree != 1:
        return None
    fit = scipy.stats.linregress(it.x[0], it.y)
    return (fit.intercept, fit.slope), (fit.intercept_stderr, fit.stderr)


def _curve_fit(it: Problem) -> Fitted:
    found, covariance = scipy.optimize.curve_fit(
        lambda design, *b: design @ np.array(b), it.design, it.y, p0=np.zeros(it.design.shape[1])
    )
    return found, np.sqrt(np.diag(covariance))


def _polyfit(it: Problem) -> Fitted | None:
    if not it.degree:
        return None
    found, covariance = np.polyfit(it.x[0], it.y, it.degree, cov=True)
    return found[::-1], np.sqrt(np.diag(covariance))[::-1]


def _ols(method: str) -> Callable[[Problem], Fitted]:
    def fitted(it: Problem) -> Fitted:
        fit = sm.OLS(it.y, it.design).fit(method=method)
        return fit.params, fit.bse

    return fitted


def _pingouin(it: Problem) -> Fitted:
    fit = pingouin.linear_regression(it.design, it.y, add_intercept=False)
    return fit["coef"].to_numpy(), fit["se"].to_numpy()


def _textbook(it: Problem) -> Fitted:
    """Normal equations and their inverse."""
    inverse = np.linalg.inv(it.design.T @ it.design)
    found = inverse @ (it.design.T @ it.y)
    n, p = it.design.shape
    squares = it.y @ it.y - found @ (it.design.T @ it.y)
    return found, np.sqrt(squares / (n - p) * np.diag(inverse))


PROGRAMS: dict[str, Callable[[Problem], Fitted | None]] = {
    "labbook": _labbook,
    "scipy linregress": _linregress,
    "scipy curve_fit from zeros": _curve_fit,
    "scipy.linalg.lstsq": lambda it: (scipy.linalg.lstsq(it.design, it.y)[0], None),
    "statsmodels OLS": _ols("pinv"),
    'statsmodels OLS, method="qr"': _ols("qr"),
    "pingouin linear_regression": _pingouin,
    "numpy lstsq": lambda it: (np.linalg.lstsq(it.design, it.y, rcond=None)[0], None),
    "numpy polyfit": _polyfit,
    "textbook (normal equations)": _textbook,
}


def rows() -> Iterator[Row]:
    """Return the digits of the worst coefficient and of the worst standard error, of what a program offers."""
    for name in SETS:
        problem = Problem(name)
        for program, function in PROGRAMS.items():
            if function in (_linregress, _polyfit) and function(problem) is None:
                continue
            found = tried(function, problem)
            if found is None:
                scores: dict[str, float | None] = {"worst coefficient": None, "worst standard error": None}
            else:
                coefficients, errors = found
                scores = {"worst coefficient": worst(map(float, coefficients), problem.coefficients)}
                if errors is not None:
                    scores["worst standard error"] = worst(map(float, errors), problem.errors)
            yield from (row(quantity, name, program, score) for quantity, score in scores.items())
