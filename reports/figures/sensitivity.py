"""Each headline as reported and recomputed: without exclusions, with the other detector, without each day."""

from __future__ import annotations

import re
import textwrap

from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from data_schema.vocabulary import Undefined
from reports.content import ReportContent, Sensitivity, Variant
from reports.display import as_shown, with_unit
from reports.figures.forest import draw_estimate, tidy_rows
from reports.figures.kind import FigureKind
from reports.figures.style import BLUE, VERMILLION, is_narrow, light_grid, new_figure
from reports.numbers import Number, Value
from reports.sentences import count_text, list_text

_ROW_IN, _LABELS_IN, _LETTER_IN = 0.135, 1.25, 0.07
_AS_REPORTED = "as reported"
_DAY = re.compile(r"without \d{4}-\d{2}-\d{2}")


def draw(content: ReportContent, width_in: float) -> Figure:
    """Draw one panel a headline and one row a variant that changes it; the line is the number as reported.

    Panels with the same rows share their names; where the rows differ, each panel has its own.
    """
    narrow = is_narrow(width_in)
    sets = content.sensitivity
    rows = [[_AS_REPORTED, *(variant.label for variant in _changed(one))] for one in sets]
    shared = all(labels == rows[0] for labels in rows)
    across = min(len(sets), (2 if narrow else 4) if shared else (1 if narrow else 2))
    lines = [max(map(len, rows[start : start + across])) for start in range(0, len(sets), across)]
    own_in = width_in / across - _LABELS_IN
    letters = max(12, int(((width_in - _LABELS_IN) / across if shared else own_in) / _LETTER_IN))
    heights = [0.95 + _ROW_IN * count for count in lines]
    figure = new_figure(width_in, sum(heights))
    grid = figure.subplots(len(lines), across, squeeze=False, sharey=shared, height_ratios=heights)
    for index, (panel, one, labels) in enumerate(zip(grid.flatten(), sets, rows, strict=False)):
        shown = as_shown(one.as_reported)
        if not isinstance(shown.value, Undefined):
            panel.axvline(shown.value, color=VERMILLION, linewidth=0.7, zorder=1)
        draw_estimate(panel, one.as_reported, 0, colour=VERMILLION, marker="D")
        for row, variant in enumerate(_changed(one), start=1):
            draw_estimate(panel, variant.number, row, colour=BLUE)
        panel.set_title(textwrap.fill(one.headline, letters), fontsize=7)
        panel.xaxis.set_major_locator(MaxNLocator(4))
        panel.set_xlabel(with_unit("", shown.unit).strip() or "value")
        light_grid(panel, "x")
        tidy_rows(panel, lines[index // across])
        panel.set_yticks(range(len(labels)), labels, fontsize=6)
    for panel in grid.flatten()[len(sets) :]:
        panel.set_visible(False)
    return figure


def _changed(one: Sensitivity) -> list[Variant]:
    """Return the variants whose value or interval is not the reported one."""
    return [variant for variant in one.variants if _shown(variant.number) != _shown(one.as_reported)]


def _shown(number: Number) -> tuple[Value | None, ...]:
    return number.value, number.ci_low, number.ci_high


def caption(content: ReportContent) -> str:
    """Say what is drawn, and how many variants are not because they change nothing."""
    text = (
        f"{count_text(len(content.sensitivity), 'headline').capitalize()} as reported (diamond, vertical line) and "
        "recomputed (circles), with the confidence interval of each."
    )
    every = [variant for one in content.sensitivity for variant in one.variants]
    drawn = [variant for one in content.sensitivity for variant in _changed(one)]
    if len(drawn) == len(every):
        return text
    parts = []
    for is_day, name in ((True, "that leave out a day"), (False, "others")):
        total, left = (sum(bool(_DAY.fullmatch(v.label)) is is_day for v in found) for found in (every, drawn))
        if total > left:
            parts.append(f"{total - left} of {total} {name}")
    return f"{text} Recomputations that change nothing are not drawn: {list_text(parts)}."


def alternative(content: ReportContent) -> str:
    """Describe the plot in words: the range of each headline over its variants."""
    return " ".join(_range_sentence(one) for one in content.sensitivity)


def _range_sentence(one: Sensitivity) -> str:
    values = [as_shown(v.number).value for v in one.variants]
    numbers = [value for value in values if not isinstance(value, Undefined)]
    if not numbers:
        return f"{one.headline}: no variant has a value."
    unit, count = as_shown(one.as_reported).unit, count_text(len(one.variants), "variant")
    return f"{one.headline}: {min(numbers):.3g} to {max(numbers):.3g} {unit} over {count}."


def absent(content: ReportContent) -> str | None:
    """Give the reason where no headline was recomputed."""
    return None if content.sensitivity else "No headline number was recomputed for this selection."


SENSITIVITY = FigureKind("sensitivity", "Sensitivity", draw, caption, alternative, absent)
