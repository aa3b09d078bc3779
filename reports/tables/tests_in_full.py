"""The tests behind comparisons in full, equivalence of apex heights within bounds (TOST), and analyses of variance."""

from __future__ import annotations

from dataclasses import replace

from data_schema.outcomes import Outcome
from data_schema.vocabulary import Undefined
from reports.content import Comparison, ReportContent
from reports.display import DASH, common_places, level_text, shown_unit
from reports.evidence import Equivalence
from reports.naming import levels_name, swept_factor, swept_words
from reports.remarks import FOOTNOTE
from reports.sentences import bounds_text
from reports.tables.comparisons import (
    COMPARISON,
    EXPLORATORY,
    ONE_DAY_EACH,
    exploratory_note,
    on_one_day_each,
    over_runs,
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
    interval_title,
    number_cell,
    p_cell,
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
                *over_runs(comparison.test, comparison.one_day_each),
                *over_runs(comparison.welch, comparison.one_day_each),
                interval_cell(comparison.welch_difference),
                words(comparison.one_day_each),
            ),
            block=block,
        )
        for comparison, first, block in placed(content, comparisons)
    )
    beside = ", and Brown and Forsythe's test beside F" if spread_tested else ""
    caption = (
        f"Tests of the comparisons of {quantity} on {content.counted} means: the F-test for equal variances chooses "
        f"Student's or Welch's t; Welch's stands beside it always{beside}."
    )
    return Table(name, caption, columns, rows)


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
                *over_runs(comparison.test, comparison.one_day_each),
                *over_runs(comparison.welch, comparison.one_day_each),
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
                *over_runs(anova.test, anova.one_day_each, 2),
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


_VERDICTS = {True: "shown", False: "not shown", None: DASH}


def _why_exploratory(comparison: Comparison) -> str:
    return "" if comparison.lead.equivalence is None else comparison.lead.equivalence.exploratory


def _equivalence(content: ReportContent) -> Table:
    tested = [comparison for comparison in content.comparisons if comparison.lead.equivalence is not None]
    found = [comparison.lead.equivalence for comparison in tested if comparison.lead.equivalence is not None]
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
                Cell(f"{lead.n_control}, {lead.n_treatment}", (lead.n_control, lead.n_treatment)),
                number_cell(item.estimate, places),
                on_one_day_each(interval_cell(item.estimate, places), why),
                *statistic_cells(item.at_low),
                *statistic_cells(item.at_high),
                on_one_day_each(p_cell(item.p), why),
                _verdict(item, why),
                Cell(bounds_text(item), (item.low, item.high)),
                provenance_cell(item.estimate.provenance),
                words(item.exploratory),
                words(comparison.one_day_each),
            ),
            block=block,
        )
        for comparison, first, block in placed(content, tested, _why_exploratory)
        for lead, why in [(comparison.lead, "" if comparison.decision is not None else comparison.one_day_each)]
        for item in [lead.equivalence]
        if item is not None
    )  # fmt: skip
    by = "by the days that hold both" if any(each.decision is not None for each in tested) else "by Welch"
    of_mean = " of the control's mean" if unit == "%" else ""
    caption = (
        f"Apex heights against the bounds {bounds_text(found[0])}{of_mean}: two one-sided tests {by} (TOST), p "
        f"the larger of both. Equivalence is shown where both reject, that is where the {level_text(estimates[0])} "
        f"lies within the bounds.{exploratory_note(tested, _why_exploratory)}"
    )
    return Table("equivalence", caption, columns, rows)


def _verdict(item: Equivalence, one_day_each: str) -> Cell:
    note = item.p.reason if isinstance(item.p, Undefined) else FOOTNOTE if one_day_each else ""
    return Cell(
        DASH if one_day_each else _VERDICTS[item.shown],
        (None if item.shown is None else str(item.shown).lower(),),
        note=note,
    )


EQUIVALENCE = TableKind("equivalence", _equivalence)
