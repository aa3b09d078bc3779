"""A plan is stated once, whoever was killed or spoke meanwhile."""

from __future__ import annotations

import csv
from pathlib import Path

import pytest

from data_schema.queries.study import open_plans
from tests.cli.shell import good, labbook
from tests.helpers.books import SmallBook, small_book
from tests.helpers.commands import KILLED, Commands

WORDS = ("plan", "--seed", "7", "--n", "2", "--per-day", "8", "--start", "2021-06-21")


def plans(small: SmallBook) -> int:
    with small.open() as book, book.reading() as connection:
        return len(open_plans(connection))


def test_a_plan_repeated_after_a_kill_is_one_plan(tmp_path: Path, commands: Commands) -> None:
    small = small_book(tmp_path)
    words = [*WORDS, "--book", small.folder, "--out", tmp_path / "plan.csv"]
    code, _said = commands.run(*words, die_after_sync=1, of="journal.jsonl")
    assert code == KILLED
    assert plans(small) == 0  # only the journal has it
    code, said = commands.run(*words[:-1], tmp_path / "again.csv")
    assert code == 2, said
    assert "seed 7" in said
    assert not (tmp_path / "again.csv").exists()
    code, said = commands.run("note", "r001", "a cable came loose", "--book", small.folder)
    assert code == 0, said
    assert plans(small) == 1


@pytest.mark.parametrize("seeds", [("7", "7"), ("7", "8")])
def test_two_at_once_do_not_plan_the_same_runs(tmp_path: Path, commands: Commands, seeds: tuple[str, str]) -> None:
    small = small_book(tmp_path)
    running = [
        commands.start(*WORDS[:2], seed, *WORDS[3:], "--book", small.folder, "--out", tmp_path / f"plan{number}.csv")
        for number, seed in enumerate(seeds)
    ]
    codes = sorted(one.wait() for one in running)
    assert codes[0] == 0
    with small.open() as book, book.reading() as connection:
        names = [name for plan in open_plans(connection) for name in plan.to_be_made]
    assert len(names) == len(set(names))
    assert plans(small) == codes.count(0) <= (1 if seeds[0] == seeds[1] else 2)


@pytest.mark.parametrize("more", [(), ("--method", "blocked", "--no-idle"), ("--per-day", "20")])
def test_a_lost_sheet_is_written_again(tmp_path: Path, more: tuple[str, ...]) -> None:
    small = small_book(tmp_path)
    first, again = tmp_path / "plan.csv", tmp_path / "again.csv"
    good(labbook(*WORDS, "--out", first, *more, at=small.folder))
    sheet = ("plan", "--sheet", "--seed", "7", "--start", "2021-06-21", "--out", again)
    entries = small.journal.read_bytes()
    assert "look again" not in good(labbook(*sheet, at=small.folder)).out
    assert again.read_bytes() == first.read_bytes()
    assert again.with_suffix(".html").read_bytes() == first.with_suffix(".html").read_bytes()
    assert small.journal.read_bytes() == entries
    assert labbook(*sheet[:3], "8", at=small.folder).code == 2
    assert labbook(*sheet, "--n", "3", at=small.folder).code == 2


@pytest.mark.parametrize("again", [False, True], ids=["drawn", "again"])
def test_no_file_is_overwritten(tmp_path: Path, again: bool) -> None:
    small = small_book(tmp_path)
    words: tuple[str, ...] = WORDS
    if again:
        good(labbook(*WORDS, "--out", tmp_path / "plan.csv", at=small.folder))
        words = ("plan", "--sheet", "--seed", "7", "--start", "2021-06-21")
    page, entries = tmp_path / "mine.html", small.journal.read_bytes()
    refused = labbook(*words, "--out", page, at=small.folder)
    assert (refused.code, page.exists()) == (2, False), refused
    page.write_text("my own page", encoding="utf-8")
    assert labbook(*words, "--out", tmp_path / "mine.csv", at=small.folder).code == 2
    assert page.read_text(encoding="utf-8") == "my own page"
    assert not (tmp_path / "mine.csv").exists()
    assert small.journal.read_bytes() == entries


def test_the_plans_that_have_a_sheet_are_named(tmp_path: Path) -> None:
    small = small_book(tmp_path)
    sheet = tmp_path / "plan.csv"
    good(labbook(*WORDS, "--out", tmp_path / "withdrawn.csv", at=small.folder))
    good(labbook("plan", "--withdraw", "--seed", "7", "--why", "a new foot", at=small.folder))
    few = ("--seed", "8", "--n", "1", "--per-day", "60", "--no-idle", "--start", "2021-06-21", "--out", sheet)
    good(labbook("plan", *few, at=small.folder))
    with sheet.open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    with sheet.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, rows[0].keys())
        writer.writeheader()
        for hour, row in enumerate(rows, start=8):
            writer.writerow({**row, "battery": "A", "started": f"{hour:02}:00", "duration_s": 720, "jumps_made": 25})
    good(labbook("runs", "import", sheet, at=small.folder))  # all of its runs are made
    assert plans(small) == 0
    withdrawn, unknown = (labbook("plan", "--sheet", "--seed", seed, at=small.folder) for seed in ("7", "9"))
    assert (withdrawn.code, unknown.code) == (2, 2)
    assert "withdrawn" in withdrawn.err
    assert "withdrawn" not in unknown.err
    for refused in (withdrawn, unknown):
        assert "(8)" in refused.err


def test_a_sheet_of_another_protocol_leaves_blank_what_it_cannot_know(tmp_path: Path) -> None:
    small = small_book(tmp_path)
    first, again = tmp_path / "plan.csv", tmp_path / "again.csv"
    good(labbook(*WORDS, "--out", first, at=small.folder))
    text = small.toml.read_text()
    assert "idle_minutes = [20" in text
    small.toml.write_text(text.replace("idle_minutes = [20", "idle_minutes = [5, 20"))
    said = good(labbook("plan", "--sheet", "--seed", "7", "--start", "2021-06-21", "--out", again, at=small.folder)).out
    assert "look again" in said
    names = [[line.split(",")[:7] for line in path.read_text().splitlines()] for path in (first, again)]
    assert names[0] == names[1]
