"""The server of the page: on this machine alone unless a host is named, until Ctrl-C; and who may ask it what.

The token of the address that `labbook web` prints becomes a cookie. `Host` is checked against DNS rebinding, `Origin`
against forms of other pages; the content security policy lets nothing run that does not come from here.
"""

from __future__ import annotations

import contextlib
import hashlib
import ipaddress
import secrets
import socket
import threading
from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass
from pathlib import Path

import uvicorn
from starlette.applications import Starlette
from starlette.datastructures import MutableHeaders
from starlette.requests import Request
from starlette.responses import JSONResponse, PlainTextResponse, RedirectResponse, Response
from starlette.routing import Route
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from data_schema.errors import BookBusy, BookReadOnly, LabbookError, UnknownName, UsageError
from data_schema.file_cache import cache_folder, for_nobody_else, why_not_trusted
from labbook.web import attention, lists, live, reports, review
from labbook.web.book import OpenBook
from labbook.web.rendering import static

_HEADERS = {
    "Content-Security-Policy": "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; "
    "connect-src 'self'; form-action 'self'; base-uri 'none'; frame-ancestors 'none'",
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cache-Control": "no-store",
}


@dataclass(frozen=True, slots=True)
class Guard:
    """An application behind the checks; `hosts` are the names and ports under which it may be asked.

    `cookie` names the cookie: browsers keep those of all ports together, and another book has another. `once` are
    tokens that open the page one time: that of a command line, which every user of the machine may list.
    """

    app: ASGIApp
    token: str
    once: set[str]
    cookie: str
    hosts: Collection[str]

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer what may be asked, and refuse the rest in a sentence."""
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return

        async def send_guarded(message: Message) -> None:
            if message["type"] == "http.response.start":
                headers = MutableHeaders(scope=message)
                for name, value in _HEADERS.items():
                    headers.setdefault(name, value)
            await send(message)

        refusal = self._refusal(Request(scope))
        await (self.app if refusal is None else refusal)(scope, receive, send_guarded)

    def _refusal(self, request: Request) -> Response | None:
        """Return the answer to what may not be asked, or to the token in an address; None where all is well."""
        host, origin = request.headers.get("host", ""), request.headers.get("origin")
        if host not in self.hosts:
            return PlainTextResponse(
                f"{host!r} is not an address of this page: use the one that labbook printed.\n", 400
            )
        if origin not in (None, f"http://{host}") or (request.method != "GET" and origin is None):
            return PlainTextResponse("This was asked by another page, and is refused.\n", 403)
        given = request.query_params.get("token")
        if given is not None and request.method == "GET" and self._opens(given):
            url = request.url.remove_query_params("token")
            response = RedirectResponse(f"{url.path}?{url.query}" if url.query else url.path, 303)
            response.set_cookie(self.cookie, self.token, httponly=True, samesite="strict")
            return response
        if not _same(request.cookies.get(self.cookie, ""), self.token):
            return PlainTextResponse("Open the page by the address that labbook printed, with its token.\n", 403)
        return None

    def _opens(self, given: str) -> bool:
        used = {token for token in self.once if _same(given, token)}
        self.once.difference_update(used)
        return bool(used) or _same(given, self.token)


def _same(given: str, token: str) -> bool:
    return secrets.compare_digest(given.encode(), token.encode())


LOOPBACK = "127.0.0.1"
_MOST_TO_END_S = 3.0
_PORTS = range(8700, 9700)
"""Of a book, one that follows from its folder, so that a page that is open finds a server that was started again."""


@dataclass(frozen=True, slots=True)
class Served:
    """Where a page is served: `url` opens it in a browser that has not been here before, `url_once` one time."""

    url: str
    url_once: str


def serve(
    folder: Path,
    person: str,
    ready: Callable[[Served], None],
    *,
    host: str = LOOPBACK,
    port: int | None = None,
    read_only: bool = False,
    view: str = "",
) -> None:
    """Serve a book until Ctrl-C; calls `ready` when the page can be opened.

    Without `port` it is the book's own, or any that is free where that is taken. Raises `UsageError` where nothing can
    be served there.
    """
    with _server(folder, person, host, port, read_only, view) as (server, listening, served):
        ready(served)
        with contextlib.suppress(KeyboardInterrupt):  # the way to end it
            server.run(sockets=[listening])


@contextlib.contextmanager
def served_beside(folder: Path, person: str, view: str) -> Iterator[Served]:
    """Serve a book to this machine's browser while the caller goes on with something else."""
    with _server(folder, person, LOOPBACK, None, False, view) as (server, listening, served):
        thread = threading.Thread(target=server.run, kwargs={"sockets": [listening]}, daemon=True)
        thread.start()
        try:
            yield served
        finally:
            server.should_exit = True
            thread.join(_MOST_TO_END_S)


@contextlib.contextmanager
def _server(
    folder: Path, person: str, host: str, port: int | None, read_only: bool, view: str
) -> Iterator[tuple[uvicorn.Server, socket.socket, Served]]:
    with contextlib.suppress(ValueError):  # a name
        address = ipaddress.ip_address(host)
        if address.is_unspecified:
            raise UsageError(f"--host {host} names no address of this machine: give the one that others reach.")
        host = address.compressed
    name = f"{_name_of(folder)[:12]}{'-reading' if read_only else ''}"
    token = _token(name)
    book = OpenBook(folder, person, read_only, name)
    book.current()
    try:
        with _listening(host, port, folder) as listening:
            taken = listening.getsockname()[1]
            shown = f"[{host}]" if ":" in host else host
            names = {shown, "localhost"} if host == LOOPBACK else {shown}
            once = secrets.token_hex(16)
            app = application(book, token, {once}, {f"{name}:{taken}" for name in names}, lambda: server.should_exit)
            server = uvicorn.Server(
                uvicorn.Config(
                    app, log_level="warning", lifespan="off", server_header=False, timeout_graceful_shutdown=1
                )
            )
            url = f"http://{shown}:{taken}/{view}?token="
            yield server, listening, Served(url + token, url + once)
    finally:
        book.close()


def _name_of(folder: Path) -> str:
    return hashlib.sha256(str(folder.resolve()).encode()).hexdigest()


def _listening(host: str, port: int | None, folder: Path) -> socket.socket:
    own = _PORTS[int(_name_of(folder)[:8], 16) % len(_PORTS)]
    for tried in (own, 0) if port is None else (port,):
        try:
            return socket.create_server((host, tried), family=socket.AF_INET6 if ":" in host else socket.AF_INET)
        except OSError as error:
            if port is not None or tried == 0:
                raise UsageError(
                    f"nothing can be served at {host}:{tried} ({error.strerror or error}): give another --port or "
                    "--host."
                ) from error
    raise AssertionError("one of two ports is tried last")


def _token(name: str) -> str:
    """Return the secret of a book's page: drawn once, and kept where nobody else may read; else drawn each time.

    A page that is for reading has another one: who may read may not judge.
    """
    path = cache_folder("web") / f"{name}.token"
    drawn = secrets.token_hex(16)
    try:
        if not path.exists():
            with for_nobody_else():
                path.parent.mkdir(parents=True, exist_ok=True)
                path.touch(0o600)
                path.write_text(drawn, encoding="ascii")
        known = path.read_text(encoding="ascii")
        private = not path.stat().st_mode & 0o077 and not why_not_trusted(path)
        return known if len(known) == len(drawn) and private else drawn
    except (OSError, ValueError):
        return drawn


VIEWS = (lists, attention, review, live, reports)
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
