"""The reports that were made, each as it was written; and the book's studies, each made when it is opened."""

from __future__ import annotations

import hashlib
import mimetypes
import re
from base64 import b64encode
from collections.abc import Iterable

from starlette.requests import Request
from starlette.responses import RedirectResponse, Response
from starlette.routing import Route

from data_schema.errors import BookError, UnknownName
from data_schema.queries.history import list_reports
from labbook.actions.report_command import report_as_of
from labbook.actions.upkeep.report_differences import report_named
from labbook.book.write_session import now_utc
from labbook.config.local_time import local_text
from labbook.studies.registry import ask, studies_of_book
from labbook.studies.study import Asked
from labbook.web.rendering import page
from reports.page.study import study_page
from reports.page.writing import report_files

_PAGE = "report.html"
_SCRIPT = re.compile(rb"<script>(.*?)</script>", re.DOTALL)


def _page(request: Request) -> Response:
    book = request.app.state.book.current()
    zone = book.configuration.study.time_zone
    with book.reading() as connection:
        reports = [(one, local_text(one.made_utc, zone)) for one in reversed(list_reports(connection))]
        studies = studies_of_book(connection, book.configuration)
        return page(request, connection, "reports.html.j2", "reports", reports=reports, studies=studies)


def _whole(request: Request) -> Response:
    return RedirectResponse(f"/reports/{request.path_params['uid']}/{_PAGE}")


def _file(request: Request) -> Response:
    """Return a file of a report, where it is as it was written: its name and hash stand in the journal."""
    book = request.app.state.book.current()
    uid, name = request.path_params["uid"], request.path_params["name"]
    with book.reading() as connection:
        made = report_named(connection, uid)
    if made.elsewhere or name not in made.files:
        raise UnknownName(f"report {made.number} has no file {name!r} here: `labbook reports show {made.number}`.")
    try:
        content = (book.folder / made.folder / name).read_bytes()
    except OSError as error:
        raise BookError(f"{name} of report {made.number} cannot be read: {error.strerror}.") from error
    if hashlib.sha256(content).hexdigest() != made.files[name]:
        raise BookError(
            f"{name} of report {made.number} is not as it was written: another report was written into its folder, or "
            "somebody changed it (`labbook db check`)."
        )
    kind = mimetypes.guess_type(name)[0] or "text/plain"
    return _alone(content, "text/plain" if kind.startswith("text/") and kind != "text/html" else kind)


def _as_of(request: Request) -> Response:
    """Return the page of the report of the book as it stood at an entry, made now."""
    book = request.app.state.book.current()
    made = report_as_of(book, None, str(request.path_params["seq"]), lambda _step: None)
    return _alone(report_files(made.content)[_PAGE], "text/html")


def _study(request: Request) -> Response:
    """Return the page of a study, made now."""
    book = request.app.state.book.current()
    name = request.path_params["name"]
    with book.reading() as connection:
        known = studies_of_book(connection, book.configuration)
    if name not in known:
        raise UnknownName(f"the book has no study {name!r}: it has {', '.join(known) or 'none'}.")
    found = ask(name, Asked(book.folder))
    made_at = now_utc().split(".")[0] + "Z"
    return _alone(study_page(found.study, found.sources, found.files, made_at).encode(), "text/html")


def _alone(content: bytes, kind: str) -> Response:
    """Return a page that stands for itself: it may run its own script, of an origin that is nobody's."""
    scripts = _SCRIPT.findall(content) if kind == "text/html" else []
    policy = (
        "default-src 'none'; style-src 'unsafe-inline'; img-src data:; base-uri 'none'; form-action 'none'; "
        f"frame-ancestors 'none'; script-src {_hashes(scripts)}"
    )
    headers = {"Content-Security-Policy": f"{policy}; sandbox allow-scripts" if kind == "text/html" else policy}
    return Response(content, headers=headers, media_type=kind)


def _hashes(scripts: Iterable[bytes]) -> str:
    found = [f"'sha256-{b64encode(hashlib.sha256(script).digest()).decode()}'" for script in scripts]
    return " ".join(found) or "'none'"


ROUTES = [
    Route("/reports", _page),
    Route("/reports/as-of/{seq:int}", _as_of),
    Route("/reports/{uid}", _whole),
    Route("/reports/{uid}/{name:path}", _file),
    Route("/studies/{name}", _study),
]
