"""What earlier labbooks read is compared with what comes of it now, and numbers that were printed stay known."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from data_schema.queries.history import list_reports
from data_schema.vocabulary import Action
from labbook.actions.upkeep.tracing import find_number, recompute, trace, trace_lines
from labbook.book.altered import Differences
from labbook.book.report_numbers import NUMBERS, numbers_bytes, numbers_path, read_numbers
from tests.helpers.books import SmallBook, reported_book
from tests.helpers.upkeep import rebuilt_as_said
from tests.helpers.wording import says

Words = dict[str, Any]


@pytest.fixture
def reported(tmp_path: Path) -> SmallBook:
    return reported_book(tmp_path, None, "foot=small")


def as_earlier(book: SmallBook, action: Action, said: Callable[[Words], Words]) -> Differences:
    """Rebuild from the journal that an earlier labbook would have written: in what it says of reports or files."""
    return rebuilt_as_said(
        book, lambda entry: replace(entry, new=said(dict(entry.new or {}))) if entry.action is action else entry
    ).differences


def test_numbers_of_an_earlier_algorithm_are_told_as_they_were_printed(reported: SmallBook) -> None:
    """Another version gives other ids and values: as if those on paper began with other letters, and were doubled."""
    with reported.open() as book, book.reading() as connection:
        report = list_reports(connection)[-1]
        numbers = read_numbers(book.store.root, report)
    uid, now = next((uid, number) for uid, number in numbers.numbers.items() if number.value)
    printed = replace(now, id=f"0ld{uid[3:]}", value=2.0 * (now.value or 0.0))
    data = numbers_bytes(replace(numbers, numbers={**numbers.numbers, printed.id: printed}))
    sha256 = hashlib.sha256(data).hexdigest()
    numbers_path(reported.folder, sha256).write_bytes(data)

    def earlier(said: Words) -> Words:
        if said["folder"] != report.folder:
            return said
        files = {**said["files"], NUMBERS: sha256}
        return {**said, "files": files, "versions": {**said["versions"], "run_energy": 0}}

    as_earlier(reported, Action.REPORT, earlier)
    with reported.open() as book:
        with book.reading() as connection:
            found = find_number(book, connection, printed.id)
            assert (found.number, [one.versions["run_energy"] for one in found.shown_in]) == (printed, [0])
            says(trace_lines(trace(connection, found)), repr(printed.value), f"report {report.called}")
        (checked,) = recompute(book, [found], lambda _step: None)
    assert checked.anew is not None
    assert (checked.anew.value, checked.differs, checked.stands) == (now.value, ("value",), None)
    says(checked.sentence, "other versions", "labbook reports diff")


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
