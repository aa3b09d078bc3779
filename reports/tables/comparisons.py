"""Effects of treatments against their control: differences, savings, equivalence within bounds; the thesis's tests.

A comparison stands in the block of its family, under its label, with a word for what was not planned.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from typing import TypeVar

from data_schema.outcomes import Outcome
from data_schema.vocabulary import Undefined
from reports.claims import bounds_text
from reports.display import DASH, SAVINGS, common_places, level_text
from reports.naming import level_of, levels_name, swept_factor, swept_words
from reports.numbers import Number, SignificanceTest, t_test
from reports.results import Anova, Comparison, Decision, Equivalence, StudyResults, ThesisRoute
from reports.tables.table import (
    Cell,
    Column,
    Columns,
    Table,
    TableKind,
    column,
    counts,
    ids,
    interval,
    number,
    p_cell,
    statistic,
    table_of,
    tables_of_outcomes,
    text,
)

N_OF_SIDES = "n_control n_treatment"
T = TypeVar("T")


def _table(
    name: str,
    caption: str,
    results: StudyResults,
    found: Sequence[tuple[Comparison, T]],
    columns: Columns[tuple[Comparison, T]],
    why: Callable[[tuple[Comparison, T]], str] = lambda row: row[0].exploratory,
) -> Table:
    """Make a table with a row a comparison, in the block of its family, under its label.

    A family with several levels a group has a block a group; one with a single row a group is one block. `why` says
    why a comparison is exploratory.
    """

    def group(one: Comparison) -> str:
        return levels_name(results, one.group) or "all runs"

    rows_of = Counter((one.family, group(one)) for one, _shown in found)
    several = {family for (family, _group), rows in rows_of.items() if rows > 1}

    def label(row: tuple[Comparison, T]) -> Cell:
        one, own, level = row[0], group(row[0]), level_of(results, row[0])
        beside = own if level.lower() in one.family.lower() else f"{own}, {level}"
        return Cell(level if one.family in several else beside, (one.family, own, one.level))

    def block(row: tuple[Comparison, T]) -> str:
        one = row[0]
        heading = f"{one.family}: {group(one)}" if one.family in several else one.family
        return f"{heading} (exploratory)" if why(row) else heading

    return table_of(name, caption, found, (text("comparison", "family group level", label), *columns), block=block)


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


def _of_outcome(results: StudyResults, quantity: Outcome, name: str) -> Table:
    found = [(one, one.decision) for one in results.comparisons if one.quantity is quantity]
    decisions = [one for _comparison, one in found]
    differences, savings = [one.difference for one in decisions], [one.savings for one in decisions]
    saves, places, savings_places = any(savings), common_places(differences), common_places(savings, 1)
    adjusted = next((one.adjusted for one in decisions if one.adjusted is not None), None)
    columns: Columns[tuple[Comparison, Decision]] = (
        counts("days", "days", lambda row: len(row[1].days)),
        counts("n", N_OF_SIDES, lambda row: (row[1].n_control, row[1].n_treatment)),
        number("difference", "difference_{unit}", quantity.unit, lambda row: row[1].difference, places),
        interval(differences, quantity.unit, lambda row: row[1].difference, places),
        statistic("t", "t", lambda row: row[1].test_of_difference),
        column(
            "Holm",
            "holm_p holm_tests holm_provenance",
            lambda row: _adjusted_cell(row[1].adjusted),
            shown=adjusted is not None,
        ),
        number(SAVINGS, "savings_percent", "%", lambda row: row[1].savings, savings_places, shown=saves),
        interval(
            savings,
            "%",
            lambda row: row[1].savings,
            savings_places,
            names="savings_ci_low_percent savings_ci_high_percent savings_ci_level",
            shown=saves,
        ),
        text("unit", "unit", lambda row: row[1].unit, shown=False),
        ids(lambda row: row[1].headline.provenance),
        text("exploratory", "exploratory", lambda row: row[0].exploratory, shown=False),
    )
    holm = "" if adjusted is None else f" Holm: p adjusted over the {adjusted.n} tests of the family."
    reasons = reasons_note(one.exploratory for one, _decision in found)
    caption = f"Every comparison of {quantity}. {_DECIDED}{holm}{one_sided_note(decisions)}{reasons}"
    return _table(name, caption, results, found, columns)


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


def _equivalence(results: StudyResults) -> Table:
    found = [(one, tested) for one in results.comparisons if (tested := one.decision.equivalence) is not None]
    if not found:
        head = Column("comparison", ("family", "group", "level"), numeric=False)
        return Table("equivalence", "Apex heights are not tested for equivalence.", (head,), ())
    estimates = [item.estimate for _, item in found]
    unit, places = estimates[0].unit, common_places(estimates)
    columns: Columns[tuple[Comparison, Equivalence]] = (
        counts("n", N_OF_SIDES, lambda row: (row[0].decision.n_control, row[0].decision.n_treatment)),
        number("difference", "difference_{unit}", unit, lambda row: row[1].estimate, places),
        interval(estimates, unit, lambda row: row[1].estimate, places),
        statistic("t, lower", "t_low", lambda row: t_test("lower bound", row[1].t_low, row[1].p_low), shown=False),
        statistic("t, upper", "t_high", lambda row: t_test("upper bound", row[1].t_high, row[1].p_high), shown=False),
        column("p", "tost_p", lambda row: p_cell(row[1].p.value)),
        text("equivalence", "equivalent", lambda row: _verdict(row[1])),
        column(
            "bounds",
            "bound_low_{unit} bound_high_{unit}",
            lambda row: Cell(bounds_text(row[1]), (row[1].low, row[1].high)),
            unit=unit,
            shown=False,
        ),
        ids(lambda row: row[1].estimate.provenance),
        text("exploratory", "exploratory", lambda row: row[1].exploratory, shown=False),
    )
    of_mean = " of the control's mean" if unit == "%" else ""
    caption = (
        f"Apex heights against the bounds {bounds_text(found[0][1])}{of_mean}: two one-sided tests by the days that "
        f"hold both (TOST), p the larger of both. Equivalence is shown where both reject, that is where the "
        f"{level_text(estimates[0])} lies within the bounds.{reasons_note(item.exploratory for _, item in found)}"
    )
    return _table("equivalence", caption, results, found, columns, lambda row: row[1].exploratory)


def _verdict(item: Equivalence) -> Cell:
    note = item.p.value.reason if isinstance(item.p.value, Undefined) else ""
    return Cell(_VERDICTS[item.shown], (None if item.shown is None else str(item.shown).lower(),), note=note)


EQUIVALENCE = TableKind("equivalence", _equivalence)


def _f_test(route: ThesisRoute) -> SignificanceTest:
    df = (float(route.n_treatment - 1), float(route.n_control - 1))
    return SignificanceTest("F", route.f.value, df, route.f_p.value)


def _routes(
    name: str, caption: str, results: StudyResults, found: list[tuple[Comparison, ThesisRoute]], unit: str
) -> Table:
    differences = [route.difference for _comparison, route in found]
    places = common_places(differences)
    columns: Columns[tuple[Comparison, ThesisRoute]] = (
        counts("n", N_OF_SIDES, lambda row: (row[1].n_control, row[1].n_treatment)),
        statistic("F", "f", lambda row: _f_test(row[1]), 2),
        text("chosen", "test", lambda row: row[1].test),
        statistic("t", "t", lambda row: t_test(row[1].test, row[1].t, row[1].p)),
        number("difference", "difference_{unit}", unit, lambda row: row[1].difference, places),
        interval(differences, unit, lambda row: row[1].difference, places),
        ids(lambda row: row[1].difference.provenance),
    )
    return _table(name, caption, results, found, columns)


def _over_runs(results: StudyResults, quantity: Outcome, name: str) -> Table:
    found = [(each, each.over_runs) for each in results.comparisons if each.quantity is quantity]
    caption = (
        f"The thesis's route (5.2.1) to {quantity}, over all runs whatever their days: the F-test for equal variances "
        "chooses Student's or Welch's t."
    )
    return _routes(name, caption, results, found, quantity.unit)


def _over_jumps(results: StudyResults) -> Table:
    found = [(each, each.over_jumps) for each in results.comparisons if each.over_jumps is not None]
    caption = (
        "The thesis's route to apex heights over single jumps. Jumps of one run share its bed, pack and day: the true "
        "p is larger."
    )
    return _routes("tests_jumps", caption, results, found, Outcome.APEX.unit)


def _anovas(results: StudyResults) -> Table:
    columns: Columns[Anova] = (
        text("group", "group", lambda anova: levels_name(results, anova.group) or anova.label),
        counts("n", "n_runs", lambda anova: anova.n),
        statistic("F", "f", lambda anova: anova.test, 2),
        ids(lambda anova: anova.p.provenance),
    )
    swept = swept_words(swept_factor(results)).coefficient
    caption = f"One-way analysis of variance over the levels of the {swept} in each group, control left out."
    return table_of("anovas", caption, results.anovas, columns, block=lambda anova: str(anova.quantity))


TESTS = tables_of_outcomes("tests_{}", _over_runs)
"""A table an outcome."""
TESTS_JUMPS = TableKind("tests_jumps", _over_jumps)
ANOVAS = TableKind("anovas", _anovas)
