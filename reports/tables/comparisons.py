"""Effects of treatments against their control: differences, savings, equivalence within bounds; the thesis's tests.

A comparison stands in the block of its family, under its label, with a word for what was not planned.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from typing import Generic, NamedTuple, TypeVar

from data_schema.outcomes import Outcome
from data_schema.vocabulary import Undefined
from reports import fields
from reports.claims import bounds_text
from reports.content import Anova, Comparison, Decision, Equivalence, ReportContent, ThesisRoute
from reports.display import DASH, SAVINGS, common_places, level_text
from reports.naming import level_of, levels_name, swept_factor, swept_words
from reports.numbers import Number, SignificanceTest, t_test
from reports.tables.table import (
    PROVENANCE,
    Cell,
    Column,
    Columns,
    Row,
    Table,
    TableKind,
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


_DECIDED = (
    "Difference: treatment less control, with interval and p by the days that hold both: paired on day means "
    "from four days on, within days where there are fewer. n: runs of the control and of the treatment on these days."
)


def _of_outcome(content: ReportContent, quantity: Outcome, name: str) -> Table:
    comparisons = [comparison for comparison in content.comparisons if comparison.quantity is quantity]
    decisions = [comparison.decision for comparison in comparisons]
    differences, savings = [one.difference for one in decisions], [one.savings for one in decisions]
    with_savings = any(saved is not None for saved in savings)
    caption = f"Every comparison of {quantity}. {_DECIDED}"
    adjusted = next((one.adjusted for one in decisions if one.adjusted is not None), None)
    if adjusted is not None:
        caption += f" Holm: p adjusted over the {adjusted.n} tests of the family."
    caption += one_sided_note(decisions)
    places, savings_places = common_places(differences), common_places(savings, 1)
    columns: Columns[ComparisonRow[Decision]] = (
        (Column("days", fields.DAYS), lambda row: count(len(row.shown.days))),
        (Column("n", fields.N_OF_SIDES), lambda row: count(row.shown.n_control, row.shown.n_treatment)),
        (
            difference_columns(differences, quantity.unit),
            lambda row: (number_cell(row.shown.difference, places), interval_cell(row.shown.difference, places)),
        ),
        (statistic_columns("t", "t"), lambda row: statistic_cells(row.shown.test_of_difference)),
        (
            Column("Holm", fields.HOLM, shown=adjusted is not None),
            lambda row: _adjusted_cell(row.shown.adjusted),
        ),
        (
            Column(SAVINGS, fields.SAVINGS, "%", shown=with_savings),
            lambda row: number_cell(row.shown.savings, savings_places),
        ),
        (
            interval_column(savings, "%", of="savings_", shown=with_savings),
            lambda row: interval_cell(row.shown.savings, savings_places),
        ),
        (text_column("unit", fields.UNIT, shown=False), lambda row: words(row.shown.unit)),
        (PROVENANCE, lambda row: provenance_cell(row.shown.headline.provenance)),
        (EXPLORATORY, lambda row: words(row.comparison.exploratory)),
    )
    caption += reasons_note(comparison.exploratory for comparison in comparisons)
    found = [ComparisonRow(comparison, comparison.decision) for comparison in comparisons]
    return table_of_comparisons(name, caption, content, found, columns)


def one_sided_note(leads: Sequence[Decision]) -> str:
    """Say which p and intervals of a table are one-sided; "" where none are."""
    of = next((lead.savings for lead in leads if lead.one_sided and lead.savings is not None), None)
    return "" if of is None else f" p of savings is one-sided, as decided, with {level_text(of)}s."


def _adjusted_cell(adjusted: Number | None) -> Cell:
    if adjusted is None:
        return Cell(DASH, (None, None, None))
    return replace(p_cell(adjusted.value), values=(adjusted.value, adjusted.n, adjusted.provenance))


COMPARISONS = tables_of_outcomes("comparisons_{}", _of_outcome)
"""A table an outcome."""


_VERDICTS = {True: "shown", False: "not shown", None: DASH}


def _equivalence(content: ReportContent) -> Table:
    found = [
        ComparisonRow(each, tested) for each in content.comparisons if (tested := each.decision.equivalence) is not None
    ]
    if not found:
        return Table("equivalence", "Apex heights are not tested for equivalence.", (COMPARISON,), ())
    estimates = [item.estimate for _, item in found]
    unit = estimates[0].unit
    places = common_places(estimates)

    def one_sided(side: str) -> tuple[Column, ...]:
        of_side = statistic_columns(f"t, {side}", "t_low" if side == "lower" else "t_high")
        return tuple(replace(column, shown=False) for column in of_side)

    columns: Columns[ComparisonRow[Equivalence]] = (
        (
            Column("n", fields.N_OF_SIDES),
            lambda row: count(row.comparison.decision.n_control, row.comparison.decision.n_treatment),
        ),
        (
            difference_columns(estimates, unit),
            lambda row: (number_cell(row.shown.estimate, places), interval_cell(row.shown.estimate, places)),
        ),
        (
            one_sided("lower"),
            lambda row: statistic_cells(t_test("lower bound", row.shown.t_low, row.shown.p_low)),
        ),
        (
            one_sided("upper"),
            lambda row: statistic_cells(t_test("upper bound", row.shown.t_high, row.shown.p_high)),
        ),
        (Column("p", fields.TOST_P), lambda row: p_cell(row.shown.p.value)),
        (text_column("equivalence", fields.EQUIVALENT), lambda row: _verdict(row.shown)),
        (
            Column("bounds", fields.named(fields.BOUNDS, unit=unit), shown=False),
            lambda row: Cell(bounds_text(row.shown), (row.shown.low, row.shown.high)),
        ),
        (PROVENANCE, lambda row: provenance_cell(row.shown.estimate.provenance)),
        (EXPLORATORY, lambda row: words(row.shown.exploratory)),
    )
    of_mean = " of the control's mean" if unit == "%" else ""
    caption = (
        f"Apex heights against the bounds {bounds_text(found[0].shown)}{of_mean}: two one-sided tests by the days that "
        f"hold both (TOST), p the larger of both. Equivalence is shown where both reject, that is where the "
        f"{level_text(estimates[0])} lies within the bounds.{reasons_note(item.exploratory for _, item in found)}"
    )
    return table_of_comparisons("equivalence", caption, content, found, columns, lambda row: row.shown.exploratory)


def _verdict(item: Equivalence) -> Cell:
    note = item.p.value.reason if isinstance(item.p.value, Undefined) else ""
    return Cell(_VERDICTS[item.shown], (None if item.shown is None else str(item.shown).lower(),), note=note)


EQUIVALENCE = TableKind("equivalence", _equivalence)


def _f_test(route: ThesisRoute) -> SignificanceTest:
    df = (float(route.n_treatment - 1), float(route.n_control - 1))
    return SignificanceTest("F", route.f.value, df, route.f_p.value)


def _routes(
    name: str, caption: str, content: ReportContent, found: list[ComparisonRow[ThesisRoute]], unit: str
) -> Table:
    differences = [route.difference for _comparison, route in found]
    places = common_places(differences)
    columns: Columns[ComparisonRow[ThesisRoute]] = (
        (Column("n", fields.N_OF_SIDES), lambda row: count(row.shown.n_control, row.shown.n_treatment)),
        (statistic_columns("F", "f", 2), lambda row: statistic_cells(_f_test(row.shown), 2)),
        (text_column("chosen", fields.CHOSEN_TEST), lambda row: words(row.shown.test)),
        (statistic_columns("t", "t"), lambda row: statistic_cells(t_test(row.shown.test, row.shown.t, row.shown.p))),
        (
            difference_columns(differences, unit),
            lambda row: (number_cell(row.shown.difference, places), interval_cell(row.shown.difference, places)),
        ),
        (PROVENANCE, lambda row: provenance_cell(row.shown.difference.provenance)),
    )
    return table_of_comparisons(name, caption, content, found, columns)


def _over_runs(content: ReportContent, quantity: Outcome, name: str) -> Table:
    found = [ComparisonRow(each, each.over_runs) for each in content.comparisons if each.quantity is quantity]
    caption = (
        f"The thesis's route (5.2.1) to {quantity}, over all runs whatever their days: the F-test for equal variances "
        "chooses Student's or Welch's t."
    )
    return _routes(name, caption, content, found, quantity.unit)


def _over_jumps(content: ReportContent) -> Table:
    found = [ComparisonRow(each, each.over_jumps) for each in content.comparisons if each.over_jumps is not None]
    caption = (
        "The thesis's route to apex heights over single jumps. Jumps of one run share its bed, pack and day: the true "
        "p is larger."
    )
    return _routes("tests_jumps", caption, content, found, Outcome.APEX.unit)


def _anovas(content: ReportContent) -> Table:
    columns: Columns[Anova] = (
        (
            text_column("group", fields.GROUP),
            lambda anova: words(levels_name(content, anova.group) or anova.label),
        ),
        (Column("n", fields.N_RUNS), lambda anova: count(anova.n)),
        (statistic_columns("F", "f", 2), lambda anova: statistic_cells(anova.test, 2)),
        (PROVENANCE, lambda anova: provenance_cell(anova.p.provenance)),
    )
    swept = swept_words(swept_factor(content)).coefficient
    caption = f"One-way analysis of variance over the levels of the {swept} in each group, control left out."
    return table_of("anovas", caption, content.anovas, columns, block=lambda anova: str(anova.quantity))


TESTS = tables_of_outcomes("tests_{}", _over_runs)
"""A table an outcome."""
TESTS_JUMPS = TableKind("tests_jumps", _over_jumps)
ANOVAS = TableKind("anovas", _anovas)
