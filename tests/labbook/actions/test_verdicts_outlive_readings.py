"""A verdict holds for every reading with the same times; where the times are others, it waits for a person."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from data_schema.journal import Entry
from data_schema.queries.detections import verdicts_waiting
from labbook.actions.files.assigning import assign
from labbook.actions.files.ingesting import IngestRequest, ingest_file
from labbook.actions.runs.jump_review import clear_waiting, decide, jump_lines, review
from tests.helpers.books import ADA, SmallBook, small_book
from tests.helpers.statements import state
from tests.helpers.upkeep import health, rebuilt, rebuilt_alike, rebuilt_as_said
from tests.helpers.wording import says

OTHER_VALUES = {"columns": {"k_gain": {"channel": "own_gain", "unit": "1"}}}


@pytest.fixture
def judged(tmp_path: Path) -> SmallBook:
    small = small_book(tmp_path)
    with small.open() as book:
        state(book, decide, "r001", [2], "reject", "touched_by_hand", None)
    return small


def excluded(small: SmallBook) -> list[bool]:
    with small.open() as book, book.reading() as connection:
        return [item.excluded is not None for item in review(book, connection, "r001").jumps]


def test_a_reading_with_the_same_times_keeps_its_verdicts(judged: SmallBook) -> None:
    with judged.open() as book:
        said = ingest_file(book, judged.log("r001"), IngestRequest(options=OTHER_VALUES, person=ADA)).messages
    assert not any("waiting for review" in line for line in said)
    assert excluded(judged) == [False, True, False]
    rebuilt(judged)
    assert excluded(judged) == [False, True, False]


def test_a_reading_with_other_times_lets_verdicts_wait_by_name(judged: SmallBook) -> None:
    lines = judged.log("r002").read_text().splitlines()
    height = lines[0].split(",").index("body_height [m]")
    path = judged.instruments / "without_time.csv"
    path.write_text("".join(["z\n", *(f"{line.split(',')[height]}\n" for line in lines[1:])]))
    columns = {"columns": {"z": {"channel": "body_height", "unit": "m"}}}
    with judged.open() as book:
        state(book, assign, "r002.csv", "none", "the other one")
        ingest_file(book, path, IngestRequest("r002", {**columns, "rate_hz": 300.0}, person=ADA))
        state(book, decide, "r002", [2], "reject", "touched_by_hand", None)
        said = ingest_file(book, path, IngestRequest(options={**columns, "rate_hz": 280.0}, person=ADA)).messages
    says(said, "waiting for review", "r002")
    found = health(judged)
    assert (found.whole, found.verdicts_waiting) == (True, 1)
    with judged.open() as book:
        with book.reading() as connection:
            (waiting,) = verdicts_waiting(connection)
            lines = jump_lines(review(book, connection, "r002"))[2]
        assert waiting.sentence in lines
        assert [state(book, clear_waiting, "r002", None, None) for _ in range(2)] == [1, 0]
    rebuilt_alike(judged)


def test_samples_that_had_another_hash_under_an_earlier_reader_keep_their_verdicts(judged: SmallBook) -> None:
    """The journal says which hash the verdict is about, and that the times were the same."""
    with judged.open() as book, book.reading() as connection:
        old = review(book, connection, "r001").signals[0].sha256

    def earlier(entry: Entry) -> Entry:
        new = dict(entry.new or {})
        if entry.reads and entry.old is None and new["original_name"] == "r001.csv":
            return replace(entry, new={**new, "signals": ["0" * 64], "reader_version": 1})
        if entry.entity_kind == "decision" and new.get("signal_sha256") == old:
            return replace(entry, new={**new, "signal_sha256": "0" * 64})
        return entry

    rebuilt_as_said(judged, earlier)
    assert excluded(judged) == [False, True, False]
