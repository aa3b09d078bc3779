"""What every least-squares fit says of itself, whatever its columns are."""

from __future__ import annotations

import math
import sys
from dataclasses import dataclass, field
from typing import TypedDict

import numpy as np

from data_schema.errors import InputRefused
from data_schema.vocabulary import Undefined
from stats.coefficients import Coefficient, one_by_one
from stats.distributions import f_upper_p, t_quantile, t_two_sided_p
from stats.double_double import Floats
from stats.results import Result
from stats.tails import f_upper, t_two_sided
from stats.wording import interval_text, missing_text, number_text, p_text, with_unit

INTERCEPT = "intercept"
_EXACT = Undefined("the fit is exact, so that nothing measures the scatter")
BEYOND_DOUBLES = Undefined("a covariance is beyond what a double can hold")
_LARGEST_EXPONENT = 400
"""Of a standard error, or its inverse: its square still fits a double, whatever stands before the power of two."""
LEAST_SD = 2.0**-_LARGEST_EXPONENT


@dataclass(frozen=True, slots=True)
class Response(Result):
    """The fitted response at one place."""

    value: float
    """In the unit of the response."""
    se: float | Undefined
    """Standard error of the mean response there, not of one more measurement."""
    ci: tuple[float, float] | Undefined
    """Student's interval of the mean response."""
    level: float
    """Level of the interval."""
    df: int
    """Degrees of freedom of the fit."""
    extrapolated: bool
    """Whether a value lies outside its column's range."""

    def sentence(self, response: str = "the response", unit: str = "") -> str:
        """Return the response in words, with its interval, degrees of freedom, and whether it is extrapolated."""
        beyond = ", outside the range that was fitted" if self.extrapolated else ""
        return (
            f"{response} is {number_text(self.value)}{with_unit(unit)} there "
            f"({interval_text(self.ci, self.level, unit)}, df = {self.df}{beyond})."
        )


@dataclass(frozen=True, slots=True)
class Fit(Result):
    """A least-squares fit; a coefficient's unit is that of the response over that of its column."""

    names: tuple[str, ...]
    """Of the coefficients: "intercept" first where there is one."""
    coefficients: tuple[float, ...]
    """In the order of `names`, shape (p,)."""
    standard_errors: tuple[float, ...] | Undefined
    """0 where the fit is exact."""
    ci: tuple[tuple[float, float], ...] | Undefined
    """Student's interval of each coefficient."""
    level: float
    """Level of the intervals."""
    t: tuple[float, ...] | Undefined
    """Coefficient over standard error; undefined for an exact fit."""
    p: tuple[float, ...] | Undefined
    """Two-sided, of each coefficient being 0."""
    covariance: tuple[tuple[float, ...], ...] | Undefined
    """Of the coefficients, shape (p, p), in the products of their units."""
    r_squared: float | Undefined
    """About the mean with an intercept, about 0 without."""
    f: float | Undefined
    """Of all coefficients but the intercept being 0, with `df_model` and `df`."""
    f_p: float | Undefined
    """P(F >= f)."""
    residual_sd: float | Undefined
    """sqrt(SS_residual / df), in the unit of the response."""
    ss_residual: float | Undefined
    """Exactly 0 for an exact fit, and for no other."""
    condition: float
    """2-norm condition of the centred columns scaled to one length: digits lost to the design, about its log10."""
    df_model: int
    """Number of coefficients without the intercept."""
    df: int
    """n minus the number of coefficients."""
    n: int
    """Number of values."""
    missing: int = field(default=0, kw_only=True)
    """Rows left out because a value in them was NaN."""

    @property
    def log10_p(self) -> tuple[float, ...] | Undefined:
        """Decimal logarithms of `p`, shape (p,), right at any size."""
        return self.t if isinstance(self.t, Undefined) else tuple(t_two_sided(t, self.df).log10_p for t in self.t)

    @property
    def f_log10_p(self) -> float | Undefined:
        """Decimal logarithm of `f_p`, right at any size."""
        return self.f if isinstance(self.f, Undefined) else f_upper(self.f, self.df_model, self.df).log10_p

    def rows(self) -> tuple[Coefficient, ...]:
        """Return the coefficients, for `to_frame`."""
        of_each = self.standard_errors, self.t, self.p, self.log10_p, self.ci
        return one_by_one(self.names, self.coefficients, *of_each, self._inflations())

    def _inflations(self) -> tuple[float | Undefined, ...]:
        """Return the variance inflation of each coefficient, where the fit has such."""
        return (Undefined("this fit has no columns of their own"),) * len(self.names)

    def sentence(self, response: str = "the response", unit: str = "") -> str:
        """Return the fit in words: each coefficient with interval, t, df and p; R squared, residual SD, n."""
        parts, logs = [], self.log10_p
        for row, (name, value) in enumerate(zip(self.names, self.coefficients, strict=True)):
            text = f"{name} {number_text(value, 6)}"
            inside = []
            if not isinstance(self.ci, Undefined):
                inside.append(interval_text(self.ci[row], self.level))
            if not isinstance(self.t, Undefined) and not isinstance(self.p, Undefined):
                log10_p = logs if isinstance(logs, Undefined) else logs[row]
                inside.append(f"t({self.df}) = {number_text(self.t[row])}, {p_text(self.p[row], log10_p)}")
            parts.append(f"{text} ({', '.join(inside)})" if inside else text)
        about = [f"R squared {number_text(self.r_squared, 6)}"]
        if not isinstance(self.f, Undefined):
            test = f"F({self.df_model}, {self.df}) = {number_text(self.f)}"
            about.append(f"{test}, {p_text(self.f_p, self.f_log10_p)}")
        if isinstance(self.residual_sd, Undefined):
            about.append(f"no standard errors, because {self.residual_sd.reason}")
        else:
            about.append(f"residual SD {number_text(self.residual_sd)}{with_unit(unit)}")
        n = f"n = {self.n}{missing_text(self.missing)}"
        return f"Least squares of {response}: {'; '.join(parts)}; {', '.join(about)}, {n}."


class FitFields(TypedDict):
    """The fields of a `Fit` by name."""

    names: tuple[str, ...]
    coefficients: tuple[float, ...]
    standard_errors: tuple[float, ...] | Undefined
    ci: tuple[tuple[float, float], ...] | Undefined
    level: float
    t: tuple[float, ...] | Undefined
    p: tuple[float, ...] | Undefined
    covariance: tuple[tuple[float, ...], ...] | Undefined
    r_squared: float | Undefined
    f: float | Undefined
    f_p: float | Undefined
    residual_sd: float | Undefined
    ss_residual: float | Undefined
    condition: float
    df_model: int
    df: int
    n: int


@dataclass(frozen=True, slots=True)
class Scaled:
    """A fit in the scale in which it was solved, and the way back."""

    coefficients: list[float]
    """The caller's but for their unit's factor and power of two."""
    fitted: Floats
    """Without the intercept; shape (n,)."""
    residuals: Floats
    """Shape (n,)."""
    response_exponent: int
    """A residual is 2**response_exponent times what stands here."""
    rows: Floats
    """Coefficients have the covariance rows @ rows.T * SS_residual / df; shape (p, p)."""
    units: tuple[tuple[float, int], ...]
    """Factor and power of two of each coefficient."""
    condition: float


def fit_fields(names: tuple[str, ...], scaled: Scaled, *, intercept: bool, level: float) -> FitFields:
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
        _ldexp(value, exponent) * factor
        for value, (factor, exponent) in zip(scaled.coefficients, scaled.units, strict=True)
    ]
    errors: tuple[float, ...] | Undefined = none
    covariance: tuple[tuple[float, ...], ...] | Undefined = none
    ci: tuple[tuple[float, float], ...] | Undefined = none
    t: tuple[float, ...] | Undefined = none
    p_values: tuple[float, ...] | Undefined = none
    f: float | Undefined = none
    f_p: float | Undefined = none
    residual_sd: float | Undefined = none
    if df > 0:
        scatter = math.sqrt(squares / df)
        residual_sd = math.ldexp(scatter, scaled.response_exponent)
        lengths = np.sqrt((scaled.rows * scaled.rows).sum(axis=1)).tolist()
        errors = tuple(
            _ldexp(scatter * length, exponent) * factor
            for length, (factor, exponent) in zip(lengths, scaled.units, strict=True)
        )
        half = t_quantile(level, df)
        ci = tuple((b - half * se, b + half * se) for b, se in zip(coefficients, errors, strict=True))
        covariance = _covariance(scaled, scatter)
        t = p_values = f = f_p = _EXACT
        if squares > 0.0:
            f = (model / df_model) / (squares / df)
            f_p = f_upper_p(f, df_model, df)
            t = tuple(b / (scatter * length) for b, length in zip(scaled.coefficients, lengths, strict=True))
            p_values = tuple(t_two_sided_p(one, df) for one in t)
    if not all(map(math.isfinite, (*coefficients, *(errors if isinstance(errors, tuple) else ())))):
        raise InputRefused("y and a column differ so much in size that a coefficient exceeds 1.8e308: change units.")
    total = model + squares
    return FitFields(
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
    value = _ldexp(scaled, exponent)
    if not math.isfinite(value) or (value < sys.float_info.min and scaled > 0.0):
        return Undefined("the sum of squares is beyond what a double can hold")
    return value


def _ldexp(value: float, exponent: int) -> float:
    """Return value * 2**exponent, infinite where doubles end."""
    try:
        return math.ldexp(value, exponent)
    except OverflowError:
        return math.inf
