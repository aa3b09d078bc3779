"""Apex heights tested for equality within bounds (TOST)."""

from __future__ import annotations

from dataclasses import replace

from data_schema.vocabulary import Undefined
from reports.content import Comparison, ReportContent
from reports.display import DASH, common_places, level_text, shown_unit
from reports.evidence import Equivalence
from reports.remarks import FOOTNOTE
from reports.sentences import bounds_text
from reports.tables.placing import COMPARISON, EXPLORATORY, ONE_DAY_EACH, exploratory_note, on_one_day_each, placed
from reports.tables.table import (
    PROVENANCE,
    Cell,
    Column,
    Row,
    Table,
    TableKind,
    interval_cell,
    interval_title,
    number_cell,
    p_cell,
    provenance_cell,
    statistic_cells,
    statistic_columns,
    unit_slug,
    words,
)

_VERDICTS = {True: "shown", False: "not shown", None: DASH}


def _why(comparison: Comparison) -> str:
    return "" if comparison.equivalence is None else comparison.equivalence.exploratory


def _table(content: ReportContent) -> Table:
    tested = [comparison for comparison in content.comparisons if comparison.equivalence is not None]
    found = [comparison.equivalence for comparison in tested if comparison.equivalence is not None]
    if not found:
        return Table("equivalence", "Apex heights are not tested for equivalence.", (COMPARISON,), ())
    estimates = [item.estimate for item in found]
    unit = estimates[0].unit
    slug, shown = unit_slug(unit), shown_unit(unit)[0]
    places = common_places(estimates)
    columns = (
        COMPARISON,
        Column("n", ("n_control", "n_treatment")),
        Column("difference", (f"difference_{slug}",), shown),
        Column(interval_title(estimates), (f"ci_low_{slug}", f"ci_high_{slug}", "ci_level"), shown),
        *(replace(column, shown=False) for column in statistic_columns("t, lower", "t_low")),
        *(replace(column, shown=False) for column in statistic_columns("t, upper", "t_high")),
        Column("p", ("tost_p",)),
        Column("equivalence", ("equivalent",), numeric=False),
        Column("bounds", (f"bound_low_{slug}", f"bound_high_{slug}"), shown=False),
        PROVENANCE,
        EXPLORATORY,
        ONE_DAY_EACH,
    )
    rows = tuple(
        Row(
            (
                first,
                Cell(f"{comparison.n_control}, {comparison.n_treatment}",
                     (comparison.n_control, comparison.n_treatment)),
                number_cell(item.estimate, places),
                on_one_day_each(interval_cell(item.estimate, places), comparison.one_day_each),
                *statistic_cells(item.at_low),
                *statistic_cells(item.at_high),
                on_one_day_each(p_cell(item.p), comparison.one_day_each),
                _verdict(item, comparison.one_day_each),
                Cell(bounds_text(item), (item.low, item.high)),
                provenance_cell(item.estimate.provenance),
                words(item.exploratory),
                words(comparison.one_day_each),
            ),
            block=block,
        )
        for comparison, first, block in placed(content, tested, _why)
        for item in [comparison.equivalence]
        if item is not None
    )  # fmt: skip
    of_mean = " of the control's mean" if unit == "%" else ""
    caption = (
        f"Apex heights against the bounds {bounds_text(found[0])}{of_mean}: two one-sided tests by Welch (TOST), p "
        f"the larger of both. Equivalence is shown where both reject, that is where the {level_text(estimates[0])} "
        f"lies within the bounds.{exploratory_note(tested, _why)}"
    )
    return Table("equivalence", caption, columns, rows)


def _verdict(item: Equivalence, one_day_each: str) -> Cell:
    note = item.p.reason if isinstance(item.p, Undefined) else FOOTNOTE if one_day_each else ""
    return Cell(
        DASH if one_day_each else _VERDICTS[item.shown],
        (None if item.shown is None else str(item.shown).lower(),),
        note=note,
    )


EQUIVALENCE = TableKind("equivalence", _table)
