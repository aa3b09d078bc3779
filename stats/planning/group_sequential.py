"""Tests of growing data: boundaries of group-sequential designs, and how often unplanned looks err.

The information of a look is the runs that it has, and t the part of the planned runs that they are. Under no effect
z sqrt t of looks at t_1, t_2 and so on is a Brownian motion. The boundary spends alpha as it was decided on beforehand,
whatever was found (Lan and DeMets 1983), on each side by

    f(t) = 2 - 2 Phi(z(a / 2) / sqrt t),    a = alpha / 2 of a two-sided test, alpha of a one-sided one,

which is near the boundary of O'Brien and Fleming (1979): hardly anything at first looks, nearly all of alpha at the
last. The chance to be outside for the first time at a look is integrated look by look over where the study went on
(Armitage, McPherson and Rowe 1969) by Gauss and Legendre's rule. A look's nominal level is the p of its z, which is
compared with the p of a t-test; intervals of level 1 less it hold at all looks together (Jennison and Turnbull 1989).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy import special

from data_schema.errors import InputRefused
from stats.checks import as_level

_NEGLIGIBLE = 1e-9
"""No look has a lower nominal level: that no interval is beyond doubles costs no more than this of alpha a look."""
_FARTHEST = 9.0
"""A z beyond which nothing is: its chance is 1e-19."""
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(16)
_SDS, _MOST = 2.0, 256
"""Standard deviations of a step between looks that a panel of the rule covers, and the most panels."""


def nominal_levels(
    information: Sequence[float],
    alpha: float = 0.05,
    *,
    spending: Sequence[float] | None = None,
    one_sided: bool = False,
) -> tuple[float, ...]:
    """Return the level of p at each look.

    `information` grows in any unit, as counts of runs; a look that adds nothing has the level of the one before.
    `spending` has the part of the plan at each look, above 0 and at most 1, by which alpha is spent; without it that is
    the information. Raises `InputRefused` for other parts.
    """
    parts = information if spending is None else spending
    if len(parts) != len(information) or not all(0.0 < each <= 1.0 for each in parts):
        raise InputRefused(f"looks at {list(parts)} of the planned runs: give parts above 0, and at most 1.")
    largest = max(information, default=1.0)
    return _levels(tuple(each / largest for each in information), tuple(parts), as_level("alpha", alpha), one_sided)


@lru_cache
def _levels(
    information: tuple[float, ...], spending: tuple[float, ...], alpha: float, one_sided: bool
) -> tuple[float, ...]:
    sides = 1 if one_sided else 2
    each_side = alpha / sides
    found: list[float] = []
    spent, before = 0.0, None
    for t, part in zip(information, spending, strict=True):
        if before is not None and t <= before.t:
            found.append(found[-1])
            continue
        to_spend = 2.0 * float(special.ndtr(special.ndtri(each_side / 2.0) / math.sqrt(part)))
        z = _boundary(before, t, max(0.0, to_spend - spent))
        spent = to_spend
        before = _after(before, t, z, one_sided)
        found.append(max(sides * float(special.ndtr(-z)), _NEGLIGIBLE))
    return tuple(found)


def share_in_error(information: Sequence[float], levels: Sequence[float], *, one_sided: bool = False) -> float:
    """Return the share of studies without an effect in which p is at most its level at one of the looks.

    `information` grows in any unit, as counts of runs; looks that add nothing count with the one before.
    """
    largest = max(information, default=1.0)
    return _share(tuple(each / largest for each in information), tuple(levels), one_sided)


@lru_cache
def _share(information: tuple[float, ...], levels: tuple[float, ...], one_sided: bool) -> float:
    sides = 1 if one_sided else 2
    share, before = 0.0, None
    for t, level in zip(information, levels, strict=True):
        if before is not None and t <= before.t:
            continue
        z = -float(special.ndtri(level / sides))
        share += sides * _outside(before, t, z)
        before = _after(before, t, z, one_sided)
    return share


@dataclass(frozen=True, slots=True)
class _Inside:
    """The density of z sqrt t of studies that go on after a look, at the points of a rule with these weights."""

    t: float
    points: NDArray[np.float64]
    weighted: NDArray[np.float64]
    """Densities times weights."""


def _boundary(before: _Inside | None, t: float, to_spend: float) -> float:
    """Return the z that is passed on one side for the first time with this chance."""
    from scipy import optimize  # loaded by who searches: it takes long

    if before is None:
        return min(-float(special.ndtri(to_spend)), _FARTHEST)
    if _outside(before, t, _FARTHEST) >= to_spend:
        return _FARTHEST
    return float(optimize.brentq(lambda z: _outside(before, t, z) - to_spend, 0.0, _FARTHEST, xtol=1e-12, rtol=1e-14))


def _outside(before: _Inside | None, t: float, z: float) -> float:
    """Return the chance to be above z at a look and at none before."""
    if before is None:
        return float(special.ndtr(-z))
    step = math.sqrt(t - before.t)
    return float(before.weighted @ special.ndtr((before.points - z * math.sqrt(t)) / step))


def _after(before: _Inside | None, t: float, z: float, one_sided: bool) -> _Inside:
    """Return the studies that go on after a look: those within z, on both sides or above."""
    high, low = z * math.sqrt(t), -(_FARTHEST if one_sided else z) * math.sqrt(t)
    step = math.sqrt(t if before is None else t - before.t)
    panels = min(_MOST, math.ceil((high - low) / (_SDS * step)))
    half = 0.5 * (high - low) / panels
    points = (low + half * (2.0 * np.arange(panels)[:, None] + 1.0 + _NODES)).ravel()
    if before is None:
        density = np.exp(-0.5 * (points / step) ** 2)
    else:
        density = np.exp(-0.5 * ((points[:, None] - before.points) / step) ** 2) @ before.weighted
    density /= math.sqrt(2.0 * math.pi) * step
    return _Inside(t, points, np.tile(half * _WEIGHTS, panels) * density)
