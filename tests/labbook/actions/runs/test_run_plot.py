"""A run that was started again is drawn with the pause as long as it was, or with a broken axis."""

from __future__ import annotations

import datetime as dt
from pathlib import Path

import pytest

from labbook.actions.files.ingesting import IngestRequest, ingest_file
from labbook.actions.runs.correcting import correct
from labbook.actions.runs.run_plot import drawn_log, plot_run
from labbook.book.opening import Book
from reports.drawn import LogGap
from tests.helpers.books import ADA, small_book
from tests.helpers.hopping_log import hopping_log
from tests.helpers.statements import state

RUN = "r001"
STARTED = dt.datetime(2021, 6, 14, 13, 30, tzinfo=dt.UTC)


def with_instants(log: bytes, start: dt.datetime) -> bytes:
    header, *lines = log.decode().splitlines()
    stamped = [header.replace("time [ms]", "time")]
    for line in lines:
        ms, rest = line.split(",", 1)
        stamped.append(f"{(start + dt.timedelta(milliseconds=float(ms))).isoformat()},{rest}")
    return "\n".join([*stamped, ""]).encode()


def gaps_between(book: Book, folder: Path, first: bytes, second: bytes) -> tuple[LogGap, ...]:
    state(book, correct, RUN, ["starts=2", "jumps_made=5"], "for this test")
    for name, content in (("a.csv", first), ("b.csv", second)):
        (folder / name).write_bytes(content)
        assert ingest_file(book, folder / name, IngestRequest(run=RUN, person=ADA)).status == "imported"
    with book.reading() as connection:
        assert plot_run(book, connection, RUN, None, folder / "run.svg").path.exists()
        return drawn_log(book, connection, RUN, None)[0].gaps


def test_a_pause_is_drawn_as_long_as_the_clocks_say(tmp_path: Path) -> None:
    with small_book(tmp_path, ingested=False).open() as book:
        first, second = hopping_log(2), hopping_log(3)
        later = STARTED + dt.timedelta(seconds=217)
        (gap,) = gaps_between(book, tmp_path, with_instants(first, STARTED), with_instants(second, later))
    end_s = float(first.splitlines()[-1].partition(b",")[0]) / 1000
    assert (gap.kind, gap.length_known) == ("restart", True)
    assert (gap.start_s, gap.end_s) == (pytest.approx(end_s, abs=1e-4), pytest.approx(217.0, abs=1e-4))


@pytest.mark.parametrize("earlier_s", [None, 1.0])
def test_a_pause_that_no_clock_measured_breaks_the_axis(tmp_path: Path, earlier_s: float | None) -> None:
    """Without instants, or where the second log would begin before the first one ended."""
    first, second = hopping_log(2), hopping_log(3)
    if earlier_s is not None:
        second = with_instants(second, STARTED + dt.timedelta(seconds=earlier_s))
        first = with_instants(first, STARTED)
    with small_book(tmp_path, ingested=False).open() as book:
        (gap,) = gaps_between(book, tmp_path, first, second)
    assert not gap.length_known
