"""Comparisons of treatments with their control: effects (difference, savings), and the tests behind them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import replace

from data_schema.vocabulary import Undefined
from reports.content import Comparison, ReportContent
from reports.display import DASH, common_places, decimal_text, degrees_text, level_text, shown_unit
from reports.naming import control_name, level_of, levels_name, swept_factor, swept_words, treatment_name
from reports.numbers import Number, Quantity, SignificanceTest
from reports.tables.table import (
    PROVENANCE,
    Cell,
    Column,
    Row,
    Table,
    TableKind,
    count,
    interval_cell,
    number_cell,
    p_cell,
    provenance_cell,
    unit_slug,
    words,
)

_STORED_UNITS = {Quantity.JOULES: "J", Quantity.APEX: "m"}
_LEGEND = (
    "Difference: treatment less control{rows}, with interval and p by Welch's t-test (the F-test's choice stands under "
    "Tests in full); n: runs of the control, of the treatment."
)
_COMPARISON = Column("comparison", ("family", "group", "level"), numeric=False)


def _placed(content: ReportContent, comparisons: list[Comparison]) -> list[tuple[Comparison, Cell, str]]:
    """Return each comparison with its first cell and its block.

    A family with several levels a group has a block a group; one with a single row a group is one block.
    """
    names = [levels_name(content, comparison.group) or "all runs" for comparison in comparisons]
    counts = Counter((comparison.family, name) for comparison, name in zip(comparisons, names, strict=True))
    several = {family for (family, _), number in counts.items() if number > 1}
    placed = []
    for comparison, name in zip(comparisons, names, strict=True):
        family, level = comparison.family, level_of(content, comparison)
        if family in several:
            text, block = level, ": ".join(filter(None, (family, name)))
        else:
            text = name if level.lower() in family.lower() else f"{name}, {level}"
            block = family
        placed.append((comparison, Cell(text, (family, name, comparison.level)), block))
    return placed


def _interval_title(numbers: list[Number | None]) -> str:
    return next((level_text(number) for number in numbers if number is not None), "CI")


def _effects(content: ReportContent, comparisons: list[Comparison], name: str, caption: str, unit: str) -> Table:
    differences: list[Number | None] = [comparison.welch_difference for comparison in comparisons]
    savings: list[Number | None] = [comparison.savings for comparison in comparisons]
    with_savings = any(saved is not None for saved in savings)
    places, savings_places = common_places(differences), common_places(savings, 1)
    slug, shown = unit_slug(unit), shown_unit(unit)[0]
    columns = (
        _COMPARISON,
        Column("n", ("n_control", "n_treatment")),
        Column("difference", (f"difference_{slug}",), shown),
        Column(_interval_title(differences), (f"ci_low_{slug}", f"ci_high_{slug}", "ci_level"), shown),
        Column("p", ("welch_p",)),
        Column("savings", ("savings_percent",), "%", shown=with_savings),
        Column(
            _interval_title(savings),
            ("savings_ci_low_percent", "savings_ci_high_percent", "savings_ci_level"),
            "%",
            shown=with_savings,
        ),
        PROVENANCE,
    )
    rows = tuple(
        Row(
            (
                first,
                Cell(
                    f"{comparison.n_control}, {comparison.n_treatment}",
                    (comparison.n_control, comparison.n_treatment),
                ),
                number_cell(comparison.welch_difference, places),
                interval_cell(comparison.welch_difference, places),
                p_cell(comparison.welch.p),
                number_cell(comparison.savings, savings_places),
                interval_cell(comparison.savings, savings_places),
                provenance_cell((comparison.savings or comparison.welch_difference).provenance),
            ),
            block=block,
            strong=comparison.headline,
        )
        for comparison, first, block in _placed(content, comparisons)
    )
    return Table(name, caption, columns, rows)


def _test_columns(title: str, field: str, degrees: int = 1) -> tuple[Column, Column]:
    df = (f"{field}_df",) if degrees == 1 else tuple(f"{field}_df_{index + 1}" for index in range(degrees))
    return Column(f"{title} (df)", (f"{field}_statistic", *df)), Column("p", (f"{field}_p",))


def _test_cells(test: SignificanceTest | None, degrees: int = 1) -> tuple[Cell, Cell]:
    if test is None:
        return Cell(DASH, (None,) * (1 + degrees)), Cell(DASH, (None,))
    df = (*test.df, *(None,) * degrees)[:degrees]
    if isinstance(test.statistic, Undefined):
        return Cell(DASH, (test.statistic, *df), note=test.statistic.reason), p_cell(test.p)
    text = f"{decimal_text(test.statistic, 2)} ({degrees_text(test.df)})"
    return Cell(text, (test.statistic, *df)), p_cell(test.p)


def _tests(content: ReportContent, quantity: Quantity, name: str) -> Table:
    comparisons = [c for c in content.comparisons if c.quantity is quantity]
    slug = unit_slug(_STORED_UNITS[quantity])
    brown_forsythe = _test_columns("Brown-Forsythe F", "brown_forsythe", 2)
    spread_tested = any(comparison.brown_forsythe is not None for comparison in comparisons)
    columns = (
        _COMPARISON,
        *_test_columns("F", "f", 2),
        *(replace(column, shown=spread_tested) for column in brown_forsythe),
        Column("chosen", ("test",), numeric=False),
        *_test_columns("t", "t"),
        *_test_columns("Welch t", "welch"),
        Column("Welch CI", (f"welch_ci_low_{slug}", f"welch_ci_high_{slug}", "welch_ci_level"), shown=False),
    )
    rows = tuple(
        Row(
            (
                first,
                *_test_cells(comparison.variance_test, 2),
                *_test_cells(comparison.brown_forsythe, 2),
                words(comparison.test.name),
                *_test_cells(comparison.test),
                *_test_cells(comparison.welch),
                interval_cell(comparison.welch_difference),
            ),
            block=block,
            strong=comparison.headline,
        )
        for comparison, first, block in _placed(content, comparisons)
    )
    beside = ", and Brown and Forsythe's test beside F" if spread_tested else ""
    caption = (
        f"Tests of the comparisons of {quantity} on run means: the F-test for equal variances chooses Student's or "
        f"Welch's t; Welch's stands beside it always{beside}."
    )
    return Table(name, caption, columns, rows)


def _jump_tests(content: ReportContent) -> Table:
    columns = (
        _COMPARISON,
        Column("jumps", ("n_control", "n_treatment")),
        *_test_columns("F", "f", 2),
        Column("chosen", ("test",), numeric=False),
        *_test_columns("t", "t"),
        *_test_columns("Welch t", "welch"),
    )
    rows = tuple(
        Row(
            (
                first,
                Cell(f"{count(comparison.n_control).text}, {count(comparison.n_treatment).text}",
                     (comparison.n_control, comparison.n_treatment)),
                *_test_cells(comparison.variance_test, 2),
                words(comparison.test.name),
                *_test_cells(comparison.test),
                *_test_cells(comparison.welch),
            ),
            block=block,
        )
        for comparison, first, block in _placed(content, list(content.jump_comparisons))
    )  # fmt: skip
    caption = (
        "Apex heights by the thesis's route, the same tests over single jumps. It takes all jumps as independent, "
        "while jumps of one run share its bed, pack and day: the true p is larger. No claim rests on this table."
    )
    return Table("tests_jumps", caption, columns, rows)


def _anovas(content: ReportContent) -> Table:
    columns = (
        Column("group", ("group",), numeric=False),
        Column("n", ("n_runs",)),
        *_test_columns("F", "f", 2),
        PROVENANCE,
    )
    rows = tuple(
        Row(
            (
                words(levels_name(content, anova.group) or anova.label),
                count(anova.n),
                *_test_cells(anova.test, 2),
                provenance_cell(anova.provenance),
            ),
            block=anova.quantity,
        )
        for anova in content.anovas
    )
    swept = swept_words(swept_factor(content)).coefficient
    caption = f"One-way analysis of variance over the levels of the {swept} in each group, control left out."
    return Table("anovas", caption, columns, rows)


def headlines(content: ReportContent) -> Table:
    """Make the table that opens the page: energy under all treated levels together against the control."""
    chosen = [c for c in content.comparisons if c.opens and c.quantity is Quantity.JOULES]
    treatment = treatment_name(content, {})
    caption = f"Energy of a jump with {treatment} against {control_name(content)}. {_LEGEND.format(rows='')}"
    table = _effects(content, chosen, "headlines", caption, "J")
    return replace(table, rows=tuple(replace(row, strong=False) for row in table.rows))


def _effects_of(quantity: Quantity, name: str) -> Callable[[ReportContent], Table]:
    def make(content: ReportContent) -> Table:
        chosen = [comparison for comparison in content.comparisons if comparison.quantity is quantity]
        others = any(comparison.savings is None for comparison in chosen) and quantity is Quantity.JOULES
        rows = ", or what the row says" if others else ""
        caption = f"Every comparison of {quantity}. {_LEGEND.format(rows=rows)}"
        return _effects(content, chosen, name, caption, _STORED_UNITS[quantity])

    return make


def _tests_of(quantity: Quantity, name: str) -> Callable[[ReportContent], Table]:
    return lambda content: _tests(content, quantity, name)


HEADLINES = TableKind("headlines", headlines)
COMPARISONS_JOULES = TableKind("comparisons_joules", _effects_of(Quantity.JOULES, "comparisons_joules"))
COMPARISONS_APEX = TableKind("comparisons_apex", _effects_of(Quantity.APEX, "comparisons_apex"))
TESTS_JOULES = TableKind("tests_joules", _tests_of(Quantity.JOULES, "tests_joules"))
TESTS_APEX = TableKind("tests_apex", _tests_of(Quantity.APEX, "tests_apex"))
TESTS_JUMPS = TableKind("tests_jumps", _jump_tests)
ANOVAS = TableKind("anovas", _anovas)
