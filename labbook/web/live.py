"""What came in last, large enough to be read from two metres: run, joules, jumps, and what is wrong."""

from __future__ import annotations

from typing import Any

from starlette.responses import JSONResponse, Response

from data_schema.queries.files import newest_files, refused_files, runs_of_file, waiting_files
from labbook.actions.runs.rig_line import rig_lines_of_runs
from labbook.web.rendering import Asked, view

_MOST = 12


def _page(asked: Asked) -> Response:
    return asked.page("live.html.j2", "live")


def _live(asked: Asked) -> Response:
    """Return the newest files with the line on each of their runs; of the first, whether all is well."""
    connection = asked.connection
    waiting = {file.file_uid: file.why.reason for file in waiting_files(connection)}
    found: list[dict[str, Any]] = [
        {"name": file.name, "role": file.role, "at_utc": file.at_utc, "runs": runs_of_file(connection, file.sha256),
         "wrong": waiting.get(file.uid, "")}
        for file in newest_files(connection, _MOST)
    ]  # fmt: skip
    found += [
        {"name": file.name, "role": "refused", "at_utc": file.at_utc, "runs": (), "wrong": file.why}
        for file in refused_files(connection, _MOST)
    ]
    found = sorted(found, key=lambda file: file["at_utc"], reverse=True)[:_MOST]
    newest = [name for file in found[:1] for name in file["runs"][:_MOST]]
    lines = rig_lines_of_runs(asked.book, newest, jumps=True)
    return JSONResponse(
        {
            "files": [{**file, "at": asked.local(file["at_utc"])} for file in found],
            "lines": [{"text": line.text, "concern": line.concern} for line in lines],
        }
    )


ROUTES = [view("/live", _page), view("/api/live", _live)]
