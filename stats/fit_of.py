"""From coefficients, residuals and the factor of a design, in the scale they were solved in, to all that a fit says."""

from __future__ import annotations

import math
import sys
from dataclasses import dataclass

import numpy as np

from data_schema.vocabulary import Undefined
from stats.distributions import f_upper_p, t_quantile, t_two_sided_p
from stats.double_double import Floats
from stats.finite import Interval, finite, finite_pair, refuse_beyond, times_power
from stats.fit import Fit

_EXACT = Undefined("the fit is exact, so that nothing measures the scatter")
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
    errors: tuple[float, ...] | Undefined = none
    covariance: tuple[tuple[float, ...], ...] | Undefined = none
    ci: tuple[Interval, ...] | Undefined = none
    t: tuple[float, ...] | Undefined = none
    p_values: tuple[float, ...] | Undefined = none
    f: float | Undefined = none
    f_p: float | Undefined = none
    residual_sd: float | Undefined = none
    if df > 0:
        scatter = math.sqrt(squares / df)
        residual_sd = finite(times_power(scatter, scaled.response_exponent), "the residual standard deviation")
        lengths = np.sqrt((scaled.rows * scaled.rows).sum(axis=1)).tolist()
        errors = tuple(
            times_power(scatter * length, exponent) * factor
            for length, (factor, exponent) in zip(lengths, scaled.units, strict=True)
        )
        half = t_quantile(level, df)
        ci = _all_or_none(
            [finite_pair(b - half * se, b + half * se) for b, se in zip(coefficients, errors, strict=True)]
        )
        covariance = _covariance(scaled, scatter)
        t = p_values = f = f_p = _EXACT
        if squares > 0.0:
            f = (model / df_model) / (squares / df)
            f_p = f_upper_p(f, df_model, df)
            t = tuple(b / (scatter * length) for b, length in zip(scaled.coefficients, lengths, strict=True))
            p_values = tuple(t_two_sided_p(one, df) for one in t)
    refuse_beyond(
        "y and a column differ so much in size that a coefficient",
        (*coefficients, *(errors if isinstance(errors, tuple) else ())),
    )
    total = model + squares
    return Fit(
        names=names,
        coefficients=tuple(coefficients),
        standard_errors=errors,
        ci=ci,
        level=level,
        t=t,
        p=p_values,
        covariance=covariance,
        r_squared=model / total if total > 0.0 else Undefined("all values of y are equal"),
        f=f,
        f_p=f_p,
        residual_sd=residual_sd,
        ss_residual=_squares(squares, 2 * scaled.response_exponent),
        condition=scaled.condition,
        df_model=df_model,
        df=df,
        n=n,
        missing=missing,
    )


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
