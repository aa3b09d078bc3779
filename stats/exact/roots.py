"""The root of a function between two places where it has other signs, without loading `scipy.optimize`.

That package takes a tenth of a second, of the three in which a report of a selection is made.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from stats.exact.numbers import Floats

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
        share = min(max(float(next_share(a, f_a, b, f_b, c, f_c)), least), 1.0 - least)
    return best


def next_share(a: ArrayLike, f_a: ArrayLike, b: ArrayLike, f_b: ArrayLike, c: ArrayLike, f_c: ArrayLike) -> Floats:
    """Return how far from a to b to look next, of one root or many: a half where the three values do not tell."""
    a, f_a, b, f_b, c, f_c = (np.asarray(each, dtype=np.float64) for each in (a, f_a, b, f_b, c, f_c))
    with np.errstate(all="ignore"):
        xi, phi = (a - b) / (c - b), (f_a - f_b) / (f_c - f_b)
        alpha = (c - a) / (b - a)
        quadratic = f_a / (f_b - f_a) * f_c / (f_b - f_c) + alpha * f_a / (f_c - f_a) * f_b / (f_c - f_b)
        allowed = (phi * phi < xi) & ((1.0 - phi) ** 2 < 1.0 - xi) & np.isfinite(quadratic)
    return np.where(allowed, quadratic, 0.5)
