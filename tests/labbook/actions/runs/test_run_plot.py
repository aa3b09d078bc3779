"""A run that was started again is drawn with the pause as long as it was, or with a broken axis."""

from __future__ import annotations

import datetime as dt
from pathlib import Path

import pytest

from labbook.actions.files.ingesting import IngestRequest, ingest_file
from labbook.actions.runs.correcting import correct
from labbook.actions.runs.run_plot import drawn_log, plot_run
from labbook.book.opening import Book
from reports.display import LogGap
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


def gap_between(book: Book, folder: Path, *logs: bytes) -> LogGap:
    state(book, correct, RUN, ["starts=2", "jumps_made=5"], "for this test")
    for number, content in enumerate(logs):
        path = folder / f"{number}.csv"
        path.write_bytes(content)
        assert ingest_file(book, path, IngestRequest(run=RUN, person=ADA)).status == "imported"
    with book.reading() as connection:
        assert plot_run(book, connection, RUN, None, folder / "run.svg").path.exists()
        (gap,) = drawn_log(book, connection, RUN, None)[0].gaps
        return gap


@pytest.mark.parametrize("later_s", [217.0, 1.0, None])
def test_a_pause_is_as_long_as_the_clocks_say_or_breaks_the_axis(tmp_path: Path, later_s: float | None) -> None:
    """It does without instants, or where the second log would begin before the first one ended."""
    first, second = hopping_log(2), hopping_log(3)
    end_s = float(first.splitlines()[-1].partition(b",")[0]) / 1000
    if later_s is not None:
        first = with_instants(first, STARTED)
        second = with_instants(second, STARTED + dt.timedelta(seconds=later_s))
    with small_book(tmp_path, ingested=False).open() as book:
        gap = gap_between(book, tmp_path, first, second)
    assert gap.length_known is (later_s == 217.0)
    if gap.length_known:
        assert gap.kind == "restart"
        assert (gap.start_s, gap.end_s) == (pytest.approx(end_s, abs=1e-4), pytest.approx(217.0, abs=1e-4))
