"""What every least-squares fit says of itself, whatever its columns are."""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence
from dataclasses import dataclass, field, fields, replace
from fractions import Fraction
from operator import mul
from typing import Any

import numpy as np

from data_schema.errors import InputRefused
from data_schema.reasons import Reason
from data_schema.rounding import alpha_of_level, error_of, interval_text, number_text, p_text, statistic_text
from data_schema.vocabulary import Undefined
from stats.exact.numbers import Interval, exact_root, finite, finite_pair, interval_about, refuse_beyond, to_double
from stats.exact.tails import f_upper, t_quantile, t_two_sided
from stats.results import Result, missing_text, share_text, with_unit


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


def coefficients_of(
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
EXACT = Undefined(Reason.FIT_EXACT)


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
        return coefficients_of(self.names, self.coefficients, *of_each, self._inflations())

    def _inflations(self) -> tuple[float | Undefined, ...]:
        """Return the variance inflation of each coefficient, where the fit has such."""
        return (Undefined(Reason.NO_OWN_COLUMNS),) * len(self.names)

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
                    f"{statistic_text('t', self.t[row], (self.df,))}, {p_text(self.p[row], alpha_of_level(self.level))}"
                )
            parts.append(f"{text} ({', '.join(inside)})" if inside else text)
        about = [f"R squared {share_text(self.r_squared)}"]
        if not isinstance(self.f, Undefined):
            test = statistic_text("F", self.f, (self.df_model, self.df))
            about.append(f"{test}, {p_text(self.f_p, alpha_of_level(self.level))}")
        if isinstance(self.residual_sd, Undefined):
            about.append(f"no standard errors, because {self.residual_sd.reason}")
        else:
            about.append(f"residual SD {number_text(self.residual_sd)}{with_unit(unit)}")
            if isinstance(self.ci, Undefined):
                about.append(f"no intervals, because {self.ci.reason}")
        times = self.times if self.response_time is None else (f"{response} in {self.response_time}", *self.times)
        n = f"n = {self.n}{missing_text(self.missing)}{''.join(f'; {one}' for one in times)}"
        return f"Least squares of {response}: {'; '.join(parts)}; {', '.join(about)}, {n}."


BEYOND_DOUBLES = Undefined(Reason.HELD_BY_NO_DOUBLE, what="a covariance is")
_LARGEST_VARIANCE = Fraction(2) ** 800

Matrix = Sequence[Sequence[int]]


@dataclass(frozen=True, slots=True)
class ExactFit:
    """Least squares in whole numbers: the normal equations solved without rounding, for p rows and a response."""

    numerators: list[int]
    """Of the coefficients, over `determinant`; shape (p,)."""
    adjugate: list[list[int]]
    """Of the rows' products with each other: their inverse, over `determinant`; shape (p, p)."""
    determinant: int
    squares: Fraction
    """What is left over of the response: exactly 0 where the fit is exact, and nowhere else."""

    def reparametrised(self, back: Matrix) -> ExactFit:
        """Return the fit in other coefficients, `back` (shape (p, p)) times these."""
        half = [[_dot(row, column) for column in self.adjugate] for row in back]
        return ExactFit(
            numerators=[_dot(row, self.numerators) for row in back],
            adjugate=[[_dot(row, other) for other in back] for row in half],
            determinant=self.determinant,
            squares=self.squares,
        )

    def inverse_in_units(self, units: Sequence[Fraction]) -> list[list[Fraction]]:
        """Return the coefficients' covariance for a residual variance of 1 in units, those of the rows."""
        return [
            [Fraction(value, self.determinant) / (one * other) for value, other in zip(row, units, strict=True)]
            for row, one in zip(self.adjugate, units, strict=True)
        ]


def exact_fit(rows: Matrix, response: Sequence[int]) -> ExactFit | None:
    """Fit a response of shape (n,) by rows of shape (p, n); None where the rows are not independent.

    In doubles the normal equations lose twice the digits that a design costs; in whole numbers they lose none.
    """
    products = [[_dot(a, b) for b in rows[: place + 1]] for place, a in enumerate(rows)]
    gram = [[products[max(i, j)][min(i, j)] for j in range(len(rows))] for i in range(len(rows))]
    found = _adjugate(gram)
    if found is None:
        return None
    adjugate, determinant = found
    with_response = [_dot(row, response) for row in rows]
    numerators = [_dot(row, with_response) for row in adjugate]
    left = determinant * _dot(response, response) - _dot(numerators, with_response)
    return ExactFit(numerators, adjugate, determinant, Fraction(left, determinant))


def _dot(a: Sequence[int], b: Sequence[int]) -> int:
    return sum(map(mul, a, b))


def _adjugate(gram: list[list[int]]) -> tuple[list[list[int]], int] | None:
    """Return adjugate and determinant of products of rows with each other; None where that is 0.

    Source: Bareiss (1968), Mathematics of Computation 22, 565: elimination in which every division leaves no remainder.
    """
    p = len(gram)
    work = [[*row, *(int(i == j) for j in range(p))] for i, row in enumerate(gram)]
    before = 1
    for k in range(p):
        pivot = work[k][k]  # the determinant of the first k rows' products: 0 only where these are not independent
        if pivot == 0:
            return None
        for i in range(p):
            if i != k:
                factor = work[i][k]
                work[i] = [(pivot * a - factor * b) // before for a, b in zip(work[i], work[k], strict=True)]
        before = pivot
    return [row[p:] for row in work], before


@dataclass(frozen=True, slots=True)
class Given:
    """What a fit was made of beside its rows."""

    units: tuple[Fraction, ...]
    """Of the rows' counts, that of the intercept's 1; shape (p,)."""
    response_unit: Fraction
    total: Fraction
    """Sum of squares of the response's counts, about their mean where there is an intercept."""
    n: int
    condition: float


def fit_of(names: tuple[str, ...], exact: ExactFit, given: Given, *, intercept: bool, level: float) -> Fit:
    """Return everything that follows from a fit, each number rounded once.

    Raises `InputRefused` where a coefficient is beyond the range of doubles.
    """
    p, squares, model = len(names), exact.squares, given.total - exact.squares
    df, df_model = given.n - p, p - intercept
    scale = [given.response_unit / unit for unit in given.units]
    coefficients = [Fraction(top, exact.determinant) * unit for top, unit in zip(exact.numerators, scale, strict=True)]
    none = Undefined(Reason.AS_MANY_AS_COEFFICIENTS)
    fit = Fit(
        names=names,
        coefficients=tuple(map(to_double, coefficients)),
        standard_errors=none,
        ci=none,
        level=level,
        t=none,
        p=none,
        covariance=none,
        r_squared=float(model / given.total) if given.total else Undefined(Reason.ALL_Y_EQUAL),
        f=none,
        f_p=none,
        residual_sd=none,
        ss_residual=_double_or_none(squares * given.response_unit**2, "the sum of squares is"),
        condition=given.condition,
        df_model=df_model,
        df=df,
        n=given.n,
    )
    errors: list[Fraction] = []
    if df > 0:
        variance = squares / df
        inverse = exact.inverse_in_units(given.units)
        errors = [exact_root(variance * inverse[j][j]) * given.response_unit for j in range(p)]
        fit = replace(
            fit,
            standard_errors=tuple(map(to_double, errors)),
            covariance=in_doubles(inverse, variance * given.response_unit**2),
            residual_sd=finite(exact_root(variance) * given.response_unit, "the residual standard deviation"),
        )
        of_all = model / df_model
        tests = _tests(fit, coefficients, errors, of_all / variance) if squares else dict.fromkeys(_OF_TESTS, EXACT)
        fit = replace(fit, **tests)
    refuse_beyond("y and a column differ so much in size that a coefficient", map(to_double, (*coefficients, *errors)))
    return fit


_OF_TESTS = "ci", "t", "p", "f", "f_p"


def _tests(fit: Fit, coefficients: list[Fraction], errors: list[Fraction], f: Fraction) -> dict[str, Any]:
    """Return intervals and tests of coefficients with these standard errors, by the names of their fields."""
    quantile = t_quantile(fit.level, fit.df)
    ends = [interval_about(b, quantile, se) for b, se in zip(coefficients, errors, strict=True)]
    lost = next((each for each in ends if isinstance(each, Undefined)), None)
    t = tuple(to_double(b / se) for b, se in zip(coefficients, errors, strict=True))
    of_all, ci = to_double(f), tuple(ends) if lost is None else lost
    if not all(map(math.isfinite, (of_all, *t))):
        return dict.fromkeys(_OF_TESTS, Undefined(Reason.BEYOND_DOUBLES, what="a test statistic")) | {"ci": ci}
    return {
        "ci": ci,
        "t": t,
        "p": tuple(t_two_sided(one, fit.df).p for one in t),
        "f": of_all,
        "f_p": f_upper(of_all, fit.df_model, fit.df).p,
    }


def in_doubles(inverse: list[list[Fraction]], variance: Fraction) -> tuple[tuple[float, ...], ...] | Undefined:
    """Return a covariance in doubles, if its variances keep so clear of their ends that sums of products do too."""
    exact = [[value * variance for value in row] for row in inverse]
    if any(row[j] and not 1 / _LARGEST_VARIANCE < row[j] < _LARGEST_VARIANCE for j, row in enumerate(exact)):
        return BEYOND_DOUBLES
    return tuple(tuple(map(to_double, row)) for row in exact)


def _double_or_none(value: Fraction, what: str) -> float | Undefined:
    double = to_double(value)
    lost = math.isinf(double) or (value > 0 and double < sys.float_info.min)
    return Undefined(Reason.HELD_BY_NO_DOUBLE, what=what) if lost else double


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
