"""The run sheet on paper: one page a day (landscape), with boxes wide enough for a pen."""

from __future__ import annotations

import datetime
import html
from collections.abc import Iterable, Sequence
from itertools import groupby

from data_schema.vocabulary import CheckKind
from labbook.plan.drawing import Plan
from labbook.plan.sheet import SheetLine, sheet_lines

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
) -> str:
    """Write the sheet as one HTML page without anything outside it; the same plan gives the same bytes.

    `names` and `dates` as for `write_run_sheet`; an empty `battery` or `robot` is a blank.
    """
    pages = (
        _page(list(lines), plan, study, battery, robot, jumps_nominal)
        for _, lines in groupby(sheet_lines(plan, names, dates), key=lambda line: line.run.day)
    )
    title = html.escape(f"Run sheet: {study}")
    return (
        f'<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n<title>{title}</title>\n'
        f"<style>\n{_STYLE}\n</style>\n</head>\n<body>\n{''.join(pages)}</body>\n</html>\n"
    )


def _page(
    lines: Sequence[SheetLine], plan: Plan, study: str, battery: str, robot: str, jumps_nominal: int | None
) -> str:
    day = lines[0].run.day
    heading = f"{study}: day {day} of {len(plan.days)}, {lines[0].date.isoformat()}"
    jumps = "" if jumps_nominal is None else f"{jumps_nominal} jumps a run. "
    about = f"{len(lines)} runs, {plan.method.value} order, seed {plan.seed}. {jumps}Before the first run:"
    checks = "".join(
        f'<span class="check">&#9633; {html.escape(kind.value.replace("_", " "))}</span>' for kind in CheckKind
    )
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
        rows.append(start + _cells(shown) + "</tr>\n")
        block = line.run.block
    return (
        f"<section>\n<h1>{html.escape(heading)}</h1>\n<p>{html.escape(about)} {checks}</p>\n"
        f'<p>At the rig: <span class="line"></span></p>\n'
        f"<table>\n<thead>\n<tr>{cells}</tr>\n</thead>\n<tbody>\n{''.join(rows)}</tbody>\n</table>\n</section>\n"
    )


def _cells(shown: Iterable[str]) -> str:
    return "".join(
        f'<td class="number">{html.escape(text)}</td>'
        if text.replace(".", "", 1).isdigit()
        else f"<td>{html.escape(text)}</td>"
        for text in shown
    )
