"""The table of each run: when it was made, what it gave, and its jumps."""

from __future__ import annotations

import shlex

from data_schema.outcomes import Outcome
from reports.content import Condition, ReportContent, RunValue
from reports.display import DASH, decimal_text, general_text, shown_unit
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
    heights: dict[str, list[float]] = {}
    for block, condition in by_group(content):
        heights.setdefault(block, []).extend(height for _, run in _runs(condition) for height in run.jumps_m)
    spans = {block: (min(of_group), max(of_group)) for block, of_group in heights.items() if of_group}
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
                    *(_value(values.get(outcome), outcome, shown=bool(anchors)) for outcome in outcomes),
                    _jumps(
                        next((run for run in values.values() if run.jumps_m), RunValue(name, 0.0)),
                        spans.get(block, (0.0, 0.0)),
                    ),
                ),
                block=block,
                anchor=anchors.get(name, ""),
            )
            for name, values in found.items()
        ]
    caption = (
        "Each run and its analysed jumps in turn, drawn from the lowest to the highest apex of its group. Unfolded: "
        "each jump's number and apex (mm), and the command that draws the run's trace."
    )
    return Table("each_run", caption, columns, tuple(rows))


def _runs(condition: Condition) -> list[tuple[Outcome, RunValue]]:
    return [(outcome, run) for outcome, summary in condition.summaries.items() for run in summary.runs]


def _value(run: RunValue | None, outcome: Outcome, *, shown: bool) -> Cell:
    """Return a run's value; of more runs than a page shows (`run_anchors`) as it stands in CSV alone."""
    if run is None:
        return Cell(DASH, (None,))
    return Cell(general_text(run.value * shown_unit(outcome.unit)[1]) if shown else "", (run.value,))


def _jumps(run: RunValue, span: tuple[float, float]) -> Cell:
    if not run.jumps_m:
        return Cell(DASH, (None, None, None))
    low, high = min(run.jumps_m), max(run.jumps_m)
    unit, factor = shown_unit("m")
    text = f"{len(run.jumps_m)}, {general_text(low * factor)} to {general_text(high * factor)} {unit}"
    width = (span[1] - span[0]) or 1.0
    marks = tuple((height - span[0]) / width for height in run.jumps_m)
    numbers = run.jumps or range(1, len(run.jumps_m) + 1)
    each = (f"{n}: {decimal_text(height * factor, 1)}" for n, height in zip(numbers, run.jumps_m, strict=True))
    name = shlex.quote(run.run)
    details = (", ".join(each), f"labbook plot {name} --out {shlex.quote(f'{run.run}.html')}")
    return Cell(text, (len(run.jumps_m), low, high), marks=marks, details=details)


EACH_RUN = TableKind("each_run", each_run, by_run=True)
