"""Commands that a page gives, each in a process of its own: what it draws or states is that of the command line."""

from __future__ import annotations

import shlex
import subprocess
import sys
from pathlib import Path

from data_schema.errors import BookBusy, BookError, InputRefused
from labbook.book.opening import Book

_BUSY = 75
_PROGRAM = f"""
from data_schema.errors import BookBusy
BookBusy.exit_code = {_BUSY}
from labbook.cli.start import main
main()
"""
"""Ends with a code of its own where the book is busy, for 3 is also that of a full disk."""


def command(book: Book, *words: str, folder: Path | None = None) -> None:
    """Give a command for a book in a process of its own, where a folder is named in that; raises what it says.

    That is `InputRefused` for what was given, `BookBusy` where another program writes to the book, else `BookError`.
    """
    done = subprocess.run(
        [sys.executable, "-c", _PROGRAM, *words, "--book", str(book.folder.resolve())],
        cwd=folder,
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode:
        said = done.stderr.strip().rpartition("labbook: ")[2] or " ".join(done.stdout.split())
        kind = {InputRefused.exit_code: InputRefused, _BUSY: BookBusy}.get(done.returncode, BookError)
        raise kind(said or f"`labbook {shlex.join(words)}` ended with {done.returncode}.")
