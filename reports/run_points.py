"""From a point of a figure to its run: each dot is named, and leads to the run's row where the page has it."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from html import escape

from data_schema.outcomes import Outcome
from reports.content import ReportContent, RunValue
from reports.display import general_text, shown_unit
from reports.figures.series import series_of

MOST_RUNS = 600
"""Up to so many runs the page has a row for each; beyond, the files have them."""

_POINT = re.compile(r"<use\b[^>]*/>")


def run_names(content: ReportContent) -> tuple[str, ...]:
    """Return the names of the analysed runs, group by group, each once."""
    summaries = (summary for condition in content.conditions for summary in condition.summaries.values())
    return tuple(dict.fromkeys(run.run for summary in summaries for run in summary.runs))


def run_anchors(content: ReportContent) -> dict[str, str]:
    """Return where each run's row is on the page; empty where there are too many of them.

    An anchor is a number, for a run's name may hold anything.
    """
    names = run_names(content)
    return {} if len(names) > MOST_RUNS else {name: f"run-{place}" for place, name in enumerate(names, start=1)}


def run_days(content: ReportContent) -> dict[str, str]:
    """Return the day of each run."""
    return {run: day.date for day in content.days for run in day.runs}


def points_drawn(content: ReportContent, outcome: Outcome) -> list[list[RunValue]]:
    """Return the runs whose points a figure by damping has, series by series, in the order in which it draws them."""
    found = (
        [run for condition in series.conditions if (summary := condition.summary(outcome)) for run in summary.runs]
        for series in series_of(content)
    )
    return [runs for runs in found if runs]


def name_points(svg: str, figure: str, content: ReportContent, anchors: Mapping[str, str]) -> str:
    """Name the points of a figure by damping that stands inline on a page; any other figure is returned as it is."""
    outcome = next((one for one in Outcome if figure == f"{one.key}_by_damping"), None)
    if outcome is None:
        return svg
    days = run_days(content)
    for place, runs in enumerate(points_drawn(content, outcome)):
        start = svg.find(f'<g id="{figure}-runs-{place}">')
        end = svg.find("</g>", start)
        if start < 0 or end < 0:
            continue
        svg = svg[:start] + _named(svg[start:end], runs, outcome, days, anchors) + svg[end:]
    return svg.replace('role="img"', 'role="group"', 1)  # what links is no single picture


def _named(
    group: str, runs: Sequence[RunValue], outcome: Outcome, days: Mapping[str, str], anchors: Mapping[str, str]
) -> str:
    points = _POINT.findall(group)
    if len(points) != len(runs):  # a value off the drawing has no point, and the others no certain name
        return group
    left = iter(runs)
    unit, factor = shown_unit(outcome.unit)

    def named(point: re.Match[str]) -> str:
        run = next(left)
        day = f", {days[run.run]}" if run.run in days else ""
        title = f"<title>{escape(f'{run.run}{day}: {general_text(run.value * factor)} {unit}')}</title>"
        if run.run not in anchors:
            return f"<g>{title}{point[0]}</g>"
        return f'<a href="#{anchors[run.run]}" tabindex="-1">{title}{point[0]}</a>'

    return _POINT.sub(named, group)
