"""A log's own date is held against the day of its run: r001 of the small book is of 2021-06-14, r009 of 2021-06-16."""

from __future__ import annotations

import datetime as dt
from pathlib import Path

import numpy as np
import pytest

from ingest.model import SignalPart
from labbook.analysis.outcomes.log_dates import future_date_sentence, is_future, swapped_day
from tests.cli.shell import good, labbook, rows
from tests.helpers.books import SmallBook
from tests.helpers.wording import says


def dated_log(folder: Path, name: str, date: str, clock: str = "10:00") -> Path:
    """A log with a date and a clock time in every row."""
    path = folder / name
    body = "".join(f"{date};{clock}:{k // 100:02d}.{k % 100:02d};{0.42 + k % 7 / 100:.3f}\n" for k in range(300))
    path.write_text("date;time;body_height [m]\n" + body)
    return path


@pytest.fixture
def early(fresh: SmallBook) -> SmallBook:
    """A book with one run of the sixth of May, which is a day and month in either order."""
    head, first, *_others = (fresh.instruments / "runs.csv").read_text().splitlines()
    sheet = fresh.instruments / "early.csv"
    sheet.write_text(f"{head}\n{first.replace('2021-06-14', '2021-05-06')}\n")
    good(labbook("runs", "import", sheet, at=fresh.folder))
    return fresh


def test_day_and_month_swapped_are_refused_with_both_readings_and_the_flag(early: SmallBook, tmp_path: Path) -> None:
    log = dated_log(tmp_path, "r001.csv", "06/05/2021")
    told = labbook("ingest", log, "--dates", "m/d/y", at=early.folder)
    assert told.code == 2
    says(told.out, "day_month_swapped", "2021-06-05", "2021-05-06", "--dates d/m/y", "r001")
    assert rows(early.folder, "SELECT count(*) FROM signal") == [(0,)]
    assert list((early.folder / "raw").rglob("*.zst")) == []
    for only in ("--dry-run", "--explain"):
        assert "day_month_swapped" in labbook("ingest", log, "--dates", "m/d/y", only, at=early.folder).out
    good(labbook("ingest", log, "--dates", "d/m/y", at=early.folder))
    assert labbook("ingest", log, "--dates", "m/d/y", at=early.folder).code == 2  # the reading before stays
    assert rows(early.folder, "SELECT start_utc FROM signal")[0][0].startswith("2021-05-06")


@pytest.mark.parametrize(
    ("text", "of_log", "of_run", "order"),
    [
        ("04/03/2024", "2024-03-04", "2024-04-03", "m/d/y"),
        ("03/04/2024", "2024-03-04", "2024-04-03", "d/m/y"),
        ("04/03/2024", "2024-03-04", "2024-04-04", None),
        ("04/03/2024", "2024-03-04", "2024-04-02", "m/d/y"),
        ("2024-03-04", "2024-03-04", "2024-04-03", None),
    ],
)
def test_a_swap_is_what_makes_the_log_of_the_day_of_its_run(
    text: str, of_log: str, of_run: str, order: str | None
) -> None:
    part = SignalPart("log", np.arange(2.0), 1.0, f"{of_log}T10:00:00Z", f"{text} 10:00:00", (), ())
    found = swapped_day([part], "r001", of_run, "UTC")
    assert [f"--dates {order}" in finding.message for finding in found] == ([] if order is None else [True])


def test_log_of_another_day_is_told_with_both_dates_and_again_by_a_rebuild(stated: SmallBook, tmp_path: Path) -> None:
    logs = [dated_log(tmp_path, "r001.csv", "2021-06-17"), dated_log(tmp_path, "r002.csv", "2021-06-14")]
    told = good(labbook("ingest", *logs, at=stated.folder)).out
    says(told, "log_day_differs", "2021-06-17", "2021-06-14", "labbook correct r001 date=2021-06-17")
    assert told.count("log_day_differs") == 1
    kept = "SELECT rule, message FROM finding WHERE rule = 'log_day_differs'"
    before = rows(stated.folder, kept)
    good(labbook("rebuild", at=stated.folder))
    assert rows(stated.folder, kept) == before != []


@pytest.mark.parametrize(
    ("date", "clock", "differs"),
    [
        ("2021-06-13", "18:40", True),
        ("2021-06-13", "23:50", False),
        ("2021-06-14", "10:00", False),
        ("2021-06-15", "00:20", False),
        ("2021-06-15", "08:40", True),
    ],
)
def test_only_a_log_about_midnight_may_be_of_a_run_of_the_day_beside_it(
    date: str, clock: str, differs: bool, stated: SmallBook, tmp_path: Path
) -> None:
    """By the clock of the lab: in UTC, 23:50 in New York is of the day after."""
    log = dated_log(tmp_path, "r001.csv", date, clock)
    assert ("log_day_differs" in good(labbook("ingest", log, at=stated.folder)).out) is differs


def test_a_file_that_waited_is_held_against_its_run_when_it_gets_one(fresh: SmallBook, tmp_path: Path) -> None:
    for name, date in (("r001.csv", "2021-12-13"), ("odd.csv", "2021-12-12")):
        good(labbook("ingest", dated_log(tmp_path, name, date), at=fresh.folder))
    told = good(labbook("runs", "import", fresh.instruments / "runs.csv", at=fresh.folder)).out
    says(told, "2021-12-13", "2021-06-14")
    says(good(labbook("assign", "odd.csv", "r002", at=fresh.folder)).out, "2021-12-12", "2021-06-14")


def test_logs_and_recharges_of_days_to_come_are_questioned_though_their_runs_are_unknown(
    fresh: SmallBook, tmp_path: Path
) -> None:
    """They were taken in without a word, to wait for runs of these names."""
    log = dated_log(tmp_path, "r900.csv", "05/06/2098")
    for words in (["--dry-run"], []):
        out = good(labbook("ingest", log, "--dates", "m/d/y", *words, at=fresh.folder)).out
        assert "--dates" not in says(out, "date_in_future", "'05/06/2098", "2098-05-06")  # no order makes it past
    sheet = tmp_path / "packs.csv"
    sheet.write_text("run,mAh,pack,ended\nr900,103,A,2021-05-06 10:00\nr901,104,B,2098-03-05 12:00\n")
    says(good(labbook("ingest", sheet, at=fresh.folder)).out, "date_in_future", "line 3", "'2098-03-05 12:00'")
    good(labbook("db", "check", "--deep", at=fresh.folder))  # what does not stay true is not stored


def test_a_day_to_come_that_is_past_in_the_other_order_is_told_with_that() -> None:
    today = dt.date(2024, 6, 1)
    says(future_date_sentence("05/12/2024 10:00", dt.date(2024, 12, 5), today), "`--dates m/d/y` if it is 2024-05-12")
    assert "--dates" not in future_date_sentence("05/08/2024", dt.date(2024, 8, 5), today - dt.timedelta(days=60))
    assert not is_future(today + dt.timedelta(days=1), today)  # it has begun somewhere
