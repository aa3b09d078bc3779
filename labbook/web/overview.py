"""All runs in a table that sorts and filters, with the plan's progress."""

from __future__ import annotations

import msgspec
from starlette.requests import Request
from starlette.responses import Response
from starlette.routing import Route

from data_schema.queries.files import newest_files
from data_schema.queries.study import planned_runs
from labbook.actions.runs.overview import overview
from labbook.config.local_time import local_text
from labbook.web.rendering import page


def _page(request: Request) -> Response:
    with request.app.state.book.current().reading() as connection:
        return page(request, connection, "overview.html.j2", "runs")


def _runs(request: Request) -> Response:
    book = request.app.state.book.current()
    where = request.query_params.get("where") or None
    with book.reading() as connection:
        runs = overview(connection, book.store, book.configuration, where)
        planned = planned_runs(connection)
        newest = newest_files(connection, 1)
    factors = [
        {"name": name, "title": factor.title or name, "levels": [level.label for level in factor.levels]}
        for name, factor in book.configuration.factors.items()
    ]
    zone = book.configuration.study.time_zone
    found = {
        "runs": runs,
        "factors": factors,
        "last_in": {"name": newest[0].name, "at": local_text(newest[0].at_utc, zone)} if newest else None,
        "planned": len(planned),
        "planned_made": sum(row.run_name is not None for row in planned),
    }
    return Response(msgspec.json.encode(found), media_type="application/json")


ROUTES = [Route("/", _page), Route("/api/runs", _runs)]
