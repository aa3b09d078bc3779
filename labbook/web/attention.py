"""What needs attention, gravest first, each with the command that mends it, done at a click where it is one choice.

Also what was found by run, for the list of runs.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from starlette.responses import JSONResponse, Response
from starlette.routing import Route

from data_schema.errors import UsageError
from labbook.actions.runs.attention import attention
from labbook.actions.runs.finding import Finding, Gravity
from labbook.actions.runs.mending import mend, mending
from labbook.analysis.outcomes.detection import Detections
from labbook.config.local_time import date_named
from labbook.web.book import OpenBook
from labbook.web.rendering import Asked, view
from labbook.web.stating import stating

_MOST = 100
"""So many findings of a gravity are shown."""


def _page(asked: Asked) -> Response:
    given = asked.given("day")
    day = None if given is None else date_named("day", given)
    detections, configuration = asked.detections, asked.book.configuration
    found = attention(detections, configuration, day=day)
    every = found if day is None else attention(detections, configuration)
    of = {gravity: [one for one in found.findings if one.gravity is gravity] for gravity in Gravity}
    return asked.page(
        "attention.html.j2",
        "attention",
        day=day,
        runs=len(found.runs),
        groups=[
            (
                str(gravity),
                [(one, _identity(one), None if asked.served.read_only else mending(one)) for one in several[:_MOST]],
                max(len(several) - _MOST, 0),
            )
            for gravity, several in of.items()
            if several
        ],
        days=[(date, sum(counts.values())) for date, counts in sorted(every.by_day.items())],
    )


def _identity(one: Finding) -> dict[str, str | None]:
    """Return what a finding is known by on the page and here."""
    return {"code": one.code, "run": one.run, "file": one.file, "command": one.command}


def _mend(served: OpenBook, given: Mapping[str, Any]) -> dict[str, Any]:
    """Do what the command of a finding does, where the book, looked at anew, still has that finding."""
    book, day = served.current(), given.get("day")
    date = date_named("day", str(day)) if day else None
    book.catch_up()
    with book.reading() as connection:
        found = attention(Detections(connection, book.store), book.configuration, day=date).findings
    meant = next((one for one in found if _identity(one).items() <= given.items()), None)
    if meant is None:
        raise UsageError("nothing is found any more that this mends, so nothing was stated: reload the page.")
    mend(book, served.person, meant, str(given.get("why") or ""))
    return {"mended": meant.command}


def _by_run(asked: Asked) -> Response:
    """Return what was found of each run that fulfils `where`."""
    found = attention(asked.detections, asked.book.configuration, where=asked.given("where")).findings
    runs: dict[str, list[dict[str, str]]] = {}
    for one in found:
        if one.run is not None:
            runs.setdefault(one.run, []).append({"code": one.code, "gravity": one.gravity, "what": one.what})
    return JSONResponse(runs)


ROUTES = [
    view("/attention", _page),
    view("/api/attention", _by_run),
    Route("/api/mending", stating(_mend), methods=["POST"]),
]
