"""The compaction of a bed: as sentences, as data, and as what its figure draws."""

from __future__ import annotations

from typing import Any

import numpy as np

from data_schema.rounding import end_text, interval_text, level_text, number_text, p_text
from data_schema.vocabulary import Undefined
from labbook.analysis.studies.compaction import CURVED_P, Compaction, StateOfGrains
from labbook.presenting.numbers import value_data
from reports.figures.compaction import FractionLine
from simulator.steady.published_results import published_numbers
from stats.packing import DENSEST, WALL
from stats.results import plural

PUBLISHED = {"loose": "bed.phi_loose", "compacted": "bed.phi_hard"}
"""What docs/published.md calls the fractions of 3.4 mm glass beads (thesis 5.1.2), to two digits."""
PUBLISHED_GRAIN_M = 3.4e-3
_POINTS = 101
_WIDEST = 1.0 / 3.0
"""Grain size over flask radius from which on hardly a grain is without a wall: fewer than six diameters across."""


def sentences(study: Compaction) -> list[str]:
    """Say how densely the grains lie in either state, how much that differs, and what the thesis found.

    First, where it is so, that no grains of one size lie as densely.
    """
    first, last = study.states
    of_states = [f"{_fraction_text(state)} {state.name}" for state in study.states]
    rise = study.rise
    error = 0.0 if isinstance(rise.standard_errors, Undefined) else rise.standard_errors[0]
    difference = number_text(rise.coefficients[0], error=error)
    within = f"within flasks, n = {rise.n}, df = {rise.df}"
    lines = [
        f"Without walls the grains fill {' and '.join(of_states)}.",
        f"Difference, {last.name} less {first.name}: {difference} "
        f"({_intervals_text(rise.intervals()[0], study.curved_rise_ci, rise.level, error)}; {within}).",
        _curve_text(study),
    ]
    if abs(study.grain_m / PUBLISHED_GRAIN_M - 1.0) < 0.05:
        known = " and ".join(f"{published_numbers()[one]:g} {name}" for name, one in PUBLISHED.items())
        lines.append(f"The thesis found {known} (5.1.2; five flasks, to two digits).")
    dense = max(max(state.fractions) for state in study.states)
    if dense > DENSEST:
        lines.insert(
            0, f"A flask is {dense:.3g} full, and equal spheres fill 0.7405 at most: check its water and its size."
        )
    interval = rise.intervals()[0]
    if not isinstance(interval, Undefined) and interval[1] < 0.0:
        lines.append(f"The state {first.name} came out denser than {last.name}: are the states swapped?")
    of_walls = [state.unbounded.fit.intervals()[1] for state in study.states]
    if any(not isinstance(interval, Undefined) and interval[0] > 0.0 for interval in of_walls):
        lines.append(
            "The fraction rises towards smaller flasks, where walls should lower it: look at the small flasks."
        )
    if (widest := max(first.wall)) > _WIDEST:
        grain_mm = 1e3 * study.grain_m
        lines.append(
            f"Grains of {grain_mm:g} mm are more than a third of the smallest flask's radius "
            f"({number_text(grain_mm / widest)} mm): check their diameter, or leave the flask out, as no line holds."
        )
    if study.doubt is not None:
        lines.append(study.doubt)
    return lines


def _fraction_text(state: StateOfGrains) -> str:
    packing = state.unbounded
    number = number_text(packing.fraction, error=packing.se)
    return f"{number} ({_intervals_text(packing.ci, state.curved_ci, packing.level, packing.se)})"


def _intervals_text(
    line: tuple[float, float] | Undefined, curve: tuple[float, float] | Undefined, level: float, se: float
) -> str:
    ends = "unknown" if isinstance(curve, Undefined) else " to ".join(end_text(end, se) for end in curve)
    return f"{interval_text(line, level, '', se)}, along a curve {ends}"


def _curve_text(study: Compaction) -> str:
    """Say which of the intervals hold: a slight curve is seldom seen in few flasks, and moves what lies beyond them."""
    if isinstance(study.curvature_p, float) and study.curvature_p <= CURVED_P:
        p = p_text(study.curvature_p, CURVED_P)
        return f"The fractions follow no line over grain size / radius (quadratic term, {p}): those along a curve hold."
    flasks = plural(study.rise.n, "flask")
    return f"The first intervals take the wall's effect for a line, which {flasks} do not tell from a slight curve."


HEAD = ("state", "flask radius (mm)", "grain / radius", "volume fraction")


def rows(study: Compaction) -> list[tuple[str, ...]]:
    """Return the table of the measurements: the mean of each flask in each state."""
    return [
        (state.name, f"{1e3 * study.grain_m / wall:.4g}", f"{wall:.4f}", f"{fraction:.4f}")
        for state in study.states
        for wall, fraction in zip(state.wall, state.fractions, strict=True)
    ]


def as_data(study: Compaction) -> dict[str, Any]:
    """Return all numbers for JSON."""
    return {
        "grain_m": study.grain_m,
        "states": [
            {
                "state": state.name,
                **state.unbounded.to_dict(),
                "curved_ci": value_data(state.curved_ci),
                "measurements": [
                    {"grain_over_radius": wall, "fraction": fraction}
                    for wall, fraction in zip(state.wall, state.fractions, strict=True)
                ],
            }
            for state in study.states
        ],
        "difference": study.rise.to_dict(),
        "difference_curved_ci": value_data(study.curved_rise_ci),
        "curvature_p": value_data(study.curvature_p),
        "doubt": study.doubt,
    }


def figure_data(study: Compaction) -> list[FractionLine]:
    """Return what the figure shows."""
    return [_line(state) for state in study.states]


def _line(state: StateOfGrains) -> FractionLine:
    places = np.linspace(0.0, max(state.wall), _POINTS).tolist()
    responses = [state.unbounded.fit.at({WALL: place}, state.unbounded.fit.level) for place in places]
    bands = [response.ci for response in responses if not isinstance(response.ci, Undefined)]
    band = tuple(zip(*bands, strict=True)) if len(bands) == len(places) else None
    interval = state.unbounded.ci
    return FractionLine(
        label=f"{state.name}, {level_text(state.unbounded.fit.level)} CI",
        wall=state.wall,
        fractions=state.fractions,
        line_wall=places,
        line=[float(response.value) for response in responses if not isinstance(response.value, Undefined)],
        band=None if band is None else (band[0], band[1]),
        at_0=state.unbounded.fraction,
        interval=None if isinstance(interval, Undefined) else interval,
    )
