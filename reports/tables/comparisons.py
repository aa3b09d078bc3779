"""Effects of treatments against their control: differences and savings, and the same with days as a random effect.

A comparison stands in the block of its family, under its label, with a word for what was not planned.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from typing import Generic, NamedTuple, TypeVar

from data_schema.outcomes import Outcome
from reports import fields
from reports.content import Comparison, ReportContent
from reports.display import DASH, SAVINGS, common_places, level_text
from reports.evidence import ByDay, Decision
from reports.naming import level_of, levels_name
from reports.numbers import Number, SignificanceTest
from reports.remarks import FOOTNOTE
from reports.tables.table import (
    PROVENANCE,
    Cell,
    Column,
    Columns,
    Row,
    Table,
    count,
    in_unit,
    interval_cell,
    interval_column,
    number_cell,
    p_cell,
    provenance_cell,
    statistic_cells,
    statistic_columns,
    table_of,
    tables_of_outcomes,
    text_column,
    words,
)

COMPARISON = text_column("comparison", fields.COMPARISON)
EXPLORATORY = text_column("exploratory", fields.EXPLORATORY, shown=False)
"""Why a comparison is exploratory; the page says so in the heading of its block and in the caption."""
ONE_DAY_EACH = text_column("one day each", fields.ONE_DAY_EACH, shown=False)
"""Why the row's p and intervals are confounded with days; the page marks them in a footnote."""


T = TypeVar("T")


class ComparisonRow(NamedTuple, Generic[T]):
    """A comparison, and what of it a table shows."""

    comparison: Comparison
    shown: T


def table_of_comparisons(
    name: str,
    caption: str,
    content: ReportContent,
    found: Sequence[ComparisonRow[T]],
    columns: Columns[ComparisonRow[T]],
    why: Callable[[ComparisonRow[T]], str] = lambda row: row.comparison.exploratory,
) -> Table:
    """Make a table with a row a comparison, in the block of its family, under its label.

    A family with several levels a group has a block a group; one with a single row a group is one block. `why` says
    why a comparison is exploratory.
    """
    names = [levels_name(content, each.comparison.group) or "all runs" for each in found]
    counts = Counter((each.comparison.family, name) for each, name in zip(found, names, strict=True))
    several = {family for (family, _), number in counts.items() if number > 1}
    table = table_of(name, caption, found, columns)
    rows = []
    for each, group, row in zip(found, names, table.rows, strict=True):
        comparison = each.comparison
        family, level = comparison.family, level_of(content, comparison)
        if family in several:
            text, block = level, ": ".join(filter(None, (family, group)))
        else:
            text = group if level.lower() in family.lower() else f"{group}, {level}"
            block = family
        block = f"{block} (exploratory)" if why(each) else block
        first = Cell(text, (family, group, comparison.level))
        rows.append(Row((first, *row.cells), block=block))
    return replace(table, columns=(COMPARISON, *table.columns), rows=tuple(rows))


def mark_confounded(cell: Cell, why: str, *, dash: bool = False) -> Cell:
    """Mark a p or an interval whose groups are confounded with days, as `why` says; a dash is not marked.

    With `dash` only a dash is marked; the file has its own reason.
    """
    return replace(cell, note=FOOTNOTE) if why and (cell.text == DASH) is dash else cell


def over_runs(test: SignificanceTest, one_day_each: str, degrees: int = 1) -> tuple[Cell, Cell]:
    """Make the cells of a test that knows no days: its p is marked where each group had one day."""
    statistic, p = statistic_cells(test, degrees)
    return statistic, mark_confounded(p, one_day_each)


def difference_columns(numbers: Sequence[Number], unit: str) -> tuple[Column, Column]:
    """Make the columns of differences in a stored unit and of their intervals."""
    return in_unit("difference", fields.DIFFERENCE, unit), interval_column(numbers, unit)


def reasons_note(given: Iterable[str]) -> str:
    """Return the end of a caption that says why rows are exploratory, each reason once; "" is none."""
    reasons = list(dict.fromkeys(filter(None, given)))
    if len(reasons) > 1:
        numbered = "; ".join(f"({place}) {reason}" for place, reason in enumerate(reasons, 1))
        return f" Rows called exploratory are so for one of these reasons: {numbered}."
    return f" Rows called exploratory are so because {reasons[0]}." if reasons else ""


_WELCH = (
    "Difference: treatment less control, with interval and p by Welch's t-test (the F-test's choice stands under "
    "Tests in full); n: {counted}s of the control, of the treatment."
)
_DECIDED = (
    "Difference: treatment less control, with interval and p by the days that hold both: paired on day means "
    "from four days on, within days where there are fewer. n: runs of the control and of the treatment on these days."
)


def _of_outcome(content: ReportContent, quantity: Outcome, name: str) -> Table:
    comparisons = [comparison for comparison in content.comparisons if comparison.quantity is quantity]
    leads = [comparison.lead for comparison in comparisons]
    differences, savings = [lead.difference for lead in leads], [lead.savings for lead in leads]
    decided = any(comparison.decision is not None for comparison in comparisons)
    with_savings = any(saved is not None for saved in savings)
    legend = (_DECIDED if decided else _WELCH).format(counted=content.counted)
    caption = f"Every comparison of {quantity}. {legend}"
    adjusted = next((lead.adjusted for lead in leads if lead.adjusted is not None), None)
    if adjusted is not None:
        caption += f" Holm: p adjusted over the {adjusted.n} tests of the family."
    caption += one_sided_note(leads)
    places, savings_places = common_places(differences), common_places(savings, 1)
    columns: Columns[ComparisonRow[Decision]] = (
        (
            Column("days", fields.DAYS, shown=decided),
            lambda row: words("") if row.comparison.decision is None else count(len(row.shown.days)),
        ),
        (Column("n", fields.N_OF_SIDES), lambda row: count(row.shown.n_control, row.shown.n_treatment)),
        (
            difference_columns(differences, quantity.unit),
            lambda row: (
                number_cell(row.shown.difference, places),
                mark_confounded(interval_cell(row.shown.difference, places), row.comparison.unsure),
            ),
        ),
        (statistic_columns("t", "t"), lambda row: over_runs(_of_difference(row.shown), row.comparison.unsure)),
        (
            Column("Holm", fields.HOLM, shown=adjusted is not None),
            lambda row: mark_confounded(_adjusted_cell(row.shown.adjusted), row.comparison.unsure),
        ),
        (
            Column(SAVINGS, fields.SAVINGS, "%", shown=with_savings),
            lambda row: number_cell(row.shown.savings, savings_places),
        ),
        (
            interval_column(savings, "%", of="savings_", shown=with_savings),
            lambda row: mark_confounded(interval_cell(row.shown.savings, savings_places), row.comparison.unsure),
        ),
        (text_column("unit", fields.UNIT, shown=False), lambda row: words(row.shown.unit)),
        (PROVENANCE, lambda row: provenance_cell((row.shown.savings or row.shown.difference).provenance)),
        (EXPLORATORY, lambda row: words(row.comparison.exploratory)),
        (ONE_DAY_EACH, lambda row: words(row.comparison.one_day_each)),
    )
    caption += reasons_note(comparison.exploratory for comparison in comparisons)
    found = [ComparisonRow(comparison, comparison.lead) for comparison in comparisons]
    return table_of_comparisons(name, caption, content, found, columns)


def one_sided_note(leads: Sequence[Decision]) -> str:
    """Say which p and intervals of a table are one-sided; "" where none are."""
    of = next((lead.savings for lead in leads if lead.test.one_sided and lead.savings is not None), None)
    return "" if of is None else f" p of savings is one-sided, as decided, with {level_text(of)}s."


def _of_difference(lead: Decision) -> SignificanceTest:
    """Return the test with the sign of the difference beside it; t of savings is stored as positive for a saving."""
    t, difference = lead.test.statistic, lead.difference.value
    if not isinstance(t, float) or not isinstance(difference, float):
        return lead.test
    return replace(lead.test, statistic=math.copysign(t, difference))


def _adjusted_cell(adjusted: Number | None) -> Cell:
    if adjusted is None:
        return Cell(DASH, (None, None, None))
    return replace(p_cell(adjusted.value), values=(adjusted.value, adjusted.n, adjusted.provenance))


COMPARISONS = tables_of_outcomes("comparisons_{}", _of_outcome)
"""A table an outcome."""


def _by_day(content: ReportContent, quantity: Outcome, name: str) -> Table:
    found = [
        ComparisonRow(comparison, comparison.by_day)
        for comparison in content.comparisons
        if comparison.quantity is quantity and comparison.by_day is not None
    ]
    differences = [by_day.difference for _, by_day in found]
    places = common_places(differences)

    def of_days(cell: Cell, row: ComparisonRow[ByDay]) -> Cell:
        return mark_confounded(cell, row.comparison.one_day_each, dash=True)

    columns: Columns[ComparisonRow[ByDay]] = (
        (Column("days", fields.DAYS), lambda row: count(row.shown.days)),
        (
            difference_columns(differences, quantity.unit),
            lambda row: (
                number_cell(row.shown.difference, places),
                of_days(interval_cell(row.shown.difference, places), row),
            ),
        ),
        (
            statistic_columns("t", "t"),
            lambda row: tuple(of_days(cell, row) for cell in statistic_cells(row.shown.test)),
        ),
        (
            in_unit("day SD", fields.DAY_SD, quantity.unit),
            lambda row: of_days(number_cell(row.shown.day_sd, places), row),
        ),
        (
            in_unit("run SD", fields.RUN_SD, quantity.unit, shown=False),
            lambda row: number_cell(row.shown.run_sd, places),
        ),
        (text_column("test", fields.METHOD), lambda row: Cell(row.shown.kind, (row.shown.method,))),
        (PROVENANCE, lambda row: provenance_cell(row.shown.difference.provenance)),
        (EXPLORATORY, lambda row: words(row.comparison.exploratory)),
        (text_column("confounding", fields.CONFOUNDING, shown=False), lambda row: words(row.shown.confounding)),
    )
    caption = (
        f"The comparisons of {quantity} with the control by day: runs of one day have the day in common (day as a "
        "random effect; the exact test where the design is balanced, else a mixed model, REML, degrees of freedom "
        "after Satterthwaite; either takes both sides to scatter alike). Day SD: how days differ, as a standard "
        "deviation by the mixed model."
        f"{reasons_note(comparison.exploratory for comparison, _ in found)}"
    )
    return table_of_comparisons(name, caption, content, found, columns)


BY_DAY = tables_of_outcomes("by_day_{}", _by_day)
"""A table an outcome."""
