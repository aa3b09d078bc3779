"""Linear regression by least squares on centred and scaled columns, so that offsets and units cost no digits.

What the data do not fix is refused with the names of the columns; a plain solver returns the numbers of least norm
instead, which look like any others.

A line through the origin is fitted to values in groups, such as those of a day, whose errors depend on each other; only
the groups are independent.
"""

from __future__ import annotations

import math
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from data_schema.errors import InputRefused, unknown_name
from data_schema.reasons import Reason
from data_schema.vocabulary import Undefined
from stats.checks import as_level, as_number, as_values
from stats.compare.shared_error import SharedError, joined_half_width
from stats.results import Result
from stats.scatter import Floats, Interval, Scale, Value, scale_of, times_power
from stats.tails import t_quantile, t_two_sided

if TYPE_CHECKING:
    import pandas as pd

INTERCEPT = "intercept"
EXACT = Undefined(Reason.FIT_EXACT)
_EPS = float(np.finfo(np.float64).eps)


@dataclass(frozen=True, slots=True)
class Response(Result):
    """The fitted response at one place."""

    value: float
    """In the unit of the response."""
    se: Value
    """Standard error of the mean response there, not of one more measurement; in the unit of the response."""
    ci: Interval | Undefined
    """Student's interval of the mean response; undefined where the fit is exact."""
    level: float
    """Level of the interval."""
    df: int
    """Degrees of freedom of the fit."""


@dataclass(frozen=True, slots=True)
class LinearFit(Result):
    """response = intercept + sum of coefficient * column; units are those of the response over its column's."""

    names: tuple[str, ...]
    """Of the coefficients: "intercept" first where there is one; shape (p,)."""
    coefficients: tuple[float, ...]
    """In the order of `names`, shape (p,)."""
    standard_errors: tuple[float, ...] | Undefined
    """Of the coefficients, in their units, shape (p,); 0 where the fit is exact."""
    ci: tuple[Interval, ...] | Undefined
    """Student's interval of each coefficient, in its unit, shape (p, 2); undefined for an exact fit."""
    level: float
    """Level of the intervals."""
    t: tuple[float, ...] | Undefined
    """Coefficient over standard error, shape (p,); undefined for an exact fit."""
    p: tuple[float, ...] | Undefined
    """Two-sided, of each coefficient being 0; shape (p,)."""
    r_squared: Value
    """About the mean with an intercept, about 0 without; 0 to 1."""
    residual_sd: Value
    """sqrt(SS_residual / df), in the unit of the response; exactly 0 for a fit that is exact but for rounding."""
    df: int
    """n minus the number of coefficients."""
    n: int
    """Number of values."""
    intercept: bool
    """Whether a constant was fitted."""
    covariance: tuple[tuple[float, ...], ...] | Undefined
    """Of the coefficients of the columns, without the intercept, in the products of their units."""
    means: tuple[float, ...]
    """Of each column, in its unit, shape (columns,); 0 without an intercept. The fit is evaluated from there."""
    response_mean: float
    """Fitted response at `means`, in its unit (0 without an intercept)."""

    @property
    def exact(self) -> bool:
        """Whether nothing is left over of the response but rounding."""
        return self.residual_sd == 0.0

    def spread(self, what: str) -> tuple[tuple[float, ...], float]:
        """Return standard errors and residual standard deviation of what is nothing without them.

        Raises `InputRefused` where one of them is undefined.
        """
        errors, sd = self.standard_errors, self.residual_sd
        if isinstance(errors, Undefined) or isinstance(sd, Undefined):
            reason = next(part.reason for part in (errors, sd) if isinstance(part, Undefined))
            raise InputRefused(f"{what} has no uncertainty, because {reason}: give more rows.")
        return errors, sd

    def intervals(self) -> tuple[Interval | Undefined, ...]:
        """Return the interval of each coefficient, shape (p,)."""
        return (self.ci,) * len(self.names) if isinstance(self.ci, Undefined) else self.ci

    def at(self, values: Mapping[str, float], level: float = 0.95) -> Response:
        """Return the fitted response where each column has the value given.

        Raises `UnknownName` for a name that is no column, `InputRefused` where one is missing or not finite.
        """
        skip = int(self.intercept)
        columns = self.names[skip:]
        for name in values:
            if name not in columns:
                raise unknown_name("column", name, columns)
        missing = [name for name in columns if name not in values]
        if missing:
            raise InputRefused(f"no value was given for {quoted_list(missing)}: give one for each column.")
        level = as_level("level", level)
        place = [as_number(f"the value of {name!r}", values[name]) for name in columns]
        steps = np.array(place) - np.array(self.means)
        value = self.response_mean + float(steps @ np.array(self.coefficients[skip:]))
        if isinstance(self.covariance, Undefined) or isinstance(self.residual_sd, Undefined):
            none = Undefined(Reason.FIT_WITHOUT_SCATTER)
            return Response(value, none, none, level, self.df)
        of_slopes = math.sqrt(max(0.0, float(steps @ np.array(self.covariance) @ steps)))
        se = math.hypot(of_slopes, self.residual_sd / math.sqrt(self.n) if self.intercept else 0.0)
        half = t_quantile(level, self.df) * se
        ci = EXACT if self.exact else (value - half, value + half)
        return Response(value, se, ci, level, self.df)


def quoted_list(names: Sequence[str]) -> str:
    """Return names in quotes: 'a', 'b' and 'c'."""
    quoted = [repr(name) for name in names]
    return " and ".join(filter(None, (", ".join(quoted[:-1]), quoted[-1])))


def fit_linear(
    y: ArrayLike,
    columns: Mapping[str, ArrayLike] | pd.DataFrame,
    *,
    intercept: bool = True,
    level: float = 0.95,
) -> LinearFit:
    """Fit y, shape (n,), as a sum of named columns (or those of a data frame), each of shape (n,), by least squares.

    Raises `InputRefused`, naming the columns, for values that are missing or infinite, lengths that differ, fewer
    values than coefficients, a constant column beside an intercept, a column of zeros, and columns that are collinear.

    >>> [round(value, 9) for value in fit_linear([1, 3, 5, 8], {"x": [0, 1, 2, 3]}).coefficients]
    [0.8, 2.3]
    """
    level = as_level("level", level)
    response = as_values("y", y)
    by_name = {name: as_values(f"the column {name!r}", values) for name, values in _named(columns).items()}
    _refuse_unfit(response, by_name, intercept)
    skip, n, k = int(intercept), response.size, len(by_name)
    y_scale, scaled_y, y_mean = _centred(response, intercept)
    scales, means, rows = [], [], []
    for values in by_name.values():
        scale, scaled, mean = _centred(values, intercept)
        scales.append(scale)
        means.append(mean)
        rows.append(scaled)
    lengths = np.array([float(np.linalg.norm(row)) for row in rows])
    design = np.array(rows).T / lengths
    _refuse_collinear(design, by_name)
    q, r = np.linalg.qr(design)
    solution = np.linalg.solve(r, q.T @ scaled_y)
    solution = solution + np.linalg.solve(r, q.T @ (scaled_y - design @ solution))  # one step takes off the rounding
    residuals, total = scaled_y - design @ solution, float(scaled_y @ scaled_y)
    squares = float(residuals @ residuals)
    if squares <= (8.0 * n * _EPS) ** 2 * max(total, n * times_power(y_mean, -y_scale.exponent) ** 2):
        squares = 0.0  # what is left is rounding
    inverse = np.linalg.inv(r)
    units = np.array([times_power(1.0, y_scale.exponent - scale.exponent) for scale in scales]) / lengths
    slopes = solution * units
    at_means = [mean if intercept else 0.0 for mean in means]
    constant = (
        [y_mean - math.fsum(slope * mean for slope, mean in zip(slopes, means, strict=True))] if intercept else []
    )
    coefficients = (*constant, *slopes.tolist())
    if not all(map(math.isfinite, coefficients)):
        raise InputRefused("y and a column differ so much in size that a coefficient exceeds 1.8e308: change units.")
    df = n - k - skip
    r_squared = (total - squares) / total if total > 0.0 else Undefined(Reason.ALL_Y_EQUAL)
    parts: dict[str, Any] = dict.fromkeys(
        ("standard_errors", "ci", "t", "p", "residual_sd", "covariance"),
        Undefined(Reason.AS_MANY_AS_COEFFICIENTS),
    )
    if df > 0:
        sd = math.sqrt(squares / df)
        of_units = inverse * (units * sd)[:, None]
        with np.errstate(over="ignore", under="ignore"):
            covariance = of_units @ of_units.T
        errors = [math.hypot(*row) for row in of_units.tolist()]
        residual_sd = times_power(sd, y_scale.exponent)
        if intercept:
            at_zero = math.hypot(*(np.array(at_means) @ of_units).tolist())
            errors.insert(0, math.hypot(residual_sd / math.sqrt(n), at_zero))
        parts |= {"standard_errors": tuple(errors), "residual_sd": residual_sd}
        parts["covariance"] = tuple(tuple(row) for row in covariance.tolist())
        parts |= _tests(coefficients, errors, df, level)
    return LinearFit(
        names=(INTERCEPT, *by_name) if intercept else tuple(by_name),
        coefficients=coefficients,
        level=level,
        r_squared=r_squared,
        df=df,
        n=n,
        intercept=intercept,
        means=tuple(at_means),
        response_mean=y_mean if intercept else 0.0,
        **parts,
    )


def _tests(coefficients: Sequence[float], errors: Sequence[float], df: int, level: float) -> dict[str, Any]:
    """Return intervals and tests of coefficients with these standard errors, by the names of their fields."""
    if not all(errors):
        return dict.fromkeys(("ci", "t", "p"), EXACT)
    quantile = t_quantile(level, df)
    both = list(zip(coefficients, errors, strict=True))
    t = tuple(value / error for value, error in both)
    return {
        "ci": tuple((value - quantile * error, value + quantile * error) for value, error in both),
        "t": t,
        "p": tuple(t_two_sided(one, df) for one in t),
    }


def _named(columns: Any) -> dict[str, Any]:
    """Return columns by their names; raises `InputRefused` where they have none."""
    if not hasattr(columns, "keys"):
        raise InputRefused('the columns have no names: give them by name, {"temperature": [...]}, or as a data frame.')
    return {str(name): columns[name] for name in columns}


def _refuse_unfit(y: Floats, columns: Mapping[str, Floats], intercept: bool) -> None:
    p = len(columns) + intercept
    if not columns or y.size < p:
        raise InputRefused(
            f"{p} coefficients were asked of {y.size} values of y: give at least one column and no fewer values than "
            "coefficients."
        )
    if intercept and INTERCEPT in columns:
        raise InputRefused(f"a column is named {INTERCEPT!r}, as the constant that is fitted: name it otherwise.")
    for name, values in columns.items():
        if values.size != y.size:
            raise InputRefused(
                f"the column {name!r} has {values.size} values and y has {y.size}: give one of each column for each "
                "of y."
            )
        if values.min() == values.max() and (intercept or not values.any()):
            what = "is constant beside an intercept" if intercept else "holds only zeros"
            raise InputRefused(f"the column {name!r} {what}: its coefficient is not identifiable, leave it out.")


def _centred(values: Floats, intercept: bool) -> tuple[Scale, Floats, float]:
    """Return a scale, the values in it (about their mean, with an intercept), and that mean in their own unit."""
    if not intercept:
        scale = Scale(0.0, math.frexp(float(np.abs(values).max()))[1])
        return scale, scale.scaled(values), 0.0
    scale = scale_of(values)
    scaled = scale.scaled(values)
    if values.min() == values.max():
        return scale, np.zeros(values.size), float(values[0])
    mean = float(scaled.mean())
    return scale, scaled - mean, scale.place(mean)


def _refuse_collinear(design: Floats, columns: Mapping[str, Floats]) -> None:
    """Raise `InputRefused` where columns of length 1 depend on each other, but for what their values are rounded by."""
    _left, singular, right = np.linalg.svd(design, full_matrices=False)
    rounding = max(
        float(np.abs(values).max()) / max(float(values.max()) / 2.0 - float(values.min()) / 2.0, 1e-300)
        for values in columns.values()
    )
    if singular[-1] <= 4.0 * design.shape[0] * _EPS * max(1.0, rounding):
        together = [name for name, share in zip(columns, np.abs(right[-1]), strict=True) if share > _TAKES_PART]
        raise InputRefused(
            f"the columns {quoted_list(together)} are collinear to the last digit, so that their coefficients are not "
            "identifiable: leave one of them out."
        )


_TAKES_PART = 1e-3
"""Share of a column in a combination of columns that is 0, from which it is named."""


@dataclass(frozen=True, slots=True)
class SlopeThroughOrigin:
    """y = slope * x, with what groups scatter by and what all x have in common.

    `se` is that of the scatter between groups, with `df` degrees of freedom, `shared_se` that of the errors that the x
    share; the interval `ci` holds both. `groups` is their number, `n` that of the values.
    """

    slope: float
    se: Value
    df: Value
    shared_se: float
    ci: Interval | Undefined
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
    of_group = np.array([[group == name for group in groups] for name in names], np.float64)
    shares = of_group @ across**2 / squares
    if float(shares.max()) >= 1.0 - _ALL_OF_ONE:
        none = Undefined(Reason.SINGLE_NO_SCATTER, unit="run" if len(names) < 2 else "group")
        return SlopeThroughOrigin(slope, none, none, error.se, none, level, len(names), across.size)
    se = float(np.sqrt(np.sum((of_group @ (across * (up - slope * across))) ** 2 / (1.0 - shares))) / squares)
    products = np.outer(shares, shares) / np.sqrt(np.outer(1.0 - shares, 1.0 - shares))
    np.fill_diagonal(products, shares)
    df = 1.0 / float(np.sum(products**2))
    ci: Interval = (slope, slope)
    if se or error.se:
        half = joined_half_width(se, df, error, level)
        ci = slope - half, slope + half
    return SlopeThroughOrigin(slope, se, df, error.se, ci, level, len(names), across.size)
