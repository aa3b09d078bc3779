"""A rebuild of many files reads them in other processes: the rows are the same, and no process outlives it."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

import pytest

from data_schema.errors import BookDamaged
from data_schema.file_cache import CACHE_VARIABLE
from labbook.actions.files.ingesting import IngestRequest, ingest_file
from labbook.book import replaying
from tests.helpers.books import SmallBook, small_book
from tests.helpers.hopping_log import hopping_log
from tests.helpers.upkeep import rebuilt, rows_with_keys

FEW, MANY = 8, 12
"""From so many files on others read them here, and of so many further ones each book has logs."""


@pytest.fixture(autouse=True)
def _few_are_enough_and_none_is_known(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(replaying, "FEWEST", FEW)
    monkeypatch.setenv(CACHE_VARIABLE, str(tmp_path / "cache"))
    (tmp_path / "cache").mkdir(mode=0o700)


@pytest.fixture(scope="module")
def full(tmp_path_factory: pytest.TempPathFactory) -> SmallBook:
    """A book with many logs, some of which nothing is found in, and files that are refused."""
    made = small_book(tmp_path_factory.mktemp("full"))
    folder = made.folder.parent / "more"
    folder.mkdir()
    with made.open() as book:
        for number in range(MANY):
            path = folder / f"log{number}.csv"
            path.write_bytes(hopping_log(jumps=1 + number % 4) + b"\n" * number)
            ingest_file(book, path, IngestRequest())
    return made


def _copy(full: SmallBook, folder: Path) -> SmallBook:
    shutil.copytree(full.folder, folder / "book")
    return SmallBook(folder / "book", full.instruments)


@pytest.mark.soak
def test_a_raw_copy_that_is_gone_is_named_and_nothing_is_changed(full: SmallBook, tmp_path: Path) -> None:
    book = _copy(full, tmp_path)
    gone = sorted((book.folder / "raw").rglob("*.zst"))[MANY // 2]
    gone.unlink()
    with pytest.raises(BookDamaged, match=gone.name):
        rebuilt(book)
    assert rows_with_keys(book.database) == rows_with_keys(full.database)
    assert not any(map(_is_reader, _children(os.getpid())))


def test_the_rows_are_those_of_the_ingest_and_samples_that_are_gone_are_written_again(
    full: SmallBook, tmp_path: Path
) -> None:
    book = _copy(full, tmp_path)
    shutil.rmtree(book.folder / "signals")
    rebuilt(book)
    assert rows_with_keys(book.database) == rows_with_keys(full.database)
    kept = {path.relative_to(full.folder): path.read_bytes() for path in (full.folder / "signals").rglob("*.parquet")}
    now = {path.relative_to(book.folder): path.read_bytes() for path in (book.folder / "signals").rglob("*.parquet")}
    assert now == kept


@pytest.mark.soak
def test_readers_of_a_killed_rebuild_end_by_themselves(full: SmallBook, tmp_path: Path) -> None:
    book = _copy(full, tmp_path)
    code = "import sys; from pathlib import Path; from labbook.book import reading_ahead, rebuilding\n"
    code += f"reading_ahead.FEWEST = {FEW}\n"
    code += "rebuilding.rebuild_database(Path(sys.argv[1]), lambda _step: print(input(), flush=True))"
    words = [sys.executable, "-c", code, str(book.folder)]
    with subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as process:
        assert process.stdin is not None
        process.stdin.write(b"one step\n")  # before the next it waits
        process.stdin.flush()
        assert process.stdout is not None
        process.stdout.readline()
        readers = _children(process.pid)
        process.kill()
    assert readers
    deadline = time.monotonic() + 30
    while any(Path(f"/proc/{reader}/cmdline").exists() and _is_reader(reader) for reader in readers):
        assert time.monotonic() < deadline
        time.sleep(0.05)
    rebuilt(book)
    assert rows_with_keys(book.database) == rows_with_keys(full.database)


def _children(pid: int) -> list[int]:
    return [int(word) for word in Path(f"/proc/{pid}/task/{pid}/children").read_text().split()]


def _is_reader(pid: int) -> bool:
    try:
        return b"spawn_main" in Path(f"/proc/{pid}/cmdline").read_bytes()
    except OSError:
        return False
