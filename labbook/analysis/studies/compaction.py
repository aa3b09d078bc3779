"""How densely a bed's grains lie, poured and compacted: fractions in flasks, and without walls (thesis 5.1.2)."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from data_schema.errors import InputRefused
from data_schema.vocabulary import Undefined
from stats.lines.regression import LinearFit, fit_linear
from stats.packing import WALL, UnboundedPacking, unbounded_fraction

FEWEST_FLASKS = 3
CURVED_P = 0.02
"""Of the quadratic term, from which down the fractions are said to follow no line."""
_LOOSE = ("loose", "poured")
"""What the less dense state is called where it is called so; else the sheet's first is taken for it."""


@dataclass(frozen=True, slots=True)
class StateOfGrains:
    """One state of the grains: the flasks' fractions, and what they say of a bed without walls.

    `wall` is grain size over flask radius, dimensionless, as long as `fractions`. `curved_ci` is the interval of the
    fraction without walls where the wall's effect need not be straight: that of a parabola.
    """

    name: str
    wall: tuple[float, ...]
    fractions: tuple[float, ...]
    unbounded: UnboundedPacking
    curved_ci: tuple[float, float] | Undefined


@dataclass(frozen=True, slots=True)
class Compaction:
    """Both states, in the order of the sheet, and how much denser the last is than the first.

    `rise` is the line through the differences within flasks: a flask's own error is the same in both states.
    `curved_rise_ci` is that of a parabola. `curvature_p` tests the quadratic term of the mean of both states: small
    where the line does not fit. `doubt` is what is to be looked at in the sheet.
    """

    states: tuple[StateOfGrains, ...]
    rise: LinearFit
    curved_rise_ci: tuple[float, float] | Undefined
    curvature_p: float | Undefined
    grain_m: float
    doubt: str | None = None


def compaction(
    measured: Mapping[str, Sequence[tuple[float, float, int]]],
    grain_m: float,
    level: float = 0.95,
    doubt: str | None = None,
) -> Compaction:
    """Extrapolate the fractions of each state to an infinite container.

    `measured` has by state the radius of each flask in m, the volume fraction in it, and its line in the sheet.
    Repeated fillings of a flask are averaged first: they share the flask's error, and flasks are what scatters. Raises
    `InputRefused` for other than two states, flasks that were not measured in both, and fewer than three sizes.
    """
    if len(measured) != 2:
        found = ", ".join(map(repr, measured))
        raise InputRefused(f"the states are {found}: measure two, such as loose and compacted.")
    in_order = sorted(measured, key=lambda name: name.casefold() not in _LOOSE)
    states = {name: _means(measured[name]) for name in in_order}
    (first, before), (last, after) = states.items()
    radii_m = [radius_m for radius_m, _ in before]
    if alone := sorted({*radii_m} ^ {radius_m for radius_m, _ in after}):
        radius_m, missing = alone[0], last if alone[0] in radii_m else first
        lines = [line for rows in measured.values() for radius, _fraction, line in rows if radius == radius_m]
        raise InputRefused(
            f"the flask of {radius_m * 1e3:g} mm (line {lines[0]}) was not measured {missing!r}: measure it, or drop "
            "its rows."
        )
    if len(radii_m) < FEWEST_FLASKS:
        raise InputRefused(
            f"only {len(radii_m)} of the flasks' sizes differ: measure at least {FEWEST_FLASKS}, or there is no line "
            "to extend to a bed without walls."
        )
    if radii_m[0] <= grain_m:
        raise InputRefused(
            f"grains of {grain_m * 1e3:g} mm do not fit a flask of {radii_m[0] * 1e3:g} mm radius: check the units."
        )
    rises = [dense - loose for (_, loose), (_, dense) in zip(before, after, strict=True)]
    middles = [0.5 * loose + 0.5 * dense for (_, loose), (_, dense) in zip(before, after, strict=True)]
    wall = [grain_m / radius_m for radius_m in radii_m]
    return Compaction(
        states=tuple(_state(name, rows, grain_m, level) for name, rows in states.items()),
        rise=fit_linear(rises, {WALL: wall}, level=level),
        curved_rise_ci=_parabola(wall, rises, level).intervals()[0],
        curvature_p=_curvature_p(_parabola(wall, middles, level)),
        grain_m=grain_m,
        doubt=doubt,
    )


def _means(rows: Sequence[tuple[float, float, int]]) -> list[tuple[float, float]]:
    """Return the mean fraction of each flask, in the order of radii."""
    by_flask: dict[float, list[float]] = {}
    for radius_m, fraction, _line in rows:
        by_flask.setdefault(radius_m, []).append(fraction)
    return [(radius_m, math.fsum(several) / len(several)) for radius_m, several in sorted(by_flask.items())]


def _state(name: str, rows: Sequence[tuple[float, float]], grain_m: float, level: float) -> StateOfGrains:
    radii_m, fractions = zip(*rows, strict=True)
    wall = tuple(grain_m / radius_m for radius_m in radii_m)
    return StateOfGrains(
        name,
        wall,
        fractions,
        unbounded_fraction(radii_m, fractions, grain_m, level=level),
        _parabola(wall, fractions, level).intervals()[0],
    )


def _parabola(wall: Sequence[float], fractions: Sequence[float], level: float) -> LinearFit:
    return fit_linear(fractions, {WALL: wall, "squared": np.square(wall)}, level=level)


def _curvature_p(parabola: LinearFit) -> float | Undefined:
    return parabola.p if isinstance(parabola.p, Undefined) else parabola.p[2]
