"""The journal played back into an empty database: for a rebuild, or beside a book to see what should stand in it.

Meanwhile the files of the journal come from the cache of readings, or are read in other processes while rows are
written in this.

Reading a stored copy and finding its jumps takes most of the time of a rebuild and needs no database. What was found is
taken in the order of the journal, of which no more is in memory than that needs. What another process cannot read, for
whatever reason, is read here when its turn comes, so that an error is the same one.
"""

from __future__ import annotations

import contextlib
import gc
import itertools
import multiprocessing
import os
import signal
import sys
import tempfile
import threading
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent.futures import Future, ProcessPoolExecutor, ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import sqlalchemy as sa

from data_schema import journal
from data_schema.engine import sqlite_engine, writing
from data_schema.errors import BookDamaged, InputRefused, UsageError
from data_schema.journal import Entry
from data_schema.journal_file import NOTHING, JournalFile, LeftOut
from data_schema.journal_rules import checked
from data_schema.queries.facts import Keys, remembering_keys
from data_schema.vocabulary import Action
from ingest.store import Store, raw_path
from labbook.book.making import fill_sqlite
from labbook.book.opening import DATABASE
from labbook.book.write_session import apply_again
from labbook.statements.importing import PreparedImport, ReadSettings, reread_stored
from labbook.statements.reading_cache import forget_unused, pack, remember, remembered, unpack

_ENTRIES_AT_ONCE = 500
"""Commands of so many entries are one transaction: committing and hashing rows for each takes a third of its time."""


@dataclass
class Replay:
    """The journal file played back into empty tables, as far as it goes at the moment.

    With `use_cache` files are read only where the cache of readings has them not; where the replay `needs_samples`,
    also those whose samples are not in the store. Files whose SHA-256 is among the `lost` wait for their raw copies.
    """

    store: Store
    mirror: JournalFile
    step: Callable[[str], None]
    use_cache: bool = True
    needs_samples: bool = True
    lost: frozenset[str] = frozenset()
    hashes: list[str] = field(default_factory=list)
    """Of the entries that were applied, in their order."""
    reports: list[Entry] = field(default_factory=list)
    """Those of them that say that a report was made."""
    without_rows: list[Entry] = field(default_factory=list)
    left_out: LeftOut = NOTHING
    verified: dict[str, str] = field(default_factory=dict)
    """SHA-256 of files of the store, as they lay there when what they hold was verified, by path."""
    _keys: Keys = field(default_factory=dict)

    def apply_to(self, engine: sa.Engine, until: int | None = None) -> None:
        """Apply what the journal holds beyond what was applied before, many commands in one transaction.

        Nothing after entry number `until`, where that is given.
        """
        last = self.mirror.last()
        seq, last_hash = self.reached
        if last is None or seq >= (last.seq if until is None else min(last.seq, until)):
            return
        total = last.seq if until is None else min(last.seq, until)
        entries = journal.verified_chain(self.mirror.tail(seq), (seq, last_hash)) if seq else self.mirror.entries()
        new = checked(itertools.takewhile(lambda entry: entry.seq <= total, entries), self.mirror.remedy)
        forget_unused()
        ahead = ReadingAhead(self.store, self.use_cache, self.needs_samples, self.verified, self.lost)
        with contextlib.closing(ahead), _nothing_collected():
            for some in _batched(journal.commands(ahead.pass_on(new))):
                with writing(engine) as connection, remembering_keys(connection, self._keys):
                    for command in some:
                        self.without_rows += self._applied(connection, command, ahead.take)
                        self.step(f"{command[-1].seq}/{total} {command[-1].action} {command[-1].entity_kind}")
                for entry in itertools.chain.from_iterable(some):
                    self.hashes.append(entry.hash)
                    self.reports += [entry] if entry.action is Action.REPORT else []

    def _applied(
        self, connection: sa.Connection, command: list[Entry], prepared: Callable[[Entry], object]
    ) -> list[Entry]:
        try:
            return apply_again(connection, self.store, command, prepared, self.lost)
        except (InputRefused, UsageError) as error:
            raise BookDamaged(
                f"entry {command[0].seq} of {self.mirror.path} cannot take effect ({error}): keep this journal and "
                "restore a backup beside it, or, where nobody changed it, report the fault with what --debug shows."
            ) from error

    @property
    def reached(self) -> tuple[int, str]:
        """Number and hash of the last entry that was applied."""
        return (len(self.hashes), self.hashes[-1]) if self.hashes else (0, journal.GENESIS)

    def finish(self, engine: sa.Engine, standing: tuple[int, str] | None) -> None:
        """Apply the last entries while nobody can write; `standing` is how far the old database goes, if known."""
        self.apply_to(engine)
        self.left_out = self.mirror.left_out()
        if standing is None or standing[0] == 0:
            return
        seq, last_hash = standing
        if seq > len(self.hashes):
            raise BookDamaged(
                f"{self.mirror.path} ends at entry {len(self.hashes)}, the database at {seq}: write the file anew "
                "from the database with `labbook rebuild --journal`, or restore it from a backup; nothing was changed."
            )
        if self.hashes[seq - 1] != last_hash:
            raise BookDamaged(
                f"entry {seq} of {self.mirror.path} is not entry {seq} of the database: the two belong to different "
                "books; put the right ones together; nothing was changed."
            )


@contextlib.contextmanager
def _nothing_collected() -> Iterator[None]:
    """Let Python look for no circles of objects, of which a replay leaves none: that takes a sixth of its time."""
    was_enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_enabled:
            gc.enable()


def _batched(commands: Iterable[list[Entry]]) -> Iterator[list[list[Entry]]]:
    """Gather commands until they have enough entries."""
    some: list[list[Entry]] = []
    n_entries = 0
    for command in commands:
        some.append(command)
        n_entries += len(command)
        if n_entries >= _ENTRIES_AT_ONCE:
            yield some
            some, n_entries = [], 0
    if some:
        yield some


@contextlib.contextmanager
def replayed(
    store: Store,
    mirror: JournalFile,
    until: int,
    step: Callable[[str], None],
    *,
    use_cache: bool,
    lost: frozenset[str] = frozenset(),
) -> Iterator[tuple[sa.Engine, Replay]]:
    """Make the database that raw copies and the first `until` entries of the journal give, for as long as it is used.

    It lies in a temporary folder of the system, with the samples of what was read. Of the book, only raw copies and
    journal are read; with `use_cache`, no raw copies but of files that the cache of readings has not. Those of the
    `lost`, by SHA-256, are not read: `lost_copies` of the book.
    """
    with tempfile.TemporaryDirectory(prefix="labbook-replay-") as name:
        folder = Path(name)
        (folder / "raw").symlink_to((store.root / "raw").resolve())
        fill_sqlite(folder / DATABASE)
        engine = sqlite_engine(folder / DATABASE, scratch=True)
        try:
            replay = Replay(Store(folder), mirror, step, use_cache=use_cache, needs_samples=False, lost=lost)
            replay.apply_to(engine, until)
            yield engine, replay
        finally:
            engine.dispose()


FEWEST = 64
"""With fewer files, starting processes takes longer than it saves."""
AHEAD = 256
"""So many files are asked for before the first is taken: they are read while the rows of a run sheet are written."""
_MOST_WAITING = 5000
"""So many entries wait at most for more files to be read."""
_MOST_PROCESSES = 4
"""More would wait for the rows to be written."""


@dataclass
class ReadingAhead:
    """Passes entries on some time after it has seen them; the files that they name are read meanwhile.

    With `use_cache` one is not read that was read before, but where its samples are needed and not in the store.
    """

    store: Store
    use_cache: bool
    needs_samples: bool
    verified: dict[str, str] = field(default_factory=dict)
    lost: frozenset[str] = frozenset()
    _pool: ProcessPoolExecutor | None = None
    _asked: dict[int, Future[bytes]] = field(default_factory=dict)
    _known: dict[int, PreparedImport] = field(default_factory=dict)
    _checking: dict[int, Future[bool]] = field(default_factory=dict)
    _threads: ThreadPoolExecutor = field(default_factory=lambda: ThreadPoolExecutor(_MOST_PROCESSES))

    def pass_on(self, entries: Iterable[Entry]) -> Iterator[Entry]:
        """Pass entries on in their order."""
        waiting: deque[tuple[Entry, bool]] = deque()
        to_read = 0
        for entry in entries:
            reads = self._must_read(entry)
            waiting.append((entry, reads))
            to_read += reads
            if reads and self._pool is not None:
                self._ask(self._pool, entry)
            elif reads and to_read == FEWEST and _processors() > 1 and sys.executable:
                self._pool = ProcessPoolExecutor(
                    min(_processors(), _MOST_PROCESSES), multiprocessing.get_context("spawn"), _begin
                )
                for one, one_reads in waiting:
                    if one_reads:
                        self._ask(self._pool, one)
            while waiting and (not to_read or to_read >= AHEAD or len(waiting) >= _MOST_WAITING):
                first, first_reads = waiting.popleft()
                to_read -= first_reads
                yield first
        yield from (entry for entry, _reads in waiting)

    def take(self, entry: Entry) -> PreparedImport | None:
        """Return what was read of an entry's file, waiting for it; None where it must be read in this process."""
        if entry.seq in self._known:
            done, checking = self._known.pop(entry.seq), self._checking.pop(entry.seq, None)
            return done if checking is None or checking.result() else None
        asked = self._asked.pop(entry.seq, None)
        if asked is None:
            return None
        try:
            return unpack(asked.result())
        except Exception:
            return None

    def close(self) -> None:
        """Let the processes end after the files that they are reading."""
        self._threads.shutdown(cancel_futures=True)
        if self._pool is not None:
            self._pool.shutdown(cancel_futures=True)

    def _must_read(self, entry: Entry) -> bool:
        """Tell whether an entry's file has to be read; what is known of another is kept for its turn."""
        if not entry.reads:
            return False
        new = entry.new or {}
        if new["sha256"] in self.lost:
            return False
        done = remembered(new["sha256"], new["settings"]) if self.use_cache else None
        if done is None:
            return True
        copies = {raw_path(done.sha256): done.copy_sha256, **{part.store_path: part.file_sha256 for part in done.parts}}
        self.verified |= {path: sha256 for path, sha256 in copies.items() if sha256 is not None}
        if self.needs_samples:
            if not all((self.store.root / path).exists() for path in copies):
                return True
            self._checking[entry.seq] = self._threads.submit(self._are_whole, done)
        self._known[entry.seq] = done
        return False

    def _are_whole(self, done: PreparedImport) -> bool:
        """Read a raw copy and samples, which a rebuild does not trust; one that was altered is read in its turn."""
        has_samples = self.store.has_samples
        return self.store.has_raw(done.sha256, done.copy_sha256) and all(
            has_samples(part.store_path, part.sha256, part.file_sha256) for part in done.parts
        )

    def _ask(self, pool: ProcessPoolExecutor, entry: Entry) -> None:
        new = entry.new or {}
        with contextlib.suppress(BrokenProcessPool, OSError):  # then files are read when their turn comes
            root = self.store.root.resolve()
            self._asked[entry.seq] = pool.submit(_read, root, new["sha256"], new["settings"])


def _processors() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _begin() -> None:
    """Begin a process that reads: silent, deaf to Ctrl-C, and at its end when the one that started it is gone."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    nowhere = os.open(os.devnull, os.O_WRONLY)
    for output in (1, 2):
        os.dup2(nowhere, output)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


def _read(root: Path, sha256: str, settings: Mapping[str, Any]) -> bytes:
    """Read a stored copy, and send what the cache of readings has: its samples are in the store."""
    store = Store(root)
    done = reread_stored(store, store.raw(raw_path(sha256), sha256), sha256, ReadSettings.from_json(settings))
    remember(done, settings)
    return pack(done)
