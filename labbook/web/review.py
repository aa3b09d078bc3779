"""Jumps one at a time, judged by keyboard: the queue, and verdicts that are stated, read back, and only then shown."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from starlette.concurrency import run_in_threadpool
from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.routing import Route

from data_schema.errors import BookReadOnly, UsageError
from data_schema.vocabulary import ReasonCode, ReviewOrder, Verdict
from labbook.actions.runs.jump_review import RunReview, add, decide, move, review
from labbook.actions.runs.review_queue import review_queue
from labbook.analysis.outcomes.detection import Detections
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
_SEED = 1
"""Of a shuffled order for which none is given."""


def _page(request: Request) -> Response:
    reasons = [
        {"key": key, "reason": str(reason), "text": str(reason).replace("_", " ")} for key, reason in _REASONS.items()
    ]
    order, run = request.query_params.get("order", ReviewOrder.DOUBT), request.query_params.get("run", "")
    return page(request, "review.html.j2", "review", reasons=reasons, order=order, orders=list(ReviewOrder), run=run)


def _queue(request: Request) -> Response:
    """Return the jumps in the order asked for: run, number, why it is doubtful, and whether a verdict stands."""
    book, given = request.app.state.book.current(), request.query_params
    run = given.get("run")
    try:
        order = ReviewOrder.RUN if run else ReviewOrder(given.get("order") or ReviewOrder.DOUBT)
        seed = int(given.get("seed") or _SEED) if order is ReviewOrder.SHUFFLED else None
    except ValueError as error:
        raise UsageError(f"{error}: the order is one of {', '.join(ReviewOrder)}, a seed is a whole number.") from None
    with book.reading() as connection:
        found = review_queue(
            Detections(connection, book.store), book.configuration, order, seed, given.get("where") or None
        )
    jumps = [
        {
            "run": one.run,
            "number": one.number,
            "doubts": [reason.words for reason in one.reasons],
            "decided": one.decision is not None,
        }
        for one in found.jumps
        if run in (None, one.run)
    ]
    return JSONResponse({"jumps": jumps})


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
    current, note, blind = book.current(), given.get("note"), given.get("blind") is True
    with current.reading() as connection:
        found = review(current, connection, name)
    with current.session(book.person) as session:
        decide(current, session, name, numbers, verdict, reason, str(note) if note else None, found, blind=blind)
    with current.reading() as connection:
        found = review(current, connection, name)
    return {"jumps": [_state(found, number) for number in numbers]}


def _put(book: OpenBook, given: dict[str, Any]) -> dict[str, Any]:
    """State where the apex of a jump is, or that there is one that the detector missed; returns its number."""
    try:
        name, at_s, number = str(given["run"]), float(given["at_s"]), given.get("number")
        moved = None if number is None else int(number)
    except (KeyError, TypeError, ValueError) as error:
        raise UsageError(f"this is no place of an apex ({error}): give run, at_s, and number to move one.") from error
    current, blind = book.current(), given.get("blind") is True
    with current.reading() as connection:
        found = review(current, connection, name)
    with current.session(book.person) as session:
        if moved is None:
            item, _stated = add(current, session, name, at_s, ReasonCode.OTHER, None, found, blind=blind)
        else:
            item, _stated = move(current, session, name, moved, at_s, ReasonCode.WRONG_APEX, None, found, blind=blind)
    return {"run": name, "number": item.jump.number}


def _stating(state: Callable[[OpenBook, dict[str, Any]], dict[str, Any]]) -> Callable[[Request], Any]:
    """Return the answer to a request that states something."""

    async def answer(request: Request) -> Response:
        book: OpenBook = request.app.state.book
        if book.read_only:
            raise BookReadOnly("the page was opened with --read-only: nothing is stated.")
        given = await request.json()
        if not isinstance(given, dict):
            raise UsageError("this states nothing: give an object with run and verdict.")
        return JSONResponse(await run_in_threadpool(state, book, given))

    return answer


ROUTES = [
    Route("/review", _page),
    Route("/api/queue", _queue),
    Route("/api/verdicts", _stating(_decide), methods=["POST"]),
    Route("/api/apexes", _stating(_put), methods=["POST"]),
]
