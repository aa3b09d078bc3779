"""From a fit of columns about their centres to the caller's columns: nothing that cancels loses a digit on the way."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from operator import mul

import numpy as np

from stats.exact.double_double import FRACTION_BITS, Floats, fixed_point, nearest_double
from stats.lines.columns import Column
from stats.lines.exact_fit import deciding_places, exact_coefficients, in_scale
from stats.lines.least_squares import Design, Factor, Solution


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
