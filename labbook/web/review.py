"""Jumps one at a time, judged by keyboard: the queue, and verdicts that are stated, read back, and only then shown."""

from __future__ import annotations

from typing import Any

from starlette.concurrency import run_in_threadpool
from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.routing import Route

from data_schema.errors import BookReadOnly, UsageError
from data_schema.vocabulary import ReasonCode, Verdict
from labbook.actions.runs.jump_review import RunReview, decide, review
from labbook.actions.runs.overview import overview
from labbook.terminal import plain
from labbook.web.book import OpenBook
from labbook.web.rendering import page

_REASONS = {
    "d": ReasonCode.DROPPED_PACKET,
    "w": ReasonCode.WRONG_APEX,
    "t": ReasonCode.TOUCHED_BY_HAND,
    "m": ReasonCode.MISFIRE,
    "s": ReasonCode.SENSOR_FAULT,
    "o": ReasonCode.OTHER,
}
"""The key of each reason to reject a jump."""


def _page(request: Request) -> Response:
    reasons = [
        {"key": key, "reason": str(reason), "text": str(reason).replace("_", " ")} for key, reason in _REASONS.items()
    ]
    return page(request, "review.html.j2", "review", reasons=reasons)


def _queue(request: Request) -> Response:
    """Return the runs with jumps in their order, and how many jumps these have, and how many a person has judged."""
    book, where = request.app.state.book.current(), request.query_params.get("where") or None
    with book.reading() as connection:
        every = overview(connection, book.store, book.configuration, where)
    runs = [one for one in every if one.detected]
    return JSONResponse(
        {
            "runs": [one.name for one in runs],
            "jumps": sum(one.detected or 0 for one in runs),
            "reviewed": sum(one.reviewed or 0 for one in runs),
        }
    )


def _state(found: RunReview, number: int) -> dict[str, Any]:
    """Return how a jump stands: whether it counts, and the verdict on it."""
    item = next(item for item in found.jumps if item.jump.number == number)
    return {
        "run": found.run.name,
        "number": number,
        "excluded": item.excluded or "",
        "decided": None if item.decision is None else plain(item.decision),
    }


def _decide(book: OpenBook, given: dict[str, Any]) -> dict[str, Any]:
    """State a verdict on jumps of a run, and return how they stand when read again."""
    try:
        name, numbers = str(given["run"]), [int(number) for number in given["numbers"]]
        verdict, reason = Verdict(given["verdict"]), str(given["reason"])
    except (KeyError, TypeError, ValueError) as error:
        raise UsageError(f"this is no verdict ({error}): give run, numbers, verdict and reason.") from error
    if book.read_only:
        raise BookReadOnly("the page was opened with --read-only: nothing is stated.")
    current, note = book.current(), given.get("note")
    with current.reading() as connection:
        found = review(current, connection, name)
    with current.session(book.person) as session:
        decide(current, session, name, numbers, verdict, reason, str(note) if note else None, found)
    with current.reading() as connection:
        found = review(current, connection, name)
    return {"jumps": [_state(found, number) for number in numbers]}


async def _verdict(request: Request) -> Response:
    return JSONResponse(await run_in_threadpool(_decide, request.app.state.book, await request.json()))


ROUTES = [
    Route("/review", _page),
    Route("/api/queue", _queue),
    Route("/api/verdicts", _verdict, methods=["POST"]),
]
