"""A run that was started again leaves several logs: they are one run's jumps, where a person says there were starts."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from data_schema.errors import UsageError
from data_schema.outcomes import Outcome
from labbook.actions.files.ingesting import FileOutcome, IngestRequest, ingest_file
from labbook.actions.report_command import state_report
from labbook.actions.runs.correcting import correct
from labbook.actions.runs.jump_review import decide, review
from labbook.actions.runs.rig_line import rig_lines_of
from labbook.book.opening import Book
from tests.helpers.books import ADA, instrument_files, small_book
from tests.helpers.wording import refuses, says

RUN = "r001"
WHOLE = instrument_files()[f"logs/{RUN}.csv"]


@pytest.fixture
def book(tmp_path: Path) -> Iterator[Book]:
    with small_book(tmp_path, ingested=False).open() as book:
        yield book


@pytest.fixture
def whole_m(tmp_path: Path) -> list[float | None]:
    """The heights of the run in a book that has its log as it was made."""
    with small_book(tmp_path / "whole").open() as book:
        return heights_m(book)


@pytest.fixture
def halves(tmp_path: Path) -> tuple[bytes, bytes]:
    """The log cut after its first jump; the second half has a clock from 0."""
    with small_book(tmp_path / "cut").open() as other, other.reading() as connection:
        first = review(other, connection, RUN).jumps[0].jump
    assert first.apex_s is not None
    head, *rows = WHOLE.decode().splitlines(keepends=True)
    cut_ms = 1000.0 * (first.apex_s + 2.0)
    times = [float(row.split(",", 1)[0]) for row in rows]
    at = next(index for index, time in enumerate(times) if time - times[0] > cut_ms)
    later = [f"{time - times[at]:.3f},{row.split(',', 1)[1]}" for time, row in zip(times[at:], rows[at:], strict=True)]
    return (head + "".join(rows[:at])).encode(), (head + "".join(later)).encode()


def ingest(book: Book, folder: Path, name: str, content: bytes) -> FileOutcome:
    (folder / name).write_bytes(content)
    outcome = ingest_file(book, folder / name, IngestRequest(run=RUN, person=ADA))
    assert outcome.status == "imported", outcome
    return outcome


def started_twice(book: Book) -> None:
    with book.session(ADA) as session:
        correct(book, session, RUN, ["starts=2"], "power button pressed")


def heights_m(book: Book) -> list[float | None]:
    with book.reading() as connection:
        return [item.jump.apex_height_m for item in review(book, connection, RUN).jumps]


def without_heights(book: Book) -> set[str]:
    """The runs of a report that have no apex heights."""
    measured = state_report(book, None, ADA, lambda _step: None).measured
    return {run.name for run in measured.evidence.runs if run.uid in measured.results[Outcome.APEX].missing}


@pytest.mark.parametrize(("names", "order"), [(("first.csv", "second.csv"), 1), (("LOG9.csv", "LOG10.csv"), -1)])
def test_two_logs_of_two_starts_are_one_run(
    names: tuple[str, str],
    order: int,
    book: Book,
    halves: tuple[bytes, bytes],
    whole_m: list[float | None],
    tmp_path: Path,
) -> None:
    for name, content in list(zip(names, halves, strict=True))[::order]:
        outcome = ingest(book, tmp_path, name, content)
    ((line, again),) = rig_lines_of(book, [outcome])
    says(line.text, "2 log", "1 start")
    assert again.text.startswith("look again: ")
    with book.reading() as connection, refuses(UsageError, "2 log", "1 start"):
        review(book, connection, RUN)
    assert RUN in without_heights(book)
    started_twice(book)
    assert heights_m(book) == pytest.approx(whole_m, abs=1e-4)
    assert RUN not in without_heights(book)
    ((line,),) = rig_lines_of(book, [outcome])
    says(line.text, "3 jumps", "2 logs")


def test_a_clock_that_starts_again_within_a_file_is_one_run(
    book: Book, halves: tuple[bytes, bytes], whole_m: list[float | None], tmp_path: Path
) -> None:
    first, second = halves
    ingest(book, tmp_path, "both.csv", first + second.split(b"\n", 1)[1])
    with book.reading() as connection:
        found = review(book, connection, RUN)
    assert len(found.signals) == 2
    assert [item.jump.number for item in found.jumps] == [1, 2, 3]
    assert heights_m(book) == pytest.approx(whole_m, abs=1e-4)
    with book.session(ADA) as session:
        decide(book, session, RUN, [2], "reject", "misfire", None)
    with book.reading() as connection:
        assert [item.excluded is None for item in review(book, connection, RUN).jumps] == [True, False, True]


def test_the_same_samples_saved_twice_are_one_log(book: Book, whole_m: list[float | None], tmp_path: Path) -> None:
    ingest(book, tmp_path, "as_logged.csv", WHOLE)
    ingest(book, tmp_path, "saved_again.csv", WHOLE.replace(b"\n", b"\r\n"))
    for say in (lambda _book: None, started_twice):
        say(book)
        assert heights_m(book) == whole_m
        assert RUN not in without_heights(book)
