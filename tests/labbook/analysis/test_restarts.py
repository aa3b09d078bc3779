"""A run that was started again leaves several logs: they are one run's jumps, where a person says there were starts."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from data_schema.errors import UsageError
from data_schema.outcomes import Outcome
from labbook.actions.files.ingesting import IngestRequest, ingest_file
from labbook.actions.report_command import state_report
from labbook.actions.runs.correcting import correct
from labbook.actions.runs.jump_review import decide, review
from labbook.actions.runs.rig_line import rig_lines_of
from labbook.book.opening import Book
from tests.helpers.books import ADA, SmallBook, small_book
from tests.helpers.wording import refuses, says

RUN = "r001"


@pytest.fixture
def made(tmp_path: Path) -> SmallBook:
    return small_book(tmp_path, ingested=False)


@pytest.fixture
def book(made: SmallBook) -> Iterator[Book]:
    with made.open() as book:
        yield book


def halves(made: SmallBook) -> tuple[bytes, bytes, int]:
    """The log cut after its first jump, the second half with a clock from 0, and how many jumps came before."""
    whole = small_book(made.folder.parent / "whole")
    with whole.open() as other, other.reading() as connection:
        first = review(other, connection, RUN).jumps[0].jump
    assert first.apex_s is not None
    head, *rows = made.log(RUN).read_text().splitlines(keepends=True)
    cut_ms = 1000.0 * (first.apex_s + 2.0)
    times = [float(row.split(",", 1)[0]) for row in rows]
    at = next(index for index, time in enumerate(times) if time - times[0] > cut_ms)
    later = [f"{time - times[at]:.3f},{row.split(',', 1)[1]}" for time, row in zip(times[at:], rows[at:], strict=True)]
    return (head + "".join(rows[:at])).encode(), (head + "".join(later)).encode(), 1


def ingest(book: Book, folder: Path, name: str, content: bytes) -> None:
    path = folder / name
    path.write_bytes(content)
    outcome = ingest_file(book, path, IngestRequest(run=RUN, person=ADA))
    assert outcome.status == "imported", outcome


def heights_m(book: Book) -> list[float | None]:
    with book.reading() as connection:
        return [item.jump.apex_height_m for item in review(book, connection, RUN).jumps]


def whole_heights_m(folder: Path) -> list[float | None]:
    with small_book(folder / "again").open() as book:
        return heights_m(book)


def test_two_logs_of_two_starts_are_one_run(made: SmallBook, book: Book, tmp_path: Path) -> None:
    first, second, _before = halves(made)
    ingest(book, tmp_path, "first.csv", first)
    ingest(book, tmp_path, "second.csv", second)
    with (
        book.reading() as connection,
        refuses(UsageError, "2 log", "1 start"),
    ):
        review(book, connection, RUN)
    assert RUN in missing(book)
    with book.session(ADA) as session:
        correct(book, session, RUN, ["starts=2"], "power button pressed")
    assert heights_m(book) == pytest.approx(whole_heights_m(tmp_path), abs=1e-4)
    assert RUN not in missing(book)


def test_a_clock_that_starts_again_within_a_file_is_one_run(made: SmallBook, book: Book, tmp_path: Path) -> None:
    first, second, before = halves(made)
    ingest(book, tmp_path, "both.csv", first + second.split(b"\n", 1)[1])
    with book.reading() as connection:
        found = review(book, connection, RUN)
    assert len(found.signals) == 2
    assert [item.jump.number for item in found.jumps] == [1, 2, 3]
    assert heights_m(book) == pytest.approx(whole_heights_m(tmp_path), abs=1e-4)
    with book.session(ADA) as session:
        decide(book, session, RUN, [before + 1], "reject", "misfire", None)
    with book.reading() as connection:
        judged = review(book, connection, RUN).jumps
    assert [item.excluded is None for item in judged] == [True, False, True]


def missing(book: Book) -> set[str]:
    """The runs of a report that have no apex heights."""
    analysis = state_report(book, None, ADA, lambda _step: None).analysis
    return {run.name for run in analysis.evidence.runs if run.uid in analysis.results[Outcome.APEX].missing}


def test_the_order_of_ingesting_does_not_matter(made: SmallBook, book: Book, tmp_path: Path) -> None:
    first, second, _before = halves(made)
    with book.session(ADA) as session:
        correct(book, session, RUN, ["starts=2"], "power button pressed")
    ingest(book, tmp_path, "LOG10.csv", second)
    ingest(book, tmp_path, "LOG9.csv", first)
    assert heights_m(book) == pytest.approx(whole_heights_m(tmp_path), abs=1e-4)


def test_the_same_samples_saved_twice_are_one_log(made: SmallBook, book: Book, tmp_path: Path) -> None:
    whole = made.log(RUN).read_bytes()
    ingest(book, tmp_path, "as_logged.csv", whole)
    ingest(book, tmp_path, "saved_again.csv", whole.replace(b"\n", b"\r\n"))
    for starts in (1, 2):
        if starts == 2:
            with book.session(ADA) as session:
                correct(book, session, RUN, ["starts=2"], "power button pressed")
        assert heights_m(book) == whole_heights_m(tmp_path / f"{starts}")
        assert RUN not in missing(book)


def test_the_line_at_the_rig_counts_the_jumps_of_all_logs(made: SmallBook, book: Book, tmp_path: Path) -> None:
    first, second, _before = halves(made)
    ingest(book, tmp_path, "first.csv", first)
    second_file = tmp_path / "second.csv"
    second_file.write_bytes(second)
    outcome = ingest_file(book, second_file, IngestRequest(run=RUN, person=ADA))
    ((line, again),) = rig_lines_of(book, [outcome])
    says(line.text, "2 log", "1 start")
    assert again.text.startswith("look again: ")
    with book.session(ADA) as session:
        correct(book, session, RUN, ["starts=2"], "power button pressed")
    ((line,),) = rig_lines_of(book, [outcome])
    says(line.text, "3 jumps", "2 logs")
