"""A watch that is killed at any moment: what it acknowledged is in the book, once, and the next one goes on."""

from __future__ import annotations

import hashlib
import json
import random
import threading
import time
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

import pytest

from ingest.store import raw_path
from tests.helpers.books import SmallBook, short_log, small_book
from tests.helpers.commands import KILLED, Commands, Running
from tests.helpers.upkeep import health, rebuilt_alike

pytestmark = pytest.mark.skipif(not Path("/proc/self/fd").exists(), reason="the files of a process are not in /proc")


@dataclass
class Rig:
    """A book, the folder that is watched, and an instrument that writes logs to it, some in two halves."""

    book: SmallBook
    commands: Commands
    inbox: Path
    whole: dict[str, bytes] = field(default_factory=dict)
    acknowledged: set[str] = field(default_factory=set)
    replaced: int = 0

    def watch(self, *words: str, **how: int) -> Running:
        told = ["--json", "--still", "0.05", "--book", self.book.folder]
        return self.commands.start("watch", self.inbox, *told, *words, **how)

    def write(self, number: int, pause_s: float) -> None:
        """Write a log, with a pause in the middle."""
        name, content = f"log of round {number}.csv", short_log(number)
        half = content.index(b"\n", len(content) // 2) + 1
        self.whole[name] = content
        with (self.inbox / name).open("wb") as log:
            for piece in (content[:half], content[half:]):
                log.write(piece)
                log.flush()
                time.sleep(pause_s)

    def read(self, running: Running) -> None:
        """Take note of what was acknowledged; the last line of a killed process may be cut off, or all missing."""
        told = running.output.read_text() if running.output.exists() else ""
        for line in told.splitlines(keepends=True):
            if line.endswith("\n"):
                happened = json.loads(line)
                if happened["event"] == "file" and happened["status"] in ("imported", "duplicate"):
                    self.acknowledged.add(happened["sha256"])
                self.replaced += len(happened["replaced"]) if happened["event"] == "file" else 0

    def check(self) -> None:
        """All that was acknowledged is in the book, and nothing is twice."""
        assert health(self.book).problems == ()
        with self.book.open() as book, book.reading() as connection:
            kept = list(connection.exec_driver_sql("SELECT sha256 FROM file").scalars())
            used = connection.exec_driver_sql("SELECT sha256 FROM ingest WHERE status = 'imported'").scalars().all()
            assert all((book.store.root / raw_path(sha256)).is_file() for sha256 in kept)
        assert max(Counter(kept).values(), default=1) == 1
        assert max(Counter(used).values(), default=1) == 1
        assert self.acknowledged <= set(kept)

    def check_whole(self) -> None:
        """Of each log that was written, the whole is in use, and nothing else."""
        self.check()
        with self.book.open() as book, book.reading() as connection:
            query = "SELECT original_name, sha256 FROM ingest WHERE status = 'imported' ORDER BY original_name"
            used = [tuple(row) for row in connection.exec_driver_sql(query)]
        hashes = {name: hashlib.sha256(content).hexdigest() for name, content in self.whole.items()}
        assert used == sorted(hashes.items())


@pytest.fixture
def rig(tmp_path: Path, commands: Commands) -> Rig:
    inbox = tmp_path / "inbox"
    inbox.mkdir()
    return Rig(small_book(tmp_path / "lab", ingested=False), commands, inbox)


@pytest.mark.parametrize("kills", [5, pytest.param(300, marks=pytest.mark.soak)])
def test_a_watch_killed_at_any_moment_loses_nothing_and_takes_nothing_twice(rig: Rig, kills: int) -> None:
    chance = random.Random(kills)
    died = 0
    for number in range(kills):
        running = rig.watch()
        writer = threading.Thread(target=rig.write, args=(number, chance.uniform(0.0, 0.4)))
        writer.start()
        time.sleep(chance.uniform(0.05, 0.8))
        running.kill()
        died += running.wait() == KILLED
        writer.join()
        rig.read(running)
        if number % 10 == 0:
            rig.check()
    assert died == kills
    last = rig.watch("--once")
    assert last.wait() == 0, last.output.read_text()
    rig.read(last)
    rig.check_whole()
    rebuilt_alike(rig.book)


@pytest.mark.parametrize("every", [3, pytest.param(1, marks=pytest.mark.soak)])
def test_killed_after_each_sync_to_the_disk_a_half_and_its_whole_are_one_log(rig: Rig, every: int) -> None:
    """The sync of the journal is one of these: what it says and the database lacks takes effect with the next watch."""
    survived = 0
    for number in range(0, 24, every):
        name, content = f"log of round {number}.csv", short_log(number)
        half = content.index(b"\n", len(content) // 2) + 1
        rig.whole[name] = content
        for piece in (content[:half], content):
            (rig.inbox / name).write_bytes(piece)
            first = rig.watch("--once", die_after_sync=number + 1)
            code = first.wait()
            assert code in (0, KILLED), first.output.read_text()
            rig.read(first)
        last = rig.watch("--once")
        assert last.wait() == 0, last.output.read_text()
        rig.read(last)
        rig.check_whole()
        survived += code == 0
        if survived:
            break
    assert number >= 5
    assert rig.replaced
    rebuilt_alike(rig.book)
