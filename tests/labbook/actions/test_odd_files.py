"""Files with odd names, too large ones, and large ones read from a mapping: taken in whole, or nothing is kept."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from data_schema.vocabulary import IngestStatus
from ingest import spool
from ingest.store import Store
from labbook.actions.files.ingesting import IngestRequest, ingest_file
from tests.helpers.books import SmallBook, small_book
from tests.helpers.statements import said_alike
from tests.ingest.bad_input import LOG

NAMES = [
    "log[1].csv",
    "log 'a' \"b\".csv",
    "two\nlines.csv",
    "\u202egpj.csv",
    "x" * 251 + ".csv",
    "log.csv",
    "LOG.CSV",
    "-rf",
    "%s{}",
    os.fsdecode(b"gr\xf6\xdfe.csv"),
]


@pytest.fixture
def book(tmp_path: Path) -> SmallBook:
    return small_book(tmp_path, runs=False, ingested=False)


def kept(store: Store) -> list[str]:
    return sorted(path.name for path in store.root.rglob("*") if path.is_file())


def test_odd_names_are_taken_as_they_are(book: SmallBook, tmp_path: Path) -> None:
    with book.open() as opened:
        for number, name in enumerate(NAMES):
            path = tmp_path / name
            path.write_bytes(LOG + f"# {number}\n".encode())
            outcome = ingest_file(opened, path, IngestRequest())
            known = "gr\\xf6\\xdfe.csv" if name.startswith("gr") else name  # what is no UTF-8 has a readable name
            assert (outcome.status, outcome.name) == (IngestStatus.IMPORTED, known)
            (last,) = said_alike(opened)[-1:]
            assert last.new is not None
            assert last.new["original_name"] == known


def test_a_file_beyond_the_bound_is_refused_and_nothing_of_it_kept(book: SmallBook, tmp_path: Path) -> None:
    book.toml.write_text(f"{book.toml.read_text()}\n[files.limits]\nlargest_file_bytes = 1000\n")
    path = tmp_path / "log.csv"
    path.write_bytes(LOG)
    with book.open() as opened:
        before = kept(opened.store)
        outcome = ingest_file(opened, path, IngestRequest())
        assert outcome.status is IngestStatus.REFUSED
        assert outcome.read is not None
        assert "largest_file_bytes" in outcome.read.findings[0].message
        assert kept(opened.store) == before


@pytest.mark.parametrize("data", [LOG, LOG.replace(b"[m]", b"[furlong]")])
def test_a_large_file_leaves_what_a_small_one_does(
    book: SmallBook, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, data: bytes
) -> None:
    path = tmp_path / "log.csv"
    path.write_bytes(data)
    with book.open() as opened:
        small = ingest_file(opened, path, IngestRequest(dry_run=True))
        before = kept(opened.store)
        monkeypatch.setattr(spool, "LARGE_BYTES", 1000)
        outcome = ingest_file(opened, path, IngestRequest())
        assert (outcome.sha256, outcome.status) == (small.sha256, small.status)
        new = [name for name in kept(opened.store) if name not in before]
        assert len(new) == (2 if outcome.status is IngestStatus.IMPORTED else 0)
        again = ingest_file(opened, path, IngestRequest())
        assert again.status is (IngestStatus.DUPLICATE if new else IngestStatus.REFUSED)
        assert len([name for name in kept(opened.store) if name not in before]) == len(new)
