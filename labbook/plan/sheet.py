"""The run sheet: one row a run, made from a plan with blanks that the person at the rig fills in.

Columns: run, date, position, kind, one for each factor, battery, robot, started, duration_s, jumps_made, starts and
note. There, `position` counts through the day; factors are empty for an idle run; `started` is local, `HH:MM`;
`duration_s` is power on to power off; `starts` says how often the robot was switched on until it reported its leg
right (thesis 5.1.3).
"""

from __future__ import annotations

import csv
import datetime
import io
import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from data_schema.errors import UsageError
from data_schema.vocabulary import RunKind
from labbook.plan.drawing import Plan, PlannedRun
from labbook.plan.sheet_cells import as_text

BEFORE_FACTORS = ("run", "date", "position", "kind")
AFTER_FACTORS = ("battery", "robot", "started", "duration_s", "jumps_made", "starts", "note")


@dataclass(frozen=True, slots=True)
class SheetLine:
    """A planned run with its name and date."""

    name: str
    date: datetime.date
    run: PlannedRun

    @property
    def note(self) -> str:
        """What the columns cannot say: how long an idle run hangs on the clamp."""
        if self.run.kind is not RunKind.IDLE or self.run.duration_s is None:
            return ""
        return f"planned {self.run.duration_s / 60.0:g} min"


def run_names(plan: Plan, first: int = 1) -> tuple[str, ...]:
    """Name the runs of a plan r001, r002 and so on, from the number `first`."""
    return tuple(f"r{number:03d}" for number in range(first, first + len(plan.runs)))


def sheet_lines(plan: Plan, names: Sequence[str], dates: Sequence[datetime.date]) -> Iterator[SheetLine]:
    """Put names and dates to the runs of a plan.

    `names` are one a run, `dates` one a day and in order, more than are needed do no harm. Raises `UsageError` when
    they do not fit the plan.
    """
    days = len(plan.days)
    if len(dates) < days:
        raise UsageError(f"the plan has {days} days and {len(dates)} dates were given: give one date a day.")
    if any(later <= earlier for earlier, later in itertools.pairwise(dates)):
        raise UsageError("the dates of the plan are not in order: give each date once, the earliest first.")
    if len(set(names)) < len(names) or len(names) != len(plan.runs):
        raise UsageError(f"the plan has {len(plan.runs)} runs: give each a name of its own, {len(names)} were given.")
    for name, run in zip(names, plan.runs, strict=True):
        yield SheetLine(name, dates[run.day - 1], run)


def write_run_sheet(
    plan: Plan, names: Sequence[str], dates: Sequence[datetime.date], *, battery: str = "", robot: str = ""
) -> str:
    """Write the sheet as CSV; the same plan, names and dates give the same bytes.

    `battery` and `robot` are written in every row; left empty they are blanks too.
    """
    factors = [factor.name for factor in plan.factors]
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(as_text(cell) for cell in [*BEFORE_FACTORS, *factors, *AFTER_FACTORS])
    for line in sheet_lines(plan, names, dates):
        levels = dict(line.run.condition or ())
        writer.writerow(
            as_text(cell)
            for cell in [
                *(line.name, line.date.isoformat(), line.run.position_in_day, line.run.kind.value),
                *(levels.get(factor, "") for factor in factors),
                *(battery, robot, "", "", "", "", line.note),
            ]
        )
    return stream.getvalue()
