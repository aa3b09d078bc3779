"""What needs attention, gravest first, each with the command that mends it, done at a click where it is one choice.

Also what was found by run, for the list of runs.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from starlette.responses import JSONResponse, Response

from data_schema.errors import UsageError
from labbook.actions.runs.attention import Blank, Finding, Gravity, attention
from labbook.analysis.outcomes.detection import Detections
from labbook.book.opening import Book
from labbook.config.local_time import date_named
from labbook.web.book import OpenBook
from labbook.web.commands import command
from labbook.web.rendering import Asked, stating, view

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


def mending(found: Finding) -> str | None:
    """Return what a button says; None where the command shows something, or a person fills it in or looks first."""
    if not {*found.fill_in} <= {Blank.WHY}:
        return None
    match ["".join(word) for word in found.words]:
        case ["assign", _, "none", *_]:
            return "Take it off the run"
        case ["assign", _, run, *_]:
            return f"Assign to {run}"
        case ["check", *_]:
            return "It was made and passed"
        case ["correct", *_]:
            return "Correct"
        case ["files", "reread", *_]:
            return "Read again"
        case ["files", "withdraw", *_]:
            return "Withdraw"
        case ["jumps", "clear", *_]:
            return "Take back"
        case ["runs", "dismiss", *_]:
            return "Dismiss"
    return None


def mend(book: Book, person: str, found: Finding, why: str) -> None:
    """Give the command of a finding as `person`; raises what it says, and `UsageError` where it has no button."""
    if mending(found) is None:
        raise UsageError(f"`{found.command}` is for a person to give: copy it, and fill in what stands in capitals.")
    if found.fill_in and not why.strip():
        raise UsageError("the reason is empty: say why in a few words, the journal keeps them.")
    words = [why if word is Blank.WHY else "".join(word) for word in found.words]
    command(book, *words, "--as", person)


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
    stating("/api/mending", _mend),
]
