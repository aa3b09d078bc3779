"""Chance that both one-sided tests of equivalence reject (Owen's Q), by Gauss-Legendre integration.

With U = sqrt(chi^2_nu / nu), a standard error estimated with nu degrees of freedom in units of the true one, it is the
integral of a normal probability over the density of U.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy import special

Floats = NDArray[np.float64]

NODES, WEIGHTS = (np.asarray(part) for part in np.polynomial.legendre.leggauss(48))
TINY = 1e-18
"""Probability that is left out at each end."""
REACH = 9.0
"""Standard deviations beyond which a normal probability is 0 or 1 to double precision."""


def _spread_nodes(df: float, breaks: Floats, width: float) -> tuple[Floats, Floats]:
    """Return nodes u and weights (density of U included) for integrands that change near `breaks`, over `width`."""
    low = math.sqrt(2.0 * float(special.gammaincinv(df / 2.0, TINY)) / df)
    high = math.sqrt(2.0 * float(special.gammainccinv(df / 2.0, TINY)) / df)
    steps = np.array([-REACH, -3.0, 0.0, 3.0, REACH])
    edges = np.concatenate([np.linspace(low, high, 9), np.add.outer(breaks, steps * width).ravel()])
    edges = np.unique(np.clip(edges, low, high))
    half = np.diff(edges) / 2.0
    u = ((edges[:-1] + edges[1:]) / 2.0 + np.multiply.outer(NODES, half)).ravel()
    weights = np.multiply.outer(WEIGHTS, half).ravel()
    log_density = (
        math.log(2.0)
        + (df / 2.0) * math.log(df / 2.0)
        - float(special.gammaln(df / 2.0))
        + (df - 1.0) * np.log(np.maximum(u, 1e-300))
        - df * u * u / 2.0
    )
    return u, weights * np.exp(log_density)


def within_both(low: float, high: float, critical: float, df: float) -> float:
    """Return P(low + critical U <= Z <= high - critical U): both one-sided tests reject (Owen's Q function)."""
    last = (high - low) / (2.0 * critical)
    u, weights = _spread_nodes(df, np.array([-low / critical, high / critical, last]), 1.0 / critical)
    inside = special.ndtr(high - critical * u) - special.ndtr(low + critical * u)
    return min(1.0, float(weights @ np.where(u < last, inside, 0.0)))
