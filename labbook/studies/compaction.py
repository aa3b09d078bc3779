"""How densely a bed's grains lie, poured and compacted: fractions in flasks, and without walls (thesis 5.1.2)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np
from matplotlib.figure import Figure

from data_schema.errors import InputRefused, UsageError
from data_schema.rounding import end_text, interval_text, level_text, number_text, p_text
from data_schema.vocabulary import Undefined
from ingest.formats.study_sheets import StudySheet, read_flasks
from labbook.studies.study import Asked, Found, level_of, sheet_source
from labbook.terminal import NOT_IN_JSON
from reports.figures.style import BLUE, ONE_COLUMN_IN, VERMILLION, draw_line, light_grid, paper_figure
from reports.page.study import Study
from simulator.steady.published_results import published_numbers
from stats.lines.regression import LinearFit, fit_linear
from stats.results import plural

DENSEST = math.pi / math.sqrt(18.0)
"""0.7405: no packing of equal spheres is denser (Hales 2005)."""
WALL = "grain size / radius"
"""What fractions are extrapolated over, to 0; dimensionless."""
FEWEST_FLASKS = 3
CURVED_P = 0.02
"""Of the quadratic term, from which down the fractions are said to follow no line."""
_LOOSE = ("loose", "poured")
"""What the less dense state is called where it is called so; else the sheet's first is taken for it."""
_FINEST_MM = 0.05
"""Below it grains are silt, or their diameter was given in metres."""
_WIDEST = 1.0 / 3.0
"""Grain size over flask radius from which on hardly a grain is without a wall: fewer than six diameters across."""
_PUBLISHED = {"loose": "bed.phi_loose", "compacted": "bed.phi_hard"}
"""What docs/published.md calls the fractions of 3.4 mm glass beads (thesis 5.1.2), to two digits."""
_PUBLISHED_GRAIN_M = 3.4e-3
_Interval = tuple[float, float] | Undefined


@dataclass(frozen=True, slots=True)
class Extrapolated:
    """A volume fraction, or the difference of two, where no grain touches a wall.

    `ci` is that of the line over grain size / flask radius, `curved_ci` that of a parabola.
    """

    fraction: float
    se: float
    ci: _Interval
    curved_ci: _Interval


@dataclass(frozen=True, slots=True)
class State(Extrapolated):
    """One state of the grains, with the mean fraction of each flask, and the line through these."""

    state: str
    grain_over_radius: tuple[float, ...]
    fractions: tuple[float, ...]
    line: LinearFit = field(metadata=NOT_IN_JSON)


@dataclass(frozen=True, slots=True)
class Compaction(Study):
    """Both states, the loose one first where it is called so, and how much denser the second is than the first.

    `difference` is the line through the differences within flasks: a flask's own error is the same in both states.
    `curvature_p` tests the quadratic term of the mean of both states: small where the line does not fit. `n` counts
    flasks; `doubt` is what is to be looked at in the sheet.
    """

    title: ClassVar[str] = "How densely the grains lie"
    states: tuple[State, State]
    difference: Extrapolated
    curvature_p: float | Undefined
    n: int
    df: int
    level: float
    grain_m: float
    doubt: str | None

    def sentences(self) -> list[str]:
        """Say how densely the grains lie in either state, how much that differs, and what the thesis found.

        First, where it is so, that no grains of one size lie as densely.
        """
        first, last = self.states
        of_states = " and ".join(f"{self._text(one)} {one.state}" for one in self.states)
        within = f"; within flasks, n = {self.n}, df = {self.df}"
        lines = [
            f"Without walls the grains fill {of_states}.",
            f"Difference, {last.state} less {first.state}: {self._text(self.difference, within)}.",
            self._line_or_curve(),
        ]
        if abs(self.grain_m / _PUBLISHED_GRAIN_M - 1.0) < 0.05:
            known = " and ".join(f"{published_numbers()[one]:g} {name}" for name, one in _PUBLISHED.items())
            lines.append(f"The thesis found {known} (5.1.2; five flasks, to two digits).")
        if (dense := max(max(one.fractions) for one in self.states)) > DENSEST:
            lines.insert(
                0, f"A flask is {dense:.3g} full, and equal spheres fill 0.7405 at most: check its water and its size."
            )
        if not isinstance(self.difference.ci, Undefined) and self.difference.ci[1] < 0.0:
            lines.append(f"The state {first.state} came out denser than {last.state}: are the states swapped?")
        of_walls = [one.line.intervals()[1] for one in self.states]
        if any(not isinstance(interval, Undefined) and interval[0] > 0.0 for interval in of_walls):
            lines.append(
                "The fraction rises towards smaller flasks, where walls should lower it: look at the small flasks."
            )
        if (widest := max(first.grain_over_radius)) > _WIDEST:
            grain_mm = 1e3 * self.grain_m
            lines.append(
                f"Grains of {grain_mm:g} mm are more than a third of the smallest flask's radius "
                f"({number_text(grain_mm / widest)} mm): check their diameter, or leave the flask out, as no line "
                "holds."
            )
        return lines if self.doubt is None else [*lines, self.doubt]

    def _text(self, one: Extrapolated, remark: str = "") -> str:
        curved = one.curved_ci
        ends = "unknown" if isinstance(curved, Undefined) else " to ".join(end_text(end, one.se) for end in curved)
        interval = f"{interval_text(one.ci, self.level, '', one.se)}, along a curve {ends}"
        return f"{number_text(one.fraction, error=one.se)} ({interval}{remark})"

    def _line_or_curve(self) -> str:
        """Say which of the intervals hold: few flasks seldom show a slight curve, which moves what lies beyond them."""
        if isinstance(self.curvature_p, float) and self.curvature_p <= CURVED_P:
            p = p_text(self.curvature_p, CURVED_P)
            return (
                f"The fractions follow no line over grain size / radius (quadratic term, {p}): those along a curve "
                "hold."
            )
        flasks = plural(self.n, "flask")
        return f"The first intervals take the wall's effect for a line, which {flasks} do not tell from a slight curve."

    def table(self) -> list[Sequence[str]]:
        """Return the mean of each flask in each state."""
        head = ("state", "flask radius (mm)", "grain / radius", "volume fraction")
        return [
            head,
            *(
                (one.state, f"{1e3 * self.grain_m / wall:.4g}", f"{wall:.4f}", f"{fraction:.4f}")
                for one in self.states
                for wall, fraction in zip(one.grain_over_radius, one.fractions, strict=True)
            ),
        ]

    def caption(self) -> str:
        """Say what is drawn."""
        return "Volume fractions over grain size / flask radius: flasks, lines, and the intervals without walls (at 0)."

    def draw(self) -> Figure:
        """Draw all measurements, the lines with their bands, and the fractions without walls (thesis fig. 5.2)."""
        with paper_figure(2.8, ONE_COLUMN_IN) as figure:
            axes = figure.add_subplot()
            for one, (colour, marker) in zip(self.states, ((BLUE, "o"), (VERMILLION, "s")), strict=True):
                places = np.linspace(0.0, max(one.grain_over_radius), 101).tolist()
                intervals = [one.line.at({WALL: place}, self.level).ci for place in places]
                band = [ci for ci in intervals if not isinstance(ci, Undefined)]
                low_high = tuple(np.transpose(band).tolist()) if len(band) == len(places) else None
                at_0, slope = one.line.coefficients
                fitted = [at_0 + slope * place for place in places]
                draw_line(
                    axes,
                    places,
                    fitted,
                    colour,
                    band=low_high,
                    points=(one.grain_over_radius, one.fractions),
                    marker=marker,
                    label=f"{one.state}, {level_text(self.level)} CI",
                )
                bar = None if isinstance(one.ci, Undefined) else [[abs(end - one.fraction)] for end in one.ci]
                look: dict[str, Any] = {"fmt": "D", "markersize": 4, "capsize": 3, "clip_on": False, "zorder": 5}
                axes.errorbar([0.0], [one.fraction], yerr=bar, color=colour, **look)
            axes.set_xlim(left=0.0)
            axes.set_xlabel("Grain size / flask radius")
            axes.set_ylabel("Volume fraction")
            light_grid(axes)
            figure.legend(loc="outside lower center", ncols=2)
            return figure


def ask(asked: Asked) -> Found[Compaction]:
    """Read the sheet of flasks and extrapolate; raises `UsageError` where the grains' diameter is not known."""
    with sheet_source("compaction", asked) as sheet:
        grain_mm = sheet.options.grain_mm
        if grain_mm is None:
            raise UsageError(
                "the grains' diameter is not known: add --grain 3.4, in mm, or write grain_mm = 3.4 below "
                "[studies.compaction] of labbook.toml."
            )
        flasks = read_flasks(sheet.file(sheet.path))
        return Found(compaction(flasks, grain_mm, level_of(sheet.options)), sheet.sources, sheet.files)


def compaction(flasks: StudySheet, grain_mm: float, level: float = 0.95) -> Compaction:
    """Extrapolate the fractions of each state to an infinite container.

    Repeated fillings of a flask are averaged first: they share the flask's error, and flasks are what scatters. Raises
    `InputRefused` for other than two states, flasks that were not measured in both, and fewer than three sizes;
    `UsageError` for grains finer than sand.
    """
    if not _FINEST_MM <= grain_mm < math.inf:
        raise UsageError(
            f"grains of {grain_mm:g} mm are not of {_FINEST_MM:g} mm or more: give their diameter in mm, such as "
            "--grain 3.4 (or grain_mm in labbook.toml)."
        )
    grain_m, means = grain_mm / 1e3, _means(flasks)
    if len(means) != 2:
        raise InputRefused(f"the states are {', '.join(map(repr, means))}: measure two, such as loose and compacted.")
    (first, before), (last, after) = means.items()
    if alone := sorted(before.keys() ^ after.keys()):
        radius_m, missing = alone[0], last if alone[0] in before else first
        line = flasks.lines[list(flasks.values["radius"]).index(radius_m)]
        raise InputRefused(
            f"the flask of {radius_m * 1e3:g} mm (line {line}) was not measured {missing!r}: measure it, or drop its "
            "rows."
        )
    if len(before) < FEWEST_FLASKS:
        raise InputRefused(
            f"only {len(before)} of the flasks' sizes differ: measure at least {FEWEST_FLASKS}, or there is no line "
            "to extend to a bed without walls."
        )
    if min(before) <= grain_m:
        raise InputRefused(
            f"grains of {grain_mm:g} mm do not fit a flask of {min(before) * 1e3:g} mm radius: check the units."
        )
    wall = tuple(grain_m / radius_m for radius_m in before)
    loose, dense = (np.array(list(of_flask.values())) for of_flask in means.values())
    states = []
    for state, fractions in ((first, loose), (last, dense)):
        found, line_of, _curve = _extrapolated(wall, fractions.tolist(), level)
        numbers = found.fraction, found.se, found.ci, found.curved_ci
        states.append(State(*numbers, state, wall, tuple(fractions.tolist()), line_of))
    difference, line_of, _curve = _extrapolated(wall, (dense - loose).tolist(), level)
    p = _extrapolated(wall, (0.5 * (loose + dense)).tolist(), level)[2].p
    return Compaction(
        states=(states[0], states[1]),
        difference=difference,
        curvature_p=p if isinstance(p, Undefined) else p[2],
        n=line_of.n,
        df=line_of.df,
        level=level,
        grain_m=grain_m,
        doubt=flasks.doubt,
    )


def _means(flasks: StudySheet) -> dict[str, dict[float, float]]:
    """Return by state the mean fraction by the radius of the flask in m, in the order of radii; loose first."""
    found: dict[str, dict[float, list[float]]] = {}
    quantities = (flasks.values[name] for name in ("radius", "flask", "water"))
    columns = zip(flasks.words["state"], *quantities, strict=True)
    for state, radius_m, flask_m3, water_m3 in columns:
        of_flask = found.setdefault(state, {}).setdefault(radius_m, [])
        of_flask.append((flask_m3 - water_m3) / flask_m3)  # the water fills what the grains leave
    in_order = sorted(found, key=lambda name: name.casefold() not in _LOOSE)
    return {
        state: {radius_m: math.fsum(several) / len(several) for radius_m, several in sorted(found[state].items())}
        for state in in_order
    }


def _extrapolated(
    wall: Sequence[float], fractions: Sequence[float], level: float
) -> tuple[Extrapolated, LinearFit, LinearFit]:
    """Fit a line and a parabola over the wall's share; returns what they say at 0, and both."""
    line = fit_linear(fractions, {WALL: wall}, level=level)
    curve = fit_linear(fractions, {WALL: wall, "squared": np.square(wall)}, level=level)
    se = 0.0 if isinstance(line.standard_errors, Undefined) else line.standard_errors[0]
    return Extrapolated(line.coefficients[0], se, line.intervals()[0], curve.intervals()[0]), line, curve
