"""Savings of the treatment, (control - treatment) / control in percent, with their intervals (Fieller)."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from data_schema.grouping import grouped
from reports import display
from reports.display import EQUALS, common_places, interval_text, level_text, sentence_start, value_text
from reports.figures.forest import ForestRow, draw_forest
from reports.figures.kind import FigureKind
from reports.figures.style import GREY, is_narrow, light_grid, new_figure, plain_ticks
from reports.naming import level_of, levels_name, swept_factor, swept_words, treated_levels, treatment_label
from reports.numbers import Number
from reports.results import Comparison, StudyResults

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_ROW_IN = 0.165


def _formula(results: StudyResults) -> str:
    control = swept_words(swept_factor(results)).control
    return f"({control} \u2212 {treatment_label(results)}) / {control}"


def _with_savings(results: StudyResults) -> list[tuple[Comparison, Number]]:
    return [(each, each.decision.savings) for each in results.by_group if each.decision.savings is not None]


def _rows(results: StudyResults) -> list[ForestRow]:
    """Return the mean of several groups, then group by group what is pooled, and each level where there are several.

    Rows pooled across some groups stand together at the end, those over all runs where there is no mean.
    """
    means = [each for each in results.overall if len(each.groups) > 1]
    found = [
        (each, savings)
        for each, savings in _with_savings(results)
        if (each.opens or len(treated_levels(results, each.group)) != 1) and (each.group or not means)
    ]
    places = common_places([each.savings for each in means] + [savings for _, savings in found])
    rows = [
        ForestRow(f"mean of {len(each.groups)} groups", (each.savings,), True, _number_text(each.savings, places))
        for each in means
    ]
    factors = max((len(each.group) for each, _ in found), default=0)
    headings = ["pooled across groups" if len(each.group) < factors else _group(results, each) for each, _ in found]
    blocks = grouped(found, headings)
    for heading, block in blocks.items():
        several = len(block) > 1 or len(block[0][0].group) < factors
        rows += [ForestRow(heading, heading=True)] if several else []
        for each, savings in sorted(block, key=lambda row: not row[0].opens):
            level, lead = level_of(results, each), each.decision
            label = level if several and len(each.group) == factors else f"{_group(results, each)}, {level}"
            runs = f"n{EQUALS}{lead.n_control}, {lead.n_treatment}"
            rows.append(ForestRow(label, (savings,), each.opens, f"{_number_text(savings, places)}  {runs}"))
    return rows


def _group(results: StudyResults, comparison: Comparison) -> str:
    return levels_name(results, comparison.group) or "all runs"


def _number_text(savings: Number, places: int) -> str:
    """Write the percentage with its interval; one that does not exist is named, its reason is in the table."""
    if savings.known is None:
        return "undefined"
    interval = "no interval" if savings.interval is None else interval_text(savings, places, unit=False)
    return f"{value_text(savings.known, places)} ({interval})"


def draw(results: StudyResults, width_in: float) -> Figure:
    """Draw one row a comparison under the name of its group; zero is no savings."""
    narrow, rows = is_narrow(width_in), _rows(results)
    figure = new_figure(width_in, 0.75 + _ROW_IN * max(len(rows), 2))
    axes = figure.add_subplot()
    axes.axvline(0.0, color=GREY, linewidth=0.8, zorder=1)
    if narrow:
        rows = [replace(row, beside="") for row in rows]
    draw_forest(axes, rows, 6 if narrow else 7)
    axes.set_xlabel(f"{sentence_start(display.SAVINGS)} {_formula(results)} (%)")
    axes.xaxis.set_major_locator(plain_ticks(5))
    light_grid(axes, "x")
    return figure


def caption(results: StudyResults) -> str:
    """Say what is drawn."""
    level = level_text(_with_savings(results)[0][1])
    several = len(treated_levels(results, {})) > 1
    marks = "diamonds, all levels pooled; circles, each; " if several else ""
    return (
        f"{sentence_start(display.SAVINGS)}, {_formula(results)}, with {level} (Fieller): {marks}right, percent "
        f"(interval) and runs."
    )


def alternative(results: StudyResults) -> str:
    """Describe the plot in words: the mean of the groups, and the pooled savings of each."""
    parts, heading = [], ""
    for row in _rows(results):
        heading = heading if row.numbers else row.label
        parts += [f"{heading} {row.label}: {row.beside}".strip()] if row.strong else []
    return f"Forest plot of {display.SAVINGS} in percent. {'; '.join(parts)}."


def absent(results: StudyResults) -> str | None:
    """Give the reason where nothing was compared with a control."""
    if _with_savings(results):
        return None
    return "This selection has no joules of both a control and a treatment to compare, so there are no savings."


_SHOWS = ("factors", "conditions", "comparisons", "overall")
SAVINGS = FigureKind("savings", sentence_start(display.SAVINGS), draw, caption, alternative, absent, _SHOWS)
