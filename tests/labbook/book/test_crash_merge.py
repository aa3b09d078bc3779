"""SIGKILL at any moment of a merge: the book is as before or merged, and merging again makes it whole."""

from __future__ import annotations

import shutil
from dataclasses import dataclass
from pathlib import Path

import pytest

from ingest.tables.sheet import SheetFile
from labbook.actions.files.ingesting import IngestRequest, ingest_file
from labbook.actions.runs.runs_importing import import_runs
from labbook.actions.upkeep.merging import merge
from labbook.book.opening import opened
from tests.helpers.books import ADA, BEN, SmallBook, instrument_files, small_book
from tests.helpers.commands import KILLED, Commands
from tests.helpers.statements import in_file, in_table, note, said_alike, state
from tests.helpers.upkeep import health

pytestmark = pytest.mark.skipif(not Path("/proc/self/fd").exists(), reason="the files of a process are not in /proc")


@dataclass
class Homecoming:
    """A book, the copy that went on in the field, and the commands that merge it into fresh copies of the first."""

    lab: SmallBook
    laptop: SmallBook
    commands: Commands
    before: int
    merged: int
    number: int = 0

    def fresh(self) -> Path:
        self.number += 1
        folder = self.lab.folder.parent / f"copy-{self.number}"
        shutil.copytree(self.lab.folder, folder)
        return folder

    def words(self, folder: Path) -> list[str | Path]:
        return ["merge", self.laptop.folder, "--book", folder, "--as", ADA]

    def check(self, folder: Path) -> None:
        """Look at what a killed merge left, and merge again."""
        with opened(folder) as book:
            table, mirrored = in_table(book), in_file(book)
        before, merged = self.before, self.merged
        assert (len(table), len(mirrored)) in ((before, before), (before, merged), (merged, merged))
        assert mirrored[: len(table)] == table
        with opened(folder) as book:
            merge(book, self.laptop.folder, ADA)
            assert len(said_alike(book)) == self.merged
        assert health(folder, deep=True).problems == ()
        shutil.rmtree(folder)


@pytest.fixture
def homecoming(tmp_path: Path, commands: Commands) -> Homecoming:
    lab = small_book(tmp_path / "lab", runs=False, ingested=False, two_people=True)
    head, *rows = instrument_files()["runs.csv"].decode().splitlines(keepends=True)
    with lab.open() as book:
        state(book, import_runs, SheetFile("runs.csv", (head + "".join(rows[:8])).encode()))
        laptop = SmallBook(tmp_path / "laptop", lab.instruments)
        shutil.copytree(lab.folder, laptop.folder)
        state(book, note, "the lab goes on")
        before = len(in_table(book))
    with laptop.open() as book:
        state(book, import_runs, SheetFile("runs.csv", (head + "".join(rows[8:])).encode()), person=BEN)
        for run in ("r009", "r010"):
            ingest_file(book, lab.log(run), IngestRequest(person=BEN))
    home = Homecoming(lab, laptop, commands, before, 0)
    folder = home.fresh()
    code, said = commands.run(*home.words(folder))
    assert code == 0, said
    with opened(folder) as book:
        home.merged = len(said_alike(book))
    return home


def test_a_merge_cut_off_between_journal_and_commit_is_applied_next_time(homecoming: Homecoming) -> None:
    folder = homecoming.fresh()
    code, said = homecoming.commands.run(*homecoming.words(folder), die_after_sync=1, of="journal.jsonl")
    assert code == KILLED, said
    with opened(folder) as book:
        assert (len(in_table(book)), len(in_file(book))) == (homecoming.before, homecoming.merged)
    homecoming.check(folder)


@pytest.mark.soak
def test_a_merge_killed_after_each_sync_is_made_or_not(homecoming: Homecoming) -> None:
    for number in range(1, 200):
        folder = homecoming.fresh()
        code, said = homecoming.commands.run(*homecoming.words(folder), die_after_sync=number)
        assert code in (0, KILLED), said
        homecoming.check(folder)
        if code == 0:
            break
    assert number > 8
