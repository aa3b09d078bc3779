"""The table of the steps from what was planned to what is analysed: how many runs and jumps, and what was left out."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from data_schema.outcomes import Outcome
from reports import fields
from reports.content import Flow, ReportContent
from reports.tables.table import Column, Columns, Table, TableKind, count, table_of, text_column, words


@dataclass(frozen=True, slots=True)
class Step:
    """A step, and what is left out on the way to it."""

    name: str
    count: int
    leaving: tuple[str, ...] = ()


def flow_lines(flow: Flow) -> dict[Outcome, tuple[Step, ...]]:
    """Return the steps of each outcome: the first begins with the plan, that of apex heights ends with jumps."""
    lines = {outcome: _run_steps(flow, outcome) for outcome in flow.runs_with}
    if flow.runs_planned is not None:
        lines[Outcome.JOULES] = (Step("runs planned", flow.runs_planned), *lines[Outcome.JOULES])
    if flow.runs_with[Outcome.APEX]:
        lines[Outcome.APEX] += _jump_steps(flow)
    return lines


def _run_steps(flow: Flow, quantity: Outcome) -> tuple[Step, ...]:
    leaving = []
    if flow.runs_void:
        leaving.append(f"{flow.runs_void} void")
    if flow.runs_idle:
        leaving.append(f"{flow.runs_idle} idle, for the passive drain")
    leaving += _reasons(flow.runs_other)
    leaving += _reasons(flow.runs_without[quantity])
    return (
        Step("runs done", flow.runs_done),
        Step(f"runs with {quantity.plural}", flow.runs_with[quantity], tuple(leaving)),
    )


def _jump_steps(flow: Flow) -> tuple[Step, ...]:
    return (
        Step("jumps made", flow.jumps_made),
        Step("stances detected", flow.jumps_detected),
        Step("jumps analysed", flow.jumps_analysed, tuple(_reasons(flow.jumps_excluded))),
    )


def _reasons(excluded: Mapping[str, int]) -> list[str]:
    return [f"{count} excluded: {reason}" for reason, count in excluded.items()]


def _flow(content: ReportContent) -> Table:
    columns: Columns[tuple[Outcome, Step]] = (
        (text_column("analysis", fields.ANALYSIS), lambda row: words(str(row[0]))),
        (text_column("step", fields.STEP), lambda row: words(row[1].name)),
        (Column("count", fields.COUNT), lambda row: count(row[1].count)),
        (text_column("left out before it", fields.LEFT_OUT, prose=True), lambda row: words("; ".join(row[1].leaving))),
    )
    steps = [(quantity, step) for quantity, steps in flow_lines(content.flow).items() for step in steps]
    return table_of("flow", "Runs and jumps, from what was planned to what was analysed.", steps, columns)


FLOW = TableKind("flow", _flow)
