"""Savings of the treatment, (control - treatment) / control in percent, with their intervals (Fieller).

Estimates with intervals, one a row: the parts that forest plots share.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

from data_schema.vocabulary import Undefined
from reports import display
from reports.content import Comparison, ReportContent
from reports.display import (
    EQUALS,
    as_shown,
    common_places,
    interval_text,
    level_text,
    sentence_start,
    value_text,
)
from reports.figures.kind import FigureKind, levels_alone
from reports.figures.style import BLACK, BLUE, GREY, VERMILLION, is_narrow, light_grid, new_figure, plain_ticks
from reports.naming import level_of, levels_name, swept_factor, swept_words, treated_levels, treatment_label
from reports.numbers import Number

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def draw_estimate(
    axes: Axes, number: Number, row: float, *, colour: str = BLACK, marker: str = "o", scale: float = 1.0
) -> None:
    """Draw one number and its interval at a height; where the number does not exist, say so in its place."""
    shown = as_shown(number)
    if not isinstance(shown.value, int | float):
        axes.text(0.02, row, "undefined", transform=axes.get_yaxis_transform(), color=GREY, fontsize=6.5, va="center")
        return
    low, high = shown.ci_low, shown.ci_high
    if isinstance(low, int | float) and isinstance(high, int | float) and math.isfinite(low + high):
        axes.plot([low, high], [row, row], color=colour, linewidth=1.1 * scale, solid_capstyle="butt", zorder=3)
    axes.plot([shown.value], [row], marker, color=colour, markersize=4.2 * scale, zorder=4)


def tidy_rows(axes: Axes, rows: int) -> None:
    """Put row 0 on top, drop the left spine and its ticks."""
    axes.set_ylim(rows - 0.4, -0.6)
    axes.spines["left"].set_visible(False)
    axes.tick_params(axis="y", length=0)


def write_beside(axes: Axes, words: str, row: float, offset_pt: float, *, size_pt: float, colour: str) -> None:
    """Write words at the right of the axes, so many points from them, at the height of a row."""
    axes.annotate(
        words,
        (1.0, row),
        xycoords=axes.get_yaxis_transform(),
        xytext=(offset_pt, 0),
        textcoords="offset points",
        va="center",
        fontsize=size_pt,
        color=colour,
        annotation_clip=False,
    )


_ROW_IN, _LETTER_PT = 0.165, 4.0
_ACROSS = "pooled across groups"


class _Row(NamedTuple):
    label: str
    savings: Number
    opens: bool
    counts: str

    @classmethod
    def of(cls, label: str, comparison: Comparison) -> _Row:
        lead = comparison.lead
        assert lead.savings is not None  # noqa: S101 - `shown_savings` has looked
        return cls(label, lead.savings, comparison.opens, f"n{EQUALS}{lead.n_control}, {lead.n_treatment}")


def shown_savings(content: ReportContent) -> list[tuple[str, list[_Row]]]:
    """Return the comparisons that have savings as heading and labelled rows, what the page opens with first.

    The mean of several groups stands on top. A group of one level has one row, and with one row it needs no heading
    (""); rows pooled across some groups stand together at the end, those over all runs where there is no mean.
    """
    means = [each for each in content.overall if len(each.scope.groups) > 1]
    found = [
        comparison
        for comparison in content.by_group
        if comparison.lead.savings is not None
        and (comparison.opens or len(treated_levels(content, comparison.group)) != 1)
        and (comparison.group or not means)
    ]
    factors = max((len(comparison.group) for comparison in found), default=0)
    groups: dict[str, list[Comparison]] = {}
    across: list[_Row] = []
    for comparison in found:
        name = levels_name(content, comparison.group) or "all runs"
        if len(comparison.group) < factors:
            across.append(_Row.of(f"{name}, {level_of(content, comparison)}", comparison))
        else:
            groups.setdefault(name, []).append(comparison)
    blocks = [("", [_Row(f"mean of {len(each.scope.groups)} groups", each.savings, True, "")]) for each in means]
    blocks += [_block(content, name, sorted(rows, key=lambda c: not c.opens)) for name, rows in groups.items()]
    return [*blocks, (_ACROSS, across)] if across else blocks


def _block(content: ReportContent, name: str, rows: list[Comparison]) -> tuple[str, list[_Row]]:
    if len(rows) == 1:
        return "", [_Row.of(f"{name}, {level_of(content, rows[0])}", rows[0])]
    return name, [_Row.of(level_of(content, comparison), comparison) for comparison in rows]


def draw(content: ReportContent, width_in: float) -> Figure:
    """Draw one row a comparison under the name of its group; zero is no savings."""
    narrow = is_narrow(width_in)
    blocks = shown_savings(content)
    rows = sum(len(found) + bool(heading) for heading, found in blocks)
    figure = new_figure(width_in, 0.75 + _ROW_IN * max(rows, 2))
    axes = figure.add_subplot()
    axes.axvline(0.0, color=GREY, linewidth=0.8, zorder=1)
    every = [row.savings for _, found in blocks for row in found]
    places = common_places(every)
    texts = [_number_text(savings, places) for savings in every]
    counts_pt = 14 + _LETTER_PT * max(map(len, texts), default=0)
    ticks: list[tuple[str, bool]] = []
    for heading, found in blocks:
        if heading:
            ticks.append((heading, True))
        for row in found:
            _draw_row(axes, row, len(ticks), places, None if narrow else counts_pt)
            ticks.append((row.label, False))
    axes.set_yticks(range(len(ticks)), [text for text, _ in ticks])
    for label_text, (_, is_heading) in zip(axes.get_yticklabels(), ticks, strict=True):
        label_text.set_fontweight("bold" if is_heading else "normal")
        label_text.set_fontsize(6 if narrow else 7)
    tidy_rows(axes, len(ticks))
    called = swept_words(swept_factor(content))
    axes.set_xlabel(
        f"{sentence_start(display.SAVINGS)} ({called.control} − {treatment_label(content)}) / {called.control} (%)"
    )
    axes.xaxis.set_major_locator(plain_ticks(5))
    light_grid(axes, "x")
    return figure


def _number_text(savings: Number, places: int) -> str:
    """Write the percentage with its interval; one that does not exist is named, its reason is in the table."""
    ends = (savings.ci_low, savings.ci_high)
    known = all(isinstance(end, int | float) for end in ends)
    interval = interval_text(savings, places, unit=False) if known else "no interval"
    return f"{value_text(savings.value, places)} ({interval})"


def _draw_row(axes: Axes, row: _Row, place: int, places: int, counts_pt: float | None) -> None:
    """Draw one estimate; the numbers at its right are left out where the runs' column has no place."""
    colour, marker = (VERMILLION, "D") if row.opens else (BLUE, "o")
    draw_estimate(axes, row.savings, place, colour=colour, marker=marker)
    if counts_pt is None or isinstance(row.savings.value, Undefined):
        return
    write_beside(axes, _number_text(row.savings, places), place, 6, size_pt=7, colour=BLACK)
    write_beside(axes, row.counts, place, counts_pt, size_pt=7, colour=GREY)


def caption(content: ReportContent) -> str:
    """Say what is drawn."""
    numbers = [c.lead.savings for c in content.comparisons if c.lead.savings is not None]
    level = level_text(numbers[0]) if numbers else "confidence interval"
    called = swept_words(swept_factor(content))
    several = len(treated_levels(content, {})) > 1
    marks = f"diamonds, all levels of the {called.coefficient} pooled; circles, each; " if several else ""
    return (
        f"{sentence_start(display.SAVINGS)}, ({called.control} − {treatment_label(content)}) / {called.control}, "
        f"with {level} (Fieller): "
        f"{marks}right, percent (interval) and {content.counted}s."
    )


def alternative(content: ReportContent) -> str:
    """Describe the plot in words: the mean of the groups, and the pooled savings of each."""
    parts = [
        f"{' '.join(filter(None, (heading, row.label)))}: {_number_text(row.savings, common_places([row.savings]))} %"
        for heading, found in shown_savings(content)
        for row in found
        if row.opens
    ]
    return f"Forest plot of {display.SAVINGS} in percent. {'; '.join(parts)}."


def absent(content: ReportContent) -> str | None:
    """Give the reason where nothing was compared with a control."""
    if any(comparison.lead.savings is not None for comparison in content.comparisons):
        return None
    return "This selection has no joules of both a control and a treatment to compare, so there are no savings."


def shows(content: ReportContent) -> dict[str, object]:
    """Return what is drawn of a report."""
    with_savings = tuple(each for each in content.comparisons if each.lead.savings is not None)
    shown = {"factors": content.factors, "conditions": levels_alone(content), "comparisons": with_savings}
    return {**shown, "overall": content.overall}


SAVINGS = FigureKind("savings", sentence_start(display.SAVINGS), draw, caption, alternative, absent, shows)
