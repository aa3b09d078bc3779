"""How a command that a page gives ended is told apart: what was given, a book that is busy, and all else."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from data_schema.disk import exclusive_lock
from data_schema.errors import BookBusy, BookError, InputRefused
from labbook.book.rebuilding import REBUILDING
from labbook.web.commands import command
from tests.helpers.books import SmallBook, small_book
from tests.helpers.wording import refuses


@pytest.fixture
def book(tmp_path: Path) -> SmallBook:
    """On SQLite alone, for its file is damaged."""
    return small_book(tmp_path)


def test_a_busy_book_alone_is_busy(book: SmallBook) -> None:
    with book.open() as opened:
        with exclusive_lock(opened.mirror.path, REBUILDING), refuses(BookBusy, "rebuilding"):
            command(opened, "rebuild")
        with refuses(InputRefused, "r999"):
            command(opened, "show", "r999")
        with book.database.open("r+b") as database:
            database.write(b"no database at all")
        with refuses(BookError, "labbook rebuild") as caught:
            command(opened, "show", "r001")
    assert not isinstance(caught.value, BookBusy)


def test_a_command_that_ends_without_a_message_says_how(
    book: SmallBook, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    first = tmp_path / "first"
    first.mkdir()
    (first / "sitecustomize.py").write_text("import os, signal\nos.kill(os.getpid(), signal.SIGKILL)\n")
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(first), os.environ.get("PYTHONPATH", "")]))
    with book.open() as opened, refuses(BookError, "labbook show r001", "ended with -9"):
        command(opened, "show", "r001")
