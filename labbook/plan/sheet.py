"""The run sheet: one row a run, made from a plan with blanks that the person at the rig fills in.

Columns: run, date, position, kind, one for each factor, battery, robot, started, duration_s, jumps_made, starts and
note. There, `position` counts through the day; factors are empty for an idle run; `started` is local, `HH:MM`;
`duration_s` is power on to power off; `starts` says how often the robot was switched on until it reported its leg
right (thesis 5.1.3). On paper it has one page a day (landscape), with boxes wide enough for a pen.
"""

from __future__ import annotations

import csv
import datetime
import html
import io
import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby

from data_schema.errors import UsageError
from data_schema.vocabulary import RunKind
from ingest.tables.sheet import is_number_text
from labbook.plan.drawing import Plan, PlannedRun
from reports.page.policy import content_policy

BEFORE_FACTORS = ("run", "date", "position", "kind")
AFTER_FACTORS = ("battery", "robot", "started", "duration_s", "jumps_made", "starts", "note")


_FORMULA = tuple("=+-@\t\r")
"""With these a spreadsheet begins a formula."""
_TEXT = "'"


def as_text(cell: object) -> object:
    """Return a cell that no spreadsheet takes for a formula: what begins like one gets an apostrophe, not numbers."""
    if isinstance(cell, str) and cell.startswith(_FORMULA) and not is_number_text(cell):
        return _TEXT + cell
    return cell


def without_mark(cell: str) -> str:
    """Return a cell without the apostrophe that `as_text` put before it."""
    return cell[1:] if cell.startswith(_TEXT) and cell[1:].startswith(_FORMULA) else cell


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


def _sheet_lines(plan: Plan, names: Sequence[str], dates: Sequence[datetime.date]) -> Iterator[SheetLine]:
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
    for line in _sheet_lines(plan, names, dates):
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


BLANKS = {"started": "5em", "duration, s": "5em", "jumps made": "4em", "starts": "4em", "note": "16em"}
"""What is filled in by hand, and the width of its box."""

_STYLE = """\
@page { size: A4 landscape; margin: 12mm }
body { font: 11pt/1.3 system-ui, sans-serif; color: #000; background: #fff; margin: 1em }
section { break-after: page; margin-bottom: 3em }
section:last-child { break-after: auto }
h1 { font-size: 14pt; margin: 0 0 .3em }
p { margin: .2em 0 .6em }
table { border-collapse: collapse }
thead { display: table-header-group }
th, td { border: 1px solid #000; padding: .15em .5em; text-align: left; height: 1.9em; white-space: nowrap }
th { font-weight: 600; height: auto }
tr { break-inside: avoid }
tr.new-block td { border-top-width: 2.5px }
td.number { text-align: right }
span.line { display: inline-block; min-width: 7em; border-bottom: 1px solid #000 }
span.check { margin-right: 1.5em }"""


def format_run_sheet_for_print(
    plan: Plan,
    names: Sequence[str],
    dates: Sequence[datetime.date],
    *,
    study: str,
    battery: str = "",
    robot: str = "",
    jumps_nominal: int | None = None,
    checks: Sequence[str] = (),
) -> str:
    """Write the sheet as one HTML page without anything outside it; the same plan gives the same bytes.

    `names` and `dates` as for `write_run_sheet`; an empty `battery` or `robot` is a blank. Each of a day's `checks` has
    a box to tick.
    """
    jumps = "" if jumps_nominal is None else f"{jumps_nominal} jumps a run. "
    about = f"{plan.method.value} order, seed {plan.seed}. {jumps}{'Before the first run:' if checks else ''}"
    boxes = "".join(f'<span class="check">&#9633; {html.escape(check.replace("_", " "))}</span>' for check in checks)
    pages = (
        _page(list(lines), plan, study, battery, robot, about, boxes)
        for _, lines in groupby(_sheet_lines(plan, names, dates), key=lambda line: line.run.day)
    )
    title = html.escape(f"Run sheet: {study}")
    return (
        f'<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        f'<meta http-equiv="Content-Security-Policy" content="{content_policy()}">\n<title>{title}</title>\n'
        f"<style>\n{_STYLE}\n</style>\n</head>\n<body>\n{''.join(pages)}</body>\n</html>\n"
    )


def _page(lines: Sequence[SheetLine], plan: Plan, study: str, battery: str, robot: str, about: str, boxes: str) -> str:
    heading = f"{study}: day {lines[0].run.day} of {len(plan.days)}, {lines[0].date.isoformat()}"
    about = f"{len(lines)} runs, {about}"
    factors = [factor.name for factor in plan.factors]
    header = ["run", "", "kind", *factors, "min", "battery", "robot"]
    cells = "".join(f"<th>{html.escape(name)}</th>" for name in header)
    cells += "".join(f'<th style="min-width: {width}">{name}</th>' for name, width in BLANKS.items())
    rows = []
    block = lines[0].run.block
    for line in lines:
        levels = dict(line.run.condition or ())
        minutes = "" if line.run.duration_s is None else f"{line.run.duration_s / 60.0:g}"
        shown = [line.name, str(line.run.position_in_day), line.run.kind.value]
        shown += [levels.get(factor, "") for factor in factors] + [minutes, battery, robot] + [""] * len(BLANKS)
        start = '<tr class="new-block">' if line.run.block != block else "<tr>"
        sides = [(' class="number"' if text.replace(".", "", 1).isdigit() else "", html.escape(text)) for text in shown]
        rows.append(start + "".join(f"<td{number}>{text}</td>" for number, text in sides) + "</tr>\n")
        block = line.run.block
    return (
        f"<section>\n<h1>{html.escape(heading)}</h1>\n<p>{html.escape(about)} {boxes}</p>\n"
        f'<p>At the rig: <span class="line"></span></p>\n'
        f"<table>\n<thead>\n<tr>{cells}</tr>\n</thead>\n<tbody>\n{''.join(rows)}</tbody>\n</table>\n</section>\n"
    )
