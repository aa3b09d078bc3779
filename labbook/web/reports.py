"""The reports that were made, each as it was written; and the book's studies, each made when it is opened."""

from __future__ import annotations

import hashlib
import mimetypes
import re
import tempfile
from pathlib import Path

from starlette.requests import Request
from starlette.responses import RedirectResponse, Response
from starlette.routing import Route

from data_schema.errors import BookError, UnknownName
from data_schema.queries.history import list_reports
from labbook.actions.upkeep.report_differences import report_named
from labbook.book.opening import Book
from labbook.studies.registry import studies_of_book
from labbook.web.commands import command
from labbook.web.rendering import Asked, view
from reports.page.policy import content_policy

_PAGE = "report.html"
_SCRIPT = re.compile(r"<script>(.*?)</script>", re.DOTALL)


def _page(asked: Asked) -> Response:
    reports = [(one, asked.local(one.made_utc)) for one in reversed(list_reports(asked.connection))]
    studies = studies_of_book(asked.connection, asked.book.configuration)
    return asked.page("reports.html.j2", "reports", reports=reports, studies=studies)


def _whole(request: Request) -> Response:
    return RedirectResponse(f"/reports/{request.path_params['uid']}/{_PAGE}")


def _file(asked: Asked) -> Response:
    """Return a file of a report, where it is as it was written: its name and hash stand in the journal."""
    made, name = report_named(asked.connection, asked.path("uid")), asked.path("name")
    if made.elsewhere or name not in made.files:
        raise UnknownName(f"report {made.number} has no file {name!r} here: `labbook reports show {made.number}`.")
    try:
        content = (asked.book.folder / made.folder / name).read_bytes()
    except OSError as error:
        raise BookError(f"{name} of report {made.number} cannot be read: {error.strerror}.") from error
    if hashlib.sha256(content).hexdigest() != made.files[name]:
        raise BookError(
            f"{name} of report {made.number} is not as it was written: another report was written into its folder, or "
            "somebody changed it (`labbook db check`)."
        )
    kind = mimetypes.guess_type(name)[0] or "text/plain"
    return _alone(content, "text/plain" if kind.startswith("text/") and kind != "text/html" else kind)


def _as_of(asked: Asked) -> Response:
    """Return the page of the report of the book as it stood at an entry, made now."""
    return _alone(_made_apart(asked.book, "report", "--as-of", asked.path("seq"), "--out", "."), "text/html")


def _study(asked: Asked) -> Response:
    """Return the page of a study, made now."""
    name = asked.path("name")
    known = studies_of_book(asked.connection, asked.book.configuration)
    if name not in known:
        raise UnknownName(f"the book has no study {name!r}: it has {', '.join(known) or 'none'}.")
    return _alone(_made_apart(asked.book, "study", name, "--page", _PAGE), "text/html")


def _made_apart(book: Book, *words: str) -> bytes:
    """Return the page that a command makes in a process of its own: drawing has settings that all threads share."""
    with tempfile.TemporaryDirectory(prefix="labbook-page-") as folder:
        command(book, *words, folder=Path(folder))
        return (Path(folder) / _PAGE).read_bytes()


def _alone(content: bytes, kind: str) -> Response:
    """Return a page that stands for itself: it may run its own script, of an origin that is nobody's."""
    scripts = _SCRIPT.findall(content.decode("utf-8", "replace")) if kind == "text/html" else []
    policy = f"{content_policy(*scripts)}; frame-ancestors 'none'"
    headers = {"Content-Security-Policy": f"{policy}; sandbox allow-scripts" if kind == "text/html" else policy}
    return Response(content, headers=headers, media_type=kind)


ROUTES = [
    view("/reports", _page),
    view("/reports/as-of/{seq:int}", _as_of),
    Route("/reports/{uid}", _whole),
    view("/reports/{uid}/{name:path}", _file),
    view("/studies/{name}", _study),
]
