"""What needs attention, gravest first, each with the command that mends it; and by run, for the list of runs."""

from __future__ import annotations

from itertools import groupby

from starlette.requests import Request
from starlette.responses import JSONResponse, Response
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
            connection,
            "attention.html.j2",
            "attention",
            day=day,
            runs=len(found.runs),
            groups=[(str(gravity), list(of)) for gravity, of in groupby(found.findings, lambda one: one.gravity)],
            days=[(date, sum(counts.values())) for date, counts in sorted(every.by_day.items())],
        )


def _by_run(request: Request) -> Response:
    """Return what was found of each run that fulfils `where`, by its code."""
    book = request.app.state.book.current()
    with book.reading() as connection:
        where = request.query_params.get("where") or None
        found = attention(Detections(connection, book.store), book.configuration, where=where).findings
    runs: dict[str, list[str]] = {}
    for one in found:
        if one.run is not None and one.code not in runs.setdefault(one.run, []):
            runs[one.run].append(one.code)
    return JSONResponse(runs)


ROUTES = [Route("/attention", _page), Route("/api/attention", _by_run)]
