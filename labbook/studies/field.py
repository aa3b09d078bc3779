"""Walks in the field: specific resistance, the energy over weight times distance, of two robots (thesis 2.2.3)."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from data_schema.errors import InputRefused
from data_schema.rounding import error_of, interval_text, level_text, number_text
from data_schema.units import STANDARD_GRAVITY_M_S2
from data_schema.vocabulary import Undefined
from ingest.formats.study_sheets import StudySheet, read_power, read_walks
from labbook.studies.study import Asked, Found, level_of, sheet_source
from reports.figures.style import BLACK, BLUE, GREY, ONE_COLUMN_IN, VERMILLION, legend_below, light_grid, paper_figure
from reports.page.study import Study
from simulator.steady.published_results import published_numbers
from stats.compare.summary import describe
from stats.results import plural

FARTHEST_APART = 1.1
"""Quotient of two robots' distances up to which they walked together, as they measure it."""
PLAUSIBLE = (0.01, 100.0)
PUBLISHED = {"thin": "field.sr_thin", "wide": "field.sr_wide"}
"""What docs/published.md calls the specific resistance of the thesis's RHex, by its legs (2.2.3)."""


@dataclass(frozen=True, slots=True)
class GeometricMean:
    """Of values on the same walks, with Student's interval of the logarithms; `published` is the thesis's, if any."""

    name: str
    walks: Mapping[str, float]
    geometric_mean: float
    ci: tuple[float, float] | Undefined
    published: float | None

    def text(self, level: float, after: str) -> str:
        """Write the mean, and after it its interval where there is one."""
        text = number_text(self.geometric_mean, error=error_of(self.ci))
        return text if isinstance(self.ci, Undefined) else text + after.format(interval_text(self.ci, level))


@dataclass(frozen=True, slots=True)
class FieldStudy(Study):
    """The specific resistance of two robots on the same walks, and the ratio of the second to the first within walks.

    `doubt` is what is to be looked at in the sheet.
    """

    title: ClassVar[str] = "What two robots need on the same walks"
    robots: tuple[GeometricMean, GeometricMean]
    ratio: GeometricMean
    level: float
    doubt: str | None

    def sentences(self) -> list[str]:
        """Say how much less or more the second robot needs, and what either needs; last what is doubtful."""
        first, second = (one.name for one in self.robots)
        walks = plural(len(self.ratio.walks), "walk")
        needs = " and ".join(f"{one.text(self.level, ' ({})')} {one.name}" for one in self.robots)
        thesis = " and ".join(f"{published_numbers()[name]:g} {legs}" for legs, name in PUBLISHED.items())
        percent = 100.0 * (self.ratio.geometric_mean - 1.0)
        change = f"{number_text(abs(percent), 2)} % {'less' if percent < 0.0 else 'more'} than"
        change = change if percent else "as much as"
        interval = self.ratio.ci
        if isinstance(interval, Undefined):
            answer = f"On these walks {second} needed {change} {first}; no interval: {interval.reason}."
        else:
            within = f"{self.ratio.name} {self.ratio.text(self.level, ', {}')}, within {walks}"
            tells = "" if interval[1] < 1.0 or interval[0] > 1.0 else "; the difference is not significant"
            answer = f"On the same walks {second} needs {change} {first} ({within}){tells}."
        lines = [
            answer,
            f"Specific resistance, energy over weight times distance: {needs} (geometric means of {walks}).",
            f"The thesis: {thesis}, on one walk of 430 m (2.2.3; {' and '.join(PUBLISHED.values())}).",
        ]
        return lines if self.doubt is None else [*lines, self.doubt]

    def caption(self) -> str:
        """Say what is drawn."""
        return (
            "Specific resistance of both robots, each walk a line, and their ratio on each walk; geometric means with "
            "intervals, and the thesis's values."
        )

    def draw(self) -> Figure:
        """Draw the walks as lines from robot to robot, from 0 on, and the ratio on each walk."""
        with paper_figure(2.9, ONE_COLUMN_IN) as figure:
            of_robots, of_ratio = figure.subplots(1, 2, width_ratios=(2.2, 1.0))
            for values in zip(*(one.walks.values() for one in self.robots), strict=True):
                of_robots.plot((0, 1), values, "o-", color=GREY, markersize=3, linewidth=0.7, label="one walk")
            for place, one in enumerate(self.robots):
                self._draw_mean(of_robots, place, 1 if place else -1, one)
            of_robots.set_xticks((0, 1), [one.name for one in self.robots], color=BLACK)
            of_robots.set_xlim(-0.6, 1.6)
            of_robots.set_ylim(bottom=0.0)
            of_robots.set_ylabel("Specific resistance")
            of_ratio.axhline(1.0, color=BLACK, linewidth=0.7)
            ratios = list(self.ratio.walks.values())
            of_ratio.plot([0.0] * len(ratios), ratios, "o", color=GREY, markersize=3)
            self._draw_mean(of_ratio, 0, 1, self.ratio)
            of_ratio.set_xticks([0], [self.ratio.name], color=BLACK)
            of_ratio.set_xlim(-0.4, 0.6)
            of_ratio.set_ylabel("Ratio")
            for axes in (of_robots, of_ratio):
                light_grid(axes)
            legend_below(figure, [of_robots], 3)
            return figure

    def _draw_mean(self, axes: Axes, place: int, side: int, one: GeometricMean) -> None:
        """Draw a mean with its interval beside the walks, and beyond it the thesis's value."""
        ends = None if isinstance(one.ci, Undefined) else [[abs(end - one.geometric_mean)] for end in one.ci]
        look: dict[str, Any] = {"fmt": "D", "color": VERMILLION, "markersize": 4, "capsize": 3, "zorder": 5}
        label = f"mean, {level_text(self.level)} CI"
        axes.errorbar([place + side * 0.15], [one.geometric_mean], yerr=ends, label=label, **look)
        if one.published is not None:
            axes.plot([place + side * 0.3], [one.published], "*", color=BLUE, markersize=6, label="the thesis")


def ask(asked: Asked) -> Found[FieldStudy]:
    """Read the sheet with one robot on one walk a row, and the power logs that it names, and compare the robots.

    Paths of logs count from the sheet's folder.
    """
    with sheet_source("field", asked) as source:
        sheet = read_walks(source.file(source.path))
        if "energy" not in sheet.values:
            logs = [replace(source.file(source.path.parent / name), name=name) for name in sheet.words["log"]]
            energies_j = [float(np.trapezoid(power_w, time_s)) for time_s, power_w in map(read_power, logs)]
            sheet = replace(sheet, values={**sheet.values, "energy": energies_j})
        study = field_study(sheet, level_of(source.options))
        return Found(study, source.sources, source.files)


def field_study(sheet: StudySheet, level: float = 0.95) -> FieldStudy:
    """Compare two robots that walked together, walk by walk: ground and pace are the same for both.

    Ratios are compared, as a harder ground asks more of both in proportion.
    Raises `InputRefused` for other than two robots, and for walks that both did not make exactly once.
    """
    rows = list(zip(sheet.words["robot"], sheet.words["walk"], strict=True))
    robots, walks = (tuple(dict.fromkeys(sheet.words[word])) for word in ("robot", "walk"))
    distances_m = sheet.values["distance"]
    if len(robots) != 2:
        raise InputRefused(f"the walks are of {', '.join(map(repr, robots))}: compare two robots.")
    for walk in walks:
        places = [place for place, (_robot, other) in enumerate(rows) if other == walk]
        for robot in robots:
            if (robot, walk) not in rows:
                raise InputRefused(
                    f"{robot!r} did not make the walk {walk!r} (line {sheet.lines[places[0]]}): give what both made "
                    "together."
                )
        one_m, other_m = sorted(distances_m[place] for place in places)
        if other_m > FARTHEST_APART * one_m:
            came = " and the other ".join(f"{distances_m[place]:g} m (line {sheet.lines[place]})" for place in places)
            raise InputRefused(
                f"on {walk!r} one robot came {came}: compare what both walked together, and check the distances."
            )
    found: dict[str, dict[str, float]] = {robot: {} for robot in robots}
    columns = zip(rows, sheet.values["energy"], sheet.values["mass"], distances_m, sheet.lines, strict=True)
    for (robot, walk), energy_j, mass_kg, distance_m, line in columns:
        found[robot][walk] = energy_j / (mass_kg * STANDARD_GRAVITY_M_S2 * distance_m)
        if not PLAUSIBLE[0] < found[robot][walk] < PLAUSIBLE[1]:
            raise InputRefused(
                f"{robot!r} has a specific resistance of {found[robot][walk]:.3g} on {walk!r} (line {line}), and "
                "robots have some 0.1 to 10: check the units of mass, distance and energy."
            )
    first, second = (
        _geometric_mean(robot, {walk: found[robot][walk] for walk in walks}, level, _published(robot))
        for robot in robots
    )
    of_thesis = None if first.published is None or second.published is None else second.published / first.published
    ratios = {walk: second.walks[walk] / first.walks[walk] for walk in walks}
    ratio = _geometric_mean(f"{second.name} / {first.name}", ratios, level, of_thesis)
    return FieldStudy((first, second), ratio, level, sheet.doubt)


def _geometric_mean(name: str, walks: Mapping[str, float], level: float, published: float | None) -> GeometricMean:
    logs = describe([math.log(value) for value in walks.values()], level)
    mean = math.nan if isinstance(logs.mean, Undefined) else math.exp(logs.mean)
    if isinstance(logs.ci_low, Undefined) or isinstance(logs.ci_high, Undefined):
        none = next(end for end in (logs.ci_low, logs.ci_high) if isinstance(end, Undefined))
        return GeometricMean(name, walks, mean, none, published)
    return GeometricMean(name, walks, mean, (math.exp(logs.ci_low), math.exp(logs.ci_high)), published)


def _published(robot: str) -> float | None:
    """Return the thesis's value for a robot that is named by its legs as there: a word of it is theirs."""
    words = re.findall(r"[^\W\d_]+", robot.casefold())
    return next((published_numbers()[name] for legs, name in PUBLISHED.items() if legs in words), None)
