"""SIGKILL at a random moment of each command that writes: what was stated stays, and the command can be given again."""

from __future__ import annotations

import itertools
import os
import random
import shutil
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import pytest

from data_schema.journal import Entry
from data_schema.journal_file import JournalFile
from ingest.store import raw_path
from labbook.actions.upkeep.restoring import MARKER
from labbook.book.copies.copying import raw_of
from labbook.book.opening import opened
from tests.helpers.books import SmallBook, short_log, small_book
from tests.helpers.commands import KILLED, Commands
from tests.helpers.databases import all_rows_by_name
from tests.helpers.figures import Count, record
from tests.helpers.statements import note, said_alike, state
from tests.helpers.upkeep import health, rebuilt_alike, rows_by_name

MOST_TRIES = 10
"""So many times as often as it is to die at most is a command started: some end before the kill."""


@dataclass
class Lab:
    """A book, a backup of it and a laptop's copy of it, all of which commands go on changing."""

    book: SmallBook
    commands: Commands
    folder: Path
    on_server: bool
    laptop: Path = field(init=False)
    stick: Path = field(init=False)
    numbers: Iterator[int] = field(default_factory=itertools.count)

    def __post_init__(self) -> None:
        self.laptop, self.stick = self.folder / "laptop", self.folder / "stick"

    def at_book(self, *words: str | Path) -> list[str | Path]:
        return [*words, "--book", self.book.folder]

    def to_sqlite(self, folder: Path) -> list[str | Path]:
        return ["restore", self.stick, folder, *(["--sqlite"] if self.on_server else [])]

    def run(self, *words: str | Path) -> None:
        code, said = self.commands.run(*words)
        assert code == 0, said

    def entries(self) -> list[Entry]:
        return list(JournalFile(self.book.journal).entries())

    def ingest(self) -> list[str | Path]:
        number = next(self.numbers)
        log = self.folder / f"log of round {number}.csv"  # of no run, so that none has two
        log.write_bytes(short_log(number))
        return self.at_book("ingest", log)

    def verdict(self) -> list[str | Path]:
        why = ("--reason", "touched_by_hand", "--note", f"seen on video {next(self.numbers)}")
        return self.at_book("jumps", "reject", "r002", "1", *why)

    def correct(self) -> list[str | Path]:
        return self.at_book("correct", "r003", f"jumps_made={20 + next(self.numbers)}", "--why", "counted again")

    def report(self) -> list[str | Path]:
        return self.at_book("report", "--out", self.folder / f"report-{next(self.numbers)}")

    def rebuild(self) -> list[str | Path]:
        return self.at_book("rebuild")

    def backup(self) -> list[str | Path]:
        self.say(self.book.folder)
        return self.at_book("backup", self.stick)

    def restore(self) -> list[str | Path]:
        self.run(*self.at_book("backup", self.stick))
        shutil.rmtree(self.folder / "restored", ignore_errors=True)
        return self.to_sqlite(self.folder / "restored")

    def merge(self) -> list[str | Path]:
        if not self.laptop.exists():
            self.run(*self.at_book("backup", self.stick))
            self.run(*self.to_sqlite(self.laptop))
        self.say(self.laptop)
        return self.at_book("merge", self.laptop)

    def plan(self) -> list[str | Path]:
        number = next(self.numbers)
        words = ("--seed", str(number), "--n", "1", "--per-day", "8", "--start", "2022-01-01")
        return self.at_book("plan", *words, "--out", self.folder / f"plan-{number}.csv")

    def reread(self) -> list[str | Path]:
        log = self.folder / "home made.csv"
        if not log.exists():
            log.write_text("t [ms],x\n" + "".join(f"{4 * place},{place % 7}\n" for place in range(300)))
            self.run(*self.at_book("ingest", log))
        return self.at_book("ingest", log, "--column", f"x=own.quantity_{next(self.numbers)}:V")

    def prune(self) -> list[str | Path]:
        for name in LEFT:
            path = self.book.folder / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(b"left by a crash")
            os.utime(path, (0.0, 0.0))
        return self.at_book("db", "prune", "--yes")

    def say(self, folder: Path) -> None:
        with opened(folder) as book:
            state(book, note, f"remark {next(self.numbers)}")


KINDS = ("ingest", "verdict", "correct", "report", "rebuild", "backup", "restore", "merge")
OTHER_KINDS = ("plan", "reread", "prune")
LEFT = (f"signals/ab/ab{'0' * 62}.parquet", f"raw/ab/.ab{'0' * 62}.zst.00000000", ".labbook.db.00000000")
"""What a prune removes."""


def check(lab: Lab, before: Sequence[Entry]) -> list[Entry]:
    """The book is whole and holds all that was stated before; returns what is there beyond."""
    found = health(lab.book)
    assert found.problems == ()
    entries = lab.entries()
    assert entries[: len(before)] == list(before)
    return entries[len(before) :]


def kinds_of(entries: Sequence[Entry]) -> Counter[tuple[str, str, bool]]:
    return Counter((entry.action, entry.entity_kind, entry.old is not None) for entry in entries)


def check_copies(lab: Lab, kind: str, *, done: bool) -> None:
    """Look at what the command makes beside the book."""
    if kind == "backup":
        for sha256 in raw_of(JournalFile(lab.stick / "journal.jsonl").entries()):
            assert (lab.stick / raw_path(sha256)).exists()
        if done:
            assert (lab.stick / "journal.jsonl").read_bytes() == lab.book.journal.read_bytes()
    if kind == "prune" and done:
        assert not any((lab.book.folder / name).exists() for name in LEFT)
    restored = lab.folder / "restored"
    if kind == "restore" and not done:
        assert not restored.exists() or (restored / MARKER).exists() or not any(restored.glob("[!.]*"))
    elif kind == "restore":
        with opened(lab.book.folder) as book:
            assert rows_by_name(restored) == all_rows_by_name(book.engine)


def kill(
    lab: Lab, kind: str, usual_s: float, usual: Counter[tuple[str, str, bool]], chance: random.Random
) -> tuple[bool, bool]:
    """Kill one command, look, give it again, look again; returns whether it died, and with its entry written."""
    words: list[str | Path] = getattr(lab, kind)()
    before = lab.entries()
    running = lab.commands.start(*words)
    time.sleep(chance.uniform(0.05, 1.0) * usual_s)
    running.kill()
    code = running.wait()
    assert code in (0, KILLED), running.output.read_text()
    left = check(lab, before)
    assert kinds_of(left) in (Counter(), usual)
    if kind == "report" and left:
        assert (Path(words[2]) / "report.html").exists()  # what is stated as made is there
    if code == KILLED:
        check_copies(lab, kind, done=False)
        if kind == "plan" and left:  # which is stated once; its sheet is there, or written again
            assert lab.commands.run(*words)[0] == 2
            lab.run(*words[:3], *words[7:], "--sheet")
        else:
            lab.run(*words)
        if kind == "plan":
            assert Path(words[-3]).exists()
    after = check(lab, before)
    again = kind == "report" and bool(left) and code == KILLED  # a second report is a second report
    assert kinds_of(after) == usual + (usual if again else Counter())
    check_copies(lab, kind, done=True)
    return code == KILLED, code == KILLED and bool(left)


def kill_in_turn(lab: Lab, kinds: Sequence[str], kills: int, seed: int) -> list[Count]:
    """Kill each kind of command until it died so many times, in turn; at the end a rebuild makes the same book."""
    chance = random.Random(seed)
    usual: dict[str, tuple[float, Counter[tuple[str, str, bool]]]] = {}
    for kind in kinds:
        took: list[float] = []
        for _ in range(2):  # the first of a kind may have more to load
            words, before, started = getattr(lab, kind)(), lab.entries(), time.monotonic()
            lab.run(*words)
            took.append(time.monotonic() - started)
            usual[kind] = min(took), kinds_of(check(lab, before))
    counts = [Count(kind, "kill", "PostgreSQL" if lab.on_server else "SQLite") for kind in kinds]
    for _, count in itertools.product(range(MOST_TRIES * kills), counts):
        if count.cut_off < kills:
            died, written = kill(lab, count.command, *usual[count.command], chance)
            count.tried, count.cut_off, count.written = count.tried + 1, count.cut_off + died, count.written + written
    with opened(lab.book.folder) as book:
        said_alike(book)
    rebuilt_alike(lab.book)
    return counts


def lab_at(folder: Path, database_url: str | None, commands: Commands) -> Lab:
    return Lab(small_book(folder, database_url=database_url), commands, folder, database_url is not None)


@pytest.mark.soak
def test_a_verdict_and_a_correction_killed_can_be_given_again(tmp_path: Path, commands: Commands) -> None:
    counts = kill_in_turn(lab_at(tmp_path, None, commands), ("verdict", "correct"), 1, seed=1)
    assert [count.cut_off for count in counts] == [1, 1]


@pytest.mark.soak
@pytest.mark.parametrize("block", range(26))
def test_a_thousand_kills_lose_nothing(
    block: int, tmp_path: Path, request: pytest.FixtureRequest, commands: Commands
) -> None:
    """In a block each of eight commands dies five times; every fourth is on PostgreSQL.

    Each has a book of its own: with every report, a rebuild of the book takes longer.
    """
    url = request.getfixturevalue("postgres_url") if block % 4 == 3 else None
    counts = kill_in_turn(lab_at(tmp_path, url, commands), KINDS, 5, seed=block)
    record(*counts)
    assert [count.cut_off for count in counts] == [5] * len(KINDS)


@pytest.mark.soak
@pytest.mark.parametrize("block", range(8))
def test_kills_of_what_is_done_less_often_lose_nothing(
    block: int, tmp_path: Path, request: pytest.FixtureRequest, commands: Commands
) -> None:
    """In a block each of three commands dies five times; every fourth is on PostgreSQL."""
    url = request.getfixturevalue("postgres_url") if block % 4 == 3 else None
    counts = kill_in_turn(lab_at(tmp_path, url, commands), OTHER_KINDS, 5, seed=100 + block)
    record(*counts)
    assert [count.cut_off for count in counts] == [5] * len(OTHER_KINDS)
