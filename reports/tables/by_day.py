"""Comparisons with the control where the day is a random effect."""

from __future__ import annotations

from data_schema.outcomes import Outcome
from reports.content import Comparison, ReportContent
from reports.display import common_places, shown_unit
from reports.evidence import ByDay
from reports.tables.placing import COMPARISON, EXPLORATORY, dash_of_one_day_each, exploratory_note, placed
from reports.tables.table import (
    PROVENANCE,
    Cell,
    Column,
    Row,
    Table,
    count,
    interval_cell,
    interval_title,
    number_cell,
    provenance_cell,
    statistic_cells,
    statistic_columns,
    tables_of_outcomes,
    unit_slug,
    words,
)


def blocked(content: ReportContent, quantity: Outcome) -> list[tuple[Comparison, ByDay]]:
    """Return the comparisons of a quantity that were made by day."""
    return [
        (comparison, comparison.by_day)
        for comparison in content.comparisons
        if comparison.quantity is quantity and comparison.by_day is not None
    ]


def _table(content: ReportContent, quantity: Outcome, name: str) -> Table:
    found = blocked(content, quantity)
    of = {id(comparison): by_day for comparison, by_day in found}
    unit = quantity.unit
    slug, shown = unit_slug(unit), shown_unit(unit)[0]
    differences = [by_day.difference for _, by_day in found]
    places = common_places(differences)
    columns = (
        COMPARISON,
        Column("days", ("days",)),
        Column("difference", (f"difference_{slug}",), shown),
        Column(interval_title(differences), (f"ci_low_{slug}", f"ci_high_{slug}", "ci_level"), shown),
        *statistic_columns("t", "t"),
        Column("day SD", (f"day_sd_{slug}",), shown),
        Column("run SD", (f"run_sd_{slug}",), shown, shown=False),
        Column("test", ("method",), numeric=False),
        PROVENANCE,
        EXPLORATORY,
        Column("confounding", ("confounding",), numeric=False, shown=False),
    )
    rows = tuple(
        Row(
            (
                first,
                count(by_day.days),
                number_cell(by_day.difference, places),
                dash_of_one_day_each(interval_cell(by_day.difference, places), comparison.one_day_each),
                *(dash_of_one_day_each(cell, comparison.one_day_each) for cell in statistic_cells(by_day.test)),
                dash_of_one_day_each(number_cell(by_day.day_sd, places), comparison.one_day_each),
                number_cell(by_day.run_sd, places),
                Cell(by_day.kind, (by_day.method,)),
                provenance_cell(by_day.difference.provenance),
                words(comparison.exploratory),
                words(by_day.confounding),
            ),
            block=block,
            strong=comparison.headline,
        )
        for comparison, first, block in placed(content, [comparison for comparison, _ in found])
        for by_day in [of[id(comparison)]]
    )
    caption = (
        f"The comparisons of {quantity} with the control by day: runs of one day have the day in common (day as a "
        "random effect; the exact test where the design is balanced, else a mixed model, REML, degrees of freedom "
        "after Satterthwaite; either takes both sides to scatter alike). Day SD: how days differ, as a standard "
        "deviation by the mixed model."
        f"{exploratory_note(comparison for comparison, _ in found)}"
    )
    return Table(name, caption, columns, rows)


BY_DAY = tables_of_outcomes("by_day_{}", _table)
"""A table an outcome."""
