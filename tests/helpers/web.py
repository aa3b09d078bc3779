"""A real server of a book's page, and requests to it as a browser makes them."""

from __future__ import annotations

import atexit
import contextlib
import functools
import http.client
import json
import os
import signal
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

from tests.helpers.commands import Commands, Running, running_commands


@dataclass
class Page:
    """A page that is served: the address with the token that `labbook web` printed."""

    url: str
    cookie: str = ""
    """The name of the book's cookie."""

    @property
    def port(self) -> int:
        port = urlsplit(self.url).port
        assert port is not None
        return port

    @property
    def base(self) -> str:
        return f"http://{urlsplit(self.url).netloc}"

    @property
    def token(self) -> str:
        return self.url.partition("token=")[2]

    def enter(self) -> None:
        """Open the address with the token, for the cookie."""
        _status, _body, headers = self.ask(f"/?token={self.token}")
        self.cookie = headers["Set-Cookie"].partition("=")[0]

    def ask(
        self, path: str, data: Any = None, *, headers: Mapping[str, str] | None = None, method: str | None = None
    ) -> tuple[int, bytes, http.client.HTTPMessage]:
        """Ask with the cookie, and post `data` as JSON; `headers` come on top, one that is "" is left out."""
        sent = {"Cookie": f"{self.cookie}={self.token}", "Host": urlsplit(self.url).netloc}
        body = None if data is None else json.dumps(data).encode()
        if body is not None:
            sent |= {"Origin": self.base, "Content-Type": "application/json"}
        sent |= headers or {}
        connection = http.client.HTTPConnection(urlsplit(self.url).hostname or "", self.port, timeout=30)
        with contextlib.closing(connection):
            connection.putrequest(method or ("GET" if body is None else "POST"), path, skip_host=True)
            for name, value in {**sent, "Content-Length": str(len(body or b""))}.items():
                if value:
                    connection.putheader(name, value)
            connection.endheaders(body)
            answer = connection.getresponse()
            return answer.status, answer.read(), answer.headers

    def json(self, path: str, data: Any = None) -> Any:
        status, body, _headers = self.ask(path, data)
        assert status == 200, body
        return json.loads(body)


@dataclass
class Server(Page):
    """A page with the process of `labbook web` that serves it."""

    running: Running = field(kw_only=True)
    ended: bool = False

    def kill(self, number: int = signal.SIGKILL) -> None:
        if not self.ended:
            os.kill(self.running.pid, number)
            self.running.wait()
            self.ended = True


@contextlib.contextmanager
def served(book: Path, *words: str, port: int = 0, commands: Commands | None = None) -> Iterator[Server]:
    """Serve a book's page in a process of its own until the end of the block."""
    starter = commands or _commands()
    running = starter.start("web", "--json", "--no-browser", "--book", book, "--port", str(port), *words)
    server = Server("", running=running)
    try:
        until(lambda: running.output.exists() and running.output.read_text().endswith("\n"), 30.0)
        server.url = json.loads(running.output.read_text())["url"]
        server.enter()
        yield server
    finally:
        server.kill(signal.SIGTERM)


@functools.cache
def _commands() -> Commands:
    """What starts servers quickly, for all tests of this process."""
    ends = contextlib.ExitStack()
    atexit.register(ends.close)
    return ends.enter_context(running_commands())


def until(holds: Callable[[], bool], seconds: float = 15.0) -> None:
    """Wait for what is to come soon, or fail."""
    end = time.monotonic() + seconds
    while not holds():
        assert time.monotonic() < end
        time.sleep(0.02)
