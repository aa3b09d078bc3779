"""All runs in a table that sorts and filters, with the plan's progress and the newest files."""

from __future__ import annotations

from dataclasses import asdict

from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.routing import Route

from data_schema.queries.study import planned_runs
from labbook.actions.runs.overview import overview
from labbook.terminal import plain
from labbook.web.rendering import page


def _page(request: Request) -> Response:
    return page(request, "overview.html.j2", "runs")


def _runs(request: Request) -> Response:
    book = request.app.state.book.current()
    where = request.query_params.get("where") or None
    with book.reading() as connection:
        runs = overview(connection, book.store, book.configuration, where)
        planned = planned_runs(connection)
    factors = [
        {"name": name, "title": factor.title or name, "levels": [level.label for level in factor.levels]}
        for name, factor in book.configuration.factors.items()
    ]
    return JSONResponse(
        {
            "runs": [plain(asdict(one)) for one in runs],
            "factors": factors,
            "planned": len(planned),
            "planned_made": sum(row.run_name is not None for row in planned),
        }
    )


ROUTES = [Route("/", _page), Route("/api/runs", _runs)]
