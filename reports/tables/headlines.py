"""The table that opens the page: what was saved and how apex height changed, a row a group, and all together."""

from __future__ import annotations

from typing import NamedTuple

from data_schema.outcomes import Outcome
from reports.display import SAVINGS, common_places
from reports.naming import control_name, levels_name, treated_levels, treatment_name
from reports.numbers import Number, Value
from reports.results import Comparison, Decision, OverallSavings, StudyResults
from reports.tables.comparisons import N_OF_SIDES, one_sided_note
from reports.tables.table import (
    Columns,
    Table,
    TableKind,
    column,
    counts,
    ids,
    interval,
    number,
    p_cell,
    table_of,
    text,
)


class _Headline(NamedTuple):
    """A row: a group, or all together (`strong`), with its runs of control and treatment."""

    name: str
    days: int
    runs: tuple[int, int]
    savings: Number | None
    savings_p: Value | None
    apex: Decision | None
    provenance: str
    strong: bool = False


def headlines(results: StudyResults) -> Table:
    """Make the table of the groups: all levels of the treatment together against the control."""
    found = groups(results)
    comparisons = [each for pair in found.values() for each in pair if each is not None]
    of_groups = [_of_group(name, *pair) for name, pair in found.items()]
    saved, heights = [row.savings for row in of_groups], [_change(row) for row in of_groups]
    saves = any(saved)  # the page has what fits a narrow one, the file both outcomes
    places, height_places = common_places(saved, 1), common_places(heights)
    columns: Columns[_Headline] = (
        text("group", "group", lambda row: row.name),
        counts("days", "days", lambda row: row.days),
        counts("n", N_OF_SIDES, lambda row: row.runs),
        number(SAVINGS, "savings_percent", "%", lambda row: row.savings, places, shown=saves),
        interval(
            saved,
            "%",
            lambda row: row.savings,
            places,
            names="savings_ci_low_percent savings_ci_high_percent savings_ci_level",
            shown=saves,
        ),
        column("p", "savings_p", lambda row: p_cell(row.savings_p), shown=saves),
        number("apex", "apex_difference_m", "m", _change, height_places, shown=not saves),
        interval(
            heights, "m", _change, height_places, names="apex_ci_low_m apex_ci_high_m apex_ci_level", shown=not saves
        ),
        column("p", "apex_p", lambda row: p_cell(None if row.apex is None else _p(row.apex)), shown=not saves),
        counts("apex n", "apex_days apex_n_control apex_n_treatment", _apex_counts, shown=False),
        ids(lambda row: row.provenance),
    )
    test = f"by the days that hold both ({results.section('Methods')})"
    what = "Energy" if saves else "Apex height"
    control, treatment = control_name(results), treatment_name(results, {})
    levels = ", all levels" if len(treated_levels(results, {})) > 1 else ""
    beside_plan = results.plan.stated and all(each.exploratory for each in comparisons)
    adjusted = next((each.decision.adjusted for each in comparisons if each.decision.adjusted is not None), None)
    holm = "" if adjusted is None else f", p of a group by Holm over {adjusted.n} tests"
    nowhere = any(not each.decision.days for each in comparisons)
    caption = (
        f"{what} of a jump with {treatment} against {control}; intervals and p {test}{holm}. "
        f"n: runs of {control} and of {treatment}{levels}, on these days"
        f"{', all where there is none' if nowhere else ''}.{' All rows are exploratory.' if beside_plan else ''}"
    )
    caption += one_sided_note([each.decision for each in comparisons])
    rows = [*of_groups, *_all_groups(results)]
    return table_of("headlines", caption, rows, columns, strong=lambda row: row.strong)


def groups(results: StudyResults) -> dict[str, tuple[Comparison | None, Comparison | None]]:
    """Return the pooled comparisons of joules and of apex height of each group, by the group's name, in one order."""
    opening = {(tuple(each.group.items()), each.quantity): each for each in results.pooled}
    keys = dict.fromkeys(group for group, _ in opening)
    return {
        levels_name(results, dict(group)) or "all runs": (
            opening.get((group, Outcome.JOULES)),
            opening.get((group, Outcome.APEX)),
        )
        for group in keys
        if (group, Outcome.JOULES) in opening or (group, Outcome.APEX) in opening
    }


def _of_group(name: str, joules: Comparison | None, apex: Comparison | None) -> _Headline:
    energy, height = (None if each is None else each.decision for each in (joules, apex))
    lead = energy or height
    assert lead is not None  # noqa: S101 - a group has one of both
    return _Headline(
        name,
        len(lead.days),
        (lead.n_control, lead.n_treatment),
        None if energy is None else energy.savings,
        None if energy is None else _p(energy),
        height,
        lead.headline.provenance,
    )


def _p(decision: Decision) -> Value:
    return decision.test.p if decision.adjusted is None else decision.adjusted.value


def _change(row: _Headline) -> Number | None:
    return None if row.apex is None else row.apex.difference


def _apex_counts(row: _Headline) -> tuple[int | None, ...]:
    return (None,) * 3 if row.apex is None else (len(row.apex.days), row.apex.n_control, row.apex.n_treatment)


def _all_groups(results: StudyResults) -> list[_Headline]:
    return [
        _Headline(
            f"mean of {len(overall.groups)} groups",
            len(overall.days),
            _runs_of_groups(results, overall),
            overall.savings,
            overall.test.p,
            None,
            overall.savings.provenance,
            strong=True,
        )
        for overall in results.overall
        if overall.quantity is Outcome.JOULES and len(overall.groups) > 1
    ]


def _runs_of_groups(results: StudyResults, overall: OverallSavings) -> tuple[int, int]:
    """Count the runs of both sides over the groups, which have none in common; of days, groups share some."""
    leads = [
        each.decision for each in results.pooled if each.quantity is overall.quantity and each.group in overall.groups
    ]
    return sum(lead.n_control for lead in leads), sum(lead.n_treatment for lead in leads)


HEADLINES = TableKind("headlines", headlines)
