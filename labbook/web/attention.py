"""What needs attention in the whole book or of a day, gravest first, each with the command that mends it."""

from __future__ import annotations

from itertools import groupby

from starlette.requests import Request
from starlette.responses import Response
from starlette.routing import Route

from labbook.actions.runs.attention import attention
from labbook.analysis.outcomes.detection import Detections
from labbook.config.local_time import date_named
from labbook.web.book import OpenBook
from labbook.web.rendering import page


def _page(request: Request) -> Response:
    served: OpenBook = request.app.state.book
    book = served.current()
    given = request.query_params.get("day") or None
    day = None if given is None else date_named("day", given)
    with book.reading() as connection:
        found = attention(Detections(connection, book.store), book.configuration, day=day)
        every = found if day is None else attention(Detections(connection, book.store), book.configuration)
    return page(
        request,
        "attention.html.j2",
        "attention",
        day=day,
        runs=len(found.runs),
        groups=[(str(gravity), list(of)) for gravity, of in groupby(found.findings, lambda one: one.gravity)],
        days=[(date, sum(counts.values())) for date, counts in sorted(every.by_day.items())],
    )


ROUTES = [Route("/attention", _page)]
