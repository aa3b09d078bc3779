"""Contrasts of condition means: what the levels of a factor differ by, and what the saving depends on."""

from __future__ import annotations

from data_schema.vocabulary import Undefined
from reports.claims import contrast_name, contrast_unit
from reports.display import (
    common_places,
    level_text,
    with_unit,
)
from reports.results import MeansContrast, StudyResults
from reports.tables.comparisons import reasons_note
from reports.tables.table import (
    PLAIN_INTERVAL,
    Cell,
    Columns,
    Table,
    TableKind,
    column,
    counts,
    ids,
    interval_cell,
    number_cell,
    p_cell,
    statistic,
    table_of,
    text,
)


def _make(results: StudyResults) -> Table:
    found = results.contrasts
    places = {
        unit: common_places([each.estimate for each in found if contrast_unit(each) == unit])
        for unit in map(contrast_unit, found)
    }
    adjusted = next((one.adjusted for one in found if one.adjusted is not None), None)
    by_days = any(one.days for one in found)
    level = next((level_text(one.estimate) for one in found), "CI")
    columns: Columns[MeansContrast] = (
        text("contrast", "kind outcome factor levels side per at", lambda one: _name_cell(results, one)),
        counts("days", "days", lambda one: len(one.days), shown=by_days),
        counts("n", "n", lambda one: one.estimate.n),
        column("estimate", "estimate unit", lambda one: _estimate(one, places[contrast_unit(one)])),
        column(level, PLAIN_INTERVAL, lambda one: interval_cell(one.estimate, places[contrast_unit(one)])),
        statistic("t", "t", lambda one: one.test),
        column(
            "Holm",
            "holm_p",
            lambda one: p_cell(None if one.adjusted is None else one.adjusted.value),
            shown=adjusted is not None,
        ),
        ids(lambda one: one.estimate.provenance),
        text("exploratory", "exploratory", lambda one: one.exploratory, shown=False),
    )
    holm = "" if adjusted is None else f" Holm: p adjusted over the {adjusted.n} contrasts."
    how = "over all runs"
    if by_days:
        how = (
            "on the days that hold what each of their effects compares: of the days' own contrasts from four days on, "
            "within days where there are fewer"
        )
    exploratory = reasons_note(one.exploratory for one in found)
    legend = "n: runs that enter. Points are percentage points of savings."
    caption = f"Contrasts of condition means {how}. {legend}{holm}{exploratory}"
    return table_of("contrasts", caption, found, columns)


def _name_cell(results: StudyResults, one: MeansContrast) -> Cell:
    values = (str(one.kind), one.quantity.key, one.factor, " ".join(one.levels), one.side, one.per, one.at)
    return Cell(contrast_name(results, one), values)


def _estimate(one: MeansContrast, places: int) -> Cell:
    cell = number_cell(one.estimate, places)
    text = cell.text if isinstance(one.estimate.value, Undefined) else with_unit(cell.text, contrast_unit(one))
    return Cell(text, (*cell.values, one.estimate.unit), cell.note)


CONTRASTS = TableKind("contrasts", _make)
