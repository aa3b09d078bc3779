"""What a detection depends on: the rest length that the book has of the run's robot, and every kind of gap."""

from __future__ import annotations

from pathlib import Path

import pytest

from data_schema.vocabulary import GapKind
from ingest.model import Gap
from labbook.actions.runs.jump_review import review
from labbook.analysis.outcomes.detection import Log, detect, detection_row, gaps_for_detector
from tests.helpers.books import SmallBook, small_book


@pytest.fixture
def made(tmp_path: Path) -> SmallBook:
    return small_book(tmp_path)


def test_the_book_says_the_rest_length_whatever_labbook_toml_calls_its_robots(made: SmallBook) -> None:
    with made.open() as book, book.reading() as connection:
        before = review(book, connection, "r001").detections
    made.toml.write_text(made.toml.read_text().replace("[robots.hopper]", "[robots.other]"))
    with made.open() as book, book.reading() as connection:
        assert review(book, connection, "r001").detections == before


def test_a_jump_over_a_gap_of_any_kind_is_marked_and_has_its_own_key(made: SmallBook) -> None:
    with made.open() as book:
        with book.reading() as connection:
            found = review(book, connection, "r001")
        samples = book.store.samples(found.signals[0].store_path, ["body_height", "leg_length"])
    apex_s = found.jumps[1].jump.apex_s
    assert apex_s is not None
    keys = set()
    for gaps in ([], *([Gap(apex_s - 0.01, 0.02, 6, 6, kind)] for kind in GapKind)):
        log = Log(samples["time"], samples["body_height"], samples.get("leg_length"), gaps_for_detector(gaps))
        row = detection_row(detect(log, "robust", 0.27), found.signals[0].sha256)
        assert (row.key == found.detections[0].key) is (not gaps)
        assert row.jumps[1].gap_touched is bool(gaps)
        assert gaps or not any(jump.gap_touched for jump in row.jumps)
        keys.add(row.key)
    assert len(keys) > 1
