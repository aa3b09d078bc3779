"""What was predicted beside what was measured, a table a quantity, and the inputs that the predictions assume."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from data_schema.vocabulary import Undefined
from reports import fields
from reports.content import POOLED, AssumedInput, AssumedParameter, PredictedQuantity, Prediction, ReportContent
from reports.display import DASH, common_places, given_text, shown_unit, with_unit
from reports.naming import level_name, levels_name, swept_factor, swept_words
from reports.numbers import Number
from reports.tables.table import (
    PROVENANCE,
    Cell,
    Column,
    Columns,
    Table,
    TableKind,
    count,
    in_unit,
    interval_cell,
    interval_column,
    number_cell,
    provenance_cell,
    table_of,
    text_column,
    value_cell,
    words,
)

if TYPE_CHECKING:
    from simulator.steady.published_results import PublishedResult

_ALWAYS = (PredictedQuantity.JOULES, PredictedQuantity.APEX, PredictedQuantity.SAVINGS)
LEGEND = (
    "std. error: one standard uncertainty of the prediction (two are about 95 %); difference: predicted less measured; "
    "ratio: difference over the expanded uncertainty of both, half the measured interval and two standard "
    "uncertainties of the prediction added in quadrature. They agree where the ratio lies within \u22121 to 1."
)
"""What the columns are."""
_VERDICTS = {True: words("yes"), False: words("no"), None: Cell(DASH, (None,))}
_UNSURE = Cell(DASH, (None,), note="two standard uncertainties of the prediction are as large as itself")


def title_text(quantity: PredictedQuantity) -> str:
    """Return what heads the table of a quantity."""
    return f"{quantity.heading}, measured and predicted"


def level_text_of(content: ReportContent, item: Prediction) -> str:
    """Name the level of a prediction: "CE", "d = 186 kg/s (gain 50)", "pooled"; "all runs" without a swept factor."""
    swept = swept_factor(content)
    if item.level == POOLED:
        return POOLED
    if swept is None:
        return levels_name(content, item.group) or "all runs"
    if item.control:
        return swept_words(swept).control_level
    levels = (condition.level(swept.name) for condition in content.conditions if not condition.control)
    level = next((level for level in levels if level is not None and level.label == item.level), None)
    return item.level if level is None else level_name(swept, level, gain=True)


def block_of(content: ReportContent, item: Prediction) -> str:
    """Name the group that a prediction stands under; "" without a swept factor."""
    return levels_name(content, item.group) if swept_factor(content) is not None else ""


def _predicted(item: Prediction, places: int) -> Cell:
    """Make a cell of a prediction, with a mark where the simulation errs by more than it may."""
    cell = number_cell(item.check.predicted, places)
    if not item.check.imprecise:
        return cell
    if item.check.numerical_error is None:
        return replace(cell, note="simulated a hundred times finer, there is no such number")
    unit, factor = shown_unit(item.check.predicted.unit)
    moved = with_unit(f"{item.check.numerical_error * factor:.1g}", unit)
    return replace(cell, note=f"simulated a hundred times finer, it moves by {moved}")


def _error(number: Number, places: int) -> Cell:
    """Make a cell of a standard uncertainty in the unit it is shown in."""
    if number.se is None and not isinstance(number.value, Undefined):
        return Cell(DASH, (None,), note="an assumed input cannot be varied so far")
    return value_cell(number.se, places, shown_unit(number.unit)[1])


_SIGNS = {"less than": "<", "greater than": ">"}


def published_text(found: PublishedResult | None) -> str:
    """Write what the thesis has, with its section: "about 15 % (5.2.1)", "p = .041 (5.2.1)"; "" for nothing."""
    if found is None or found.published is None:
        return ""
    if found.unit == "p":
        text = f"p {_SIGNS.get(found.relation, '=')} {given_text(found.published).removeprefix('0')}"
    else:
        unit, factor = ("%", 100.0) if found.unit == "1" else shown_unit(found.unit)
        text = f"{found.relation} {with_unit(given_text(factor * found.published), unit)}".strip()
    return f"{text} ({found.where})"


def _published(found: PublishedResult | None) -> Cell:
    values = (None, None, None) if found is None else (found.published, found.unit, found.where)
    return Cell(published_text(found), values)


def _make(content: ReportContent, quantity: PredictedQuantity, name: str) -> Table:
    items = content.predictions.of(quantity)
    traced = text_column("published (thesis)", fields.PUBLISHED_RESULT)
    measured = [item.measured for item in items]
    places = common_places(measured)
    finer = max(places, common_places([item.check.predicted for item in items], places))
    columns: Columns[Prediction] = (
        (
            text_column("condition", fields.CONDITION),
            lambda item: Cell(level_text_of(content, item), (levels_name(content, item.group), item.level)),
        ),
        (Column("n", fields.N_RUNS), lambda item: count(item.n)),
        (in_unit("measured", fields.MEASURED, quantity.unit), lambda item: number_cell(item.measured, places)),
        (interval_column(measured, quantity.unit), lambda item: interval_cell(item.measured, places)),
        (in_unit("predicted", fields.PREDICTED, quantity.unit), lambda item: _predicted(item, finer)),
        (in_unit("std. error", fields.PREDICTED_SE, quantity.unit), lambda item: _error(item.check.predicted, finer)),
        (
            in_unit("numerical error", fields.NUMERICAL_ERROR, quantity.unit, shown=False),
            lambda item: Cell("", (item.check.numerical_error,)),
        ),
        (
            in_unit("difference", fields.DIFFERENCE, quantity.unit),
            lambda item: number_cell(item.check.difference, places),
        ),
        (Column("ratio", fields.ERROR_RATIO), lambda item: value_cell(item.check.error_ratio.value, 2)),
        (
            text_column("agree", fields.AGREES),
            lambda item: _UNSURE if item.unsure and item.agrees is None else _VERDICTS[item.agrees],
        ),
        *(((traced, lambda item: _published(item.published)),) if any(item.published for item in items) else ()),
        (PROVENANCE, lambda item: provenance_cell(item.check.predicted.provenance)),
    )
    return table_of(
        name,
        f"{title_text(quantity)}; {LEGEND}",
        items,
        columns,
        block=lambda item: block_of(content, item),
        strong=lambda item: item.level == POOLED,
    )


def _assumed(content: ReportContent) -> Table:
    quantities = [of for of in PredictedQuantity if of in _ALWAYS or content.predictions.of(of)]
    changed = tuple(in_unit(of.short, fields.CHANGE, of.unit, of=of.name.lower()) for of in quantities)
    columns: Columns[AssumedInput] = (
        (text_column("input", fields.INPUT), lambda one: words(one.name)),
        (text_column("value", fields.VALUE_AND_UNIT), lambda one: _value_and_unit(one.parameter)),
        (text_column("why", fields.WHY, prose=True), lambda one: words(one.parameter.why)),
        (
            Column("varied by", fields.VARIED_BY, "%"),
            lambda one: Cell(given_text(100.0 * one.parameter.varied_by), (one.parameter.varied_by,)),
        ),
        (changed, lambda one: tuple(_change(one, of) for of in quantities)),
    )
    caption = (
        "Inputs of the simulation without a source, and the most that raising or lowering each by its part changes in "
        "any condition (savings: in percentage points)."
    )
    return table_of("predicted_inputs", caption, content.predictions.assumed, columns)


def _value_and_unit(one: AssumedParameter) -> Cell:
    return Cell(with_unit(given_text(one.value), one.unit), (one.value, one.unit))


def _change(one: AssumedInput, quantity: PredictedQuantity) -> Cell:
    factor = shown_unit(quantity.unit)[1]
    return value_cell(one.changes.get(quantity), 2 if factor == 1.0 else 1, factor)


def _table_kind(quantity: PredictedQuantity) -> TableKind:
    name = f"predicted_{quantity.name.lower()}"
    return TableKind(name, lambda content: _make(content, quantity, name))


PREDICTED = tuple(map(_table_kind, PredictedQuantity))
"""A table a quantity."""
PREDICTED_INPUTS = TableKind("predicted_inputs", _assumed)
