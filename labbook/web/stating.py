"""Answers to requests that state something: JSON from the page, and never where it is opened for reading only."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from starlette.concurrency import run_in_threadpool
from starlette.requests import Request
from starlette.responses import JSONResponse, Response

from data_schema.errors import BookReadOnly, UsageError
from labbook.web.book import OpenBook


def stating(state: Callable[[OpenBook, Mapping[str, Any]], dict[str, Any]]) -> Callable[[Request], Any]:
    """Return the answer to a request that states something."""

    async def answer(request: Request) -> Response:
        book: OpenBook = request.app.state.book
        if book.read_only:
            raise BookReadOnly("the page was opened with --read-only: nothing is stated.")
        try:
            given = await request.json()
        except ValueError:
            given = None
        if not isinstance(given, dict):
            raise UsageError("this states nothing: give a JSON object, as the page does.")
        return JSONResponse(await run_in_threadpool(state, book, given))

    return answer
