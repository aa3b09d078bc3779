"""What was measured: days, counts; and where numbers and assumptions came from."""

from __future__ import annotations

from reports.content import Condition, Day, Factor, ReportContent
from reports.display import DASH, EQUALS, with_unit
from reports.flow_steps import flow_lines
from reports.naming import group_name, level_value, swept_factor, swept_words
from reports.tables.table import Cell, Column, Row, Table, TableKind, count, provenance_cell, words


def _days(content: ReportContent) -> Table:
    columns = (
        Column("day", ("day",), numeric=False),
        Column("runs", ("n_runs", "runs")),
        Column("conditions", ("conditions",), numeric=False, prose=True),
        Column("packs", ("packs",), numeric=False, prose=True),
        Column("checks made", ("checks_made",), numeric=False, prose=True),
        Column("checks not made", ("checks_not_made",), numeric=False, prose=True),
        Column("note", ("note",), numeric=False, prose=True, shown=any(day.note for day in content.days)),
    )
    rows = tuple(Row(_day_cells(content, day)) for day in content.days)
    return Table("days", "What was measured and when.", columns, rows)


def _day_cells(content: ReportContent, day: Day) -> tuple[Cell, ...]:
    conditions = "; ".join(day.conditions)
    lists = (day.packs, day.checks_made, day.checks_not_made)
    return (
        words(day.date),
        Cell(str(len(day.runs)), (len(day.runs), " ".join(day.runs))),
        Cell(_conditions_text(content, day) or conditions or DASH, (conditions,)),
        *(Cell(", ".join(names).replace("_", " ") or DASH, (", ".join(names),)) for names in lists),
        words(day.note),
    )


def _conditions_text(content: ReportContent, day: Day) -> str:
    """Sum up the conditions of a day's analysed runs: "small foot, k = 1091 N/m: CE, d = 186, 352 kg/s"."""
    swept, runs = swept_factor(content), set(day.runs)
    groups: dict[str, list[Condition]] = {}
    for condition in content.conditions:
        if any(run.run in runs for summary in condition.summaries.values() for run in summary.runs):
            groups.setdefault(group_name(content, condition), []).append(condition)
    return "; ".join(": ".join(filter(None, (name, _levels_text(swept, found)))) for name, found in groups.items())


def _levels_text(swept: Factor | None, conditions: list[Condition]) -> str:
    if swept is None:
        return ""
    names = [swept_words(swept).control_level] if any(condition.control for condition in conditions) else []
    levels = [level for c in conditions if not c.control and (level := c.level(swept.name)) is not None]
    values = [level.label if level.value is None else level_value(level) for level in levels]
    if values:
        lead = f"{swept.symbol}{EQUALS}" if swept.symbol else ""
        names.append(with_unit(f"{lead}{', '.join(values)}", swept.unit))
    return ", ".join(names)


def _flow(content: ReportContent) -> Table:
    columns = (
        Column("analysis", ("analysis",), numeric=False),
        Column("step", ("step",), numeric=False),
        Column("count", ("count",)),
        Column("left out before it", ("left_out",), numeric=False, prose=True),
    )
    rows = tuple(
        Row((words(str(quantity)), words(step.name), count(step.count), words("; ".join(step.leaving))))
        for quantity, steps in flow_lines(content.flow).items()
        for step in steps
    )
    return Table("flow", "Runs and jumps, from what was planned to what was analysed.", columns, rows)


def _assumed(content: ReportContent) -> Table:
    columns = (
        Column("parameter", ("parameter",), numeric=False, prose=True),
        Column("value", ("value",), numeric=False),
        Column("why", ("why",), numeric=False, prose=True),
        Column("varied", ("varied",), numeric=False, prose=True),
    )
    rows = tuple(
        Row((words(one.name), words(one.value), words(one.why), words(one.varied or DASH))) for one in content.assumed
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
