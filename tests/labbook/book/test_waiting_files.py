"""A file that was imported once and that a newer reader refuses never stops a rebuild; a declaration mends it."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from data_schema.errors import UsageError
from data_schema.journal import Entry
from data_schema.queries.charges import charges_by_run
from data_schema.queries.imported_files import find_files, links_of_file
from data_schema.queries.readings import waiting_files
from data_schema.vocabulary import Action, FileRole, IngestStatus
from labbook.actions.files.assigning import assign
from labbook.actions.files.ingesting import IngestRequest, ingest_file
from labbook.actions.files.rereading import RereadRequest
from labbook.actions.files.stored_files import files_to_reread, list_files, reread_named
from labbook.actions.runs.correcting import correct
from labbook.actions.runs.jump_review import decide, review
from labbook.actions.runs.to_do import to_do, to_do_lines
from labbook.analysis.outcomes.detection import Detections
from labbook.analysis.study_data import gather
from labbook.book.naming import run_named
from labbook.book.opening import Book
from labbook.book.rebuilding import Rebuilt, rebuild_database
from tests.helpers.books import ADA, SmallBook, small_book
from tests.helpers.databases import all_rows_by_name
from tests.helpers.journals import renumbered
from tests.helpers.once import made_once
from tests.helpers.statements import in_file
from tests.helpers.wording import refuses, says

SHEET, LOG = "2021-06-14.csv", "r001.csv"


def read_otherwise(book: SmallBook, declared: Mapping[str, Mapping[str, Any]]) -> Rebuilt:
    """Rebuild from the journal of a labbook whose readers did as this one's do where something else is declared."""

    def said(entry: Entry) -> Entry:
        new = dict(entry.new or {})
        if entry.action not in (Action.INGEST, Action.READ) or new["original_name"] not in declared:
            return entry
        now = {**new["settings"]["declared"], **declared[new["original_name"]]}
        return replace(entry, new={**new, "settings": {**new["settings"], "declared": now}})

    with book.open() as standing:
        entries = renumbered([said(entry) for entry in in_file(standing)])
    book.journal.write_text("".join(entry.line + "\n" for entry in entries), encoding="utf-8")
    book.database.unlink()
    return rebuild_database(book.folder, lambda _step: None)


def as_by_another_labbook(book: SmallBook, names: tuple[str, ...]) -> Rebuilt:
    """Rebuild from the journal of a labbook with a format that this one does not have."""
    return read_otherwise(book, {name: {"format": "of_a_plugin"} for name in names})


def state(book: Book, say: Callable[[Any], object]) -> None:
    with book.session(ADA) as session:
        say(session)


def charge_of(book: Book, run: str) -> Any:
    with book.reading() as connection:
        return charges_by_run(connection).get(run_named(connection, run).uid, [None])[0]


@pytest.fixture
def waiting(tmp_path: Path) -> tuple[SmallBook, Rebuilt]:
    """A book with verdicts, corrections and assignments on a log and a sheet that this labbook cannot read."""

    def made(folder: Path) -> tuple[SmallBook, Rebuilt]:
        small = small_book(folder)
        with small.open() as book:
            uid = charge_of(book, "r002").uid
            state(
                book, lambda session: correct(book, session, f"charge:{uid}", ["charge_mah=77"], "the display said 77")
            )
            state(book, lambda session: assign(session, f"{SHEET}#3", "none", "another pack's"))
            state(book, lambda session: decide(book, session, "r001", [2], "reject", "touched_by_hand", None))
            state(book, lambda session: assign(session, LOG, "r003", "names were swapped"))
            state(book, lambda session: assign(session, LOG, "r001", "no, they were not"))
        return small, as_by_another_labbook(small, (SHEET, LOG))

    small, done = made_once("waiting-files", made)
    shutil.copytree(small.folder.parent, tmp_path, dirs_exist_ok=True)
    return SmallBook(tmp_path / "book", tmp_path / "instruments"), done


def test_it_is_listed_and_its_numbers_say_why_they_are_undefined(waiting: tuple[SmallBook, Rebuilt]) -> None:
    small, done = waiting
    assert len(done.differences.files_waiting) == 2
    assert all("of_a_plugin" in line and "labbook files reread" in line for line in done.differences.files_waiting)
    with small.open() as book, book.reading() as connection:
        assert {file.name for file in waiting_files(connection)} == {SHEET, LOG}
        remarks = {item.reading.name: item.remark for item in list_files(connection)}
        says(remarks[LOG], "for a declaration")
        lines = to_do_lines(to_do(Detections(connection, book.store), book.configuration, None))
        assert sum("waits for" in line for line in lines) == 2
        with refuses(UsageError, "r001.csv"):
            review(book, connection, "r001")
        evidence = gather(connection, book.configuration, None)
        run = run_named(connection, "r001")
        why = evidence.waits(run.uid, FileRole.LOG)
        assert why is not None
        assert "r001.csv waits" in why.reason


def test_a_declaration_mends_it_and_what_was_said_meanwhile_takes_effect(waiting: tuple[SmallBook, Rebuilt]) -> None:
    small, _done = waiting
    with small.open() as book:
        assert {row.name for row in files_to_reread(book, lambda _name: None)} == {SHEET, LOG}
        for name in (SHEET, LOG):
            done = reread_named(book, name, RereadRequest({}, ADA, "read by this labbook"))
            assert not done.read.refused
            says(done.changes, "for a declaration")
            assert done.verdicts_waiting == ()
        assert charge_of(book, "r002").charge_mah == 77
        assert charge_of(book, "r003") is None
        with book.reading() as connection:
            assert waiting_files(connection) == []
            found = review(book, connection, "r001")
        assert [item.excluded is None for item in found.jumps] == [True, False, True]
        rows = all_rows_by_name(book.engine)
    rebuild_database(small.folder, lambda _step: None)
    with small.open() as book:
        assert all_rows_by_name(book.engine) == rows


LINES = "run_a,first,second,minutes\nr001,150,,12\nr003,160,160,12\n"
PARTS = "".join(f"{4 * place},{0.4 + 0.001 * place:.4f}\n" for place in range(300))


def amounts(column: str) -> dict[str, Any]:
    """Read the sheet by one of its two columns of amounts; the second leaves its first row out."""
    return {"columns": {"run_a": {"channel": "run"}, column: {"channel": "charge", "unit": "mAh"}}}


def as_declared(column: str) -> dict[str, Any]:
    """The same as the journal has it."""
    said = {"channel": "charge", "unit": "mAh", "sign": 1}
    return {"columns": {"run_a": {"channel": "run", "unit": None, "sign": 1}, column: said}}


def take(book: Book, path: Path, text: str, options: dict[str, Any] | None = None, run: str | None = None) -> None:
    path.write_text(text)
    outcome = ingest_file(book, path, IngestRequest(run, options, person=ADA))
    assert outcome.status is IngestStatus.IMPORTED


def read_again(book: Book, name: str, options: dict[str, Any]) -> None:
    assert not reread_named(book, name, RereadRequest(options, ADA, "otherwise")).read.refused


def links(book: Book, name: str) -> dict[str, str]:
    with book.reading() as connection:
        (file,) = find_files(connection, name)
        return {link.part: link.run_name for link in links_of_file(connection, file.uid)}


def rebuilt_alike(small: SmallBook) -> None:
    with small.open() as book:
        rows = all_rows_by_name(book.engine)
    rebuild_database(small.folder, lambda _step: None)
    with small.open() as book:
        assert all_rows_by_name(book.engine) == rows


@pytest.fixture
def bare(tmp_path: Path) -> SmallBook:
    """A book with runs, and nothing of the instruments."""
    return small_book(tmp_path, ingested=False)


def test_a_reader_that_gives_fewer_rows_and_parts_stops_no_rebuild(bare: SmallBook, tmp_path: Path) -> None:
    with bare.open() as book:
        take(book, tmp_path / "s.csv", LINES, amounts("first"))
        take(book, tmp_path / "both.csv", f"time [ms],z\n{PARTS}# again\n{PARTS}", run="r001")
        uid = charge_of(book, "r001").uid
        state(book, lambda session: correct(book, session, f"charge:{uid}", ["charge_mah=77"], "the display said 77"))
        state(book, lambda session: assign(session, "s.csv#1", "r004", "of that run"))
        state(book, lambda session: assign(session, "both.csv#log_segment_2", "r002", "started again"))
    done = read_otherwise(bare, {"s.csv": as_declared("second"), "both.csv": {"footer": "# again"}})
    assert done.differences.files_waiting == ()
    assert [uid in sentence for sentence in done.differences.without_rows] == [True, True, False]
    with bare.open() as book:
        assert links(book, "both.csv") == {"log": "r001"}
        read_again(book, "s.csv", amounts("first"))
        assert charge_of(book, "r001") is None
        assert charge_of(book, "r004").charge_mah == 77
    rebuilt_alike(bare)
