"""The thesis's own tests beside those that decide: F, then t, over runs and over single jumps; analyses of variance."""

from __future__ import annotations

from data_schema.outcomes import Outcome
from reports import fields
from reports.content import Anova, ReportContent, ThesisRoute
from reports.display import common_places
from reports.naming import levels_name, swept_factor, swept_words
from reports.numbers import SignificanceTest, t_test
from reports.tables.comparisons import ComparisonRow, difference_columns, table_of_comparisons
from reports.tables.table import (
    PROVENANCE,
    Column,
    Columns,
    Table,
    TableKind,
    count,
    interval_cell,
    number_cell,
    provenance_cell,
    statistic_cells,
    statistic_columns,
    table_of,
    tables_of_outcomes,
    text_column,
    words,
)


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
