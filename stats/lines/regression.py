"""Linear regression whose digits hold: on time stamps, on offsets, on nearly collinear columns.

What the data do not fix is refused with the names of the columns; a plain solver returns the numbers of least norm
instead, which look like any others (W20).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from operator import mul
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from data_schema.errors import InputRefused, unknown_name
from data_schema.vocabulary import Undefined
from stats.checks import Missing, as_level, as_number
from stats.exact.error_free import FRACTION_BITS, Floats, exact_root, fixed_point, nearest_double
from stats.lines.columns import Column, as_column, as_response, as_ticks, time_unit, time_units
from stats.lines.complete import complete_rows
from stats.lines.fit import INTERCEPT, Fit, Response, Scaled, fit_of, response_at, root_of_form
from stats.lines.least_squares import (
    Design,
    Factor,
    Solution,
    deciding_places,
    exact_coefficients,
    factorise,
    in_scale,
    solve,
)


@dataclass(frozen=True)
class CentredColumns:
    """What was fitted: columns and response, about their centres where there is an intercept."""

    columns: Sequence[Column]
    response: Column
    intercept: bool

    @cached_property
    def off_centre(self) -> list[float]:
        """Mean of each column minus its centre, in the column's scale; 0 without an intercept."""
        return [float(column.high.sum()) / column.high.size if self.intercept else 0.0 for column in self.columns]

    @property
    def means(self) -> tuple[float, ...]:
        """Of each column, in its unit; 0 without an intercept."""
        return tuple(
            (column.centre + math.ldexp(off, column.exponent)) / column.ticks_per_unit
            for column, off in zip(self.columns, self.off_centre, strict=True)
        )

    @property
    def units(self) -> tuple[tuple[float, int], ...]:
        """Factor and power of two of each coefficient."""
        constant = [(1.0, self.response.exponent)] if self.intercept else []
        return *constant, *((one.ticks_per_unit, self.response.exponent - one.exponent) for one in self.columns)

    @property
    def back(self) -> Floats:
        """What makes coefficients of the columns as they were of those of the centred ones; shape (p, p)."""
        matrix = np.eye(len(self.columns) + self.intercept)
        if self.intercept:
            matrix[0, 1:] = [-column.centre_scaled for column in self.columns]
        return matrix

    def callers(self, solution: Solution, design: Design, factor: Factor) -> tuple[list[float], float]:
        """Return the coefficients but for their units, and the response at the columns' means (0 without intercept).

        Only the intercept is a sum in the caller's terms: it is taken with all digits, those of an exact fit exactly.
        """
        exact = None if solution.residuals.any() else self._exact(deciding_places(design, factor))
        if exact is not None:
            return in_scale(exact, self.units), self._exact_response(exact)
        parts = zip(*(part.tolist() for part in solution.coefficients), strict=True)
        fixed, response_mean = [fixed_point(*pair) for pair in parts], 0.0
        if self.intercept:
            fixed[0] += fixed_point(self.response.centre_scaled)
            response_mean = nearest_double(_along(fixed, self.off_centre), self.response.exponent)
            fixed[0] = _along(fixed, [-column.centre_scaled for column in self.columns])
        return [nearest_double(value) for value in fixed], response_mean

    def _exact(self, places: list[int]) -> list[Fraction] | None:
        """Return coefficients that leave nothing over of the response at some places, if there are such."""
        constant = [[Fraction(1)] * len(places)] if self.intercept else []
        columns = [*constant, *(column.exactly(places) for column in self.columns)]
        return exact_coefficients(columns, self.response.exactly(places))

    def _exact_response(self, coefficients: Sequence[Fraction]) -> float:
        if not self.intercept:
            return 0.0
        means = (
            Fraction(column.centre) + Fraction(off) * Fraction(2) ** column.exponent
            for column, off in zip(self.columns, self.off_centre, strict=True)
        )
        return float(sum(map(mul, coefficients[1:], means), coefficients[0]))


def _along(fixed: Sequence[int], steps: Sequence[float]) -> int:
    """Return fixed[0] + the sum of fixed[j] * steps[j - 1]."""
    products = (value * fixed_point(step) for value, step in zip(fixed[1:], steps, strict=True))
    return fixed[0] + (sum(products) >> FRACTION_BITS)


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
        constant: tuple[float | Undefined, ...] = (Undefined("the intercept is no column"),) if self.intercept else ()
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
            raise InputRefused(f"no value was given for {_named(missing)}: give one for each column.")
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
            se = self.covariance if isinstance(self.covariance, Undefined) else Undefined("the fit has no scatter")
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
    """
    level = as_level("level", level)
    columns = _as_columns(columns)
    (y, *kept), left_out = complete_rows([as_ticks(y), *columns.values()], missing)
    columns = dict(zip(columns, kept, strict=True))
    n = _check(y, columns, intercept)
    response = as_response(y, centred=intercept)
    regressors = {
        name: as_column(f"the column {name!r}", values, centred=intercept) for name, values in columns.items()
    }
    _check_identifiable(regressors, intercept)
    given = list(regressors.values())
    names = (INTERCEPT, *columns) if intercept else tuple(columns)
    design = _design(given, n, intercept)
    factor = factorise(design)
    if not isinstance(factor, Factor):
        raise InputRefused(
            f"the columns {_named(_collinear(columns, [names[row] for row in factor]))} are collinear to the last "
            "digit, so that their coefficients are not identifiable: leave one of them out."
        )
    solution = solve(design, factor, response.pair)
    centred = CentredColumns(given, response, intercept)
    coefficients, response_mean = centred.callers(solution, design, factor)
    scaled = Scaled(
        coefficients=coefficients,
        fitted=solution.fitted,
        residuals=solution.residuals,
        response_exponent=response.exponent,
        rows=factor.carried(centred.back),
        units=centred.units,
        condition=factor.condition,
    )
    skip = int(intercept)
    return LinearFit(
        **replace(
            fit_of(names, scaled, intercept=intercept, level=level, missing=left_out),
            times=time_units(columns),
            response_time=time_unit(y),
        ).as_fields(),
        intercept=intercept,
        vif=tuple(((factor.norms[skip:] / factor.distances[skip:]) ** 2).tolist()),
        means=centred.means,
        response_mean=response_mean,
        lowest=tuple(column.lowest for column in given),
        highest=tuple(column.highest for column in given),
    )


def _as_columns(columns: Any) -> dict[str, ArrayLike]:
    """Return columns by their names; raises `InputRefused` where they have none."""
    if hasattr(columns, "columns"):  # a data frame
        columns = {str(name): columns[name] for name in columns.columns}
    if not isinstance(columns, Mapping):
        raise InputRefused('the columns have no names: give them by name, {"temperature": [...]}, or as a data frame.')
    return {name: as_ticks(values) for name, values in columns.items()}


def _check(y: ArrayLike, columns: Mapping[str, ArrayLike], intercept: bool) -> int:
    """Return the number of values, after what does not fit together was refused."""
    n, p = int(np.size(y)), len(columns) + intercept
    if not columns or n < p:
        raise InputRefused(
            f"{p} coefficients were asked of {n} values of y: give at least one column and no fewer values than "
            "coefficients."
        )
    for name, values in columns.items():
        if np.shape(values) != np.shape(y):
            raise InputRefused(
                f"the column {name!r} has the shape {np.shape(values)} and y has {np.shape(y)}: give one value of "
                "each column for each of y."
            )
    if intercept and INTERCEPT in columns:
        raise InputRefused(f"a column is named {INTERCEPT!r}, as the constant that is fitted: name it otherwise.")
    return n


def _check_identifiable(columns: Mapping[str, Column], intercept: bool) -> None:
    for name, column in columns.items():
        if column.constant and (intercept or not column.high.any()):
            what = "is constant beside an intercept" if intercept else "holds only zeros"
            raise InputRefused(f"the column {name!r} {what}: its coefficient is not identifiable, leave it out.")


def _collinear(columns: Mapping[str, ArrayLike], found: list[str]) -> list[str]:
    """Return the names of those found collinear without the intercept, where it only takes up what centring moved."""
    names = [name for name in found if name != INTERCEPT]
    if len(names) == len(found):
        return found
    uncentred = [as_column(name, columns[name], centred=False) for name in names]
    alone = factorise(_design(uncentred, uncentred[0].high.size, intercept=False))
    return found if isinstance(alone, Factor) else [names[row] for row in alone]


def _design(columns: list[Column], n: int, intercept: bool) -> Design:
    high = [column.high for column in columns]
    low = [column.low for column in columns]
    if intercept:
        high.insert(0, np.ones(n))
    # What rounding did to a column is a share of its values, not of what centring left of them.
    sizes = [
        math.sqrt(float(column.high @ column.high) + (0.0 if column.exact else n * column.centre_scaled**2))
        for column in columns
    ]
    rows = np.array(high)
    lower = None
    if any(part is not None for part in low):
        lower = np.array([np.zeros(n) if part is None else part for part in low])
    return Design(rows, lower, intercept, np.array(([0.0] if intercept else []) + sizes))


def _named(names: list[str]) -> str:
    quoted = [repr(name) for name in names]
    return quoted[0] if len(quoted) == 1 else f"{', '.join(quoted[:-1])} and {quoted[-1]}"
