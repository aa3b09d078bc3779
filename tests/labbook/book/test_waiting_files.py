"""A file that was imported once and that a newer reader refuses never stops a rebuild; a declaration mends it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from data_schema.errors import UsageError
from data_schema.journal import Entry
from data_schema.queries.charges import charges_by_run
from data_schema.queries.readings import waiting_files
from data_schema.vocabulary import Action
from labbook.actions.assigning import assign
from labbook.actions.correcting import correct
from labbook.actions.jump_review import decide, review
from labbook.actions.kept_files import files_to_reread, list_files, reread_named
from labbook.actions.rereading import RereadRequest
from labbook.actions.to_do import to_do, to_do_lines
from labbook.analysis.detections import Detections
from labbook.analysis.gathering import gather
from labbook.book.naming import run_named
from labbook.book.opening import Book
from labbook.book.rebuilding import Rebuilt, rebuild_database
from tests.helpers.books import ADA, SmallBook, small_book
from tests.helpers.databases import all_rows_by_name
from tests.helpers.journals import renumbered
from tests.helpers.statements import in_file

SHEET, LOG = "2021-06-14.csv", "r001.csv"


def as_by_another_labbook(book: SmallBook, names: tuple[str, ...]) -> Rebuilt:
    """Rebuild from the journal of a labbook with a format that this one does not have."""

    def said(entry: Entry) -> Entry:
        new = dict(entry.new or {})
        if entry.action is not Action.INGEST or new["original_name"] not in names:
            return entry
        declared = {**new["settings"]["declared"], "format": "of_a_plugin"}
        return replace(entry, new={**new, "settings": {**new["settings"], "declared": declared}})

    with book.open() as standing:
        entries = renumbered([said(entry) for entry in in_file(standing)])
    book.journal.write_text("".join(entry.line + "\n" for entry in entries), encoding="utf-8")
    book.database.unlink()
    return rebuild_database(book.folder, lambda _step: None)


def state(book: Book, say: Callable[[Any], object]) -> None:
    with book.desk(ADA) as desk:
        say(desk)


def charge_of(book: Book, run: str) -> Any:
    with book.reading() as connection:
        return charges_by_run(connection).get(run_named(connection, run).uid, [None])[0]


@pytest.fixture
def waiting(tmp_path: Path) -> tuple[SmallBook, Rebuilt]:
    """A book with verdicts, corrections and assignments on a log and a sheet that this labbook cannot read."""
    small = small_book(tmp_path)
    with small.open() as book:
        uid = charge_of(book, "r002").uid
        state(book, lambda desk: correct(book, desk, f"charge:{uid}", ["charge_mah=77"], "the display said 77"))
        state(book, lambda desk: assign(desk, f"{SHEET}#3", "none", "another pack's"))
        state(book, lambda desk: decide(book, desk, "r001", [2], "reject", "touched_by_hand", None))
        state(book, lambda desk: assign(desk, LOG, "r003", "names were swapped"))
        state(book, lambda desk: assign(desk, LOG, "r001", "no, they were not"))
    return small, as_by_another_labbook(small, (SHEET, LOG))


def test_it_is_listed_and_its_numbers_say_why_they_are_undefined(waiting: tuple[SmallBook, Rebuilt]) -> None:
    small, done = waiting
    assert len(done.differences.files_waiting) == 2
    assert all("of_a_plugin" in line and "labbook files reread" in line for line in done.differences.files_waiting)
    with small.open() as book, book.reading() as connection:
        assert {file.name for file in waiting_files(connection)} == {SHEET, LOG}
        remarks = {item.reading.name: item.remark for item in list_files(connection)}
        assert remarks[LOG].startswith("waits for a declaration: ")
        lines = to_do_lines(to_do(Detections(connection, book.store), book.configuration, None))
        assert sum("waits for a declaration" in line for line in lines) == 2
        with pytest.raises(UsageError, match=r"log r001.csv waits for a declaration"):
            review(book, connection, "r001")
        evidence = gather(connection, book.configuration, None)
        run = run_named(connection, "r001")
        assert "r001.csv waits" in (
            evidence.waits(run.uid, evidence.logs[run_named(connection, "r002").uid][0].role) or ""
        )


def test_a_declaration_mends_it_and_what_was_said_meanwhile_takes_effect(waiting: tuple[SmallBook, Rebuilt]) -> None:
    small, _done = waiting
    with small.open() as book:
        assert {row.name for row in files_to_reread(book, lambda _name: None)} == {SHEET, LOG}
        for name in (SHEET, LOG):
            done = reread_named(book, name, RereadRequest({}, ADA, "read by this labbook"), keep_options=True)
            assert not done.read.refused
            assert "the file waited for a declaration and is read now" in done.changes
            assert done.waiting == ()
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
