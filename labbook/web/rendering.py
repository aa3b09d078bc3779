"""Views: what a request asks for, read in one transaction, and pages from the templates of reports.

Also what pages state, as JSON and never where the book is opened for reading only, and the files of style and script
that they load.
"""

from __future__ import annotations

import importlib.resources
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

import jinja2
import sqlalchemy as sa
from starlette.concurrency import run_in_threadpool
from starlette.requests import Request
from starlette.responses import HTMLResponse, JSONResponse, PlainTextResponse, Response
from starlette.routing import Route

from data_schema import journal
from data_schema.errors import BookReadOnly, UsageError
from labbook.analysis.outcomes.detection import Detections
from labbook.book.opening import Book
from labbook.config.local_time import local_text
from labbook.web.book import OpenBook

_MOST_DIGITS = 18
_KINDS = {".css": "text/css", ".js": "text/javascript"}


@cache
def _environment() -> jinja2.Environment:
    return jinja2.Environment(
        loader=jinja2.PackageLoader("reports", "templates/web"),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )


@dataclass(frozen=True, slots=True)
class Asked:
    """A request, and the transaction in which it is answered: what was stated later is news to the page."""

    request: Request
    served: OpenBook
    book: Book
    connection: sa.Connection

    @property
    def detections(self) -> Detections:
        """What finds jumps."""
        return Detections(self.connection, self.book.store)

    @property
    def last_entry(self) -> int:
        """The number of the book's last entry."""
        return journal.head(self.connection)[0]

    def path(self, name: str) -> str:
        """Return a part of the address."""
        return str(self.request.path_params[name])

    def given(self, name: str) -> str | None:
        """Return what stands behind the address by a name; None where nothing does."""
        return self.request.query_params.get(name) or None

    def number(self, name: str) -> int | None:
        """Return a number from 1 that stands there."""
        given = self.request.query_params.get(name)
        if given is None:
            return None
        if not (given.isdecimal() and len(given) <= _MOST_DIGITS and int(given)):
            raise UsageError(f"{name}={given[:20]!r} is no number from 1: correct the address.")
        return int(given)

    def local(self, at_utc: str) -> str:
        """Return an instant in the study's time zone."""
        return local_text(at_utc, self.book.configuration.study.time_zone)

    def page(self, template: str, view: str, **values: Any) -> HTMLResponse:
        """Answer with a page; `view` is the entry of the menu that it belongs to."""
        about = {
            "view": view,
            "study": self.book.configuration.study.name,
            "person": self.served.person,
            "book": self.served.name,
            "read_only": self.served.read_only,
            "entries": self.last_entry,
        }
        return HTMLResponse(_environment().get_template(template).render(**about, **values))


def view(path: str, answer: Callable[[Asked], Response]) -> Route:
    """Return the route of a view."""

    def endpoint(request: Request) -> Response:
        served: OpenBook = request.app.state.book
        book = served.current()
        with book.reading() as connection:
            return answer(Asked(request, served, book, connection))

    return Route(path, endpoint)


def stating(path: str, state: Callable[[OpenBook, Mapping[str, Any]], dict[str, Any]]) -> Route:
    """Return the route of a request that states something."""

    async def answer(request: Request) -> Response:
        book: OpenBook = request.app.state.book
        if book.read_only:
            raise BookReadOnly("the page was opened with --read-only: nothing is stated.")
        try:
            given = await request.json()
        except ValueError:
            given = None
        if not isinstance(given, dict):
            raise UsageError("this states nothing: give a JSON object, as the page does.")
        return JSONResponse(await run_in_threadpool(state, book, given))

    return Route(path, answer, methods=["POST"])


@cache
def _static() -> dict[str, tuple[bytes, str]]:
    """Return the files that a page may load, by name; no path of a request reaches the file system."""
    folder = importlib.resources.files("reports").joinpath("templates", "web")
    return {
        entry.name: (entry.read_bytes(), kind)
        for entry in folder.iterdir()
        for ending, kind in _KINDS.items()
        if entry.name.endswith(ending)
    }


def static(request: Request) -> Response:
    """Answer with a file of style or script."""
    found = _static().get(request.path_params["name"])
    if found is None:
        return PlainTextResponse("There is no such file.\n", 404)
    return Response(found[0], media_type=found[1])
