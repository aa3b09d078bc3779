"""What `labbook ingest` says of the runs of a folder of logs and charges: each once, with all that is known of it."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from tests.cli.shell import good, labbook
from tests.helpers.books import SmallBook
from tests.helpers.wording import says

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
    says(good(labbook(*today, at=stated.folder)).out, *copied)
    assert good(labbook("show", "r002", at=stated.folder)).out.count("gap (dropped)") == 1
    good(labbook("files", "withdraw", "r002 (2).csv", "--why", "a copy", at=stated.folder))
    assert not good(labbook(*today, "--json", at=stated.folder)).json["samples_twice"]
