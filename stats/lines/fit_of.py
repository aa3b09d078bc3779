"""From coefficients, residuals and the factor of a design, in the scale they were solved in, to all that a fit says."""

from __future__ import annotations

import math
import sys
from dataclasses import dataclass

import numpy as np

from data_schema.vocabulary import Undefined
from stats.exact.distributions import f_upper_p, t_quantile, t_two_sided_p
from stats.exact.double_double import Floats
from stats.exact.finite import Interval, finite, finite_pair, refuse_beyond, times_power
from stats.lines.fit import EXACT, Fit

BEYOND_DOUBLES = Undefined("a covariance is beyond what a double can hold")
_LARGEST_EXPONENT = 400
"""Of a standard error, or its inverse: its square still fits a double, whatever stands before the power of two."""
LEAST_SD = 2.0**-_LARGEST_EXPONENT


@dataclass(frozen=True, slots=True)
class Scaled:
    """A fit in the scale in which it was solved, and the way back."""

    coefficients: list[float]
    """The caller's but for their unit's factor and power of two."""
    fitted: Floats
    """In the response's scale, about its centre where there is an intercept; shape (n,)."""
    residuals: Floats
    """Shape (n,)."""
    response_exponent: int
    """A residual is 2**response_exponent times what stands here."""
    rows: Floats
    """Coefficients have the covariance rows @ rows.T * SS_residual / df; shape (p, p)."""
    units: tuple[tuple[float, int], ...]
    """Factor and power of two of each coefficient."""
    condition: float

    @property
    def lengths(self) -> list[float]:
        """Standard errors of the coefficients for a residual standard deviation of 1; shape (p,)."""
        found: list[float] = np.sqrt((self.rows * self.rows).sum(axis=1)).tolist()
        return found


@dataclass(frozen=True, slots=True)
class _ByScatter:
    """What the residuals say of the coefficients; a field of `Fit` each."""

    residual_sd: float | Undefined
    standard_errors: tuple[float, ...] | Undefined
    ci: tuple[Interval, ...] | Undefined
    covariance: tuple[tuple[float, ...], ...] | Undefined


@dataclass(frozen=True, slots=True)
class _Tests:
    """Of each coefficient being 0, and of all but the intercept; a field of `Fit` each."""

    t: tuple[float, ...] | Undefined
    p: tuple[float, ...] | Undefined
    f: float | Undefined
    f_p: float | Undefined


def fit_of(names: tuple[str, ...], scaled: Scaled, *, intercept: bool, level: float, missing: int) -> Fit:
    """Return everything that follows from coefficients, residuals and the factor of the design.

    Raises `InputRefused` where a coefficient is beyond the range of doubles.
    """
    n, p = scaled.residuals.size, len(names)
    df, df_model = n - p, p - intercept
    squares = float(scaled.residuals @ scaled.residuals)
    from_mean = scaled.fitted - float(scaled.fitted.sum()) / n if intercept else scaled.fitted
    model = float(from_mean @ from_mean)
    none = Undefined("there are as many values as coefficients")
    coefficients = [
        times_power(value, exponent) * factor
        for value, (factor, exponent) in zip(scaled.coefficients, scaled.units, strict=True)
    ]
    by_scatter = _ByScatter(none, none, none, none)
    tests = _Tests(none, none, none, none)
    if df > 0:
        by_scatter = _by_scatter(scaled, coefficients, math.sqrt(squares / df), t_quantile(level, df))
        tests = _tests(scaled, model, squares, df_model, df) if squares > 0.0 else _Tests(EXACT, EXACT, EXACT, EXACT)
    errors = by_scatter.standard_errors
    refuse_beyond(
        "y and a column differ so much in size that a coefficient",
        (*coefficients, *(errors if isinstance(errors, tuple) else ())),
    )
    total = model + squares
    return Fit(
        names=names,
        coefficients=tuple(coefficients),
        standard_errors=errors,
        ci=by_scatter.ci,
        level=level,
        t=tests.t,
        p=tests.p,
        covariance=by_scatter.covariance,
        r_squared=model / total if total > 0.0 else Undefined("all values of y are equal"),
        f=tests.f,
        f_p=tests.f_p,
        residual_sd=by_scatter.residual_sd,
        ss_residual=_squares(squares, 2 * scaled.response_exponent),
        condition=scaled.condition,
        df_model=df_model,
        df=df,
        n=n,
        missing=missing,
    )


def _by_scatter(scaled: Scaled, coefficients: list[float], scatter: float, quantile: float) -> _ByScatter:
    """Return standard errors and intervals for a residual standard deviation, `scatter`, in the response's scale."""
    errors = tuple(
        times_power(scatter * length, exponent) * factor
        for length, (factor, exponent) in zip(scaled.lengths, scaled.units, strict=True)
    )
    ends: list[Interval | Undefined] = [EXACT]
    if scatter:
        ends = [finite_pair(b - quantile * se, b + quantile * se) for b, se in zip(coefficients, errors, strict=True)]
    residual_sd = finite(times_power(scatter, scaled.response_exponent), "the residual standard deviation")
    return _ByScatter(residual_sd, errors, _all_or_none(ends), _covariance(scaled, scatter))


def _tests(scaled: Scaled, model: float, squares: float, df_model: int, df: int) -> _Tests:
    """Return the tests by the sums of squares of the model and of the residuals, which are not 0."""
    scatter = math.sqrt(squares / df)
    t = tuple(b / (scatter * length) for b, length in zip(scaled.coefficients, scaled.lengths, strict=True))
    f = (model / df_model) / (squares / df)
    return _Tests(t, tuple(t_two_sided_p(one, df) for one in t), f, f_upper_p(f, df_model, df))


def _covariance(scaled: Scaled, scatter: float) -> tuple[tuple[float, ...], ...] | Undefined:
    factors = np.array([factor for factor, _ in scaled.units])
    exponents = np.array([exponent for _, exponent in scaled.units])
    rows = scatter * scaled.rows * factors[:, np.newaxis]
    matrix = rows @ rows.T
    if int(np.abs(exponents).max()) > _LARGEST_EXPONENT:
        return BEYOND_DOUBLES
    matrix = np.ldexp(matrix, exponents[:, np.newaxis] + exponents)
    return tuple(tuple(row) for row in matrix.tolist())


def _squares(scaled: float, exponent: int) -> float | Undefined:
    value = times_power(scaled, exponent)
    if not math.isfinite(value) or (value < sys.float_info.min and scaled > 0.0):
        return Undefined("the sum of squares is beyond what a double can hold")
    return value


def _all_or_none(intervals: list[Interval | Undefined]) -> tuple[Interval, ...] | Undefined:
    lost = next((interval for interval in intervals if isinstance(interval, Undefined)), None)
    return tuple(interval for interval in intervals if not isinstance(interval, Undefined)) if lost is None else lost
