"""Charger sheets in one archive or workbook: lines repeat from member to member, and each charge is one of its own."""

from __future__ import annotations

import gzip
import io
import zipfile
from collections.abc import Callable
from pathlib import Path

import pytest

from data_schema.queries.charges import charges_by_run
from labbook.actions.files.assigning import assign
from labbook.actions.files.ingesting import IngestRequest, ingest_file
from labbook.actions.files.rereading import RereadRequest
from labbook.actions.files.stored_files import reread_named, restore, withdraw
from labbook.actions.runs.correcting import correct
from labbook.book.naming import run_named
from labbook.book.opening import Book
from tests.helpers.books import ADA, SmallBook, small_book
from tests.ingest.synthetic_workbooks import workbook
from tests.labbook.actions.test_sheets_read_again import charges, rebuilt_alike

HEADER = "run,charge,other,minutes"
MON, WED = ("r001,150,150,12", "r002,160,,12"), ("r003,170,170,12", "r004,180,180,12")
ALL = {"r001": [150.0], "r002": [160.0], "r003": [170.0], "r004": [180.0]}


def zipped(*members: tuple[str, bytes]) -> bytes:
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in members:
            archive.writestr(name, data)
    return packed.getvalue()


def text(rows: tuple[str, ...]) -> bytes:
    return "\n".join([HEADER, *rows, ""]).encode()


def sheets() -> bytes:
    def cells(rows: tuple[str, ...]) -> list[list[str | float]]:
        named = [row.split(",") for row in rows]
        return [HEADER.split(","), *([run, *(float(cell) if cell else "" for cell in row)] for run, *row in named)]

    return workbook({"mon": cells(MON), "wed": cells(WED)})


FILES: dict[str, Callable[[], bytes]] = {
    "c.zip": lambda: zipped(("mon.csv", text(MON)), ("wed.csv", text(WED))),
    "same_names.zip": lambda: zipped(("a/c.csv", text(MON)), ("b/c.csv", text(WED))),
    "c.xlsx": sheets,
    "nested.zip": lambda: zipped(("c.xlsx", sheets())),
    "c.zip.gz": lambda: gzip.compress(zipped(("mon.csv", text(MON)), ("wed.csv", text(WED)))),
}


def column(name: str = "charge") -> dict[str, object]:
    return {"columns": {name: {"channel": "charge", "unit": "mAh"}}}


def take(book: Book, folder: Path, name: str, data: bytes) -> None:
    path = folder / name
    path.write_bytes(data)
    outcome = ingest_file(book, path, IngestRequest(options=column(), person=ADA))
    assert outcome.read is not None
    assert not outcome.read.refused, outcome.read.findings


def read_again(book: Book, name: str, by: str) -> None:
    assert not reread_named(book, name, RereadRequest(column(by), ADA, "otherwise")).read.refused


@pytest.fixture
def small(tmp_path: Path) -> SmallBook:
    return small_book(tmp_path, ingested=False)


@pytest.mark.parametrize("name", FILES)
def test_the_book_holds_every_charge_of_every_sheet(small: SmallBook, tmp_path: Path, name: str) -> None:
    with small.open() as book:
        take(book, tmp_path, name, FILES[name]())
        assert charges(book) == ALL
        with book.session(ADA) as session:
            withdraw(session, name, "a draft")
        assert not any(charges(book).values())
        with book.session(ADA) as session:
            restore(session, name, None)
        assert charges(book) == ALL
    rebuilt_alike(small)


@pytest.mark.parametrize("name", ["c.zip", "c.xlsx"])
def test_what_was_said_of_a_charge_stays_with_its_sheet(small: SmallBook, tmp_path: Path, name: str) -> None:
    """Read by the other column, the first sheet lacks the row in whose line a charge of the second one stands."""
    with small.open() as book:
        take(book, tmp_path, name, FILES[name]())
        with book.reading() as connection:
            uid = charges_by_run(connection)[run_named(connection, "r004").uid][0].uid
        with book.session(ADA) as session:
            correct(book, session, f"charge:{uid}", ["charge_mah=181"], "the display said 181")
        with book.session(ADA) as session:
            assign(session, f"{name}#2", "none", "another pack's")
        corrected = {**ALL, "r002": [], "r004": [181.0]}
        assert charges(book) == corrected
        read_again(book, name, "other")
        assert charges(book) == corrected
        with book.session(ADA) as session:
            withdraw(session, name, "a draft")
        with book.session(ADA) as session:
            restore(session, name, None)
        assert charges(book) == corrected
        read_again(book, name, "charge")
        assert charges(book) == corrected
    rebuilt_alike(small)


def test_charges_that_come_with_another_reading_are_all_held(small: SmallBook, tmp_path: Path) -> None:
    with small.open() as book:
        path = tmp_path / "c.zip"
        path.write_bytes(FILES["c.zip"]())
        ingest_file(book, path, IngestRequest(options=column("other"), person=ADA))
        assert charges(book) == {**ALL, "r002": []}
        read_again(book, "c.zip", "charge")
        assert charges(book) == ALL
    rebuilt_alike(small)
