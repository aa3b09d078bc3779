"""What was measured: days, counts; and where numbers and assumptions came from."""

from __future__ import annotations

from reports.content import Day, ReportContent
from reports.flow_steps import jump_steps, run_steps
from reports.tables.table import Cell, Column, Row, Table, TableKind, count, provenance_cell, words


def _days(content: ReportContent) -> Table:
    columns = (
        Column("day", ("day",), numeric=False),
        Column("runs", ("n_runs", "runs")),
        Column("conditions", ("conditions",), numeric=False, prose=True),
        Column("packs", ("packs",), numeric=False),
        Column("checks made", ("checks_made",), numeric=False, prose=True),
        Column("checks not made", ("checks_not_made",), numeric=False, prose=True),
        Column("note", ("note",), numeric=False, prose=True, shown=any(day.note for day in content.days)),
    )
    rows = tuple(Row(_day_cells(day)) for day in content.days)
    return Table("days", "What was measured and when.", columns, rows)


def _day_cells(day: Day) -> tuple[Cell, ...]:
    lists = (("; ", day.conditions), (", ", day.packs), (", ", day.checks_made), (", ", day.checks_not_made))
    return (
        words(day.date),
        Cell(str(len(day.runs)), (len(day.runs), " ".join(day.runs))),
        *(Cell(between.join(names) or "\u2013", (between.join(names),)) for between, names in lists),
        words(day.note),
    )


def _flow(content: ReportContent) -> Table:
    columns = (
        Column("step", ("step",), numeric=False),
        Column("count", ("count",)),
        Column("left out before it", ("left_out",), numeric=False, prose=True),
    )
    steps = (*run_steps(content.flow), *jump_steps(content.flow))
    rows = tuple(Row((words(step.name), count(step.count), words("; ".join(step.leaving)))) for step in steps)
    return Table("flow", "Runs and jumps, from what was planned to what was analysed.", columns, rows)


def _assumed(content: ReportContent) -> Table:
    columns = (
        Column("parameter", ("parameter",), numeric=False, prose=True),
        Column("value", ("value",), numeric=False),
        Column("why", ("why",), numeric=False, prose=True),
        Column("varied", ("varied",), numeric=False, prose=True),
    )
    rows = tuple(
        Row((words(one.name), words(one.value), words(one.why), words(one.varied or "\u2013")))
        for one in content.assumed
    )
    return Table("assumed", "Parameters without a source.", columns, rows)


def _provenance(content: ReportContent) -> Table:
    columns = (
        Column("id", ("id",), numeric=False),
        Column("number", ("what",), numeric=False, prose=True),
        Column("inputs", ("n_inputs",)),
    )
    rows = tuple(
        Row((provenance_cell(source.id), words(source.what), count(source.inputs))) for source in content.provenance
    )
    caption = "Where each number came from; `labbook why ID` follows it down to the files."
    return Table("provenance", caption, columns, rows)


DAYS = TableKind("days", _days)
FLOW = TableKind("flow", _flow)
ASSUMED = TableKind("assumed", _assumed)
PROVENANCE_IDS = TableKind("provenance", _provenance)
