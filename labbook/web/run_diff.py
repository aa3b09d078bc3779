"""Two runs beside each other: what differs between them, and their body heights one over the other."""

from __future__ import annotations

from starlette.requests import Request
from starlette.responses import Response
from starlette.routing import Route

from data_schema.errors import UsageError
from labbook.actions.runs.run_diff import compare_runs, difference_rows
from labbook.actions.runs.run_view import run_view
from labbook.analysis.outcomes.detection import Detections
from labbook.web.rendering import page


def _page(request: Request) -> Response:
    book = request.app.state.book.current()
    names = [request.query_params.get(which, "").strip() for which in ("first", "second")]
    if not all(names):
        raise UsageError("two runs are compared: give the names of both.")
    with book.reading() as connection:
        detections = Detections(connection, book.store)
        first, second = (run_view(detections, book.configuration, name) for name in names)
        found = compare_runs(first, second)
        return page(
            request,
            connection,
            "run_diff.html.j2",
            "runs",
            first=found.first,
            second=found.second,
            rows=difference_rows(found, first.time_zone),
            both=all(isinstance(view.jumps_found, int) for view in (first, second)),
        )


ROUTES = [Route("/diff", _page)]
