"""The queue of jumps to look at: all of them, the doubtful first, and the same order for the same seed."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from data_schema.errors import UsageError
from data_schema.vocabulary import ReviewOrder
from labbook.actions.files.ingesting import IngestRequest, ingest_file
from labbook.actions.runs.correcting import void
from labbook.actions.runs.jump_review import QueuedJump, ReviewQueue, decide, review, review_queue
from labbook.analysis.outcomes.detection import Detections
from labbook.book.opening import Book
from tests.helpers.books import ADA, BEN, SmallBook, ingest_all, small_book
from tests.helpers.hopping_log import apex_s, hopping_log
from tests.helpers.statements import state
from tests.helpers.upkeep import rebuilt
from tests.helpers.wording import refuses, says

RUN = "r001"


@pytest.fixture
def made(tmp_path: Path) -> SmallBook:
    """A book of which r001 has ten jumps: of the fourth the apex is lost, in the seventh few samples are."""
    small = small_book(tmp_path, ingested=False, two_people=True)
    lost = [(apex_s(4) - 0.1, apex_s(4) + 0.1), (apex_s(7) + 0.05, apex_s(7) + 0.07)]
    small.log(RUN).write_bytes(hopping_log(10, lost_s=lost))
    with small.open() as book:
        ingest_file(book, small.log(RUN), IngestRequest(run=RUN, person=ADA))
        small.log(RUN).unlink()
        ingest_all(book, small.instruments)
    return small


def queue(
    book: Book,
    order: ReviewOrder = ReviewOrder.DOUBT,
    seed: int | None = None,
    where: str | None = None,
    unreviewed: bool = False,
) -> ReviewQueue:
    with book.reading() as connection:
        detections = Detections(connection, book.store)
        return review_queue(detections, book.configuration, order, seed, where, unreviewed=unreviewed)


def names(found: ReviewQueue) -> list[tuple[str, int]]:
    return [(item.run, item.number) for item in found.jumps]


def test_it_has_every_jump_once_under_the_number_of_its_run(made: SmallBook) -> None:
    with made.open() as book:
        by_run = queue(book, ReviewOrder.RUN)
        with book.reading() as connection:
            for run in dict.fromkeys(item.run for item in by_run.jumps):
                *others, last = review(book, connection, run).jumps
                flies = last.jump.apex_height_m is not None  # else it is the landing that no jump follows
                shown = [*others, last] if flies else others
                listed = [(item.jump.number, item.signal_sha256) for item in shown]
                assert [(item.number, item.signal_sha256) for item in by_run.jumps if item.run == run] == listed
        assert [*dict.fromkeys(item.run for item in by_run.jumps)] == [
            f"r{n:03d}" for n in (*range(1, 7), *range(9, 15))
        ]
        assert by_run.left_out == {}
        assert sorted(names(queue(book))) == sorted(names(by_run))


def test_the_doubtful_come_first_and_the_reasons_are_said(made: SmallBook) -> None:
    with made.open() as book:
        found = queue(book, where=f"run={RUN}").jumps
    first, second = found[:2]
    assert (first.number, [reason.name for reason in first.reasons]) == (4, ["no_apex", "gap_touched"])
    assert (second.number, [reason.name for reason in second.reasons]) == (7, ["gap_touched"])
    says(first.reasons[1].words, "samples", "missing")
    assert first.doubt == sum(reason.weight for reason in first.reasons) > second.doubt
    assert [item.doubt for item in found[2:]] == [0.0] * (len(found) - 2)
    assert max(item.number for item in found) == 10  # the last landing is no lost jump, and no doubt


def test_a_height_far_from_those_of_the_other_jumps_and_a_wide_error_are_doubtful(tmp_path: Path) -> None:
    """Of a log in which noise blurs one flight, and another one is higher."""
    small = small_book(tmp_path, ingested=False)
    header, *lines = hopping_log(10).decode().splitlines()
    rows = [[float(cell) for cell in line.split(",")] for line in lines]
    for place, row in enumerate(rows):
        at_s = row[0] / 1e3
        row[1] += 0.02 if abs(at_s - apex_s(3)) < 0.1 else 0.0
        row[1] += 0.004 * (-1) ** place if abs(at_s - apex_s(8)) < 0.1 else 0.0
    text = "\n".join([header, *(",".join(f"{cell:.6f}" for cell in row) for row in rows), ""])
    path = small.instruments / "blurred.csv"
    path.write_text(text)
    with small.open() as book:
        ingest_file(book, path, IngestRequest(run=RUN, person=ADA))
        reasons = {item.number: {reason.name for reason in item.reasons} for item in queue(book).jumps}
    assert "height_far" in reasons[3]
    assert "wide_error" in reasons[8]
    assert all(reasons[number] == set() for number in (1, 2, 5, 6, 10))


def test_a_seed_gives_one_order_whatever_is_said_meanwhile(made: SmallBook) -> None:
    with made.open() as book:
        before = names(queue(book, ReviewOrder.SHUFFLED, 3))
        assert before != names(queue(book, ReviewOrder.SHUFFLED, 4))
        assert sorted(before) == sorted(names(queue(book, ReviewOrder.RUN)))
        run, number = before[0]
        state(book, decide, run, [number], "reject", "misfire", None)
        assert names(queue(book, ReviewOrder.SHUFFLED, 3)) == before
        assert names(queue(book, ReviewOrder.SHUFFLED, 3, unreviewed=True)) == before[1:]
    rebuilt(made)
    with made.open() as book:
        assert names(queue(book, ReviewOrder.SHUFFLED, 3)) == before
        with refuses(UsageError, "--seed"):
            queue(book, ReviewOrder.SHUFFLED)
        with refuses(UsageError, "--seed 3", "run"):
            queue(book, ReviewOrder.RUN, 3)
        with refuses(UsageError, "r999"):
            queue(book, where="run=r999")


def test_it_tells_which_verdict_stands_and_what_each_person_said_last(made: SmallBook) -> None:
    def of(book: Book, number: int) -> QueuedJump:
        return next(item for item in queue(book, where=f"run={RUN}").jumps if item.number == number)

    with made.open() as book:
        state(book, decide, RUN, [2], "accept", "looks_right", None)
        state(book, decide, RUN, [2], "reject", "touched_by_hand", None, blind=True, person=BEN)
        found = of(book, 2)
        assert found.decision is not None
        assert (found.decision.person, found.decision.verdict, found.decision.blind) == (BEN, "reject", True)
        assert [(said.person, said.verdict, said.blind) for said in found.verdicts] == [
            (ADA, "accept", False),
            (BEN, "reject", True),
        ]
        assert found.excluded is not None
        state(book, decide, RUN, [2], "clear", "other", None, person=BEN)
        found = of(book, 2)
        assert (found.decision, found.excluded) == (None, None)
        assert [said.person for said in found.verdicts] == [ADA]


def test_a_run_without_jumps_is_left_out_with_the_reason_and_a_void_one_without(made: SmallBook) -> None:
    with made.open() as book:
        path = made.instruments / "again.csv"
        path.write_bytes(hopping_log(2))
        ingest_file(book, path, IngestRequest(run="r002", person=ADA))
        state(book, void, "r003", "foot came loose")
        found = queue(book)
    assert {item.run for item in found.jumps}.isdisjoint({"r002", "r003"})
    assert [*found.left_out] == ["r002"]
    says(found.left_out["r002"], "2", "1 start")


def test_no_signal_is_read(made: SmallBook) -> None:
    with made.open() as book:
        before = queue(book)
        shutil.rmtree(book.store.root / "signals")
        assert queue(book) == before
