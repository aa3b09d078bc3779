"""The server of the page: on this machine alone unless a host is named, until Ctrl-C."""

from __future__ import annotations

import contextlib
import hashlib
import ipaddress
import secrets
import socket
import threading
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import uvicorn

from data_schema.errors import UsageError
from data_schema.file_cache import cache_folder, for_nobody_else, why_not_trusted
from labbook.web.app import application
from labbook.web.book import OpenBook

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
