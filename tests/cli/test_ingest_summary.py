"""What a person reads of a batch: the sum, what needs attention, worst first, and each run once, with all of it."""

from __future__ import annotations

import os
import re
import shlex
from pathlib import Path

import pytest

from tests.cli.shell import good, labbook, refused, rows
from tests.helpers.attention import told
from tests.helpers.books import SmallBook
from tests.helpers.hopping_log import apex_s, hopping_log
from tests.helpers.wording import says


@pytest.fixture
def foreign(tmp_path: Path) -> Path:
    """A home-made logger's file whose height has a name of its own."""
    path = tmp_path / "log 1.csv"
    path.write_text(
        "t [ms],legLen,pot_raw,motor\n" + "".join(f"{3 * i},{i % 9},{420 + i % 7},{i % 5}\n" for i in range(300))
    )
    return path


def test_a_log_without_body_height_says_so_first_with_the_ready_command(stated: SmallBook, foreign: Path) -> None:
    """It was imported with three remarks on unknown columns, and the run had no apexes without a word."""
    answer = good(labbook("ingest", foreign, "--run", "r001", "--unit", "legLen=mm", "--dry-run", at=stated.folder))
    _summary, first, columns, how = answer.out.splitlines()[:4]
    assert "NO body_height" in first
    assert all(repr(name) in columns for name in ("legLen", "pot_raw", "motor"))
    assert "`labbook channels`" in how
    (item,) = good(labbook("ingest", foreign, "--unit", "legLen=mm", "--dry-run", "--json", at=stated.folder)).json
    command = item["missing_body_height"]["command"]
    assert command in how
    words = [word.replace(":UNIT", ":mm") for word in shlex.split(command)]
    assert words == ["--column", "pot_raw=body_height:mm"]
    (item,) = good(labbook("ingest", foreign, "--unit", "legLen=mm", "--run", "r001", "--json", at=stated.folder)).json
    again = item["missing_body_height"]["command"].replace(":UNIT", ":mm")
    good(labbook(*shlex.split(again)[1:], "--unit", "legLen=mm", at=stated.folder))
    assert ("body_height",) in rows(stated.folder, "SELECT name FROM channel")


def test_a_log_of_an_idle_run_needs_no_body_height(stated: SmallBook, foreign: Path) -> None:
    said = good(labbook("ingest", foreign, "--run", "r007", "--unit", "legLen=mm", "--dry-run", at=stated.folder))
    assert "NO body_height" not in said.out


@pytest.fixture
def batch(tmp_path: Path) -> Path:
    folder = tmp_path / "batch"
    folder.mkdir()
    return folder


def test_the_sum_comes_first_then_what_needs_attention_worst_first(
    stated: SmallBook, foreign: Path, batch: Path
) -> None:
    for run, jumps, lost in (("r001", 3, 1), ("r002", 6, 0), ("r003", 3, 0)):  # 3 are made in each
        gap = [(apex_s(2) - 0.1, apex_s(2) + 0.1)][:lost]
        (batch / f"{run}.csv").write_bytes(hopping_log(jumps, lost_s=gap))
    (batch / "photo.jpg").write_bytes(b"\xff\xd8\xff\xe0" + bytes(range(256)) * 4)
    (batch / "sheet.csv").write_text("run,mAh\nr004,150\nr005,ERR\nr006,152\n")
    (batch / "x.csv").write_bytes(foreign.read_bytes().replace(b"legLen", b"left"))
    answer = labbook("ingest", batch, at=stated.folder)
    assert answer.code == 2
    lines = answer.out.splitlines()
    says(lines[0], "6 files", "5 imported", "0", "1 refused")
    says(lines, "not_a_number", "line 3", "'ERR'")
    marks = ["photo.jpg: refused", "NO body_height", "not_a_number", "6 of 3 jumps found", "2 of 3 jumps found"]
    places = [
        next(place for place, line in enumerate(lines) if mark in line)
        for mark in [*marks, "the others:", "3 of 3 jumps found"]
    ]
    assert places == sorted(places)


@pytest.mark.parametrize("same_bytes", [True, False])
def test_a_copy_of_another_runs_log_comes_before_logs_that_lack_a_jump(
    stated: SmallBook, batch: Path, same_bytes: bool
) -> None:
    """It came last, or was not seen at all where a line had been added."""
    for number in (1, 2, 3, 4, 5):
        (batch / f"r00{number}.csv").write_bytes(hopping_log(2, lost_s=[(0.1 * number, 0.1 * number + 0.004)]))
    above = b"" if same_bytes else b"# exported again\n"
    (batch / "r006.csv").write_bytes(above + (batch / "r005.csv").read_bytes())
    lines = good(labbook("ingest", batch, at=stated.folder)).out.splitlines()
    (place, *_) = [place for place, line in enumerate(lines) if " copy" in line]
    says(lines[place], "r006", "labbook assign" if same_bytes else "labbook files withdraw")
    assert place < min(place for place, line in enumerate(lines) if "2 of 3 jumps found" in line)
    assert place < 4


def test_files_that_ail_alike_are_told_once(stated: SmallBook, foreign: Path, batch: Path) -> None:
    """It was the same findings again for each of a new user's logs."""
    for number in range(14):
        text = foreign.read_text().replace("legLen", "left") + f"{900 + number},1,421,1\n"
        (batch / f"log{number:02}.csv").write_text(text)
        (batch / f"bad{number:02}.csv").write_text(text.replace("t [ms]", "t"))
    answer = labbook("ingest", batch, at=stated.folder)
    assert answer.code == 2
    lines = answer.out.splitlines()
    says(lines[0], "28 files", "14 imported", "14 refused")
    assert len(lines) < 20
    for mark, times in (("NO body_height", 1), ("unknown_column", 1), ("time_unit_missing", 1), ("and 1 more.", 2)):
        assert sum(mark in line for line in lines) == times, mark


def test_many_files_that_are_fine_are_counted_and_listed_on_demand(stated: SmallBook) -> None:
    """It was one line for each of hundreds of files, with what mattered between them."""
    folders = [stated.instruments / name for name in ("logs", "charger")]
    good(labbook("ingest", *folders, at=stated.folder))
    again = good(labbook("ingest", *folders, at=stated.folder)).out.splitlines()
    says(again[0], "14 files", "0 imported", "0 refused")
    assert len(again) == 2
    assert len(good(labbook("ingest", *folders, "--verbose", at=stated.folder)).out.splitlines()) == 15


def test_what_a_folder_holds_beside_files_is_named_as_skipped(stated: SmallBook, tmp_path: Path) -> None:
    """A link to a stick that is not there any more was passed over without a word."""
    folder, elsewhere = tmp_path / "day", tmp_path / "elsewhere"
    folder.mkdir()
    elsewhere.mkdir()
    (folder / "r003.csv").symlink_to(elsewhere / "r003.csv")
    (folder / "older").symlink_to(elsewhere)
    os.mkfifo(folder / "pipe")
    refused(labbook("ingest", "../day", at=stated.folder), 2, "no file in ../day", "r003.csv (a link to nothing)")
    for run in ("r001", "r002"):
        (folder / f"{run}.csv").symlink_to(stated.log(run))
    for words in ((), ("--dry-run", "--verbose")):
        _summary, line = good(labbook("ingest", "../day", *words, at=stated.folder)).out.splitlines()[:2]
        says(line, "skipped (3)", "r003.csv", "link", "older", "pipe")
    for words in (("--json",), ("--explain",), ("--draft-profile",)):
        told = labbook("ingest", "../day", *words, at=stated.folder)
        assert (told.code, told.err.strip()) == (0, line)


JUMPED = ["r001", "r002", "r003", "r004", "r005", "r006", "r009", "r010", "r011", "r012", "r013", "r014"]


@pytest.mark.parametrize("order", [("charger", "logs"), pytest.param(("logs", "charger"), marks=pytest.mark.soak)])
def test_each_run_is_told_once_with_jumps_and_joules(stated: SmallBook, order: tuple[str, str]) -> None:
    paths = [stated.instruments / name for name in order]
    out = good(labbook("ingest", *paths, at=stated.folder)).out
    lines = [line.strip() for line in out.splitlines() if line.startswith("  run r")]
    assert [line[4:8] for line in lines] == JUMPED
    assert all(re.search(r"3 of 3 jumps found, .*gaps?.*, \d+\.\d J a jump", line) for line in lines)


def test_programs_find_a_run_once_at_the_last_of_its_files(stated: SmallBook) -> None:
    found = good(labbook("ingest", stated.instruments / "charger", stated.log("r001"), "--json", at=stated.folder)).json
    rig = {Path(item["file"]).name: item["rig"] for item in found}
    (line,) = rig["r001.csv"]
    assert re.search(r"^run r001: 3 of 3 jumps found, no gaps, \d+\.\d J a jump", line)
    assert [text[4:8] for text in rig["2021-06-14.csv"]] == [name for name in JUMPED[1:] if name < "r009"]


def test_gaps_of_all_logs_of_a_run_are_counted_together(stated: SmallBook) -> None:
    """A run of two logs: 7 samples are missing in one and 11 in the other."""
    again = stated.log("r002").with_name("r002_again.csv")
    stated.log("r004").rename(again)
    out = good(labbook("ingest", stated.log("r002"), again, "--run", "r002", at=stated.folder)).out
    (line,) = [line for line in out.splitlines() if line.startswith("  run r002")]
    assert ", 2 gaps (18 samples), joules unknown" in line


def test_a_copy_of_a_log_of_the_same_run_is_named_and_its_gaps_count_once(stated: SmallBook) -> None:
    again = stated.log("r002").with_name("r002 (2).csv")
    again.write_bytes(stated.log("r002").read_bytes().replace(b"\n", b"\r\n"))
    out = good(labbook("ingest", stated.log("r002"), again, "--run", "r002", at=stated.folder)).out
    says(out, "run r002:", "3 of 3 jumps found", ", 1 gap (7 samples)")
    copied = ("r002 (2).csv", "the samples of r002.csv", "labbook files withdraw 'r002 (2).csv'")
    says(out, *copied)
    today = ("today", "--day", "2021-06-14")
    (copy,) = told(stated.folder, *today)["samples_twice"]
    says(copy["command"], "labbook files withdraw 'r002 (2).csv'")
    assert good(labbook("show", "r002", at=stated.folder)).out.count("gap (dropped)") == 1
    good(labbook("files", "withdraw", "r002 (2).csv", "--why", "a copy", at=stated.folder))
    assert "samples_twice" not in told(stated.folder, *today)
