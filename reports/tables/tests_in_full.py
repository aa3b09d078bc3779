"""The tests behind the comparisons in full, and the analyses of variance."""

from __future__ import annotations

from dataclasses import replace

from data_schema.outcomes import Outcome
from reports.content import ReportContent
from reports.naming import levels_name, swept_factor, swept_words
from reports.numbers import SignificanceTest
from reports.tables.placing import (
    COMPARISON,
    EXPLORATORY,
    ONE_DAY_EACH,
    exploratory_note,
    on_one_day_each,
    placed,
    reasons_note,
)
from reports.tables.table import (
    PROVENANCE,
    Cell,
    Column,
    Row,
    Table,
    TableKind,
    count,
    interval_cell,
    provenance_cell,
    statistic_cells,
    statistic_columns,
    tables_of_outcomes,
    unit_slug,
    words,
)


def _tests(content: ReportContent, quantity: Outcome, name: str) -> Table:
    comparisons = [c for c in content.comparisons if c.quantity is quantity]
    slug = unit_slug(quantity.unit)
    spread, spread_p = statistic_columns("Brown-Forsythe F", "brown_forsythe", 2)
    spread_tested = any(comparison.brown_forsythe is not None for comparison in comparisons)
    columns = (
        COMPARISON,
        *statistic_columns("F", "f", 2),
        replace(spread, shown=False),
        replace(spread_p, title="Brown-Forsythe p", shown=spread_tested),
        Column("chosen", ("test",), numeric=False),
        *statistic_columns("t", "t"),
        *statistic_columns("Welch t", "welch"),
        Column("Welch CI", (f"welch_ci_low_{slug}", f"welch_ci_high_{slug}", "welch_ci_level"), shown=False),
        ONE_DAY_EACH,
    )
    rows = tuple(
        Row(
            (
                first,
                *statistic_cells(comparison.variance_test, 2),
                *statistic_cells(comparison.brown_forsythe, 2),
                words(comparison.test.name),
                *_over_runs(comparison.test, comparison.one_day_each),
                *_over_runs(comparison.welch, comparison.one_day_each),
                interval_cell(comparison.welch_difference),
                words(comparison.one_day_each),
            ),
            block=block,
            strong=comparison.headline,
        )
        for comparison, first, block in placed(content, comparisons)
    )
    beside = ", and Brown and Forsythe's test beside F" if spread_tested else ""
    caption = (
        f"Tests of the comparisons of {quantity} on {content.counted} means: the F-test for equal variances chooses "
        f"Student's or Welch's t; Welch's stands beside it always{beside}."
    )
    return Table(name, caption, columns, rows)


def _over_runs(test: SignificanceTest, one_day_each: str, degrees: int = 1) -> tuple[Cell, Cell]:
    """Make the cells of a test that knows no days: its p is marked where each group had one day."""
    statistic, p = statistic_cells(test, degrees)
    return statistic, on_one_day_each(p, one_day_each)


def _jump_tests(content: ReportContent) -> Table:
    columns = (
        COMPARISON,
        Column("jumps", ("n_control", "n_treatment")),
        *statistic_columns("F", "f", 2),
        Column("chosen", ("test",), numeric=False),
        *statistic_columns("t", "t"),
        *statistic_columns("Welch t", "welch"),
        EXPLORATORY,
        ONE_DAY_EACH,
    )
    rows = tuple(
        Row(
            (
                first,
                Cell(f"{count(comparison.n_control).text}, {count(comparison.n_treatment).text}",
                     (comparison.n_control, comparison.n_treatment)),
                *statistic_cells(comparison.variance_test, 2),
                words(comparison.test.name),
                *_over_runs(comparison.test, comparison.one_day_each),
                *_over_runs(comparison.welch, comparison.one_day_each),
                words(comparison.exploratory),
                words(comparison.one_day_each),
            ),
            block=block,
        )
        for comparison, first, block in placed(content, content.jump_comparisons)
    )  # fmt: skip
    caption = (
        "Apex heights by the thesis's route, the same tests over single jumps. It takes all jumps as independent, "
        "while jumps of one run share its bed, pack and day: the true p is larger. No claim rests on this table."
        f"{exploratory_note(content.jump_comparisons)}"
    )
    return Table("tests_jumps", caption, columns, rows)


def _anovas(content: ReportContent) -> Table:
    columns = (
        Column("group", ("group",), numeric=False),
        Column("n", ("n_runs",)),
        *statistic_columns("F", "f", 2),
        PROVENANCE,
        EXPLORATORY,
        ONE_DAY_EACH,
    )
    rows = tuple(
        Row(
            (
                words(levels_name(content, anova.group) or anova.label),
                count(anova.n),
                *_over_runs(anova.test, anova.one_day_each, 2),
                provenance_cell(anova.provenance),
                words(anova.exploratory),
                words(anova.one_day_each),
            ),
            block=f"{anova.quantity} (exploratory)" if anova.exploratory else str(anova.quantity),
        )
        for anova in content.anovas
    )
    swept = swept_words(swept_factor(content)).coefficient
    caption = f"One-way analysis of variance over the levels of the {swept} in each group, control left out."
    caption += reasons_note(anova.exploratory for anova in content.anovas)
    return Table("anovas", caption, columns, rows)


TESTS = tables_of_outcomes("tests_{}", _tests)
"""A table an outcome."""
TESTS_JUMPS = TableKind("tests_jumps", _jump_tests)
ANOVAS = TableKind("anovas", _anovas)
