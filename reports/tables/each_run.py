"""The table of each run, when it was made, what it gave, and its jumps; and the points of figures that lead to it.

Each dot is named, and leads to the run's row where the page has it.
"""

from __future__ import annotations

import re
import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from html import escape
from statistics import median

from data_schema.outcomes import Outcome
from data_schema.rounding import decimals_for
from reports.display import DASH, decimal_text, general_text, shown_unit
from reports.figures.series import series_of
from reports.results import Condition, Run, StudyResults, joule_deviations
from reports.tables.conditions import by_group, factor_columns
from reports.tables.table import Cell, ColumnOf, Columns, Table, TableKind, column, table_of, text


@dataclass(frozen=True, slots=True)
class _Run:
    """An analysed run with its condition and its value by outcome; `deviation_j` is from its mean."""

    name: str
    about: Run
    block: str
    condition: Condition
    values: Mapping[Outcome, float]
    deviation_j: float | None


def _each(results: StudyResults) -> list[_Run]:
    """Return the runs in the order of conditions."""
    found = []
    for block, condition in by_group(results):
        values: dict[str, dict[Outcome, float]] = {}
        for outcome, summary in condition.summaries.items():
            for name, value in summary.runs:
                values.setdefault(name, {})[outcome] = value
        deviations = joule_deviations(condition)
        found += [
            _Run(name, results.runs[name], block, condition, of_run, deviations.get(name))
            for name, of_run in values.items()
        ]
    return found


def each_run(results: StudyResults) -> Table:
    """Make the table of each run, in the order of conditions; what figures by day show of it is in CSV alone."""
    runs, days, anchors = _each(results), run_days(results), run_anchors(results)
    heights: dict[str, list[float]] = {}
    for run in runs:
        heights.setdefault(run.block, []).extend(run.about.heights_m.values())
    spans = {block: (min(found), max(found)) for block, found in heights.items() if found}
    columns: Columns[_Run] = (
        text("run", "run", lambda run: run.name),
        text("day", "day", lambda run: days.get(run.name, DASH)),
        column("in the day", "position pack deviation_j", _in_day, shown=False),
        factor_columns(results, lambda run: run.condition),
        *(_outcome_column(one, runs, shown=bool(anchors)) for one in results.outcomes),
        text("jumps", "jumps_analysed lowest_m highest_m", lambda run: _jumps(run, spans.get(run.block, (0.0, 0.0)))),
    )
    caption = (
        "Each run and its analysed jumps in turn, drawn from the lowest to the highest apex of its group. Unfolded: "
        "each jump's number and apex (mm), and the command that draws the run's trace."
    )
    table = table_of("each_run", caption, runs, columns, block=lambda run: run.block)
    if not anchors:
        return table
    rows = tuple(replace(row, anchor=anchors.get(run.name, "")) for row, run in zip(table.rows, runs, strict=True))
    return replace(table, rows=rows)


_NONE, _NO_JUMPS, _NOT_IN_DAY = Cell(DASH, (None,)), Cell(DASH, (None,) * 3), Cell("", (None,) * 3)
"""Of runs without a value, of which there may be a hundred thousand."""


def _in_day(run: _Run) -> Cell:
    about = run.about
    return _NOT_IN_DAY if run.deviation_j is None else Cell("", (about.position, about.pack, run.deviation_j))


def _outcome_column(outcome: Outcome, runs: Sequence[_Run], *, shown: bool) -> ColumnOf[_Run]:
    """Make the column of an outcome, with the decimals that give its median value three digits.

    Of more runs than a page shows (`run_anchors`) CSV alone has the values.
    """
    factor = shown_unit(outcome.unit)[1]
    sizes = [abs(run.values[outcome]) for run in runs if outcome in run.values]
    places = decimals_for(0.1 * factor * median(sizes)) if sizes else 0

    def cell(run: _Run) -> Cell:
        value = run.values.get(outcome)
        if value is None:
            return _NONE
        return Cell(decimal_text(value * factor, places) if shown else "", (value,))

    return column(outcome.heading, f"{outcome.key}_{outcome.unit}", cell, unit=outcome.unit)


def _jumps(run: _Run, span: tuple[float, float]) -> Cell:
    heights_m = run.about.heights_m
    if not heights_m:
        return _NO_JUMPS
    low, high = min(heights_m.values()), max(heights_m.values())
    unit, factor = shown_unit("m")
    text = f"{len(heights_m)}, {general_text(low * factor)} to {general_text(high * factor)} {unit}"
    width = (span[1] - span[0]) or 1.0
    marks = tuple((height - span[0]) / width for height in heights_m.values())
    each = (f"{number}: {decimal_text(height * factor, 1)}" for number, height in heights_m.items())
    details = (", ".join(each), f"labbook plot {shlex.quote(run.name)} --out {shlex.quote(f'{run.name}.html')}")
    return Cell(text, (len(heights_m), low, high), marks=marks, details=details)


EACH_RUN = TableKind("each_run", each_run, by_run=True)


MOST_RUNS = 600
"""Up to so many runs the page has a row for each; beyond, the files have them."""

_POINT = re.compile(r"<use\b[^>]*/>")


def run_names(results: StudyResults) -> tuple[str, ...]:
    """Return the names of the analysed runs, group by group, each once."""
    summaries = (summary for condition in results.conditions for summary in condition.summaries.values())
    return tuple(dict.fromkeys(run for summary in summaries for run, _value in summary.runs))


def run_anchors(results: StudyResults) -> dict[str, str]:
    """Return where each run's row is on the page; empty where there are too many of them.

    An anchor is a number, for a run's name may hold anything.
    """
    names = run_names(results)
    return {} if len(names) > MOST_RUNS else {name: f"run-{place}" for place, name in enumerate(names, start=1)}


def run_days(results: StudyResults) -> dict[str, str]:
    """Return the day of each run."""
    return {run: day.date for day in results.days for run in day.runs}


def points_drawn(results: StudyResults, outcome: Outcome) -> list[list[tuple[str, float]]]:
    """Return the runs whose points a figure by level has, series by series, in the order in which it draws them."""
    found = (
        [run for condition in series.conditions if (summary := condition.summary(outcome)) for run in summary.runs]
        for series in series_of(results)
    )
    return [runs for runs in found if runs]


def name_points(svg: str, figure: str, results: StudyResults, anchors: Mapping[str, str]) -> str:
    """Name the points of a figure by level that stands inline on a page; any other figure is returned as it is."""
    outcome = next((one for one in Outcome if figure == f"{one.key}_by_level"), None)
    if outcome is None:
        return svg
    days = run_days(results)
    for place, runs in enumerate(points_drawn(results, outcome)):
        start = svg.find(f'<g id="{figure}-runs-{place}">')
        end = svg.find("</g>", start)
        if start < 0 or end < 0:
            continue
        svg = svg[:start] + _named(svg[start:end], runs, outcome, days, anchors) + svg[end:]
    return svg.replace('role="img"', 'role="group"', 1)  # what links is no single picture


def _named(
    group: str, runs: Sequence[tuple[str, float]], outcome: Outcome, days: Mapping[str, str], anchors: Mapping[str, str]
) -> str:
    points = _POINT.findall(group)
    if len(points) != len(runs):  # a value off the drawing has no point, and the others no certain name
        return group
    left = iter(runs)
    unit, factor = shown_unit(outcome.unit)

    def named(point: re.Match[str]) -> str:
        run, value = next(left)
        day = f", {days[run]}" if run in days else ""
        title = f"<title>{escape(f'{run}{day}: {general_text(value * factor)} {unit}')}</title>"
        if run not in anchors:
            return f"<g>{title}{point[0]}</g>"
        return f'<a href="#{anchors[run]}" tabindex="-1">{title}{point[0]}</a>'

    return _POINT.sub(named, group)
