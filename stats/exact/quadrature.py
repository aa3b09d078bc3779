"""Integrals by Gauss and Kronrod's rules of 10 and 21 nodes, many at once, halving panels until the digits stand.

The rule's numbers and the estimate of its error are those of QUADPACK's QK21 (Piessens and others 1983). The estimate
is cautious: for smooth integrands what is left is far below it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

Floats: TypeAlias = NDArray[np.float64]
Rows: TypeAlias = NDArray[np.intp]
Integrand: TypeAlias = Callable[[Floats, Rows], Floats]
"""From points (panels, nodes) and the integral that each panel (panels,) belongs to, to values (panels, nodes)."""


class Panels(NamedTuple):
    """Where integrals are taken: ends and the number of its integral for each panel, all (panels,)."""

    left: Floats
    right: Floats
    rows: Rows


def _both_sides(half: list[float], sign: float) -> Floats:
    """Return a symmetric rule's numbers from those at and below its middle, which is the last of them."""
    return np.array([*half, *(sign * number for number in half[-2::-1])])


_HALF = [
    -0.995657163025808080735527280689003,
    -0.973906528517171720077964012084452,
    -0.930157491355708226001207180059508,
    -0.865063366688984510732096688423493,
    -0.780817726586416897063717578345042,
    -0.679409568299024406234327365114874,
    -0.562757134668604683339000099272694,
    -0.433395394129247190799265943165784,
    -0.294392862701460198131126603103866,
    -0.14887433898163121088482600112972,
    0.0,
]
_KRONROD = [
    0.011694638867371874278064396062192,
    0.03255816230796472747881897245939,
    0.05475589657435199603138130024458,
    0.07503967481091995276704314091619,
    0.093125454583697605535065465083366,
    0.109387158802297641899210590325805,
    0.123491976262065851077958109585166,
    0.134709217311473325928054001771707,
    0.142775938577060080797094273138717,
    0.147739104901338491374841515972068,
    0.149445554002916905664936468389821,
]
NODES, _WEIGHTS = _both_sides(_HALF, -1.0), _both_sides(_KRONROD, 1.0)
_GAUSS_WEIGHTS = np.polynomial.legendre.leggauss(10)[1]
_MOST_HALVINGS, _MOST_OPEN = 60, 64
_NOISE = 50.0 * float(np.finfo(np.float64).eps)


def panels_between(edges: Floats) -> Panels:
    """Return the panels between neighbours of `edges` (integrals, edges), which need no order; empty ones are left."""
    edges = np.sort(edges, axis=1)
    left, right = edges[:, :-1], edges[:, 1:]
    wide = right > left
    return Panels(left[wide], right[wide], np.nonzero(wide)[0])


def integrals(integrand: Integrand, panels: Panels, count: int, tolerance: float, floor: float = 0.0) -> Floats:
    """Return `count` integrals of a function that is not negative.

    The estimated error of each panel is below `tolerance` of its integral, or below `floor`. Edges of panels belong
    where the integrand has a kink or a step: there is no other loss of order.
    """
    totals = np.zeros(count)
    left, right, rows = panels
    for _ in range(_MOST_HALVINGS):
        half = (right - left) / 2.0
        middle = left + half
        values = integrand(middle[:, None] + half[:, None] * NODES, rows)
        found = half * _weighted(values, _WEIGHTS)
        coarse = half * _weighted(values[:, 1::2], _GAUSS_WEIGHTS)
        mean = _weighted(values, _WEIGHTS) / 2.0
        spread = half * _weighted(np.abs(values - mean[:, None]), _WEIGHTS)
        error = np.abs(found - coarse)
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            error = np.where(spread > 0.0, spread * np.minimum(1.0, (200.0 * error / spread) ** 1.5), 0.0)
        so_far = totals + np.bincount(rows, found, count)
        open_ = error > np.maximum(np.maximum(tolerance * so_far[rows], floor), _NOISE * found)
        if not open_.any() or np.count_nonzero(open_) > _MOST_OPEN * (count + 1):
            return so_far
        done = ~open_
        totals += np.bincount(rows[done], found[done], count)
        left, middle, right, rows = left[open_], middle[open_], right[open_], rows[open_]
        left, right, rows = np.concatenate([left, middle]), np.concatenate([middle, right]), np.tile(rows, 2)
    return totals + np.bincount(rows, np.tile(found[open_] / 2.0, 2), count)


def _weighted(values: Floats, weights: Floats) -> Floats:
    # Not `@`: starting threads for so few numbers takes far longer than the sums.
    return np.asarray(np.einsum("ij,j->i", values, weights))
