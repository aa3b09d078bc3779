"""The command line as a person meets it: in this process where many calls are made, in one of its own where it counts.

Also what may not change: `contents` is a book's files and table rows, `unchanged` compares them before and after.
"""

from __future__ import annotations

import contextlib
import hashlib
import io
import json
import os
import pty
import re
import resource
import sqlite3
import subprocess
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from labbook.cli.main import run
from tests.helpers.folders import contents as digests

LABBOOK = Path(sys.executable).with_name("labbook")
"""The installed command."""


@dataclass(frozen=True, slots=True)
class Answer:
    """What a command gave back."""

    code: int
    out: str
    err: str

    @property
    def json(self) -> Any:
        """The parsed standard output."""
        return json.loads(self.out)


def labbook(*words: str | Path, at: Path) -> Answer:
    """Give a command in this process, in the folder `at`, as from a script: nobody sits at a terminal."""
    out, err = io.StringIO(), io.StringIO()
    code: object = 0
    with contextlib.chdir(at), contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            run([str(word) for word in words])
        except SystemExit as end:
            code = end.code
    return Answer(code if isinstance(code, int) else 0, out.getvalue(), err.getvalue())


def environment(**more: str) -> dict[str, str]:
    """What a process of its own sees: no speaker, 80 columns, no colours."""
    kept = {name: value for name, value in os.environ.items() if name != "LABBOOK_AS"}
    return {**kept, "COLUMNS": "80", "NO_COLOR": "1", **more}


def process(*words: str | Path, at: Path, **options: Any) -> Answer:
    """Give a command in a process of its own."""
    done = subprocess.run(
        [LABBOOK, *words],
        cwd=at,
        env=environment(),
        capture_output=True,
        text=True,
        stdin=subprocess.DEVNULL,
        timeout=60,
        check=False,
        **options,
    )
    return Answer(done.returncode, done.stdout, done.stderr)


def at_a_terminal(*words: str | Path, at: Path, typed: str) -> tuple[int, str, str]:
    """Give a command with a person at the terminal who types; returns exit code, standard output, what was asked."""
    person, terminal = pty.openpty()
    asked = b""
    with subprocess.Popen(
        [LABBOOK, *words],
        cwd=at,
        env=environment(TERM="dumb"),
        stdin=terminal,
        stdout=subprocess.PIPE,
        stderr=terminal,
        start_new_session=True,
    ) as running:
        os.close(terminal)
        os.write(person, typed.encode())
        assert running.stdout is not None
        out = running.stdout.read().decode()
        while True:
            try:
                piece = os.read(person, 4096)
            except OSError:  # the terminal is closed
                break
            if not piece:
                break
            asked += piece
        code = running.wait(timeout=60)
    os.close(person)
    return code, out, asked.decode()


def good(answer: Answer) -> Answer:
    """Check that a command did what it was asked."""
    assert answer.code == 0, answer
    assert answer.err == ""
    return answer


def refused(answer: Answer, code: int, *said: str) -> None:
    """Check that a command ended with `code` and one message of labbook's own that says all of `said`."""
    assert answer.code == code, answer
    assert answer.out == ""
    assert answer.err.startswith("labbook: "), answer.err
    assert answer.err.endswith("\n")
    assert len(re.findall(r"^labbook: ", answer.err, re.MULTILINE)) == 1
    assert "Traceback" not in answer.err
    for words in said:
        assert words in answer.err


@dataclass(frozen=True, slots=True)
class Contents:
    """A book's files by path (SHA-256), and its tables' rows."""

    files: Mapping[str, str]
    rows: Sequence[str]


def contents(book: Path) -> Contents:
    """Read all that a book holds; a database that cannot be read counts as a file."""
    found = digests(book).items()
    files = {name: digest for name, digest in found if digest and not Path(name).name.startswith("labbook.db")}
    database = book / "labbook.db"
    try:
        with contextlib.closing(sqlite3.connect(f"file:{database}?mode=ro", uri=True)) as connection:
            return Contents(files, sorted(connection.iterdump()))  # rows of hashes have no order
    except sqlite3.Error:
        digest = hashlib.sha256(database.read_bytes()).hexdigest() if database.exists() else "none"
        return Contents({**files, "labbook.db": digest}, [])


@contextlib.contextmanager
def unchanged(book: Path) -> Iterator[None]:
    """Check that nothing in a book was added, changed or lost meanwhile."""
    before = contents(book)
    yield
    assert contents(book) == before


def rows(book: Path, query: str) -> list[tuple[Any, ...]]:
    """Ask a book's database."""
    with contextlib.closing(sqlite3.connect(f"file:{book / 'labbook.db'}?mode=ro", uri=True)) as connection:
        return connection.execute(query).fetchall()


@contextlib.contextmanager
def no_file_above(n_bytes: int) -> Iterator[None]:
    """Let the system refuse to write beyond so many bytes of any file."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (n_bytes, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
