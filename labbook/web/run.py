"""One run: facts, files, notes, its trace with jumps and gaps, and all its jumps one over the other."""

from __future__ import annotations

import numpy as np
from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.routing import Route

from data_schema.queries.runs import run_names
from labbook.actions.runs.jump_review import review
from labbook.actions.runs.run_plot import drawn_log
from labbook.actions.runs.run_view import run_view, view_lines
from labbook.analysis.outcomes.detection import Detections
from labbook.analysis.outcomes.run_apexes import anchor_of
from labbook.terminal import plain
from labbook.web.rendering import page


def _page(request: Request) -> Response:
    book = request.app.state.book.current()
    name = request.path_params["name"]
    with book.reading() as connection:
        view = run_view(Detections(connection, book.store), book.configuration, name)
        names = list(run_names(connection))
        place = names.index(view.run.name)
        return page(
            request,
            connection,
            "run.html.j2",
            "runs",
            run=view.run,
            lines=[line.strip() for line in view_lines(view)[1:]],
            before=names[place - 1] if place else None,
            after=names[place + 1] if place + 1 < len(names) else None,
            beside=names[place - 1] if place else names[place + 1] if place + 1 < len(names) else None,
            has_log=isinstance(view.jumps_found, int),
        )


def _log(request: Request) -> Response:
    """Return what is drawn of a run's log beside its samples: jumps with their verdicts, and gaps."""
    book = request.app.state.book.current()
    with book.reading() as connection:
        found = review(book, connection, request.path_params["name"])
        log, _remark = drawn_log(book, connection, found, None)
    judged = {item.jump.number: item for item in found.jumps}
    jumps = [
        {
            **plain(jump),
            "decided": None if (decided := judged[jump.number].decision) is None else plain(decided),
            "se_m": judged[jump.number].jump.apex_height_se_m,
            "flags": judged[jump.number].jump.flags,
            "anchor_s": anchor_of(judged[jump.number].before),
            "signal": judged[jump.number].signal_sha256,
            "why_no_apex": judged[jump.number].jump.undefined_reason,
        }
        for jump in log.jumps
    ]
    gaps = [plain(gap) for gap in log.gaps]
    return JSONResponse({"run": log.run, "title": log.title, "jumps": jumps, "gaps": gaps, "samples": log.time_s.size})


def _samples(request: Request) -> Response:
    """Return a log's samples: times in s as float64, then body heights in m as float32, little-endian."""
    book = request.app.state.book.current()
    with book.reading() as connection:
        log, _remark = drawn_log(book, connection, review(book, connection, request.path_params["name"]), None)
    data = log.time_s.astype("<f8").tobytes() + log.body_height_m.astype("<f4").tobytes()
    leg = log.leg_length_m
    if leg is not None and not np.isnan(leg).all():
        data += leg.astype("<f4").tobytes()
    return Response(data, media_type="application/octet-stream")


ROUTES = [
    Route("/runs/{name}", _page),
    Route("/api/runs/{name}/log", _log),
    Route("/api/runs/{name}/samples", _samples),
]
