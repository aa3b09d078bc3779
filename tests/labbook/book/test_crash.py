"""SIGKILL at any moment, and two at once: nothing is lost, nothing is half there, nothing is there twice.

Real processes are killed; what they leave is looked at, and the next command must go on from there.
"""

from __future__ import annotations

import hashlib
import random
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import pytest
import sqlalchemy as sa

from data_schema import journal
from data_schema.tables.files import file, ingest
from data_schema.tables.signals import signal
from labbook.book.opening import Book, open_book
from tests.helpers.books import ADA, SmallBook, short_log, small_book, small_toml
from tests.helpers.commands import KILLED, Commands
from tests.helpers.databases import all_rows, server_in_a_soak
from tests.helpers.statements import in_file, in_table, note, notes, said_alike, state
from tests.helpers.upkeep import rebuilt

ON_SQLITE = pytest.mark.parametrize("database_url", ["sqlite"], indirect=True)
pytestmark = pytest.mark.skipif(not Path("/proc/self/fd").exists(), reason="the files of a process are not in /proc")


@dataclass
class Lab:
    """A book with runs but without files, and an instrument that keeps writing small ones."""

    book: SmallBook
    commands: Commands
    inbox: Path
    standing: Book
    written: dict[str, Path] = field(default_factory=dict)

    def record(self, number: int) -> Path:
        """Write the next round's log into a folder of its own; no two are the same."""
        folder = self.inbox / f"round-{number:04d}"
        folder.mkdir()
        content = short_log(number)
        path = folder / f"r{1 + number % 6:03d}-0.csv"
        path.write_bytes(content)
        self.written[hashlib.sha256(content).hexdigest()] = path
        return folder

    def ingest(self, *folders: Path) -> list[str | Path]:
        """The command that ingests folders."""
        return ["ingest", *folders, "--book", self.book.folder]

    def done(self, *words: str | Path) -> str:
        """Run a command that has to end well; returns what it printed."""
        code, said = self.commands.run(*words)
        assert code == 0, said
        return said

    def check(self, waiting: int = 1) -> int:
        """Look at what is there, at most `waiting` entries only in the file; returns how many files are imported."""
        with self.standing.reading() as connection:
            if connection.dialect.name == "sqlite":
                assert connection.exec_driver_sql("PRAGMA integrity_check").scalar_one() == "ok"
                assert connection.exec_driver_sql("PRAGMA foreign_key_check").fetchall() == []
            kept = connection.execute(sa.select(file.c.sha256, file.c.store_path)).all()
            samples = connection.execute(sa.select(signal.c.store_path)).scalars().all()
            of_imports = sa.select(ingest.c.sha256).where(ingest.c.status == "imported")
            imported = connection.execute(of_imports).scalars().all()
            in_database = list(journal.verified_chain(journal.stored(connection)))
        root = self.standing.store.root
        assert all((root / path).is_file() for _sha256, path in kept)
        assert all((root / path).is_file() for path in samples)
        assert Counter(imported) == Counter(sha256 for sha256, _path in kept)
        assert max(Counter(imported).values(), default=1) == 1
        mirrored = in_file(self.standing)
        assert mirrored[: len(in_database)] == in_database
        assert len(mirrored) - len(in_database) <= waiting
        return len(imported)

    def check_all_there(self) -> None:
        """All that was ever written is imported, once, byte for byte."""
        self.check()
        said_alike(self.standing)
        with self.standing.reading() as connection:
            rows = connection.execute(sa.select(file.c.sha256, file.c.store_path)).all()
        assert sorted(row.sha256 for row in rows) == sorted(self.written)
        for sha256, path in rows:
            assert self.standing.store.raw(path, sha256) == self.written[sha256].read_bytes()


@pytest.fixture
def lab(tmp_path: Path, database_url: str | None, commands: Commands) -> Iterator[Lab]:
    book = small_book(tmp_path / "lab", ingested=False, database_url=database_url)
    inbox = tmp_path / "inbox"
    inbox.mkdir()
    standing = open_book(book.folder)
    yield Lab(book, commands, inbox, standing)
    standing.close()


def kill_rounds(lab: Lab, rounds: int) -> int:
    """Kill an ingest at a random moment again and again, each taking up what the one before left; how many died."""
    chance = random.Random(4)
    usual_s = []
    for number in range(3):
        before = lab.record(number)
        started = time.monotonic()
        lab.done(*lab.ingest(before))
        usual_s.append(time.monotonic() - started)
    died = in_a_row = 0
    for number in range(3, rounds + 3):
        now = lab.record(number)
        running = lab.commands.start(*lab.ingest(before, now))
        time.sleep(chance.uniform(0, 1.3 * min(usual_s)))
        running.kill()
        code = running.wait()
        assert code in (0, KILLED), running.output.read_text()
        died += code == KILLED
        in_a_row = in_a_row + 1 if code == KILLED else 0
        lab.check(waiting=in_a_row)  # what waits in the file is taken over by a commit, which a kill can prevent again
        before = now
    return died


@pytest.mark.soak
def test_killed_for_long_nothing_is_lost_nothing_is_half_there(lab: Lab) -> None:
    kill_rounds(lab, 1500)
    lab.done(*lab.ingest(lab.inbox))
    lab.check_all_there()
    if lab.standing.engine.dialect.name == "sqlite":
        rows = all_rows(lab.standing.engine)
        lab.standing.close()
        rebuilt(lab.book)
        assert all_rows(lab.standing.engine) == rows


@ON_SQLITE
@pytest.mark.parametrize("every", [3, pytest.param(1, marks=pytest.mark.soak)])
def test_killed_after_each_sync_to_the_disk_the_next_ingest_goes_on(lab: Lab, every: int) -> None:
    """Raw copy, its folder, samples, their folder, journal: one file, and a process that dies after each of them."""
    survived = 0
    for number in range(0, 20, every):
        folder = lab.record(number)
        code, said = lab.commands.run(*lab.ingest(folder), die_after_sync=number + 1)
        assert code in (0, KILLED), said
        lab.check()
        lab.done(*lab.ingest(folder))
        lab.check_all_there()
        survived += code == 0
        if survived:
            break
    assert number >= 5  # at least so many syncs there were


def test_a_statement_cut_off_between_journal_and_commit_is_applied_next_time(lab: Lab) -> None:
    words = ["note", "r001", "left rail squeaked", "--book", str(lab.book.folder)]
    code, _said = lab.commands.run(*words, die_after_sync=1, of="journal.jsonl")
    assert code == KILLED
    assert notes(lab.standing).count("left rail squeaked") == 0
    (late,) = in_file(lab.standing)[len(in_table(lab.standing)) :]
    assert late.new is not None
    assert late.new["text"] == "left rail squeaked"
    state(lab.standing, note, "afterwards")
    assert notes(lab.standing)[-2:] == ["left rail squeaked", "afterwards"]
    assert said_alike(lab.standing)[-2] == late


def test_an_ingest_cut_off_between_journal_and_commit_is_there_already_next_time(lab: Lab) -> None:
    folder = lab.record(0)
    code, _said = lab.commands.run(*lab.ingest(folder), die_after_sync=1, of="journal.jsonl")
    assert code == KILLED
    assert lab.check() == 0
    said = lab.done(*lab.ingest(folder))
    assert "1 file: 0 imported, 1 there already, 0 refused." in said.splitlines()
    lab.check_all_there()


def test_a_new_book_cut_off_anywhere_can_be_made_or_used(tmp_path: Path, commands: Commands) -> None:
    for number in range(1, 10):
        folder = tmp_path / str(number)
        folder.mkdir()
        (folder / "labbook.toml").write_text(small_toml())
        code, said = commands.run("init", folder, "--as", ADA, die_after_sync=number)
        assert code in (0, KILLED), said
        code_again, said = commands.run("init", folder, "--as", ADA)
        assert code_again == 0, said
        code_used, said = commands.run("check", "lubrication", "--book", folder)
        assert code_used == 0, said
        if code == 0:
            break
    assert code == 0


@pytest.mark.soak
@ON_SQLITE
def test_a_full_disk_is_a_sentence_and_nothing_is_lost(lab: Lab) -> None:
    """Files cannot grow beyond a size: first nothing fits, then the raw copy, then all but the last bytes of a line."""
    ends = lab.book.journal.stat().st_size
    refused = 0
    for number, most in enumerate((100, 2000, 20_000, ends + 100, ends + 1000, 10 * ends)):
        folder = lab.record(number)
        for words in (lab.ingest(folder), ["note", "r001", "squeaks", "--book", lab.book.folder]):
            before = lab.check(12), len(in_table(lab.standing)), len(in_file(lab.standing))
            code, said = lab.commands.run(*words, largest_file=most)
            assert code in (0, 2, 3), said
            assert "Traceback" not in said
            if code:
                refused += 1
                assert said.count("labbook: ") == 1, said
                imported, in_database, in_journal = before
                in_journal += "stands in journal.jsonl already: do not say it again" in said
                after = lab.check(12), len(in_table(lab.standing)), len(in_file(lab.standing))
                assert after == (imported, in_database, in_journal)
    assert 4 <= refused < 12
    lab.done(*lab.ingest(lab.inbox))
    lab.check_all_there()


# --- two at once


def test_two_that_ingest_the_same_folder_import_each_file_once(lab: Lab) -> None:
    for number in range(6):
        lab.record(number)
    both = [lab.commands.start(*lab.ingest(lab.inbox)) for _ in range(2)]
    codes = [running.wait() for running in both]
    assert codes == [0, 0], [running.output.read_text() for running in both]
    lab.check_all_there()
    counted = [running.output.read_text().splitlines()[0] for running in both]
    imported = [int(line.split(": ")[1].split(" ")[0]) for line in counted]
    assert sum(imported) == len(lab.written)


@pytest.mark.soak
def test_one_is_killed_while_two_ingest_and_the_other_finishes(lab: Lab) -> None:
    for number in range(12):
        lab.record(number)
    first, second = (lab.commands.start(*lab.ingest(lab.inbox)) for _ in range(2))
    time.sleep(0.15)
    first.kill()
    assert first.wait() in (0, KILLED)
    assert second.wait() == 0, second.output.read_text()
    lab.check_all_there()


@server_in_a_soak("database_url")
def test_many_speakers_at_once_make_one_chain(lab: Lab) -> None:
    before = len(said_alike(lab.standing))
    running = [lab.commands.start("note", "r001", f"remark {number}", "--book", lab.book.folder) for number in range(4)]
    assert [one.wait() for one in running] == [0] * 4
    assert len(said_alike(lab.standing)) == before + 4
    assert {f"remark {number}" for number in range(4)} <= set(notes(lab.standing))


@pytest.mark.soak
@ON_SQLITE
def test_another_reading_killed_after_each_sync_is_made_or_not(lab: Lab) -> None:
    (path,) = lab.record(0).iterdir()
    lab.done(*lab.ingest(path))
    meant = ("aux", "sync", "sequence") * 8
    for number, channel in enumerate(meant):
        gain = f"k_gain={channel}"
        words = ["files", "reread", path.name, "--column", gain, "--book", lab.book.folder]
        code, said = lab.commands.run(*words, die_after_sync=number + 1)
        assert code in (0, KILLED), said
        lab.check()
        if code == 0:
            break
        lab.done("note", "r001", f"after kill {number}", "--book", lab.book.folder)
    assert number >= 2
    lab.check_all_there()
