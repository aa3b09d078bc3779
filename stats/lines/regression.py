"""Linear regression whose digits hold: on time stamps, on offsets, on nearly collinear columns.

What the data do not fix is refused with the names of the columns; a plain solver returns the numbers of least norm
instead, which look like any others (W20).

Polynomials are fitted by Chebyshev's about the middle of the range of x, in whole numbers: of 192 bits, or of all where
next to nothing of the response is left over. They are carried back to the caller's powers without rounding. Powers
rounded to doubles cap Filip's data at 8 digits, whatever solves them; numpy's polyfit has no standard errors there.

A line through the origin is fitted to values in groups, such as those of a day, whose errors depend on each other; only
the groups are independent.
"""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from operator import mul
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from data_schema.errors import InputRefused, unknown_name
from data_schema.reasons import Reason
from data_schema.vocabulary import Undefined
from stats.checks import Missing, as_level, as_number, as_values, complete_rows
from stats.compare.shared_error import SharedError, join_errors
from stats.exact.numbers import exact_root, refuse_beyond, to_120_bits, to_double
from stats.lines.columns import (
    as_column,
    as_ticks,
    identifiable,
    named_columns,
    quoted_list,
    refuse_unfit,
    refuse_unidentifiable,
    time_unit,
    time_units,
)
from stats.lines.fit import (
    INTERCEPT,
    ExactFit,
    Fit,
    Given,
    Response,
    exact_fit,
    fit_of,
    in_doubles,
    response_at,
    root_of_form,
)

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True, slots=True)
class LinearFit(Fit):
    """response = intercept + sum of coefficient * column."""

    intercept: bool
    """Whether a constant was fitted."""
    vif: tuple[float, ...]
    """Variance inflation of each column, 1 / (1 - R squared on the other columns); no intercept, shape (columns,)."""
    means: tuple[float, ...]
    """Of each column, in its unit, shape (columns,); 0 without an intercept. The fit is evaluated from there."""
    response_mean: float
    """Fitted response at `means`, in its unit (0 without an intercept)."""
    lowest: tuple[float, ...]
    """Least value of each column, in its unit; shape (columns,)."""
    highest: tuple[float, ...]
    """Largest value of each column, in its unit; shape (columns,)."""

    def _inflations(self) -> tuple[float | Undefined, ...]:
        constant: tuple[float | Undefined, ...] = (Undefined(Reason.INTERCEPT_NO_COLUMN),) if self.intercept else ()
        return (*constant, *self.vif)

    def at(self, values: Mapping[str, float], level: float = 0.95) -> Response:
        """Return the fitted response where each column has the value given.

        Raises `UnknownName` for a name that is no column, `InputRefused` where one is missing or not finite.
        """
        columns = self.names[1:] if self.intercept else self.names
        for name in values:
            if name not in columns:
                raise unknown_name("column", name, columns)
        missing = [name for name in columns if name not in values]
        if missing:
            raise InputRefused(f"no value was given for {quoted_list(missing)}: give one for each column.")
        level = as_level("level", level)
        place = [as_number(f"the value of {name!r}", values[name]) for name in columns]
        ranges = zip(place, self.lowest, self.highest, strict=True)
        extrapolated = any(not low <= value <= high for value, low, high in ranges)
        steps = [Fraction(value) - Fraction(mean) for value, mean in zip(place, self.means, strict=True)]
        skip = int(self.intercept)
        products = (step * Fraction(slope) for step, slope in zip(steps, self.coefficients[skip:], strict=True))
        value = sum(products, Fraction(self.response_mean))
        se: Fraction | Undefined
        if isinstance(self.covariance, Undefined) or isinstance(self.residual_sd, Undefined):
            se = self.covariance if isinstance(self.covariance, Undefined) else Undefined(Reason.FIT_WITHOUT_SCATTER)
        else:
            of_slopes = root_of_form(steps, [row[skip:] for row in self.covariance[skip:]])
            level_variance = Fraction(self.residual_sd) ** 2 / self.n if self.intercept else Fraction(0)
            se = exact_root(level_variance + of_slopes**2)
        return response_at(value, se, level, self.df, extrapolated=extrapolated, exact=self.ss_residual == 0.0)


def fit_linear(
    y: ArrayLike,
    columns: Mapping[str, ArrayLike] | pd.DataFrame,
    *,
    intercept: bool = True,
    level: float = 0.95,
    missing: Missing = "refuse",
) -> LinearFit:
    """Fit y, shape (n,), as a sum of named columns (or those of a data frame), each of shape (n,), by least squares.

    y and columns may be numbers of any real type, whole numbers and decimals (kept exact), or time stamps and durations
    of any kind (in seconds, time stamps since 1970; without a time zone they are taken for UTC). The numbers are those
    of exact arithmetic on the input.
    Raises `InputRefused`, naming the columns, for infinite values, for NaN unless `missing` is "drop" (which leaves
    out rows), lengths that differ, fewer values than coefficients, a constant column beside an intercept, a column of
    zeros, and columns that are collinear.

    >>> fit_linear([1, 3, 5, 8], {"x": [0, 1, 2, 3]}).coefficients
    (0.8, 2.3)
    """
    level = as_level("level", level)
    columns = named_columns(columns)
    (y, *present), left_out = complete_rows([as_ticks(y), *columns.values()], missing)
    columns = dict(zip(columns, present, strict=True))
    n = refuse_unfit(y, columns, intercept)
    response = as_column("y", y)
    by_name = {name: as_column(f"the column {name!r}", values) for name, values in columns.items()}
    refuse_unidentifiable(by_name, intercept)
    given = list(by_name.values())
    skip = int(intercept)
    rows = [*([[1] * n] if intercept else []), *(column.counts for column in given)]
    turned = [column.direction(centred=intercept) for column in given]
    spreads = [column.squares(centred=intercept) for column in given]
    exact = identifiable(exact_fit(rows, response.counts), by_name, turned, spreads, skip)
    means = [Fraction(sum(column.counts), n) * skip for column in given]
    at_means = sum(map(mul, exact.numerators[skip:], means), Fraction(exact.numerators[0]))
    fit = fit_of(
        (INTERCEPT, *columns) if intercept else tuple(columns),
        exact,
        Given(
            units=(*((Fraction(1),) * skip), *(column.unit for column in given)),
            response_unit=response.unit,
            total=response.squares(centred=intercept),
            n=n,
            condition=float(np.linalg.cond(np.array([*([np.full(n, n**-0.5)] if intercept else []), *turned]).T)),
        ),
        intercept=intercept,
        level=level,
    )
    fit = replace(fit, missing=left_out, times=time_units(columns), response_time=time_unit(y))
    return LinearFit(
        **fit.as_fields(),
        intercept=intercept,
        vif=tuple(
            float(spread * Fraction(exact.adjugate[place][place], exact.determinant))
            for place, spread in enumerate(spreads, skip)
        ),
        means=tuple(float(mean * column.unit) for mean, column in zip(means, given, strict=True)),
        response_mean=float(at_means / exact.determinant * response.unit) if intercept else 0.0,
        lowest=tuple(column.lowest for column in given),
        highest=tuple(column.highest for column in given),
    )


_HIGHEST_DEGREE = 20
"""Beyond it a curve through measurements says nothing."""
_BITS = 192
"""Of a wave in whole numbers: the condition of as many waves costs less than 40."""
_NEARLY_EXACT = Fraction(2) ** -120  # of the response's squares: below what rounding it to doubles leaves


@dataclass(frozen=True, slots=True)
class PolynomialFit(Fit):
    """response = sum of coefficients[k] * x**k; the coefficient of x**k is named "x^k"."""

    degree: int
    """The highest power."""
    centre: float
    """Middle of the range of x, in its unit."""
    half_range: float
    """The fit is evaluated in u = (x - centre) / half_range, between -1 and 1."""
    chebyshev_coefficients: tuple[float, ...]
    """Of the Chebyshev polynomials T_k(u), where nothing cancels, in the response's unit; shape (degree + 1,)."""
    chebyshev_covariance: tuple[tuple[float, ...], ...] | Undefined
    """Of these coefficients, shape (degree + 1, degree + 1)."""
    lowest: float
    """Least x, in its unit."""
    highest: float
    """Largest x, in its unit."""

    def at(self, x: float, level: float = 0.95) -> Response:
        """Return the fitted response at x; raises `InputRefused` for an x that is not finite."""
        place = as_number("x", x)
        level = as_level("level", level)
        u = (Fraction(place) - Fraction(self.centre)) / Fraction(self.half_range)
        waves = [Fraction(1), u]
        for _ in range(2, self.degree + 1):
            waves.append(to_120_bits(2 * u * waves[-1] - waves[-2]))
        products = (Fraction(c) * wave for c, wave in zip(self.chebyshev_coefficients, waves, strict=True))
        value, covariance = sum(products, Fraction(0)), self.chebyshev_covariance
        se = covariance if isinstance(covariance, Undefined) else root_of_form(waves, covariance)
        extrapolated = not self.lowest <= place <= self.highest
        return response_at(value, se, level, self.df, extrapolated=extrapolated, exact=self.ss_residual == 0.0)


def fit_polynomial(
    x: ArrayLike, y: ArrayLike, degree: int, *, level: float = 0.95, missing: Missing = "refuse"
) -> PolynomialFit:
    """Fit y over x, both of shape (n,), by a polynomial of the given degree (1 to 20) with an intercept.

    `x` and `y` may be numbers of any real type, or time stamps and durations of any kind (then in seconds, time stamps
    since 1970 UTC).
    Raises `InputRefused` for infinite values, for NaN unless `missing` is "drop" (which leaves out pairs), lengths that
    differ, another degree, or fewer different x than coefficients.

    >>> fit_polynomial([0, 1, 2, 3], [1, 2, 5, 10], degree=2).coefficients
    (1.0, 0.0, 1.0)
    """
    level = as_level("level", level)
    degree = _checked_degree(degree)
    p = degree + 1
    (x, y), left_out = complete_rows([as_ticks(x), as_ticks(y)], missing)
    if np.shape(x) != np.shape(y) or np.size(y) < p:
        raise InputRefused(
            f"x has the shape {np.shape(x)} and y has {np.shape(y)}: give one y for each x, and at least {p} for "
            f"degree {degree}."
        )
    column, response = as_column("x", x), as_column("y", y)
    different = len(set(column.counts))
    if different <= degree:
        raise _too_few(different, degree)
    low, high = min(column.counts), max(column.counts)
    twice = [2 * count - low - high for count in column.counts]
    half_range = high - low
    total = response.squares(centred=True)
    waves, shifts = _fitted(_waves(twice, half_range, degree), response.counts, total)
    if waves is None:
        raise _too_few(different, degree)
    chebyshev_units = tuple(Fraction(2**shift, half_range**power) for power, shift in enumerate(shifts))
    chebyshev = [
        to_double(Fraction(top, waves.determinant) / unit * response.unit)
        for top, unit in zip(waves.numerators, chebyshev_units, strict=True)
    ]
    refuse_beyond("x and y are such that a coefficient", chebyshev)
    fit = fit_of(
        (INTERCEPT, "x", *(f"x^{power}" for power in range(2, p)))[:p],
        waves.reparametrised(_powers(low + high, half_range, shifts)),
        Given(
            units=tuple(2 ** max(shifts) * column.unit**power for power in range(p)),
            response_unit=response.unit,
            total=total,
            n=len(column.counts),
            condition=_condition(twice, half_range, degree),
        ),
        intercept=True,
        level=level,
    )
    fit = replace(fit, missing=left_out, times=time_units({"x": x}), response_time=time_unit(y))
    variance = waves.squares / fit.df * response.unit**2 if fit.df else Fraction(0)
    return PolynomialFit(
        **fit.as_fields(),
        degree=degree,
        centre=float(Fraction(low + high, 2) * column.unit),
        half_range=float(Fraction(half_range, 2) * column.unit),
        chebyshev_coefficients=tuple(chebyshev),
        chebyshev_covariance=fit.covariance
        if not fit.df
        else in_doubles(waves.inverse_in_units(chebyshev_units), variance),
        lowest=column.lowest,
        highest=column.highest,
    )


def _checked_degree(degree: int) -> int:
    if isinstance(degree, bool) or not isinstance(degree, int | np.integer) or not 1 <= degree <= _HIGHEST_DEGREE:
        raise InputRefused(f"the degree is {degree!r}: give a whole number from 1 to {_HIGHEST_DEGREE}.")
    return int(degree)


def _too_few(different: int, degree: int) -> InputRefused:
    return InputRefused(
        f"x has {different} different value{'s' if different != 1 else ''}, which do not fix the {degree + 1} "
        f"coefficients of degree {degree}: choose a lower degree."
    )


def _waves(twice: Sequence[int], half_range: int, degree: int) -> list[list[int]]:
    """Return half_range^k T_k(twice / half_range), whole numbers, for k from 0 to the degree; shape (degree + 1, n)."""
    square = half_range * half_range
    waves = [[1] * len(twice), list(twice)]
    while len(waves) <= degree:
        waves.append([2 * x * a - square * b for x, a, b in zip(twice, waves[-1], waves[-2], strict=True)])
    return waves


def _fitted(rows: list[list[int]], response: Sequence[int], total: Fraction) -> tuple[ExactFit | None, list[int]]:
    """Return the fit of waves without last bits that no coefficient depends on, and how many bits of each that were.

    All stay where next to nothing of the response (its sum of squares: `total`) is left over: the fit may be exact.
    """
    shifts = [max(max(map(abs, row)).bit_length() - _BITS, 0) for row in rows]
    found = exact_fit([[value >> shift for value in row] for row, shift in zip(rows, shifts, strict=True)], response)
    if any(shifts) and (found is None or found.squares <= _NEARLY_EXACT * total):
        return exact_fit(rows, response), [0] * len(rows)
    return found, shifts


def _powers(ends: int, half_range: int, shifts: Sequence[int]) -> list[list[int]]:
    """Return what makes coefficients of powers of the count from those of shortened waves, times 2^-largest shift.

    `twice` of the waves is 2 * count - ends.
    """
    square, degree, most = half_range * half_range, len(shifts) - 1, max(shifts)
    waves = [[1] + [0] * degree, [-ends, 2] + [0] * (degree - 1)]
    while len(waves) <= degree:
        last, before = waves[-1], waves[-2]
        risen = [0, *last[:-1]]
        waves.append([4 * a - 2 * ends * b - square * c for a, b, c in zip(risen, last, before, strict=True)])
    columns = ([value << most - shift for value in wave] for wave, shift in zip(waves, shifts, strict=True))
    return [list(row) for row in zip(*columns, strict=True)]


def _condition(twice: Sequence[int], half_range: int, degree: int) -> float:
    """Return the 2-norm condition of the waves, scaled to one length."""
    waves = np.polynomial.chebyshev.chebvander(np.array([x / half_range for x in twice]), degree)
    return float(np.linalg.cond(waves / np.linalg.norm(waves, axis=0)))


@dataclass(frozen=True, slots=True)
class SlopeThroughOrigin:
    """y = slope * x, with what groups scatter by and what all x have in common.

    `se` is that of the scatter between groups, with `df` degrees of freedom, `shared_se` that of the errors that the x
    share; the interval `ci` holds both. `groups` is their number, `n` that of the values.
    """

    slope: float
    se: float | Undefined
    df: float | Undefined
    shared_se: float
    ci: tuple[float, float] | Undefined
    level: float
    groups: int
    n: int


_ALL_OF_ONE = 1e-9
"""What the other groups hold of the squares where one group alone tells the slope, to rounding."""


def slope_through_origin(
    x: ArrayLike, y: ArrayLike, groups: Sequence[Hashable], shared: Sequence[SharedError] = (), level: float = 0.95
) -> SlopeThroughOrigin:
    """Fit y = slope * x by least squares; only groups are independent of each other.

    The standard error is the cluster-robust CR2 and the interval has Satterthwaite's degrees of freedom, both for a
    working model of independent values of equal variance. With h_g the group's share of sum(x^2) and s_g the sum of
    x * residual in it, the variance is sum(s_g^2 / (1 - h_g)) / sum(x^2)^2, unbiased under that model, and

        1 / df = sum(h_g^2) + sum over pairs g != j of h_g^2 h_j^2 / ((1 - h_g) (1 - h_j)),

    fewer than groups less one where few groups hold most of sum(x^2). For groups that have the same x this is the mean
    of their slopes with its interval: a curve that all of them follow is no scatter. Source: Bell and McCaffrey (2002),
    Pustejovsky and Tipton (2018).
    Errors of x make the slope smaller by their variance over the mean square of x, 0.02 % where they are 1.5 %.

    Parameters
    ----------
    x, y : (n,) values in one unit each
    groups : (n,) the group of each value, such as its day; each value its own where nothing is shared
    shared : (n,) errors that the x have in common with each other, where there are any
    level : of the interval

    Raises
    ------
    InputRefused for lengths that differ, no values, and x that are all 0.
    """
    across, up, level = as_values("the values of x", x), as_values("the values of y", y), as_level("level", level)
    if not across.size == up.size == len(groups) or (shared and len(shared) != across.size):
        raise InputRefused(f"there are {across.size} x, {up.size} y and {len(groups)} groups: give as many of each.")
    squares = float(across @ across) if across.size else 0.0
    if not squares > 0.0:
        raise InputRefused("no x differs from 0, and a line through the origin has no slope: give others.")
    slope = float(across @ up) / squares
    pulls = (up - 2.0 * slope * across) / squares
    error = SharedError()
    for pull, one in zip(pulls.tolist(), shared, strict=bool(shared)):
        error = error.minus(one.times(-pull))
    names = list(dict.fromkeys(group for group, value in zip(groups, across.tolist(), strict=True) if value))
    if len(names) < 2:
        none = Undefined(Reason.SINGLE_NO_SCATTER, unit="run")
        return SlopeThroughOrigin(slope, none, none, error.se, none, level, len(names), across.size)
    of_group = np.array([[group == name for group in groups] for name in names], dtype=np.float64)
    shares = of_group @ across**2 / squares
    if float(shares.max()) >= 1.0 - _ALL_OF_ONE:
        none = Undefined(Reason.SINGLE_NO_SCATTER, unit="group")
        return SlopeThroughOrigin(slope, none, none, error.se, none, level, len(names), across.size)
    se = float(np.sqrt(np.sum((of_group @ (across * (up - slope * across))) ** 2 / (1.0 - shares))) / squares)
    products = np.outer(shares, shares) / np.sqrt(np.outer(1.0 - shares, 1.0 - shares))
    np.fill_diagonal(products, shares)
    df = 1.0 / float(np.sum(products**2))
    ci: tuple[float, float] = (slope, slope)
    if se or error.se:
        _both, half, exponent = join_errors(se, df, error, level)
        ci = slope - float(np.ldexp(half, exponent)), slope + float(np.ldexp(half, exponent))
    return SlopeThroughOrigin(slope, se, df, error.se, ci, level, len(names), across.size)
