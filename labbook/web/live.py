"""What came in last, large enough to be read from two metres: run, joules, jumps, and what is wrong.

Also server-sent events: that the book has a new entry, so that pages look again.
"""

from __future__ import annotations

import asyncio
import json
from collections.abc import AsyncIterator
from typing import Any

from starlette.concurrency import run_in_threadpool
from starlette.requests import Request
from starlette.responses import JSONResponse, Response, StreamingResponse
from starlette.routing import Route

from data_schema import journal
from data_schema.errors import LabbookError
from data_schema.queries.files import newest_files, refused_files, runs_of_file, waiting_files
from labbook.actions.runs.rig_line import rig_lines_of_runs
from labbook.web.book import OpenBook
from labbook.web.rendering import Asked, view

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
    view("/live", lambda asked: asked.page("live.html.j2", "live")),
    view("/api/live", _live),
    Route("/api/events", _events),
]
