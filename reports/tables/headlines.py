"""The table that opens the page: what was saved and how apex height changed, a row a group, and all together."""

from __future__ import annotations

from collections.abc import Sequence

from data_schema.outcomes import Outcome
from reports import fields
from reports.content import Comparison, Decision, OverallSavings, ReportContent
from reports.display import DASH, SAVINGS, common_places
from reports.naming import control_name, levels_name, treated_levels, treatment_name
from reports.numbers import Number
from reports.tables.comparisons import one_sided_note
from reports.tables.table import (
    PROVENANCE,
    Cell,
    Column,
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
    text_column,
    words,
)


def headlines(content: ReportContent) -> Table:
    """Make the table of the groups: all levels of the treatment together against the control."""
    found = groups(content)
    saved: list[Number | None] = [None if joules is None else joules.decision.savings for joules, _ in found.values()]
    heights: list[Number | None] = [None if apex is None else apex.decision.difference for _, apex in found.values()]
    comparisons = [each for pair in found.values() for each in pair if each is not None]
    alone = not any(saved)  # the page has what fits a narrow one, the file both outcomes
    columns = (
        text_column("group", fields.GROUP),
        Column("days", fields.DAYS),
        Column("n", fields.N_OF_SIDES),
        *_columns(SAVINGS, fields.SAVINGS, saved, "%", of="savings", shown=not alone),
        *_columns("apex", fields.APEX_DIFFERENCE, heights, "m", of="apex", shown=alone),
        Column("apex n", fields.APEX_COUNTS, shown=False),
        PROVENANCE,
    )
    places = common_places(saved, 1), common_places(heights)
    rows = [_row(group, pair, places) for group, pair in found.items()]
    rows += _all_groups(content, places[0])
    test = f"by the days that hold both ({content.section('Methods')})"
    what = "Apex height" if alone else "Energy"
    control, treatment = control_name(content), treatment_name(content, {})
    levels = ", all levels" if len(treated_levels(content, {})) > 1 else ""
    beside_plan = content.planned and all(each.exploratory for each in comparisons)
    adjusted = next((each.decision.adjusted for each in comparisons if each.decision.adjusted is not None), None)
    holm = "" if adjusted is None else f", p of a group by Holm over {adjusted.n} tests"
    nowhere = any(not each.decision.days for each in comparisons)
    caption = (
        f"{what} of a jump with {treatment} against {control}; intervals and p {test}{holm}. "
        f"n: runs of {control} and of {treatment}{levels}, on these days"
        f"{', all where there is none' if nowhere else ''}.{' All rows are exploratory.' if beside_plan else ''}"
    )
    caption += one_sided_note([each.decision for each in comparisons])
    return Table("headlines", caption, columns, tuple(rows))


def _columns(
    title: str, names: fields.Fields, numbers: Sequence[Number | None], unit: str, *, of: str, shown: bool
) -> tuple[Column, Column, Column]:
    """Make the columns of an effect in a stored unit, its interval and its p."""
    return (
        in_unit(title, names, unit, shown=shown),
        interval_column(numbers, unit, of=f"{of}_", shown=shown),
        Column("p", fields.named(fields.P_OF_TEST, of=of), shown=shown),
    )


def groups(content: ReportContent) -> dict[str, tuple[Comparison | None, Comparison | None]]:
    """Return the pooled comparisons of joules and of apex height of each group, by the group's name, in one order."""
    opening = {(tuple(each.group.items()), each.quantity): each for each in content.pooled}
    keys = dict.fromkeys(group for group, _ in opening)
    return {
        levels_name(content, dict(group)) or "all runs": (
            opening.get((group, Outcome.JOULES)),
            opening.get((group, Outcome.APEX)),
        )
        for group in keys
        if (group, Outcome.JOULES) in opening or (group, Outcome.APEX) in opening
    }


_NONE = Cell("", (None, None, None))


def _row(group: str, pair: tuple[Comparison | None, Comparison | None], places: tuple[int, int]) -> Row:
    joules, apex = pair
    lead = next(each.decision for each in pair if each is not None)
    return Row(
        (
            words(group),
            count(len(lead.days)),
            count(lead.n_control, lead.n_treatment),
            *_effect(joules, None if joules is None else joules.decision.savings, places[0]),
            *_effect(apex, None if apex is None else apex.decision.difference, places[1]),
            _NONE if apex is None else _counts(apex.decision),
            provenance_cell(lead.headline.provenance),
        )
    )


def _counts(decision: Decision) -> Cell:
    return Cell("", (len(decision.days), decision.n_control, decision.n_treatment))


def _effect(comparison: Comparison | None, number: Number | None, places: int) -> tuple[Cell, Cell, Cell]:
    """Make the cells of an effect, its interval and its p."""
    if comparison is None:
        return Cell(DASH, (None,)), Cell(DASH, (None, None, None)), Cell(DASH, (None,))
    lead = comparison.decision
    interval, p = interval_cell(number, places), p_cell(lead.test.p if lead.adjusted is None else lead.adjusted.value)
    return (
        number_cell(number, places),
        interval,
        p,
    )


def _all_groups(content: ReportContent, places: int) -> list[Row]:
    none = Cell("", (None,))
    return [
        Row(
            (
                words(f"mean of {len(overall.groups)} groups"),
                count(len(overall.days)),
                _runs_of_groups(content, overall),
                number_cell(overall.savings, places),
                interval_cell(overall.savings, places),
                p_cell(overall.test.p),
                none,
                _NONE,
                none,
                _NONE,
                provenance_cell(overall.savings.provenance),
            ),
            strong=True,
        )
        for overall in content.overall
        if overall.quantity is Outcome.JOULES and len(overall.groups) > 1
    ]


def _runs_of_groups(content: ReportContent, overall: OverallSavings) -> Cell:
    """Count the runs of both sides over the groups, which have none in common; of days, groups share some."""
    leads = [
        each.decision for each in content.pooled if each.quantity is overall.quantity and each.group in overall.groups
    ]
    return count(sum(lead.n_control for lead in leads), sum(lead.n_treatment for lead in leads))


HEADLINES = TableKind("headlines", headlines)
