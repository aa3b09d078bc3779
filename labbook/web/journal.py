"""The journal: what was stated, by whom, when and why, a line a command, the newest first."""

from __future__ import annotations

from starlette.requests import Request
from starlette.responses import Response
from starlette.routing import Route

from labbook.actions.upkeep.journal_view import newest_commands
from labbook.config.local_time import local_text
from labbook.web.rendering import page, whole_number

_MOST = 100


def _page(request: Request) -> Response:
    book = request.app.state.book.current()
    zone = book.configuration.study.time_zone
    with book.reading() as connection:
        found = newest_commands(connection, _MOST, whole_number(request, "before"))
        return page(
            request,
            connection,
            "journal.html.j2",
            "journal",
            commands=[(one, local_text(one.at_utc, zone)) for one in found],
            older=found[-1].first if found and found[-1].first > 1 else None,
        )


ROUTES = [Route("/journal", _page)]
