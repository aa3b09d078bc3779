"""Polynomials of one variable, in powers formed with twice the digits about the middle of its range.

Powers rounded to doubles cap Filip's data at 8 digits, whatever solves them; numpy's polyfit has none of the standard
errors right there. The fit of the centred powers is carried back to the caller's powers in exact arithmetic.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike

from data_schema.errors import InputRefused
from data_schema.vocabulary import Undefined
from stats.checks import Missing, as_level, as_number
from stats.exact.error_free import (
    FRACTION_BITS,
    fixed_point,
    multiply,
    nearest_double,
    product_of_halves,
    shortened,
    split,
    two_sum,
)
from stats.exact.finite import refuse_beyond, to_double
from stats.lines.columns import Column, as_column, as_response, as_ticks, time_unit, time_units
from stats.lines.complete import complete_rows
from stats.lines.fit import (
    BEYOND_DOUBLES,
    INTERCEPT,
    LEAST_SD,
    Fit,
    Response,
    Scaled,
    fit_of,
    response_at,
    root_of_form,
)
from stats.lines.least_squares import Design, Factor, deciding_places, exact_coefficients, factorise, in_scale, solve

HIGHEST_DEGREE = 20
"""Beyond it the powers' condition exceeds what refinement in double-double answers for."""


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
            waves.append(shortened(2 * u * waves[-1] - waves[-2]))
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
    column, response = as_column("x", x, at_middle=True), as_response(y)
    if column.constant:
        raise _too_few(1, degree)
    stretch = 1.0 / float(np.abs(column.high).max())
    design = _design(column, stretch, degree)
    factor = _factorised(design, column, degree)
    solution = solve(design, factor, response.pair)
    fixed = [fixed_point(*pair) for pair in zip(*(part.tolist() for part in solution.coefficients), strict=True)]
    fixed[0] += fixed_point(response.centre_scaled)
    back = _back(column.centre_scaled, stretch, degree)
    ticks = column.ticks_per_unit
    units = tuple((ticks**power, response.exponent - power * column.exponent) for power in range(p))
    coefficients = _carried(back, fixed)
    chebyshev = tuple(nearest_double(value, response.exponent) for value in fixed)
    exact = None if solution.residuals.any() else _exactly(column, stretch, response, design, factor)
    if exact is not None:
        coefficients, chebyshev = in_scale(exact[0], units), tuple(map(to_double, exact[1]))
    scaled = Scaled(
        coefficients=coefficients,
        fitted=solution.fitted,
        residuals=solution.residuals,
        response_exponent=response.exponent,
        rows=factor.carried(np.array([[nearest_double(weight) if weight else 0.0 for weight in row] for row in back])),
        units=units,
        condition=factor.condition,
    )
    refuse_beyond("x and y are such that a coefficient", chebyshev)
    names = (INTERCEPT, "x", *(f"x^{power}" for power in range(2, p)))[:p]
    fit = fit_of(names, scaled, intercept=True, level=level, missing=left_out)
    fit = replace(fit, times=time_units({"x": x}), response_time=time_unit(y))
    return PolynomialFit(
        **fit.as_fields(),
        degree=degree,
        centre=column.centre / ticks,
        half_range=math.ldexp(1.0 / stretch, column.exponent) / ticks,
        chebyshev_coefficients=chebyshev,
        chebyshev_covariance=_chebyshev_covariance(fit.residual_sd, factor),
        lowest=column.lowest,
        highest=column.highest,
    )


def _checked_degree(degree: int) -> int:
    if isinstance(degree, bool) or not isinstance(degree, int | np.integer) or not 1 <= degree <= HIGHEST_DEGREE:
        raise InputRefused(f"the degree is {degree!r}: give a whole number from 1 to {HIGHEST_DEGREE}.")
    return int(degree)


def _factorised(design: Design, column: Column, degree: int) -> Factor:
    """Return the factor of the design; raises `InputRefused` where x does not fix that many coefficients."""
    factor = factorise(design)
    if isinstance(factor, Factor):
        return factor
    different = np.unique(np.stack(column.pair), axis=1).shape[1]
    if different <= degree:
        raise _too_few(different, degree)
    raise InputRefused(
        f"the powers of x up to {degree} are collinear to the last digit on these values: choose a lower degree."
    )


def _too_few(different: int, degree: int) -> InputRefused:
    return InputRefused(
        f"x has {different} different value{'s' if different != 1 else ''}, which do not fix the {degree + 1} "
        f"coefficients of degree {degree}: choose a lower degree."
    )


def _design(column: Column, stretch: float, degree: int) -> Design:
    """Return T_0(u) to T_degree(u), u = stretch * column, by 2 u T_k - T_(k - 1) in double-double."""
    high, low = column.pair
    factor = np.array(stretch)
    product, error = product_of_halves(high, split(high), factor, split(factor))
    u = two_sum(product, error + low * stretch)
    waves = [(np.ones_like(high), np.zeros_like(high)), u]
    for _ in range(2, degree + 1):
        last, before = multiply(u, waves[-1]), waves[-2]
        total, error = two_sum(2.0 * last[0], -before[0])
        waves.append(two_sum(total, error + (2.0 * last[1] - before[1])))
    rows, lower = np.array([wave[0] for wave in waves]), np.array([wave[1] for wave in waves[1:]])
    return Design(rows, lower if lower.any() else None, True, np.sqrt((rows * rows).sum(axis=1)))


def _chebyshev_covariance(sd: float | Undefined, factor: Factor) -> tuple[tuple[float, ...], ...] | Undefined:
    """Return that of the coefficients of T_k(u), shape (p, p), for a residual standard deviation."""
    if isinstance(sd, Undefined):
        return sd
    if sd > 0.0 and not LEAST_SD < sd < 1.0 / LEAST_SD:
        return BEYOND_DOUBLES
    rows = sd * factor.inverse
    return tuple(tuple(row) for row in (rows @ rows.T).tolist())


def _exactly(
    column: Column, stretch: float, response: Column, design: Design, factor: Factor
) -> tuple[list[Fraction], list[Fraction]] | None:
    """Return coefficients of the powers and of T_k(u) that leave nothing over of the response, if there are such."""
    places, count = deciding_places(design, factor), len(design.high)
    x, y = column.exactly(places), response.exactly(places)
    powers = exact_coefficients([[value**power for value in x] for power in range(count)], y)
    unit = Fraction(stretch) / Fraction(2) ** column.exponent
    u = [unit * (value - Fraction(column.centre)) for value in x]
    waves = [[Fraction(1)] * len(u), u]
    while len(waves) < count:
        waves.append([2 * a * b - c for a, b, c in zip(u, waves[-1], waves[-2], strict=True)])
    chebyshev = exact_coefficients(waves, y)
    return None if powers is None or chebyshev is None else (powers, chebyshev)


@lru_cache(maxsize=HIGHEST_DEGREE)
def _chebyshev(degree: int) -> list[list[int]]:
    """Return row k: the whole-number coefficients of T_k in powers of its argument."""
    rows = [[1] + [0] * degree, [0, 1] + [0] * (degree - 1)]
    for _ in range(2, degree + 1):
        doubled = [0, *(2 * value for value in rows[-1][:-1])]
        rows.append([a - b for a, b in zip(doubled, rows[-2], strict=True)])
    return rows


def _carried(back: list[list[int]], fixed: list[int]) -> list[float]:
    """Return the coefficients of powers of x, but for their units, from those of T_k(u), in fixed point."""
    return [
        nearest_double(sum(weight * value for weight, value in zip(row, fixed, strict=True)) >> FRACTION_BITS)
        for row in back
    ]


def _back(centre: float, stretch: float, degree: int) -> list[list[int]]:
    """Return what makes coefficients of powers of x from those of T_k(stretch * (x - centre)), in fixed point."""
    step, scale = -fixed_point(centre), fixed_point(stretch)
    powers, scales = [1 << FRACTION_BITS], [1 << FRACTION_BITS]
    for _ in range(degree):
        powers.append(powers[-1] * step >> FRACTION_BITS)
        scales.append(scales[-1] * scale >> FRACTION_BITS)
    shift = [
        [math.comb(i, j) * powers[i - j] * scales[i] >> FRACTION_BITS for i in range(j, degree + 1)]
        for j in range(degree + 1)
    ]
    # T_k has powers of one parity, up to k.
    return [
        [
            sum(weight * wave[i] for i, weight in enumerate(row, j) if i <= k and (k - i) % 2 == 0)
            for k, wave in enumerate(_chebyshev(degree))
        ]
        for j, row in enumerate(shift)
    ]
