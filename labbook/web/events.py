"""Server-sent events: that the book has a new entry, so that pages look again."""

from __future__ import annotations

import asyncio
import json
from collections.abc import AsyncIterator

from starlette.concurrency import run_in_threadpool
from starlette.requests import Request
from starlette.responses import Response, StreamingResponse
from starlette.routing import Route

from data_schema import journal
from data_schema.errors import LabbookError
from labbook.web.book import OpenBook

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


ROUTES = [Route("/api/events", _events)]
