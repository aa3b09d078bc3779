"""Each headline as reported and recomputed: without exclusions, with the other detector, by other rules, a day less."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from data_schema.vocabulary import Undefined
from reports.content import ReportContent, Sensitivity, Variant
from reports.display import DASH, EQUALS, as_shown, count_text, general_text, list_text
from reports.figures.kind import FigureKind
from reports.figures.savings import draw_estimate, tidy_rows, write_beside
from reports.figures.style import BLUE, GREY, VERMILLION, is_narrow, light_grid, new_figure
from reports.numbers import Number, Value

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_ROW_IN, _LABELS_IN, _LETTER_IN, _FRAME_IN, _TITLE_LINE_IN = 0.135, 1.25, 0.07, 0.42, 0.11
_COUNT_IN = 0.5
_PAGE_IN = 9.0
"""A figure that would be higher than a page draws the recomputations without one day as one row."""

_AS_REPORTED = "as reported"


@dataclass(frozen=True, slots=True)
class _Row:
    """A row of a panel: several numbers where days stand together, or rules."""

    label: str
    numbers: tuple[Number, ...]


@dataclass(frozen=True, slots=True)
class _Grid:
    """The panels' rows and places: `height_in` of each line of panels, letters that a panel's title may have."""

    rows: list[list[_Row]]
    shared: bool
    across: int
    heights_in: list[float]
    letters: int


def draw(content: ReportContent, width_in: float) -> Figure:
    """Draw one panel a headline and one row a variant that changes it; the line is the number as reported.

    Panels with the same rows share their names; where the rows differ, each panel has its own. The runs that a number
    is computed from stand at its right.
    """
    from matplotlib.ticker import MaxNLocator

    narrow = is_narrow(width_in)
    sets = content.sensitivity
    grid = _grid(sets, width_in, folded=narrow)
    if sum(grid.heights_in) > _PAGE_IN:
        grid = _grid(sets, width_in, folded=True)
    figure = new_figure(width_in, sum(grid.heights_in))
    lines = len(grid.heights_in)
    panels = figure.subplots(lines, grid.across, squeeze=False, sharey=grid.shared, height_ratios=grid.heights_in)
    for index, (panel, one, rows) in enumerate(zip(panels.flatten(), sets, grid.rows, strict=False)):
        start = index - index % grid.across
        shown = as_shown(one.as_reported)
        if not isinstance(shown.value, Undefined):
            panel.axvline(shown.value, color=VERMILLION, linewidth=0.7, zorder=1)
        for place, row in enumerate(rows):
            _draw_row(panel, row, place)
        panel.set_title(textwrap.fill(_title(one), grid.letters), fontsize=6 if narrow else 7)
        panel.xaxis.set_major_locator(MaxNLocator(4))
        light_grid(panel, "x")
        tidy_rows(panel, max(map(len, grid.rows[start : start + grid.across])))
        panel.set_yticks(range(len(rows)), [row.label for row in rows], fontsize=6)
    for panel in panels.flatten()[len(sets) :]:
        panel.set_visible(False)
    return figure


def _grid(sets: Sequence[Sensitivity], width_in: float, *, folded: bool) -> _Grid:
    rows = [_rows(one, folded=folded) for one in sets]
    shared = all([row.label for row in own] == [row.label for row in rows[0]] for own in rows)
    narrow = is_narrow(width_in)
    across = 1 if narrow else min(len(sets), 4 if shared else 2)
    labels_in = _LABELS_IN if shared else across * _LABELS_IN
    letters = max(12, int(((width_in - labels_in) / across - _COUNT_IN) / _LETTER_IN))
    titles = [len(textwrap.wrap(_title(one), letters)) for one in sets]
    heights = [
        _FRAME_IN
        + _ROW_IN * max(map(len, rows[start : start + across]))
        + _TITLE_LINE_IN * max(titles[start : start + across])
        for start in range(0, len(sets), across)
    ]
    return _Grid(rows, shared, across, heights, letters)


def _title(one: Sensitivity) -> str:
    unit = as_shown(one.as_reported).unit
    return f"{one.headline} ({unit})" if unit not in ("", "1") else one.headline


def _rows(one: Sensitivity, *, folded: bool) -> list[_Row]:
    changed = _changed(one)
    days = [variant for variant in changed if variant.day]
    rules = [variant for variant in changed if variant.by_rules]
    alone = [variant for variant in changed if variant not in rules and not (folded and variant in days)]
    rows = [_Row(variant.label, (variant.number,)) for variant in alone]
    together = ((_ONE_DAY, days if folded else []), (_RULES, rules))
    rows += [_Row(label, tuple(variant.number for variant in several)) for label, several in together if several]
    return [_Row(_AS_REPORTED, (one.as_reported,)), *rows]


_ONE_DAY = "without one day, each"
_RULES = "by other rules, each"


def _draw_row(axes: Axes, row: _Row, place: int) -> None:
    """Draw a row's numbers at one height, or close together, and at the right how many runs they are computed from."""
    reported = row.label == _AS_REPORTED
    for index, number in enumerate(row.numbers):
        shift = 0.0 if len(row.numbers) == 1 else 0.6 * (index / (len(row.numbers) - 1) - 0.5)
        colour, marker = (VERMILLION, "D") if reported else (BLUE, "o")
        draw_estimate(axes, number, place + shift, colour=colour, marker=marker, scale=1 / len(row.numbers) ** 0.4)
    counts = sorted({number.n for number in row.numbers if number.n is not None})
    if counts:
        text = str(counts[0]) if len(counts) == 1 else f"{counts[0]}{DASH}{counts[-1]}"
        write_beside(axes, f"n{EQUALS}{text}", place, 3, size_pt=5.5, colour=GREY)


def _changed(one: Sensitivity) -> list[Variant]:
    """Return the variants whose value, interval or runs are not the reported ones."""
    return [variant for variant in one.variants if _shown(variant.number) != _shown(one.as_reported)]


def _shown(number: Number) -> tuple[Value | None, ...]:
    return number.value, number.ci_low, number.ci_high, number.n


def caption(content: ReportContent) -> str:
    """Say what is drawn, and how many variants are not because they change nothing."""
    text = (
        f"{count_text(len(content.sensitivity), 'headline').capitalize()} as reported (diamond, vertical line) and "
        "recomputed (circles), with the confidence interval of each; n: runs that a number rests on."
    )
    names = [_kind(variant) for one in content.sensitivity for variant in one.variants]
    drawn = [_kind(variant) for one in content.sensitivity for variant in _changed(one)]
    left = [
        f"{name} ({names.count(name) - drawn.count(name)} of {names.count(name)})"
        for name in dict.fromkeys(names)
        if names.count(name) > drawn.count(name)
    ]
    return f"{text} Recomputations that change nothing are not drawn: {list_text(left)}." if left else text


def _kind(variant: Variant) -> str:
    return "without one day" if variant.day else _RULES if variant.by_rules else variant.label


def alternative(content: ReportContent) -> str:
    """Describe the plot in words: the range of each headline over its variants."""
    return " ".join(_range_sentence(one) for one in content.sensitivity)


def _range_sentence(one: Sensitivity) -> str:
    values = [as_shown(v.number).value for v in one.variants]
    numbers = [value for value in values if not isinstance(value, Undefined)]
    if not numbers:
        return f"{one.headline}: no variant has a value."
    unit, count = as_shown(one.as_reported).unit, count_text(len(one.variants), "variant")
    return f"{one.headline}: {general_text(min(numbers))} to {general_text(max(numbers))} {unit} over {count}."


def absent(content: ReportContent) -> str | None:
    """Give the reason where no headline was recomputed."""
    return None if content.sensitivity else "No headline number was recomputed for this selection."


def shows(content: ReportContent) -> dict[str, object]:
    """Return what is drawn of a report."""
    return {"sensitivity": content.sensitivity}


SENSITIVITY = FigureKind("sensitivity", "Sensitivity", draw, caption, alternative, absent, shows)
