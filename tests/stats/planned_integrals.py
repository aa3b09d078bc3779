"""Powers by other integrals than the product's: QUADPACK over the share, panels by the dozen over all else."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable
from functools import lru_cache
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy import integrate, special
from scipy.stats import chi

Floats = NDArray[np.float64]
_NODES, _WEIGHTS = (np.asarray(part) for part in np.polynomial.legendre.leggauss(16))


def panels(edges: Floats) -> tuple[Floats, Floats]:
    """Return nodes and weights (..., nodes) of Gauss's rule between neighbours of sorted `edges` (..., edges)."""
    half = np.diff(edges)[..., None] / 2.0
    nodes = (edges[..., :-1, None] + half) + half * _NODES
    shape = (*edges.shape[:-1], -1)
    return nodes.reshape(shape), (half * _WEIGHTS).reshape(shape)


def scale_density(u: Floats, df: float) -> Floats:
    """Return the density of U = chi / sqrt(df) over that at 1: about there nothing large cancels."""
    above = u - 1.0
    return np.asarray(np.exp((df - 1.0) * np.log1p(above) - df * (above + above * above / 2.0)))


@lru_cache(maxsize=64)
def scale_ends(df: float) -> tuple[float, float, float]:
    """Return from where to where U counts, and the integral of its density over that."""
    law = chi(df, scale=1.0 / math.sqrt(df))
    low, high = float(law.ppf(1e-18)), float(law.isf(1e-18))
    u, weights = panels(np.linspace(low, high, 65))
    return low, high, float(weights @ scale_density(u, df))


def over_scale(value: Callable[[Floats], Floats], df: float, turns: list[tuple[float, float]], last: float) -> float:
    """Return the mean of a value of U = chi / sqrt(df), which turns at some points over some widths, up to `last`."""
    low, high, whole = scale_ends(df)
    high = min(high, last)
    if high <= low:
        return 0.0
    beside = [at + sign * width * 2.0**k for at, width in turns for sign in (-1.0, 0.0, 1.0) for k in range(-2, 5)]
    edges = np.unique(np.clip([*np.linspace(low, high, 17), *beside], low, high))
    u, weights = panels(edges)
    return float(weights @ (scale_density(u, df) * value(u))) / whole


def over_share(value: Callable[[float, float], float], df_a: float, df_b: float, turn: float) -> float:
    """Return the mean over the share of a in both sums of squares, by QUADPACK in the angle.

    The angle is counted from the top of its density in widths of that, and the density is taken over what it has there.
    """
    top, width = math.atan2(math.sqrt(df_a), math.sqrt(df_b)), 1.0 / math.sqrt(2.0 * (df_a + df_b))
    cotangent = math.sqrt(df_b / df_a)

    def density(steps: float) -> float:
        sine, less = math.sin(width * steps), 2.0 * math.sin(width * steps / 2.0) ** 2
        # Sine and cosine over those at the top, less 1.
        ratios = (max(slope * sine - less, -1.0 + 2.0**-53) for slope in (cotangent, -1.0 / cotangent))
        of_sine, of_cosine = map(math.log1p, ratios)
        return math.exp((df_a - 1.0) * of_sine + (df_b - 1.0) * of_cosine)

    def weighted(steps: float) -> float:
        angle = top + width * steps
        return density(steps) * value(math.sin(angle) ** 2, math.cos(angle) ** 2)

    turn = math.atan(turn)
    cuts = [0.0, math.pi / 2.0, *(top + width * k for k in (-9.0, -3.0, 0.0, 3.0, 9.0))]
    cuts += [turn * 4.0**k for k in (-2, 0, 2)] + [math.pi / 2.0 - (math.pi / 2.0 - turn) * 4.0**k for k in (-2, 0, 2)]
    cuts = sorted({(min(max(cut, 0.0), math.pi / 2.0) - top) / width for cut in cuts})
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", integrate.IntegrationWarning)
        part, whole = (
            math.fsum(integrate.quad(f, *ends, epsabs=1e-13, epsrel=1e-11, limit=60)[0] for ends in pairwise(cuts))
            for f in (weighted, density)
        )
    return part / whole


def welch_df(part_a: float, part_b: float, df_a: float, df_b: float) -> float:
    return (part_a + part_b) ** 2 / (part_a**2 / df_a + part_b**2 / df_b)


def welch(
    ends: tuple[float, float] | None, difference: float, sds: tuple[float, float], sizes: tuple[int, int], tail: float
) -> float:
    """Return the power of Welch's test, two-sided at `tail` each, or with `ends` of both one-sided tests."""
    df_a, df_b = sizes[0] - 1.0, sizes[1] - 1.0
    df, var_a, var_b = df_a + df_b, sds[0] ** 2 / sizes[0], sds[1] ** 2 / sizes[1]
    error = math.sqrt(var_a + var_b)

    def given(share_a: float, share_b: float) -> float:
        part_a, part_b = share_a * var_a * df / df_a, share_b * var_b * df / df_b
        critical = -float(special.stdtrit(welch_df(part_a, part_b, df_a, df_b), tail)) * math.sqrt(part_a + part_b)
        c, d = critical / error, difference / error
        if ends is None:
            turns = [(d / c, 1.0 / c), (-d / c, 1.0 / c)]
            return over_scale(lambda u: special.ndtr(d - c * u) + special.ndtr(-d - c * u), df, turns, math.inf)
        low, high = ((end - difference) / error for end in ends)
        turns = [(-low / c, 1.0 / c), (high / c, 1.0 / c)]
        return over_scale(
            lambda u: special.ndtr(high - c * u) - special.ndtr(low + c * u), df, turns, (high - low) / (2.0 * c)
        )

    return over_share(given, df_a, df_b, math.sqrt(var_b / df_b / var_a * df_a))


def percent(
    difference: float, mean: float, sd: float, low: float, high: float, n_a: int, n_b: int, alpha: float
) -> float:
    """Return the power at percent bounds, the mean of b integrated over between where the bounds leave anything."""
    df_a, df_b = n_a - 1.0, n_b - 1.0
    df, c_b = df_a + df_b, -float(special.stdtrit(n_b - 1.0, alpha))
    f, root_a, root_b = (1.0 + low / 100.0, 1.0 + high / 100.0), math.sqrt(n_a), math.sqrt(n_b)
    # In standard deviations, with e the error of the mean of b: f (mean + e) -+ margin U - (mean + difference).
    center = [(factor * mean - (mean + difference)) / sd for factor in f]

    def given(share_a: float, share_b: float) -> float:
        part_a, part_b = share_a * df / df_a / n_a, share_b * df / df_b / n_b
        margins = [
            -float(special.stdtrit(welch_df(part_a, k * k * part_b, df_a, df_b), alpha))
            * math.sqrt(part_a + k * k * part_b)
            for k in f
        ]
        least = c_b * math.sqrt(part_b)

        def value(u: Floats) -> Floats:
            at_low, at_high = center[0] + margins[0] * u, center[1] - margins[1] * u
            start = np.maximum(root_b * (least * u - mean / sd), root_b * (at_low - at_high) / (f[1] - f[0]))
            edges = [start]
            for at, k in ((at_low, f[0]), (at_high, f[1])):
                edges += [root_b * (steps / root_a - at) / k for steps in (-8.0, -3.0, 0.0, 3.0, 8.0)]
            edges += [np.full_like(u, at) for at in (-9.0, -4.0, 0.0, 4.0, 9.0)]
            start = np.clip(start, -9.0, 9.0)[:, None]
            z, weights = panels(np.sort(np.clip(np.stack(edges, axis=-1), start, 9.0), axis=-1))
            inside = special.ndtr(root_a * (at_high[:, None] + f[1] * z / root_b)) - special.ndtr(
                root_a * (at_low[:, None] + f[0] * z / root_b)
            )
            density = np.exp(-z * z / 2.0) / math.sqrt(2.0 * math.pi)
            return np.asarray(np.einsum("ij,ij->i", weights, density * np.maximum(inside, 0.0)))

        both, errors = margins[0] + margins[1], [math.hypot(1.0 / root_a, k / root_b) for k in f]
        turns = [
            (-center[0] / margins[0], errors[0] / margins[0]),
            (center[1] / margins[1], errors[1] / margins[1]),
            ((center[1] - center[0]) / both, (f[1] - f[0]) / root_b / both),
            (mean / sd / least, 1.0 / root_b / least),
        ]
        return over_scale(value, df, turns, math.inf)

    return over_share(given, df_a, df_b, math.sqrt(f[0] * f[1] / n_b / df_b * n_a * df_a))
