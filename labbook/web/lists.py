"""What is looked through: all runs with the plan's progress, two runs beside each other, files, the journal.

What came in last, large enough to be read from two metres: run, joules, jumps, and what is wrong. Also server-sent
events: that the book has a new entry, so that pages look again.
"""

from __future__ import annotations

import asyncio
import json
from collections.abc import AsyncIterator
from typing import Any

import msgspec
from starlette.concurrency import run_in_threadpool
from starlette.requests import Request
from starlette.responses import JSONResponse, Response, StreamingResponse
from starlette.routing import Route

from data_schema import journal
from data_schema.errors import LabbookError, UsageError
from data_schema.queries.files import newest_files, refused_files, runs_of_file, waiting_files
from data_schema.queries.study import planned_runs
from labbook.actions.files.stored_files import list_files, show_file, show_lines
from labbook.actions.runs.rig_line import rig_lines_of_runs
from labbook.actions.runs.run_view import compare_runs, difference_rows, overview, run_view
from labbook.actions.upkeep.journal_view import newest_commands
from labbook.web.rendering import Asked, OpenBook, view

_MOST_COMMANDS, _MOST_FILES, _MOST_REFUSED = 100, 200, 12


def _runs(asked: Asked) -> Response:
    """Return all runs, which the page sorts and filters."""
    configuration, connection = asked.book.configuration, asked.connection
    planned, newest = planned_runs(connection), newest_files(connection, 1)
    found = {
        "runs": overview(connection, asked.book.store, configuration, asked.given("where")),
        "factors": [
            {"name": name, "title": factor.title or name, "levels": [level.label for level in factor.levels]}
            for name, factor in configuration.factors.items()
        ],
        "last_in": {"name": newest[0].name, "at": asked.local(newest[0].at_utc)} if newest else None,
        "planned": len(planned),
        "planned_made": sum(row.run_name is not None for row in planned),
    }
    return Response(msgspec.json.encode(found), media_type="application/json")


def _two_runs(asked: Asked) -> Response:
    names = [(asked.given(which) or "").strip() for which in ("first", "second")]
    if not all(names):
        raise UsageError("two runs are compared: give the names of both.")
    first, second = (run_view(asked.detections, asked.book.configuration, name) for name in names)
    found = compare_runs(first, second)
    return asked.page(
        "run_diff.html.j2",
        "runs",
        first=found.first,
        second=found.second,
        rows=difference_rows(found, first.time_zone),
        both=all(isinstance(one.jumps_found, int) for one in (first, second)),
    )


def _files(asked: Asked) -> Response:
    number = asked.number("page") or 1
    every = list_files(asked.connection)[::-1]
    refused = refused_files(asked.connection, _MOST_REFUSED) if number == 1 else []
    shown = every[_MOST_FILES * (number - 1) : _MOST_FILES * number]
    return asked.page(
        "files.html.j2",
        "files",
        files=[(one, asked.local(one.reading.at_utc)) for one in shown],
        refused=[(one, asked.local(one.at_utc)) for one in refused],
        count=len(every),
        number=number,
        more=len(every) > _MOST_FILES * number,
    )


def _file(asked: Asked) -> Response:
    found = show_file(asked.connection, asked.path("uid"))
    lines = [line.removeprefix("  ") for line in show_lines(found)[1:]]
    return asked.page("file.html.j2", "files", file=found, lines=lines)


def _journal(asked: Asked) -> Response:
    found = newest_commands(asked.connection, _MOST_COMMANDS, asked.number("before"))
    older = found[-1].first if found and found[-1].first > 1 else None
    commands = [(one, asked.local(one.at_utc)) for one in found]
    return asked.page("journal.html.j2", "journal", commands=commands, older=older)


_MOST = 12


def _live(asked: Asked) -> Response:
    """Return the newest files with the line on each of their runs; of the first, whether all is well."""
    connection = asked.connection
    waiting = {file.file_uid: file.why.reason for file in waiting_files(connection)}
    found: list[dict[str, Any]] = [
        {"name": file.name, "role": file.role, "at_utc": file.at_utc, "runs": runs_of_file(connection, file.sha256),
         "wrong": waiting.get(file.uid, "")}
        for file in newest_files(connection, _MOST)
    ]  # fmt: skip
    found += [
        {"name": file.name, "role": "refused", "at_utc": file.at_utc, "runs": (), "wrong": file.why}
        for file in refused_files(connection, _MOST)
    ]
    found = sorted(found, key=lambda file: file["at_utc"], reverse=True)[:_MOST]
    newest = [name for file in found[:1] for name in file["runs"][:_MOST]]
    lines = rig_lines_of_runs(asked.book, newest, jumps=True)
    return JSONResponse(
        {
            "files": [{**file, "at": asked.local(file["at_utc"])} for file in found],
            "lines": [{"text": line.text, "concern": line.concern} for line in lines],
        }
    )


_LOOK_EVERY_S = 0.3


def _entries(book: OpenBook) -> int:
    """Return the number of the book's last entry."""
    with book.current().reading() as connection:
        return journal.head(connection)[0]


async def _events(request: Request) -> Response:
    book: OpenBook = request.app.state.book

    async def told() -> AsyncIterator[str]:
        last = -1
        while not (request.app.state.ending() or await request.is_disconnected()):
            try:
                now = await run_in_threadpool(_entries, book)
            except LabbookError:  # busy, or being replaced: the next look tells
                now = last
            if now != last:
                last = now
                yield f"data: {json.dumps({'entries': now})}\n\n"
            await asyncio.sleep(_LOOK_EVERY_S)

    return StreamingResponse(told(), media_type="text/event-stream")


ROUTES = [
    view("/", lambda asked: asked.page("overview.html.j2", "runs")),
    view("/api/runs", _runs),
    view("/diff", _two_runs),
    view("/files", _files),
    view("/files/{uid}", _file),
    view("/journal", _journal),
    view("/live", lambda asked: asked.page("live.html.j2", "live")),
    view("/api/live", _live),
    Route("/api/events", _events),
]
