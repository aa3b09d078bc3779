"""A file that was imported once and that a newer reader refuses never stops a rebuild; a declaration mends it."""

from __future__ import annotations

import shutil
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from data_schema.errors import UsageError
from data_schema.journal import Entry
from data_schema.queries.files import find_files, links_of_file, waiting_files
from data_schema.vocabulary import FileRole
from labbook.actions.files.assigning import assign
from labbook.actions.files.rereading import RereadRequest
from labbook.actions.files.stored_files import files_to_reread, list_files, reread_named
from labbook.actions.runs.jump_review import decide, review
from labbook.analysis.study_data import gather
from labbook.book.naming import run_named
from labbook.book.rebuilding import Rebuilt
from tests.helpers.attention import found_in
from tests.helpers.books import ADA, SmallBook, small_book
from tests.helpers.desk import Desk, desk_at
from tests.helpers.once import made_once
from tests.helpers.upkeep import rebuilt_alike, rebuilt_as_said
from tests.helpers.wording import refuses, says

SHEET, LOG = "2021-06-14.csv", "r001.csv"


def read_otherwise(book: SmallBook, declared: Mapping[str, Mapping[str, Any]]) -> Rebuilt:
    """Rebuild from the journal of a labbook whose readers did as this one's do where something else is declared."""

    def said(entry: Entry) -> Entry:
        new = dict(entry.new or {})
        if not entry.reads or new["original_name"] not in declared:
            return entry
        now = {**new["settings"]["declared"], **declared[new["original_name"]]}
        return replace(entry, new={**new, "settings": {**new["settings"], "declared": now}})

    return rebuilt_as_said(book, said)


@pytest.fixture
def waiting(tmp_path: Path) -> tuple[SmallBook, Rebuilt]:
    """A book with verdicts, corrections and assignments on a log and a sheet of a format that this labbook lacks."""

    def made(folder: Path) -> tuple[SmallBook, Rebuilt]:
        small = small_book(folder)
        with small.open() as book:
            desk = Desk(small, book, folder)
            desk.correct_charge("r002", "charge_mah=77")
            desk.say(assign, f"{SHEET}#3", "none", "another pack's")
            desk.say(decide, "r001", [2], "reject", "touched_by_hand", None)
            desk.say(assign, LOG, "r003", "names were swapped")
            desk.say(assign, LOG, "r001", "no, they were not")
        return small, read_otherwise(small, {name: {"format": "of_a_plugin"} for name in (SHEET, LOG)})

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
        assert {one.file for one in found_in(book)["file_waits"]} == {SHEET, LOG}
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
        charges = Desk(small, book, small.folder).charges()
        assert (charges["r002"], charges["r003"]) == ([77], [])
        with book.reading() as connection:
            assert waiting_files(connection) == []
            found = review(book, connection, "r001")
        assert [item.excluded is None for item in found.jumps] == [True, False, True]
    rebuilt_alike(small)


LINES = "run_a,first,second,minutes\nr001,150,,12\nr003,160,160,12\n"
PARTS = "".join(f"{4 * place},{0.4 + 0.001 * place:.4f}\n" for place in range(300))


def as_declared(column: str) -> dict[str, Any]:
    """Read the sheet by one of its two columns of amounts, as the journal has it; the second leaves its first row out.

    A person may declare the same.
    """
    said = {"channel": "charge", "unit": "mAh", "sign": 1}
    return {"columns": {"run_a": {"channel": "run", "unit": None, "sign": 1}, column: said}}


def test_a_reader_that_gives_fewer_rows_and_parts_stops_no_rebuild(tmp_path: Path) -> None:
    with desk_at(tmp_path) as desk:
        desk.take("s.csv", LINES, as_declared("first"))
        desk.take("both.csv", f"time [ms],z\n{PARTS}# again\n{PARTS}", run="r001")
        uid = desk.uid_of("r001")
        desk.correct_charge("r001", "charge_mah=77")
        desk.say(assign, "s.csv#1", "r004", "of that run")
        desk.say(assign, "both.csv#log_segment_2", "r002", "started again")
    done = read_otherwise(desk.small, {"s.csv": as_declared("second"), "both.csv": {"footer": "# again"}})
    assert done.differences.files_waiting == ()
    assert [uid in sentence for sentence in done.differences.without_rows] == [True, True, False]
    with desk.small.open() as book:
        again = replace(desk, book=book)
        with book.reading() as connection:
            (file,) = find_files(connection, "both.csv")
            assert {link.part: link.run_name for link in links_of_file(connection, file.uid)} == {"log": "r001"}
        again.read_again("s.csv", as_declared("first"))
        assert (again.charges()["r001"], again.charges()["r004"]) == ([], [77])
    rebuilt_alike(desk.small)
