"""What earlier labbooks printed and read is compared with what comes of it now, and stays known whatever comes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from data_schema.errors import UnknownName
from data_schema.journal import Entry
from data_schema.vocabulary import Action
from labbook.actions.report_command import state_report
from labbook.actions.upkeep.tracing import PrintedNumber, trace, trace_lines
from labbook.analysis.algorithms import versions_now
from labbook.book.differing import Differences
from labbook.book.rebuilding import rebuild_database
from tests.helpers.books import ADA, SmallBook, copy_of, small_book
from tests.helpers.journals import renumbered
from tests.helpers.statements import in_file
from tests.helpers.wording import says

Words = dict[str, Any]


@pytest.fixture
def reported(tmp_path: Path) -> SmallBook:
    def made(folder: Path) -> SmallBook:
        small = small_book(folder)
        with small.open() as book:
            state_report(book, None, ADA, lambda _step: None)
            state_report(book, "foot=small", ADA, lambda _step: None)
        return small

    return copy_of("reported-twice", made, tmp_path)


def as_earlier(book: SmallBook, action: Action, said: Callable[[Words], Words]) -> Differences:
    """Rebuild from the journal that an earlier labbook would have written: in what it says of reports or files."""

    def earlier(entry: Entry) -> Entry:
        return replace(entry, new=said(dict(entry.new or {}))) if entry.action is action else entry

    with book.open() as standing:
        entries = renumbered([earlier(entry) for entry in in_file(standing)])
    book.journal.write_text("".join(entry.line + "\n" for entry in entries), encoding="utf-8")
    book.database.unlink()
    return rebuild_database(book.folder, lambda _step: None).differences


def reports(book: SmallBook) -> list[Entry]:
    with book.open() as standing:
        return [entry for entry in in_file(standing) if entry.action is Action.REPORT]


def test_numbers_of_an_earlier_algorithm_are_kept_and_told(reported: SmallBook) -> None:
    """Another version gives other ids: as if those on paper began with other letters."""
    before = [entry.new["shown"] for entry in reports(reported) if entry.new]
    old = {uid: f"0ld{uid[3:]}" for shown in before for uid in list(shown)[:5]}

    def earlier(said: Words) -> Words:
        shown = {old.get(uid, uid): value for uid, value in said["shown"].items()}
        return {**said, "shown": shown, "versions": {**said["versions"], "run_energy": 0}}

    found = as_earlier(reported, Action.REPORT, earlier)
    gone = sum(uid in old for shown in before for uid in shown)
    assert found == Differences(numbers_gone=gone, reports_concerned=2, other_versions=True)
    assert found.sentences[0].startswith(f"{gone} shown numbers of 2")  # how many varies with the book's ids
    with reported.open() as book, book.reading() as connection:
        for uid, as_printed in old.items():
            told = trace(connection, as_printed)
            assert isinstance(told, PrintedNumber)
            assert told.uid == as_printed
            value = next(shown[uid] for shown in before if uid in shown)
            assert told.value == value
            lines = trace_lines(told)
            assert lines[0] == f"{as_printed}: printed as {'undefined' if value is None else repr(value)}"
            assert [line.split(" ")[3] for line in lines[1:-1]] == [
                entry.entity_uid for entry in reports(reported) if as_printed in (entry.new or {})["shown"]
            ]
            assert all("run_energy 0" in line for line in lines[1:-1])
            assert "computes it anew" in lines[-1]
            assert f"run_energy {versions_now()['run_energy']}" in lines[-1]
        with pytest.raises(UnknownName, match="several numbers"):
            trace(connection, "0ld")


@pytest.mark.parametrize("same", [pytest.param(True, marks=pytest.mark.soak), False])
def test_files_read_by_an_earlier_reader_are_counted(reported: SmallBook, same: bool) -> None:
    def earlier(said: Words) -> Words:
        if said["original_name"] not in ("r001.csv", "r002.csv"):
            return said
        rows = said["rows"] if same else {**said["rows"], "kept": said["rows"]["kept"] - 1}
        return {**said, "reader_version": said["reader_version"] - 1, "rows": rows}

    found = as_earlier(reported, Action.INGEST, earlier)
    assert found == Differences(files_read_anew=2, files_changed=0 if same else 2, other_versions=True)
    result = "with the same result" if same else "2 of them with another result"
    says(found.sentences, "2 files", "another version", result)
