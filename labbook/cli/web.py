"""`labbook web` and `labbook review`: the book as a page in a browser of this machine."""

import contextlib
import os
import sys
import threading
import webbrowser
from typing import TYPE_CHECKING, Annotated

import typer

from labbook.cli.common import AsOption, BookOption
from labbook.terminal import Shown, for_program, say

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

HostOption = Annotated[
    str,
    typer.Option(help="Another address of this machine: whoever reaches it and has the link can read and judge."),
]
PortOption = Annotated[
    int | None, typer.Option(min=0, max=65535, help="The port; without it the book's own, 0 takes any that is free.")
]
ReadOnlyOption = Annotated[bool, typer.Option("--read-only", help="Show everything, state nothing.")]
QuietOption = Annotated[bool, typer.Option("--no-browser", help="Print the address, open no browser.")]


def web(
    host: HostOption = "127.0.0.1",
    port: PortOption = None,
    read_only: ReadOnlyOption = False,
    no_browser: QuietOption = False,
    book: BookOption = None,
    person: AsOption = None,
) -> Shown:
    """Open the book as a page in the browser: runs, each run's log, and reviewing jumps by keyboard. Ctrl-C ends it.

    The page is for this machine alone, under an address with a token of its own; nothing is fetched from elsewhere.
    --json prints one document with the address at the start, and one at the end.

    Example: labbook web --as AN
    """
    return _serve(book, person, "", host=host, port=port, read_only=read_only, no_browser=no_browser)


def review(
    host: HostOption = "127.0.0.1",
    port: PortOption = None,
    no_browser: QuietOption = False,
    book: BookOption = None,
    person: AsOption = None,
) -> Shown:
    """Review jumps by keyboard, one at a time, on a page in the browser. Ctrl-C ends it.

    Every verdict is a statement in the book, saved at its key. The page lists the keys with `?`.

    Example: labbook review --as AN
    """
    return _serve(book, person, "review", host=host, port=port, read_only=False, no_browser=no_browser)


def _serve(
    folder: "Path | None",
    person: str | None,
    view: str,
    *,
    host: str,
    port: int | None,
    read_only: bool,
    no_browser: bool,
) -> Shown:
    from labbook.book.opening import find_folder, opened

    with _needs_extra():
        from labbook.web.serving import Served, serve
    with opened(folder) as book:
        speaker = "" if read_only and person is None else book.speaker(person)
    quiet = for_program()

    def ready(served: Served) -> None:
        if quiet:
            typer.echo(f'{{"url": "{served.url}"}}')
        else:
            say(f"{served.url}\nCtrl-C ends it.")
        if not no_browser:
            _open(served.url_once)

    serve(find_folder(folder), speaker, ready, host=host, port=port, read_only=read_only, view=view)
    return Shown({"ended": True}, [])


@contextlib.contextmanager
def page_beside(folder: "Path | None", person: str | None) -> "Iterator[str]":
    """Open what comes in as a page in the browser, while the caller goes on; yields its address."""
    from labbook.book.opening import find_folder, opened

    with _needs_extra():
        from labbook.web.serving import served_beside
    with opened(folder) as book:
        speaker = book.speaker(person)
    with served_beside(find_folder(folder), speaker, "live") as served:
        _open(served.url_once)
        yield served.url


def _open(url: str) -> None:
    """Open a browser beside what goes on, where there is a screen: one of the terminal would take that."""
    screens = ("DISPLAY", "WAYLAND_DISPLAY", "BROWSER")
    if sys.platform in ("darwin", "win32") or any(map(os.environ.get, screens)):
        threading.Thread(target=webbrowser.open, args=(url,), daemon=True).start()


@contextlib.contextmanager
def _needs_extra() -> "Iterator[None]":
    from data_schema.errors import UsageError

    try:
        yield
    except ModuleNotFoundError as error:
        raise UsageError(
            f"the page needs {error.name}, which is not installed: `pip install 'robot-labbook[web]'`."
        ) from error
