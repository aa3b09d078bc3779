"""The application: its views, each a file with its routes, behind the checks of who may ask."""

from __future__ import annotations

from collections.abc import Callable, Collection

from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import JSONResponse, PlainTextResponse, Response
from starlette.routing import Route
from starlette.types import ASGIApp

from data_schema.errors import BookBusy, BookReadOnly, LabbookError, UnknownName
from labbook.web import attention, events, lists, live, reports, review, run
from labbook.web.book import OpenBook
from labbook.web.rendering import static
from labbook.web.safety import Guard

VIEWS = (lists, attention, run, review, live, reports, events)
"""The modules whose `ROUTES` are served."""

_STATUS: tuple[tuple[type[LabbookError], int], ...] = ((UnknownName, 404), (BookBusy, 503), (BookReadOnly, 403))


def application(
    book: OpenBook, token: str, once: set[str], hosts: Collection[str], ending: Callable[[], bool]
) -> ASGIApp:
    """Return the application for a book, for who has the token or one of `once`, under these hosts with their port.

    `ending` tells whether the server is about to end: then pages that listen are let go.
    """
    routes = [route for view in VIEWS for route in view.ROUTES]
    app = Starlette(
        routes=[*routes, Route("/static/{name}", static)],
        exception_handlers={LabbookError: _refused, 404: _not_found},
    )
    app.state.book = book
    app.state.ending = ending
    return Guard(app, token, once, f"labbook-{book.name}", hosts)


def _refused(request: Request, error: Exception) -> Response:
    """Answer with the sentence of an error, to a script as JSON."""
    status = next((code for kind, code in _STATUS if isinstance(error, kind)), 422)
    if request.url.path.startswith("/api/"):
        return JSONResponse({"error": str(error)}, status)
    return PlainTextResponse(f"{error}\n", status)


def _not_found(_request: Request, _error: Exception) -> Response:
    return PlainTextResponse("There is no such page.\n", 404)
