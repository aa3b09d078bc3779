"""What was read of a file is known again: a replay reads no raw copy, unless it is asked to."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from data_schema.errors import BookDamaged
from data_schema.file_cache import CACHE_VARIABLE
from data_schema.queries.history import list_reports
from labbook.actions.files.ingesting import IngestRequest, ingest_file
from labbook.actions.upkeep.tracing import ReportOfNumber, recompute
from labbook.book.report_numbers import read_numbers
from tests.helpers.books import ADA, SmallBook, small_book
from tests.helpers.upkeep import health, rebuilt, rows_with_keys
from tests.helpers.whole_book import copy_of_whole_book


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = tmp_path / "cache"
    folder.mkdir(mode=0o700)
    monkeypatch.setenv(CACHE_VARIABLE, str(folder))
    return folder


def spoil_raw_copies(book: SmallBook) -> int:
    copies = list((book.folder / "raw").rglob("*.zst"))
    for path in copies:
        path.chmod(0o644)
        path.write_bytes(b"")
    return len(copies)


def test_a_check_reads_again_what_is_not_known_and_a_deep_one_and_a_recomputed_number_everything(
    tmp_path: Path, cache: Path
) -> None:
    book = copy_of_whole_book(tmp_path)
    assert health(book).problems == ()  # with a cache that is empty, and fills
    with book.open() as standing, standing.reading() as connection:
        report = list_reports(connection)[-1]
        numbers = read_numbers(standing.store.root, report)
        of_report = ReportOfNumber(next(iter(numbers.numbers.values())), numbers, (report,))
    n_copies = spoil_raw_copies(book)
    assert len(health(book).problems) == n_copies
    assert len(health(book, deep=True).problems) == n_copies + 1
    with book.open() as standing, pytest.raises(BookDamaged, match="raw copy"):
        recompute(standing, [of_report], lambda _step: None)
    for path in cache.rglob("*"):
        if path.is_file():
            path.write_bytes(b"not a reading")
    assert len(health(book).problems) == n_copies + 1


def test_a_rebuild_of_what_is_known_gives_the_same_rows_and_writes_samples_that_are_gone(
    tmp_path: Path, cache: Path
) -> None:
    book = small_book(tmp_path)
    log = tmp_path / "standing.csv"
    log.write_text("time [s],body_height [m]\n" + "".join(f"{n / 300:.4f},{0.3 + n * 1e-6:.6f}\n" for n in range(3000)))
    with book.open() as standing:
        done = ingest_file(standing, log, IngestRequest(run="r001", person=ADA))
        assert done.read is not None
        assert any("No jump can be found" in finding.message for finding in done.read.findings)
    before = rows_with_keys(book.database)
    samples = {path: path.read_bytes() for path in (book.folder / "signals").rglob("*.parquet")}
    shutil.rmtree(next(iter(samples)).parent)
    for times in range(2):
        assert rebuilt(book).altered == (), times
        assert rows_with_keys(book.database) == before
    assert {path: path.read_bytes() for path in samples} == samples
