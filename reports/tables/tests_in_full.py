"""The tests behind comparisons in full, equivalence of apex heights within bounds (TOST), and analyses of variance."""

from __future__ import annotations

from dataclasses import replace

from data_schema.outcomes import Outcome
from data_schema.vocabulary import Undefined
from reports import fields
from reports.content import Anova, Comparison, ReportContent
from reports.display import DASH, common_places, level_text
from reports.evidence import Equivalence
from reports.naming import levels_name, swept_factor, swept_words
from reports.remarks import FOOTNOTE
from reports.sentences import bounds_text
from reports.tables.comparisons import (
    COMPARISON,
    EXPLORATORY,
    ONE_DAY_EACH,
    ComparisonRow,
    difference_columns,
    mark_confounded,
    over_runs,
    reasons_note,
    table_of_comparisons,
)
from reports.tables.table import (
    PROVENANCE,
    Cell,
    Column,
    Columns,
    Table,
    TableKind,
    count,
    interval_cell,
    interval_column,
    number_cell,
    p_cell,
    provenance_cell,
    statistic_cells,
    statistic_columns,
    table_of,
    tables_of_outcomes,
    words,
)

_BY_RUNS: Columns[ComparisonRow[Comparison]] = (
    (Column("chosen", fields.CHOSEN_TEST, numeric=False), lambda row: words(row.shown.test.name)),
    (statistic_columns("t", "t"), lambda row: over_runs(row.shown.test, row.shown.one_day_each)),
    (statistic_columns("Welch t", "welch"), lambda row: over_runs(row.shown.welch, row.shown.one_day_each)),
)


def _tests(content: ReportContent, quantity: Outcome, name: str) -> Table:
    found = [ComparisonRow(each, each) for each in content.comparisons if each.quantity is quantity]
    spread, spread_p = statistic_columns("Brown-Forsythe F", "brown_forsythe", 2)
    spread_tested = any(comparison.brown_forsythe is not None for comparison, _ in found)
    columns: Columns[ComparisonRow[Comparison]] = (
        (statistic_columns("F", "f", 2), lambda row: statistic_cells(row.shown.variance_test, 2)),
        (
            (replace(spread, shown=False), replace(spread_p, title="Brown-Forsythe p", shown=spread_tested)),
            lambda row: statistic_cells(row.shown.brown_forsythe, 2),
        ),
        *_BY_RUNS,
        (
            interval_column((), quantity.unit, of="welch_", shown=False),
            lambda row: interval_cell(row.shown.welch_difference),
        ),
        (ONE_DAY_EACH, lambda row: words(row.shown.one_day_each)),
    )
    beside = ", and Brown and Forsythe's test beside F" if spread_tested else ""
    caption = (
        f"Tests of the comparisons of {quantity} on {content.counted} means: the F-test for equal variances chooses "
        f"Student's or Welch's t; Welch's stands beside it always{beside}."
    )
    return table_of_comparisons(name, caption, content, found, columns)


def _jump_tests(content: ReportContent) -> Table:
    columns: Columns[ComparisonRow[Comparison]] = (
        (Column("jumps", fields.N_OF_SIDES), lambda row: count(row.shown.n_control, row.shown.n_treatment)),
        (statistic_columns("F", "f", 2), lambda row: statistic_cells(row.shown.variance_test, 2)),
        *_BY_RUNS,
        (EXPLORATORY, lambda row: words(row.shown.exploratory)),
        (ONE_DAY_EACH, lambda row: words(row.shown.one_day_each)),
    )
    caption = (
        "Apex heights by the thesis's route, the same tests over single jumps. It takes all jumps as independent, "
        "while jumps of one run share its bed, pack and day: the true p is larger. No claim rests on this table."
        f"{reasons_note(comparison.exploratory for comparison in content.jump_comparisons)}"
    )
    return table_of_comparisons(
        "tests_jumps", caption, content, [ComparisonRow(each, each) for each in content.jump_comparisons], columns
    )


def _anovas(content: ReportContent) -> Table:
    columns: Columns[Anova] = (
        (
            Column("group", fields.GROUP, numeric=False),
            lambda anova: words(levels_name(content, anova.group) or anova.label),
        ),
        (Column("n", fields.N_RUNS), lambda anova: count(anova.n)),
        (statistic_columns("F", "f", 2), lambda anova: over_runs(anova.test, anova.one_day_each, 2)),
        (PROVENANCE, lambda anova: provenance_cell(anova.provenance)),
        (EXPLORATORY, lambda anova: words(anova.exploratory)),
        (ONE_DAY_EACH, lambda anova: words(anova.one_day_each)),
    )
    swept = swept_words(swept_factor(content)).coefficient
    caption = f"One-way analysis of variance over the levels of the {swept} in each group, control left out."
    caption += reasons_note(anova.exploratory for anova in content.anovas)
    return table_of(
        "anovas",
        caption,
        content.anovas,
        columns,
        block=lambda anova: f"{anova.quantity} (exploratory)" if anova.exploratory else str(anova.quantity),
    )


TESTS = tables_of_outcomes("tests_{}", _tests)
"""A table an outcome."""
TESTS_JUMPS = TableKind("tests_jumps", _jump_tests)
ANOVAS = TableKind("anovas", _anovas)


_VERDICTS = {True: "shown", False: "not shown", None: DASH}


def _equivalence(content: ReportContent) -> Table:
    found = [
        ComparisonRow(each, tested) for each in content.comparisons if (tested := each.lead.equivalence) is not None
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
            lambda row: count(row.comparison.lead.n_control, row.comparison.lead.n_treatment),
        ),
        (
            difference_columns(estimates, unit),
            lambda row: (
                number_cell(row.shown.estimate, places),
                mark_confounded(interval_cell(row.shown.estimate, places), row.comparison.unsure),
            ),
        ),
        (one_sided("lower"), lambda row: statistic_cells(row.shown.at_low)),
        (one_sided("upper"), lambda row: statistic_cells(row.shown.at_high)),
        (Column("p", fields.TOST_P), lambda row: mark_confounded(p_cell(row.shown.p), row.comparison.unsure)),
        (
            Column("equivalence", fields.EQUIVALENT, numeric=False),
            lambda row: _verdict(row.shown, row.comparison.unsure),
        ),
        (
            Column("bounds", fields.named(fields.BOUNDS, unit=unit), shown=False),
            lambda row: Cell(bounds_text(row.shown), (row.shown.low, row.shown.high)),
        ),
        (PROVENANCE, lambda row: provenance_cell(row.shown.estimate.provenance)),
        (EXPLORATORY, lambda row: words(row.shown.exploratory)),
        (ONE_DAY_EACH, lambda row: words(row.comparison.one_day_each)),
    )
    by = "by the days that hold both" if any(each.decision is not None for each, _ in found) else "by Welch"
    of_mean = " of the control's mean" if unit == "%" else ""
    caption = (
        f"Apex heights against the bounds {bounds_text(found[0].shown)}{of_mean}: two one-sided tests {by} (TOST), p "
        f"the larger of both. Equivalence is shown where both reject, that is where the {level_text(estimates[0])} "
        f"lies within the bounds.{reasons_note(item.exploratory for _, item in found)}"
    )
    return table_of_comparisons("equivalence", caption, content, found, columns, lambda row: row.shown.exploratory)


def _verdict(item: Equivalence, one_day_each: str) -> Cell:
    note = item.p.reason if isinstance(item.p, Undefined) else FOOTNOTE if one_day_each else ""
    return Cell(
        DASH if one_day_each else _VERDICTS[item.shown],
        (None if item.shown is None else str(item.shown).lower(),),
        note=note,
    )


EQUIVALENCE = TableKind("equivalence", _equivalence)
