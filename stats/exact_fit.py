"""Coefficients of a fit that leaves nothing over, in rational numbers: an intercept of 0 is 0, and not 1e-31."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction


def exact_coefficients(columns: Sequence[Sequence[Fraction]], y: Sequence[Fraction]) -> list[Fraction] | None:
    """Return the coefficients of p columns, each of shape (n,), whose sum is y, shape (n,), at every place.

    None where no coefficients do that, or where the columns do not fix them.
    """
    places = iter(zip(*columns, y, strict=True))
    solved: dict[int, list[Fraction]] = {}
    while len(solved) < len(columns):
        place = next(places, None)
        if place is None:
            return None
        rest = list(place)
        for column, equation in solved.items():
            rest = _less(rest, rest[column], equation)
        pivot = next((column for column, weight in enumerate(rest[:-1]) if weight), None)
        if pivot is not None:
            equation = [weight / rest[pivot] for weight in rest]
            solved = {column: _less(row, row[pivot], equation) for column, row in solved.items()}
            solved[pivot] = equation
        elif rest[-1]:
            return None
    coefficients = [solved[column][-1] for column in range(len(columns))]
    for *weights, value in places:
        if sum((c * weight for c, weight in zip(coefficients, weights, strict=True)), Fraction(0)) != value:
            return None
    return coefficients


def in_scale(coefficients: Sequence[Fraction], units: Sequence[tuple[float, int]]) -> list[float]:
    """Return coefficients over the powers of two of their units."""
    return [float(value / Fraction(2) ** exponent) for value, (_, exponent) in zip(coefficients, units, strict=True)]


def _less(row: Sequence[Fraction], times: Fraction, other: Sequence[Fraction]) -> list[Fraction]:
    return [value - times * taken for value, taken in zip(row, other, strict=True)]
