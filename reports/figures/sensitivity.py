"""Each headline as reported and recomputed: without exclusions, with the other detector, by other rules, a day less."""

from __future__ import annotations

import math
import textwrap
from typing import TYPE_CHECKING

from data_schema.grouping import grouped
from reports.display import DASH, EQUALS, as_shown, count_text, general_text
from reports.figures.estimation import named_with_unit
from reports.figures.forest import ForestRow, draw_forest
from reports.figures.kind import FigureKind
from reports.figures.style import VERMILLION, is_narrow, light_grid, new_figure, plain_ticks
from reports.naming import headline_name
from reports.numbers import Number
from reports.results import Comparison, StudyResults, Varied

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_ROW_IN, _FRAME_IN = 0.2, 0.8
_AS_REPORTED, _ONE_DAY, _RULES = "as reported", "without one day, each", "by other rules, each"


def draw(results: StudyResults, width_in: float) -> Figure:
    """Draw one panel a headline and one row a variant, or all days and all rules; the line is the number as reported.

    How many runs a number is computed from stands at its right.
    """
    sets = results.headlines
    labels = list(dict.fromkeys(label for one in sets for label in _numbers(*one)))
    across = 1 if is_narrow(width_in) else min(len(sets), 4)
    down = -(-len(sets) // across)
    figure = new_figure(width_in, down * (_FRAME_IN + _ROW_IN * len(labels)))
    panels = figure.subplots(down, across, squeeze=False, sharey=True).flatten()
    for panel in panels[len(sets) :]:
        panel.set_visible(False)
    for panel, one in zip(panels, sets, strict=False):
        reported, numbers = as_shown(one[0].decision.headline), _numbers(*one)
        if reported.known is not None:
            panel.axvline(reported.known, color=VERMILLION, linewidth=0.7, zorder=1)
        draw_forest(panel, [_row(label, numbers.get(label, [])) for label in labels], 6)
        title = named_with_unit(headline_name(results, one[0]), reported.unit)
        panel.set_title(textwrap.fill(title, 40 if across == 1 else 60 // across), fontsize=6)
        panel.xaxis.set_major_locator(plain_ticks(4))
        light_grid(panel, "x")
    return figure


def _numbers(comparison: Comparison, varied: list[Varied]) -> dict[str, list[Number]]:
    """Return the numbers of each row by its label."""
    reported = comparison.decision.headline
    changed = [one for one in varied if not (one.day and _same(one.result.headline, reported))]
    return {
        _AS_REPORTED: [reported],
        **grouped([one.result.headline for one in changed], [_label(one) for one in changed]),
    }


def _same(number: Number, reported: Number) -> bool:
    """Tell whether a number and its interval are those reported but for rounding."""
    pairs = [(each.known, *(each.interval or ())) for each in (as_shown(number), as_shown(reported))]
    return len(pairs[0]) == len(pairs[1]) and all(
        a == b or (a is not None and b is not None and math.isclose(a, b, rel_tol=1e-9))
        for a, b in zip(*pairs, strict=True)
    )


def _label(varied: Varied) -> str:
    return _ONE_DAY if varied.day else _RULES if varied.by_rules else varied.variant


def _row(label: str, numbers: list[Number]) -> ForestRow:
    counts = sorted({number.n for number in numbers if number.n is not None})
    runs = DASH.join(map(str, dict.fromkeys((counts[0], counts[-1])))) if counts else ""
    return ForestRow(label, tuple(numbers), label == _AS_REPORTED, f"n{EQUALS}{runs}" if runs else "")


def caption(results: StudyResults) -> str:
    """Say what is drawn."""
    return (
        f"{count_text(len(results.headlines), 'headline').capitalize()} as reported (diamond, vertical line) and "
        "recomputed (circles), with the confidence interval of each; n: runs that a number is computed from. Days that "
        "change nothing are not drawn."
    )


def alternative(results: StudyResults) -> str:
    """Describe the plot in words: the range of each headline over its variants."""
    return " ".join(_range_sentence(headline_name(results, one), varied) for one, varied in results.headlines)


def _range_sentence(headline: str, varied: list[Varied]) -> str:
    shown = [as_shown(one.result.headline) for one in varied]
    numbers = [one.known for one in shown if one.known is not None]
    if not numbers:
        return f"{headline}: no variant has a value."
    unit, count = shown[0].unit, count_text(len(varied), "variant")
    return f"{headline}: {general_text(min(numbers))} to {general_text(max(numbers))} {unit} over {count}."


def absent(results: StudyResults) -> str | None:
    """Give the reason where no headline was recomputed."""
    return None if results.pooled else "No headline number was recomputed for this selection."


_SHOWS = ("factors", "conditions", "comparisons", "variations")
SENSITIVITY = FigureKind("sensitivity", "Sensitivity", draw, caption, alternative, absent, _SHOWS)
