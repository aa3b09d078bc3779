"""The root of a function between two places where it has other signs, without loading `scipy.optimize`.

That package takes a tenth of a second, of the three in which a report of a selection is made.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

Point = tuple[float, float]
"""A place and the function's value there."""

_ENOUGH = 2.0 * float(np.finfo(np.float64).eps)


def root_between(function: Callable[[float], float], one: Point, other: Point, most_steps: int = 200) -> float:
    """Return where a function is 0 between two places at which it has other signs, to the last digits.

    By inverse quadratic interpolation where the three last places allow it, and by halves elsewhere: where a value is
    infinite, or the function has steps.

    Source: Chandrupatla (1997), Advances in Engineering Software 28, 145.
    """
    (a, f_a), (b, f_b), share = one, other, 0.5
    best = a
    for _ in range(most_steps):
        place = a + share * (b - a)
        value = function(place)
        if (value > 0.0) == (f_a > 0.0):
            c, f_c = a, f_a
        else:
            (c, f_c), (b, f_b) = (b, f_b), (a, f_a)
        a, f_a = place, value
        best = a if abs(f_a) < abs(f_b) else b
        if value == 0.0 or abs(b - a) <= 2.0 * _ENOUGH * abs(best):
            return best
        least = _ENOUGH * abs(best) / abs(b - a)
        share = min(max(_share((a, f_a), (b, f_b), (c, f_c)), least), 1.0 - least)
    return best


def _share(a: Point, b: Point, c: Point) -> float:
    """Return how far from `a` to `b` the root lies by the three places, a half where they do not tell."""
    (x_a, f_a), (x_b, f_b), (x_c, f_c) = a, b, c
    if not all(map(math.isfinite, (f_a, f_b, f_c))) or len({f_a, f_b, f_c}) < 3:
        return 0.5
    xi, phi = (x_a - x_b) / (x_c - x_b), (f_a - f_b) / (f_c - f_b)
    if not (phi * phi < xi and (1.0 - phi) ** 2 < 1.0 - xi):
        return 0.5
    return f_a / (f_b - f_a) * f_c / (f_b - f_c) + (x_c - x_a) / (x_b - x_a) * f_a / (f_c - f_a) * f_b / (f_c - f_b)
