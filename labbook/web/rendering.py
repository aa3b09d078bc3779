"""Pages from the templates of reports, and the files of style and script that they load."""

from __future__ import annotations

import importlib.resources
from functools import cache
from typing import Any

import jinja2
import sqlalchemy as sa
from starlette.requests import Request
from starlette.responses import HTMLResponse, PlainTextResponse, Response

from data_schema import journal
from data_schema.errors import UsageError
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


def page(request: Request, connection: sa.Connection, template: str, view: str, **values: Any) -> HTMLResponse:
    """Answer with a page; `view` is the entry of the menu that it belongs to.

    `connection` is the transaction in which the values were read: what was stated later is news to the page.
    """
    book: OpenBook = request.app.state.book
    text = (
        _environment()
        .get_template(template)
        .render(
            view=view,
            study=book.current().configuration.study.name,
            person=book.person,
            book=book.name,
            read_only=book.read_only,
            entries=journal.head(connection)[0],
            **values,
        )
    )
    return HTMLResponse(text)


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


def whole_number(request: Request, name: str) -> int | None:
    """Return what an address asks for by a number from 1, None where it does not."""
    given = request.query_params.get(name)
    if given is None:
        return None
    if not (given.isdecimal() and len(given) <= _MOST_DIGITS and int(given)):
        raise UsageError(f"{name}={given[:20]!r} is no number from 1: correct the address.")
    return int(given)


def static(request: Request) -> Response:
    """Answer with a file of style or script."""
    found = _static().get(request.path_params["name"])
    if found is None:
        return PlainTextResponse("There is no such file.\n", 404)
    return Response(found[0], media_type=found[1])
