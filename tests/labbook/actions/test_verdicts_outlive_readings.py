"""A verdict holds for every reading with the same times; where the times are others, it waits for a person."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from data_schema.queries.detections import verdicts_waiting
from data_schema.vocabulary import Action
from labbook.actions.files.assigning import assign
from labbook.actions.files.ingesting import IngestRequest, ingest_file
from labbook.actions.runs.jump_review import clear_waiting, decide, jump_lines, review
from labbook.actions.upkeep.health import check_book
from labbook.book.rebuilding import rebuild_database
from labbook.terminal import progress
from tests.helpers.books import ADA, SmallBook, small_book
from tests.helpers.databases import all_rows_by_name
from tests.helpers.journals import renumbered
from tests.helpers.statements import in_file
from tests.helpers.wording import says

OTHER_VALUES = {"columns": {"k_gain": {"channel": "own_gain", "unit": "1"}}}


@pytest.fixture
def judged(tmp_path: Path) -> SmallBook:
    small = small_book(tmp_path)
    with small.open() as book, book.session(ADA) as session:
        decide(book, session, "r001", [2], "reject", "touched_by_hand", None)
    return small


def again(small: SmallBook, options: dict[str, Any]) -> tuple[str, ...]:
    with small.open() as book:
        return ingest_file(book, small.log("r001"), IngestRequest(options=options, person=ADA)).messages


def excluded(small: SmallBook) -> list[bool]:
    with small.open() as book, book.reading() as connection:
        return [item.excluded is not None for item in review(book, connection, "r001").jumps]


def test_a_reading_with_the_same_times_keeps_its_verdicts(judged: SmallBook) -> None:
    assert not any("waiting for review" in line for line in again(judged, OTHER_VALUES))
    assert excluded(judged) == [False, True, False]
    rebuild_database(judged.folder, lambda _step: None)
    assert excluded(judged) == [False, True, False]


def test_a_reading_with_other_times_lets_verdicts_wait_by_name(judged: SmallBook) -> None:
    """The old answer: the verdict was silently lost, and `db check` said that the book was whole."""
    small = judged
    lines = small.log("r002").read_text().splitlines()
    height = lines[0].split(",").index("body_height [m]")
    path = small.instruments / "without_time.csv"
    path.write_text("".join(["z\n", *(f"{line.split(',')[height]}\n" for line in lines[1:])]))
    columns = {"columns": {"z": {"channel": "body_height", "unit": "m"}}}
    with small.open() as book:
        with book.session(ADA) as session:
            assign(session, "r002.csv", "none", "the other one")
        ingest_file(book, path, IngestRequest("r002", {**columns, "rate_hz": 300.0}, person=ADA))
        with book.session(ADA) as session:
            decide(book, session, "r002", [2], "reject", "touched_by_hand", None)
        said = ingest_file(book, path, IngestRequest(options={**columns, "rate_hz": 280.0}, person=ADA)).messages
    says(said, "waiting for review", "r002")
    found = check_book(judged.folder, lambda total: progress("checking", total, shown=False))
    assert (found.whole, found.verdicts_waiting) == (True, 1)
    with judged.open() as book:
        with book.reading() as connection:
            (waiting,) = verdicts_waiting(connection)
            lines = jump_lines(review(book, connection, "r002"))[2]
        assert waiting.sentence in lines
        with book.session(ADA) as session:
            assert clear_waiting(session, "r002", None) == 1
            assert clear_waiting(session, "r002", None) == 0
        rows = all_rows_by_name(book.engine)
    rebuild_database(judged.folder, lambda _step: None)
    with judged.open() as book:
        assert all_rows_by_name(book.engine) == rows


def test_samples_that_had_another_hash_under_an_earlier_reader_keep_their_verdicts(judged: SmallBook) -> None:
    """The journal says which hash the verdict is about, and that the times were the same."""

    def earlier(old: str) -> Callable[[Any], Any]:
        def said(entry: Any) -> Any:
            new = dict(entry.new or {})
            if entry.action is Action.INGEST and new["original_name"] == "r001.csv":
                return replace(entry, new={**new, "signals": ["0" * 64], "reader_version": 1})
            if entry.action is Action.DECIDE and new.get("signal_sha256") == old:
                return replace(entry, new={**new, "signal_sha256": "0" * 64})
            return entry

        return said

    with judged.open() as book:
        with book.reading() as connection:
            old = review(book, connection, "r001").signals[0].sha256
        entries = renumbered([earlier(old)(entry) for entry in in_file(book)])
    judged.journal.write_text("".join(entry.line + "\n" for entry in entries), encoding="utf-8")
    judged.database.unlink()
    rebuild_database(judged.folder, lambda _step: None)
    assert excluded(judged) == [False, True, False]
