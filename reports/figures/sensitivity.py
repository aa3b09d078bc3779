"""Each headline as reported and recomputed: without exclusions, with the other detector, without each day."""

from __future__ import annotations

import textwrap

from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from data_schema.vocabulary import Undefined
from reports.content import ReportContent, Sensitivity
from reports.display import as_shown, with_unit
from reports.figures.forest import draw_estimate, tidy_rows
from reports.figures.kind import FigureKind
from reports.figures.style import BLUE, VERMILLION, is_narrow, light_grid, new_figure
from reports.sentences import count_text

_ROW_IN, _LABELS_IN, _LETTER_IN = 0.135, 1.25, 0.07
_AS_REPORTED = "as reported"


def draw(content: ReportContent, width_in: float) -> Figure:
    """Draw one panel a headline and one row a variant; the vertical line is the number as reported."""
    narrow = is_narrow(width_in)
    sets = content.sensitivity
    across = min(len(sets), 2 if narrow else 4)
    down = -(-len(sets) // across)
    labels = list(dict.fromkeys(variant.label for one in sets for variant in one.variants))
    rows = {label: row for row, label in enumerate([_AS_REPORTED, *labels])}
    letters = max(12, int((width_in - _LABELS_IN) / across / _LETTER_IN))
    figure = new_figure(width_in, down * (0.95 + _ROW_IN * len(rows)))
    grid = figure.subplots(down, across, squeeze=False, sharey=True)
    for panel, one in zip(grid.flatten(), sets, strict=False):
        shown = as_shown(one.as_reported)
        if not isinstance(shown.value, Undefined):
            panel.axvline(shown.value, color=VERMILLION, linewidth=0.7, zorder=1)
        draw_estimate(panel, one.as_reported, 0, colour=VERMILLION, marker="D")
        for variant in one.variants:
            draw_estimate(panel, variant.number, rows[variant.label], colour=BLUE)
        panel.set_title(textwrap.fill(one.headline, letters), fontsize=7)
        panel.xaxis.set_major_locator(MaxNLocator(4))
        panel.set_xlabel(with_unit("", shown.unit).strip() or "value")
        light_grid(panel, "x")
        tidy_rows(panel, len(rows))
        panel.set_yticks(list(rows.values()), list(rows), fontsize=6)
    for panel in grid.flatten()[len(sets) :]:
        panel.set_visible(False)
    return figure


def caption(content: ReportContent) -> str:
    """Say what is drawn."""
    return (
        f"{count_text(len(content.sensitivity), 'headline').capitalize()} as reported (diamond, vertical line) and "
        "recomputed (circles), with the confidence interval of each."
    )


def alternative(content: ReportContent) -> str:
    """Describe the plot in words: the range of each headline over its variants."""
    return " ".join(_range_sentence(one) for one in content.sensitivity)


def _range_sentence(one: Sensitivity) -> str:
    values = [as_shown(v.number).value for v in one.variants]
    numbers = [value for value in values if not isinstance(value, Undefined)]
    if not numbers:
        return f"{one.headline}: no variant has a value."
    unit = as_shown(one.as_reported).unit
    return f"{one.headline}: {min(numbers):.3g} to {max(numbers):.3g} {unit} over {len(one.variants)} variants."


def absent(content: ReportContent) -> str | None:
    """Give the reason where no headline was recomputed."""
    return None if content.sensitivity else "No headline number was recomputed for this selection."


SENSITIVITY = FigureKind("sensitivity", "Sensitivity", draw, caption, alternative, absent)
