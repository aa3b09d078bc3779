"""Coefficients of a fit that leaves nothing over, in rational numbers: an intercept of 0 is 0, and not 1e-31.

That nothing is left over is known to about 28 digits before. Rational coefficients are those of as many places as fix
them, which are chosen well apart, and are taken where they are right at places between, too.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

import numpy as np

from stats.exact.finite import to_double
from stats.lines.least_squares import Design, Factor

_BETWEEN = 6
"""Places at which the coefficients are checked beside those that fix them."""


def deciding_places(design: Design, factor: Factor) -> list[int]:
    """Return the places that fix the p coefficients, each the farthest from those before, and some between."""
    left = factor.inverse.T @ design.high
    fixing: list[int] = []
    for _ in range(len(left)):
        if fixing:
            direction = left[:, fixing[-1]] / np.linalg.norm(left[:, fixing[-1]])
            left -= np.outer(direction, direction @ left)
        fixing.append(int(np.argmax((left * left).sum(axis=0))))
    between = np.linspace(0, left.shape[1] - 1, _BETWEEN).astype(int).tolist()
    return list(dict.fromkeys([*fixing, *between]))


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
    """Return coefficients over the powers of two of their units; infinite where doubles end."""
    return [
        to_double(value / Fraction(2) ** exponent) for value, (_, exponent) in zip(coefficients, units, strict=True)
    ]


def _less(row: Sequence[Fraction], times: Fraction, other: Sequence[Fraction]) -> list[Fraction]:
    return [value - times * taken for value, taken in zip(row, other, strict=True)]
