"""Critical values of one tail at many degrees of freedom, from polynomials where there are very many.

Each pair of Games and Howell has its own degrees of freedom, and 200 groups have 19 900 pairs. The logarithm of a
critical value is analytic in that of the degrees of freedom, with no singularity nearer to an octave than pi, so that
20 places of an octave give a double's digits at all others (Chebyshev's polynomials err by 18 to the minus 20).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.polynomial import chebyshev

from stats.exact.known_scale import Floats

_NODES = 20
_ENOUGH = 2 * _NODES
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
    for octave in np.flatnonzero(counts > _ENOUGH).tolist():
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
