"""What every least-squares fit says of itself, whatever its columns are."""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence
from dataclasses import dataclass, field, fields
from fractions import Fraction
from typing import Any

import numpy as np

from data_schema.errors import InputRefused
from data_schema.rounding import alpha_beside, error_of, interval_text, number_text, p_text, statistic_text
from data_schema.vocabulary import Undefined
from stats.exact.distributions import f_upper_p, t_quantile, t_two_sided_p
from stats.exact.error_free import Floats
from stats.exact.finite import Interval, finite, finite_pair, refuse_beyond, times_power
from stats.exact.tails import f_upper, t_two_sided
from stats.results import Result
from stats.wording import missing_text, share_text, with_unit


@dataclass(frozen=True, slots=True)
class Coefficient(Result):
    """One coefficient of a least-squares fit, in the unit of the response over that of its column."""

    name: str
    """Of its column, or "intercept"."""
    coefficient: float
    """Its estimate, in the unit of the response over that of its column."""
    standard_error: float | Undefined
    """In the unit of the coefficient; 0 where the fit is exact."""
    t: float | Undefined
    """Coefficient over standard error."""
    p: float | Undefined
    """Two-sided, of the coefficient being 0."""
    log10_p: float | Undefined
    """Decimal logarithm of p, right at any size."""
    ci: tuple[float, float] | Undefined
    """Student's interval, of the fit's level."""
    vif: float | Undefined
    """Variance inflation of its column."""


def one_by_one(
    names: Sequence[str],
    coefficients: Sequence[float],
    standard_errors: Sequence[float] | Undefined,
    t: Sequence[float] | Undefined,
    p: Sequence[float] | Undefined,
    log10_p: Sequence[float] | Undefined,
    ci: Sequence[tuple[float, float]] | Undefined,
    vif: Sequence[float | Undefined],
) -> tuple[Coefficient, ...]:
    """Return the coefficients in the order of their names; what is undefined of all is so of each."""
    of_each = [
        [part] * len(names) if isinstance(part, Undefined) else part for part in (standard_errors, t, p, log10_p, ci)
    ]
    return tuple(Coefficient(*row) for row in zip(names, coefficients, *of_each, vif, strict=True))


INTERCEPT = "intercept"
EXACT = Undefined("the fit is exact, so that nothing measures the scatter")


@dataclass(frozen=True, slots=True)
class Fit(Result):
    """A least-squares fit; a coefficient's unit is that of the response over that of its column."""

    names: tuple[str, ...]
    """Of the coefficients: "intercept" first where there is one; shape (p,)."""
    coefficients: tuple[float, ...]
    """In the order of `names`, shape (p,)."""
    standard_errors: tuple[float, ...] | Undefined
    """Of the coefficients, in their units, shape (p,); 0 where the fit is exact."""
    ci: tuple[tuple[float, float], ...] | Undefined
    """Student's interval of each coefficient, in its unit, shape (p, 2); undefined for an exact fit."""
    level: float
    """Level of the intervals."""
    t: tuple[float, ...] | Undefined
    """Coefficient over standard error, shape (p,); undefined for an exact fit."""
    p: tuple[float, ...] | Undefined
    """Two-sided, of each coefficient being 0; shape (p,)."""
    covariance: tuple[tuple[float, ...], ...] | Undefined
    """Of the coefficients, shape (p, p), in the products of their units."""
    r_squared: float | Undefined
    """About the mean with an intercept, about 0 without; 0 to 1."""
    f: float | Undefined
    """Of all coefficients but the intercept being 0, with `df_model` and `df`."""
    f_p: float | Undefined
    """P(F >= f)."""
    residual_sd: float | Undefined
    """sqrt(SS_residual / df), in the unit of the response."""
    ss_residual: float | Undefined
    """In the response's unit squared: exactly 0 for an exact fit, and for no other."""
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
    times: tuple[str, ...] = field(default=(), kw_only=True)
    """Columns that were given as moments or durations, with their unit in the fit: "start in s since 1970 UTC"."""
    response_time: str | None = field(default=None, kw_only=True)
    """The unit of a response that was given as moments or durations, "s since 1970 UTC" or "s"; else None."""

    @property
    def log10_p(self) -> tuple[float, ...] | Undefined:
        """Decimal logarithms of `p`, shape (p,), right at any size."""
        return self.t if isinstance(self.t, Undefined) else tuple(t_two_sided(t, self.df).log10_p for t in self.t)

    @property
    def f_log10_p(self) -> float | Undefined:
        """Decimal logarithm of `f_p`, right at any size."""
        return self.f if isinstance(self.f, Undefined) else f_upper(self.f, self.df_model, self.df).log10_p

    def as_fields(self) -> dict[str, Any]:
        """Return the fields by name, for a fit that says more."""
        return {one.name: getattr(self, one.name) for one in fields(Fit)}

    def rows(self) -> tuple[Coefficient, ...]:
        """Return the coefficients, for `to_frame`."""
        of_each = self.standard_errors, self.t, self.p, self.log10_p, self.ci
        return one_by_one(self.names, self.coefficients, *of_each, self._inflations())

    def _inflations(self) -> tuple[float | Undefined, ...]:
        """Return the variance inflation of each coefficient, where the fit has such."""
        return (Undefined("this fit has no columns of their own"),) * len(self.names)

    def spread(self, what: str) -> tuple[tuple[float, ...], float]:
        """Return standard errors and residual standard deviation of what is nothing without them.

        Raises `InputRefused` where one of them is undefined.
        """
        errors, sd = self.standard_errors, self.residual_sd
        if isinstance(errors, Undefined) or isinstance(sd, Undefined):
            reason = next(part.reason for part in (errors, sd) if isinstance(part, Undefined))
            raise InputRefused(f"{what} has no uncertainty, because {reason}: change units.")
        return errors, sd

    def intervals(self) -> tuple[Interval | Undefined, ...]:
        """Return the interval of each coefficient, shape (p,)."""
        return (self.ci,) * len(self.names) if isinstance(self.ci, Undefined) else self.ci

    def sentence(self, response: str = "the response", unit: str = "") -> str:
        """Return the fit in words: each coefficient with interval, t, df and p; R squared, residual SD, n."""
        parts = []
        for row, (name, value) in enumerate(zip(self.names, self.coefficients, strict=True)):
            interval = self.ci if isinstance(self.ci, Undefined) else self.ci[row]
            text = f"{name} {number_text(value, error=error_of(interval))}"
            inside = []
            if not isinstance(interval, Undefined):
                inside.append(interval_text(interval, self.level))
            if not isinstance(self.t, Undefined) and not isinstance(self.p, Undefined):
                inside.append(
                    f"{statistic_text('t', self.t[row], (self.df,))}, {p_text(self.p[row], alpha_beside(self.level))}"
                )
            parts.append(f"{text} ({', '.join(inside)})" if inside else text)
        about = [f"R squared {share_text(self.r_squared)}"]
        if not isinstance(self.f, Undefined):
            test = statistic_text("F", self.f, (self.df_model, self.df))
            about.append(f"{test}, {p_text(self.f_p, alpha_beside(self.level))}")
        if isinstance(self.residual_sd, Undefined):
            about.append(f"no standard errors, because {self.residual_sd.reason}")
        else:
            about.append(f"residual SD {number_text(self.residual_sd)}{with_unit(unit)}")
            if isinstance(self.ci, Undefined):
                about.append(f"no intervals, because {self.ci.reason}")
        times = self.times if self.response_time is None else (f"{response} in {self.response_time}", *self.times)
        n = f"n = {self.n}{missing_text(self.missing)}{''.join(f'; {one}' for one in times)}"
        return f"Least squares of {response}: {'; '.join(parts)}; {', '.join(about)}, {n}."


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


@dataclass(frozen=True, slots=True)
class Response(Result):
    """The fitted response at one place."""

    value: float | Undefined
    """In the unit of the response."""
    se: float | Undefined
    """Standard error of the mean response there, not of one more measurement; in the unit of the response."""
    ci: tuple[float, float] | Undefined
    """Student's interval of the mean response; undefined where the fit is exact."""
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
            f"{response} is {number_text(self.value, error=error_of(self.ci))}{with_unit(unit)} there "
            f"({interval_text(self.ci, self.level, unit)}, df = {self.df}{beyond})."
        )


def response_at(
    value: Fraction, se: Fraction | Undefined, level: float, df: int, *, extrapolated: bool, exact: bool
) -> Response:
    """Return a fitted value with Student's interval, each number rounded once; `exact` says that nothing is left."""
    shown = finite(value, "the response")
    if isinstance(se, Undefined):
        return Response(shown, se, se, level, df, extrapolated)
    half = Fraction(t_quantile(level, df)) * se
    ci = EXACT if exact else finite_pair(value - half, value + half)
    return Response(shown, finite(se, "the standard error"), ci, level, df, extrapolated)


def root_of_form(vector: Sequence[Fraction], covariance: Sequence[Sequence[float]]) -> Fraction:
    """Return the root of v'Cv for numbers of any size; the covariance keeps clear of the ends of the doubles."""
    largest = max(map(abs, vector), default=Fraction(0))
    if largest == 0:
        return Fraction(0)
    unit = Fraction(2) ** (largest.numerator.bit_length() - largest.denominator.bit_length())
    scaled = np.array([float(number / unit) for number in vector])
    return Fraction(math.sqrt(max(float(scaled @ np.array(covariance) @ scaled), 0.0))) * unit
