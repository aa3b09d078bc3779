"""The server of the page: on this machine alone unless a host is named, until Ctrl-C."""

from __future__ import annotations

import secrets
import socket
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import uvicorn

from data_schema.errors import UsageError
from labbook.web.app import application
from labbook.web.book import OpenBook

LOOPBACK = "127.0.0.1"


@dataclass(frozen=True, slots=True)
class Served:
    """Where a page is served: `url` opens it in a browser that has not been here before."""

    url: str
    host: str
    port: int


def serve(
    folder: Path,
    person: str,
    ready: Callable[[Served], None],
    *,
    host: str = LOOPBACK,
    port: int = 0,
    read_only: bool = False,
    view: str = "",
) -> None:
    """Serve a book until Ctrl-C; calls `ready` when the page can be opened. Port 0 takes any that is free.

    Raises `UsageError` where nothing can be served there.
    """
    token = secrets.token_hex(16)
    book = OpenBook(folder, person, read_only)
    book.current()
    try:
        listening = socket.create_server((host, port))
    except OSError as error:
        raise UsageError(
            f"nothing can be served at {host}:{port} ({error.strerror or error}): give another --port or --host."
        ) from error
    with listening:
        taken = listening.getsockname()[1]
        names = {host, "localhost"} if host == LOOPBACK else {host}
        app = application(book, token, {f"{name}:{taken}" for name in names})
        server = uvicorn.Server(
            uvicorn.Config(app, log_level="warning", lifespan="off", server_header=False, timeout_graceful_shutdown=1)
        )
        ready(Served(f"http://{host}:{taken}/{view}?token={token}", host, taken))
        try:
            server.run(sockets=[listening])
        finally:
            book.close()
