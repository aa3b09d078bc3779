"""The table of each run: when it was made, what it gave, and its jumps."""

from __future__ import annotations

from data_schema.outcomes import Outcome
from reports.content import Condition, ReportContent, RunValue
from reports.display import DASH, general_text, shown_unit
from reports.run_points import run_anchors, run_days
from reports.tables.conditions import by_group, factor_cells, factor_columns
from reports.tables.table import Cell, Column, Row, Table, TableKind, words


def each_run(content: ReportContent) -> Table:
    """Make the table of each run, in the order of conditions."""
    outcomes = content.outcomes
    columns = (
        Column("run", ("run",), numeric=False),
        Column("day", ("day",), numeric=False),
        *factor_columns(content),
        *(Column(one.heading, (f"{one.key}_{one.unit}",), shown_unit(one.unit)[0]) for one in outcomes),
        Column("jumps", ("jumps_analysed", "lowest_m", "highest_m"), numeric=False),
    )
    heights = [height for condition in content.conditions for run in _runs(condition) for height in run[1].jumps_m]
    span = (min(heights), max(heights)) if heights else (0.0, 0.0)
    days, anchors = run_days(content), run_anchors(content)
    rows = []
    for block, condition in by_group(content):
        levels = factor_cells(content, condition)
        found: dict[str, dict[Outcome, RunValue]] = {}
        for outcome, run in _runs(condition):
            found.setdefault(run.run, {})[outcome] = run
        rows += [
            Row(
                (
                    words(name),
                    words(days.get(name, DASH)),
                    *levels,
                    *(_value(values.get(outcome), outcome) for outcome in outcomes),
                    _jumps(next((run.jumps_m for run in values.values() if run.jumps_m), ()), span),
                ),
                block=block,
                anchor=anchors.get(name, ""),
            )
            for name, values in found.items()
        ]
    caption = (
        "Each run and its analysed jumps, lowest to highest apex of all runs from left to right. "
        "labbook plot RUN --out RUN.html draws its trace."
    )
    return Table("each_run", caption, columns, tuple(rows))


def _runs(condition: Condition) -> list[tuple[Outcome, RunValue]]:
    return [(outcome, run) for outcome, summary in condition.summaries.items() for run in summary.runs]


def _value(run: RunValue | None, outcome: Outcome) -> Cell:
    if run is None:
        return Cell(DASH, (None,))
    return Cell(general_text(run.value * shown_unit(outcome.unit)[1]), (run.value,))


def _jumps(heights_m: tuple[float, ...], span: tuple[float, float]) -> Cell:
    if not heights_m:
        return Cell(DASH, (None, None, None))
    low, high = min(heights_m), max(heights_m)
    unit, factor = shown_unit("m")
    text = f"{len(heights_m)}, {general_text(low * factor)} to {general_text(high * factor)} {unit}"
    width = (span[1] - span[0]) or 1.0
    marks = tuple((height - span[0]) / width for height in heights_m)
    return Cell(text, (len(heights_m), low, high), marks=marks)


EACH_RUN = TableKind("each_run", each_run)
