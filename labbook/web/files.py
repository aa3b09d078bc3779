"""The files of the instruments: all of them, the newest first, and how each was read."""

from __future__ import annotations

from starlette.requests import Request
from starlette.responses import Response
from starlette.routing import Route

from data_schema.queries.files import refused_files
from labbook.actions.files.stored_files import list_files, show_file, show_lines
from labbook.config.local_time import local_text
from labbook.web.rendering import page, whole_number

_MOST = 200
_MOST_REFUSED = 12


def _page(request: Request) -> Response:
    book = request.app.state.book.current()
    zone = book.configuration.study.time_zone
    number = whole_number(request, "page") or 1
    with book.reading() as connection:
        every = list_files(connection)[::-1]
        refused = refused_files(connection, _MOST_REFUSED) if number == 1 else []
        files = [(one, local_text(one.reading.at_utc, zone)) for one in every[_MOST * (number - 1) : _MOST * number]]
        return page(
            request,
            connection,
            "files.html.j2",
            "files",
            files=files,
            refused=[(one, local_text(one.at_utc, zone)) for one in refused],
            count=len(every),
            number=number,
            more=len(every) > _MOST * number,
        )


def _file(request: Request) -> Response:
    book = request.app.state.book.current()
    with book.reading() as connection:
        found = show_file(connection, request.path_params["uid"])
        lines = [line.removeprefix("  ") for line in show_lines(found)[1:]]
        return page(request, connection, "file.html.j2", "files", file=found, lines=lines)


ROUTES = [Route("/files", _page), Route("/files/{uid}", _file)]
