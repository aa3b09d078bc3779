"""Measured and predicted side by side: every condition a row, a panel a quantity."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from reports.display import as_shown, count_text, general_text, given_text, level_text, sentence_start, shown_unit
from reports.figures.forest import draw_estimate, name_rows
from reports.figures.kind import FigureKind
from reports.figures.style import BLACK, VERMILLION, is_narrow, light_grid, new_figure, plain_ticks
from reports.naming import levels_name
from reports.numbers import Number
from reports.results import COVERAGE_FACTOR, POOLED, PredictedQuantity, Prediction, StudyResults
from reports.tables.predictions import block_of, level_text_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_ROW_IN = 0.175
_APART = 0.17
"""How far a measured value stands above its row, and a predicted one below it, in rows."""
_RowKey = tuple[str, str]


def _rows(results: StudyResults) -> list[tuple[_RowKey | None, str]]:
    """Return the rows from the top: a group's name over its levels; a heading has no key."""
    groups: dict[str, dict[_RowKey, tuple[int, str]]] = {}
    for item in results.predictions.items:
        heading = block_of(results, item)
        rank = 2 if item.level == POOLED else 0 if item.control else 1
        groups.setdefault(heading, {})[_key(results, item)] = (rank, level_text_of(results, item))
    rows: list[tuple[_RowKey | None, str]] = []
    for heading, levels in groups.items():
        if heading:
            rows.append((None, heading))
        rows += [(key, text) for key, (_rank, text) in sorted(levels.items(), key=lambda pair: pair[1][0])]
    return rows


def _key(results: StudyResults, item: Prediction) -> _RowKey:
    return levels_name(results, item.group), item.level


def _shown(results: StudyResults) -> list[PredictedQuantity]:
    return [quantity for quantity in PredictedQuantity if results.predictions.of(quantity)]


def _unit(quantity: PredictedQuantity) -> str:
    return "J a jump" if quantity is PredictedQuantity.JOULES else shown_unit(quantity.unit)[0]


def draw(results: StudyResults, width_in: float) -> Figure:
    """Draw one panel a quantity; measured means with their interval, predictions with two standard uncertainties."""
    narrow, rows, quantities = is_narrow(width_in), _rows(results), _shown(results)
    figure = new_figure(width_in, 1.0 + _ROW_IN * max(len(rows), 3))
    panels = figure.subplots(1, len(quantities), squeeze=False, sharey=True)[0]
    places = {key: place for place, (key, _text) in enumerate(rows) if key is not None}
    for axes, quantity in zip(panels, quantities, strict=True):
        _draw_panel(axes, results, quantity, places, narrow)
        name_rows(axes, [(text, key is None) for key, text in rows], 5.5 if narrow else 7)
    for label, colour, marker in (("measured", BLACK, "o"), ("predicted", VERMILLION, "D")):
        panels[0].plot([], [], color=colour, marker=marker, markersize=4.0, linewidth=1.1, label=label)
    figure.legend(loc="outside lower center", ncols=2)
    return figure


def _draw_panel(
    axes: Axes, results: StudyResults, quantity: PredictedQuantity, places: dict[_RowKey, int], narrow: bool
) -> None:
    scale = 0.7 if narrow else 1.0
    for item in results.predictions.of(quantity):
        place = places[_key(results, item)]
        draw_estimate(axes, item.measured, place - _APART, scale=scale)
        draw_estimate(axes, _expanded(item.check.predicted), place + _APART, VERMILLION, "D", 0.8 * scale)
    axes.set_xlabel(("\n" if narrow else " ").join([*sentence_start(quantity.short).split(), f"({_unit(quantity)})"]))
    axes.xaxis.set_major_locator(plain_ticks(3 if narrow else 5))
    axes.margins(x=0.08)
    light_grid(axes, "x")


def _expanded(number: Number) -> Number:
    """Give a prediction the interval of its expanded uncertainty."""
    if number.known is None or not isinstance(number.se, int | float):
        return number
    half = COVERAGE_FACTOR * number.se
    return replace(number, ci_low=number.known - half, ci_high=number.known + half)


def caption(results: StudyResults) -> str:
    """Say what is drawn."""
    about = results.predictions
    level = level_text(about.items[0].measured)
    return (
        f"Measured means (circles) with their {level}, and what the scene {about.scene} predicts for each condition as "
        f"it was run (diamonds), ± {given_text(COVERAGE_FACTOR)} standard uncertainties (simulator, assumed "
        "inputs)."
    )


def alternative(results: StudyResults) -> str:
    """Describe the plot in words: how many predictions, and the range of the differences."""
    sentences = []
    for quantity in _shown(results):
        items = results.predictions.of(quantity)
        found = [value for item in items if (value := as_shown(item.check.difference).known) is not None]
        span = ""
        if found:
            ends = f"{general_text(min(found))} to {general_text(max(found))} {_unit(quantity)}"
            span = f"; predicted less measured {ends}"
        sentences.append(f"{quantity}: {count_text(len(items), 'prediction')}{span}.")
    return f"Measured and predicted values of each condition. {' '.join(sentences)}"


def absent(results: StudyResults) -> str | None:
    """Give the reason where nothing was predicted."""
    if results.predictions.items:
        return None
    return "Nothing is predicted: labbook.toml names no scene under [simulation], or nothing was measured."


_SHOWS = ("factors", "conditions", "predictions")
PREDICTIONS = FigureKind(
    "predictions", "Predicted and measured", draw, caption, alternative, absent, _SHOWS, section="predicted"
)
