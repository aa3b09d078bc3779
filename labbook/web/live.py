"""What came in last, large enough to be read from two metres: run, joules, jumps, and what is wrong."""

from __future__ import annotations

from typing import Any

from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.routing import Route

from data_schema.queries.files import newest_files, runs_of_file, waiting_files
from data_schema.vocabulary import IngestStatus
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
        runs = {file.uid: runs_of_file(connection, file.sha256) for file in files}
        waiting = {file.file_uid: file.why.reason for file in waiting_files(connection)}
    zone = book.configuration.study.time_zone
    newest = [name for file in files[:1] for name in runs[file.uid][:_MOST]]
    lines = rig_lines_of_runs(book, newest, jumps=True)
    found: list[dict[str, Any]] = [
        {
            "name": file.name,
            "role": file.role,
            "at": local_text(file.at_utc, zone),
            "runs": runs[file.uid],
            "refused": file.status is IngestStatus.REFUSED,
            "waits": waiting.get(file.uid, ""),
        }
        for file in files
    ]
    return JSONResponse({"files": found, "lines": [{"text": line.text, "concern": line.concern} for line in lines]})


ROUTES = [Route("/live", _page), Route("/api/live", _live)]
