"""Critical values: where an upper tail, falling with the statistic, has the size asked for.

At many degrees of freedom they come from polynomials. Each pair of Games and Howell has its own degrees of freedom, and
200 groups have 19 900 pairs. The logarithm of a critical value is analytic in that of the degrees of freedom, with no
singularity nearer to an octave than pi, so that 20 places of an octave give a double's digits at all others
(Chebyshev's polynomials err by 18 to the minus 20).
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

from stats.exact.known_scale import Floats

LogUpper = Callable[[NDArray[np.intp], Floats], Floats]
"""Logarithms of the upper tails of those of m distributions that are asked for, at a statistic each, shape (p,)."""

_ENOUGH = 1e-14
_MOST_STEPS = 200


def critical_values(log_upper: LogUpper, tail: float, guess: Floats) -> Floats:
    """Return the statistics that have the upper tail `tail`, shape (m,), searched from `guess` by Chandrupatla's rule.

    Source: Chandrupatla (1997), Advances in Engineering Software 28, 145: inverse quadratic interpolation where the
    three last places allow it, halves elsewhere.
    """
    wanted = math.log(min(tail, 1.0 - 2.0**-53))  # 1 is all that is left of a level near 0
    rows = np.arange(guess.size)
    b, fb, a, fa = _bracketed(log_upper, wanted, guess)
    c, fc = a.copy(), fa.copy()
    share = np.full(guess.size, 0.5)
    found = np.where(np.abs(fa) < np.abs(fb), a, b)
    for _ in range(_MOST_STEPS):
        x = a[rows] + share[rows] * (b[rows] - a[rows])
        f = log_upper(rows, x) - wanted
        same = np.sign(f) == np.sign(fa[rows])
        c[rows], fc[rows] = np.where(same, a[rows], b[rows]), np.where(same, fa[rows], fb[rows])
        b[rows], fb[rows] = np.where(same, b[rows], a[rows]), np.where(same, fb[rows], fa[rows])
        a[rows], fa[rows] = x, f
        found[rows] = np.where(np.abs(fa[rows]) < np.abs(fb[rows]), a[rows], b[rows])
        with np.errstate(divide="ignore"):
            least = _ENOUGH * np.maximum(np.abs(found[rows]), 1e-3) / np.abs(b[rows] - a[rows])
        going = (least < 0.5) & (f != 0.0)
        rows, least = rows[going], least[going]
        share[rows] = np.clip(_share(a[rows], fa[rows], b[rows], fb[rows], c[rows], fc[rows]), least, 1.0 - least)
        if not rows.size:
            break
    return found


def _bracketed(log_upper: LogUpper, wanted: float, guess: Floats) -> tuple[Floats, Floats, Floats, Floats]:
    """Return places on both sides of each critical value: the lower, its excess, the upper, its excess."""
    low, high = guess.copy(), guess.copy()
    f_low = log_upper(np.arange(guess.size), guess) - wanted
    f_high = f_low.copy()
    for ends, values, others, other_values, side in (
        (low, f_low, high, f_high, -1.0),
        (high, f_high, low, f_low, 1.0),
    ):
        rows = np.flatnonzero(side * values > 0.0)
        while rows.size:
            others[rows], other_values[rows] = ends[rows], values[rows]
            ends[rows] += side * 0.5 * np.maximum(np.abs(ends[rows]), 1.0)
            values[rows] = log_upper(rows, ends[rows]) - wanted
            rows = rows[side * values[rows] > 0.0]
    return low, f_low, high, f_high


def _share(a: Floats, fa: Floats, b: Floats, fb: Floats, c: Floats, fc: Floats) -> Floats:
    """Return how far from a to b to look next."""
    with np.errstate(all="ignore"):
        xi, phi = (a - b) / (c - b), (fa - fb) / (fc - fb)
        alpha = (c - a) / (b - a)
        quadratic = fa / (fb - fa) * fc / (fb - fc) + alpha * fa / (fc - fa) * fb / (fc - fb)
    allowed = (phi * phi < xi) & ((1.0 - phi) ** 2 < 1.0 - xi) & np.isfinite(quadratic)
    return np.where(allowed, quadratic, 0.5)


_NODES = 20
_ENOUGH_OF_OCTAVE = 2 * _NODES
"""Degrees of freedom in one octave from which on a polynomial is worth its places."""
_LOWEST, _HIGHEST = 0, 20
"""Octaves that have polynomials: from 1 degree of freedom, which a pair of variances has at least, to 2**20."""
_STANDS = 1e-13
"""Last coefficients below this are the rounding of what is searched."""
_PLACES = chebyshev.chebpts1(_NODES)
_TO_COEFFICIENTS = chebyshev.chebvander(_PLACES, _NODES - 1).T * (2.0 / _NODES)
_TO_COEFFICIENTS[0] /= 2.0


def criticals_over_df(search: Callable[[Floats], Floats], df: Floats) -> Floats:
    """Return what `search` gives for degrees of freedom of shape (m,): positive, each searched for itself."""
    octaves = np.frexp(np.where(np.isfinite(df), df, 0.0))[1] - 1
    counts = np.bincount(np.clip(octaves, _LOWEST, _HIGHEST), minlength=_HIGHEST + 1)
    found = np.empty(df.shape)
    alone = np.ones(df.shape, dtype=bool)
    for octave in np.flatnonzero(counts > _ENOUGH_OF_OCTAVE).tolist():
        inside = (octaves == octave) & (df >= 1.0)
        logs = np.log(search(np.exp2(octave + (_PLACES + 1.0) / 2.0)))
        coefficients = _TO_COEFFICIENTS @ logs
        if np.max(np.abs(coefficients[-3:])) <= _STANDS:
            x = 2.0 * (np.log2(df[inside]) - octave) - 1.0
            found[inside] = np.exp(chebyshev.chebval(x, coefficients))
            alone &= ~inside
    if np.any(alone):
        found[alone] = search(df[alone])
    return found
