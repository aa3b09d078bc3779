"""What came in last, large enough to be read from two metres: run, joules, jumps, and what is wrong."""

from __future__ import annotations

from typing import Any

from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.routing import Route

from data_schema.queries.files import newest_files, refused_files, runs_of_file, waiting_files
from labbook.actions.runs.rig_line import rig_lines_of_runs
from labbook.config.local_time import local_text
from labbook.web.book import OpenBook
from labbook.web.rendering import page

_MOST = 12


def _page(request: Request) -> Response:
    with request.app.state.book.current().reading() as connection:
        return page(request, connection, "live.html.j2", "live")


def _live(request: Request) -> Response:
    """Return the newest files with the line on each of their runs; of the first, whether all is well."""
    served: OpenBook = request.app.state.book
    book = served.current()
    with book.reading() as connection:
        files = newest_files(connection, _MOST)
        refused = refused_files(connection, _MOST)
        runs = {file.uid: runs_of_file(connection, file.sha256) for file in files}
        waiting = {file.file_uid: file.why.reason for file in waiting_files(connection)}
    zone = book.configuration.study.time_zone
    found: list[dict[str, Any]] = [
        *(
            {"name": file.name, "role": file.role, "at_utc": file.at_utc, "runs": runs[file.uid],
             "wrong": waiting.get(file.uid, "")}
            for file in files
        ),
        *(
            {"name": file.name, "role": "refused", "at_utc": file.at_utc, "runs": (), "wrong": file.why}
            for file in refused
        ),
    ]  # fmt: skip
    found = sorted(found, key=lambda file: file["at_utc"], reverse=True)[:_MOST]
    newest = [name for file in found[:1] for name in file["runs"][:_MOST]]
    lines = [{"text": line.text, "concern": line.concern} for line in rig_lines_of_runs(book, newest, jumps=True)]
    return JSONResponse({"files": [{**file, "at": local_text(file["at_utc"], zone)} for file in found], "lines": lines})


ROUTES = [Route("/live", _page), Route("/api/live", _live)]
