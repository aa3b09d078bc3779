"""Run sheets as spreadsheets of other countries save them: read where they can mean one thing, else asked about."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.cli.shell import at_a_terminal, good, labbook, refused, rows, unchanged
from tests.helpers.books import SmallBook
from tests.helpers.tomls import without

HEAD = "run;date;position;kind;foot;k_gain;b_ad_gain;battery;robot;started;duration_s;jumps_made;starts;note\n"
NOTE = "Füße geölt, 5 °C"


def sheet(folder: Path, *, date: str = "14.6.2021", started: str = "9:05", page: str = "utf-8") -> Path:
    path = folder / "runs.csv"
    path.write_bytes(f"{HEAD}r1;{date};1;jumps;small;400;0;A;;{started};722,5;3;;{NOTE}\n".encode(page))
    return path


@pytest.mark.parametrize(("page", "said"), [("utf-8", False), ("utf-16", False), ("cp1252", True), ("mac-roman", True)])
def test_a_german_sheet_is_read_and_its_page_is_said(fresh: SmallBook, tmp_path: Path, page: str, said: bool) -> None:
    """A sheet in Windows-1252 and a date as 14.6.2021 were refused."""
    options = ["--encoding", page] if page == "mac-roman" else []
    done = good(labbook("runs", "import", sheet(tmp_path, page=page), *options, at=fresh.folder))
    assert done.out.startswith("1 runs stated")
    assert (f"read as {page}" in done.out) is said
    found = rows(fresh.folder, "SELECT name, duration_s, date_local, text FROM run JOIN day ON run.day = day.id, note")
    assert found == [("r1", 722.5, "2021-06-14", NOTE)]


def test_a_time_that_came_twice_is_wanted_with_its_offset(fresh: SmallBook, tmp_path: Path) -> None:
    """The first of the two was stored without a word."""
    without(fresh.folder, r"(?<=time_zone = )[^\n]*", '"Europe/Berlin"')
    twice = sheet(tmp_path, date="31.10.2021", started="02:30")
    with unchanged(fresh.folder):
        refused(labbook("runs", "import", twice, at=fresh.folder), 2, "run r1 (line 2)", "show twice", "02:30+01:00")
    good(labbook("runs", "import", sheet(tmp_path, date="31.10.2021", started="02:30+01:00"), at=fresh.folder))
    assert rows(fresh.folder, "SELECT started_utc FROM run") == [("2021-10-31T01:30:00Z",)]


def test_a_date_that_could_be_two_is_asked_about_at_a_terminal(fresh: SmallBook, tmp_path: Path) -> None:
    path = sheet(tmp_path, date="03/06/2021")
    with unchanged(fresh.folder):
        refused(labbook("runs", "import", path, at=fresh.folder), 2, "03/06/2021", "`--dates d/m/y`")
    code, out, asked = at_a_terminal("runs", "import", path, at=fresh.folder, typed="perhaps\nm/d/y\n")
    assert code == 0, out
    assert "m/d/y: the month" in asked
    assert rows(fresh.folder, "SELECT date_local FROM day") == [("2021-03-06",)]
