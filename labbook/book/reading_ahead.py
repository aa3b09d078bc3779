"""Files of the journal come from the cache of readings, or are read in other processes while rows are written in this.

Reading a stored copy and finding its jumps takes most of the time of a rebuild and needs no database. What was found is
taken in the order of the journal, of which no more is in memory than that needs. What another process cannot read, for
whatever reason, is read here when its turn comes, so that an error is the same one.
"""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import signal
import sys
import threading
from collections import deque
from collections.abc import Iterable, Iterator, Mapping
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from data_schema.journal import Entry
from data_schema.vocabulary import Action
from ingest.store import Store, raw_path
from labbook.statements.importing import PreparedImport, ReadSettings, reread_stored
from labbook.statements.reading_cache import pack, remember, remembered, unpack

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
    _pool: ProcessPoolExecutor | None = None
    _asked: dict[int, Future[bytes]] = field(default_factory=dict)
    _known: dict[int, PreparedImport] = field(default_factory=dict)

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
            return self._known.pop(entry.seq)
        asked = self._asked.pop(entry.seq, None)
        if asked is None:
            return None
        try:
            return unpack(asked.result())
        except Exception:
            return None

    def close(self) -> None:
        """Let the processes end after the files that they are reading."""
        if self._pool is not None:
            self._pool.shutdown(cancel_futures=True)

    def _must_read(self, entry: Entry) -> bool:
        """Tell whether an entry's file has to be read; what is known of another is kept for its turn."""
        if entry.action not in (Action.INGEST, Action.READ):
            return False
        new = entry.new or {}
        done = remembered(new["sha256"], new["settings"]) if self.use_cache else None
        if done is None or (self.needs_samples and not self._has_files(done)):
            return True
        self._known[entry.seq] = done
        return False

    def _has_files(self, done: PreparedImport) -> bool:
        paths = {part.store_path: part.sha256 for part in done.parts}
        return self.store.has_raw(done.sha256) and all(self.store.has_samples(*item) for item in paths.items())

    def _ask(self, pool: ProcessPoolExecutor, entry: Entry) -> None:
        new = entry.new or {}
        with contextlib.suppress(BrokenProcessPool, OSError):  # then files are read when their turn comes
            root = self.store.root.resolve()
            self._asked[entry.seq] = pool.submit(_read, root, new["sha256"], new["settings"])


@contextlib.contextmanager
def reading_ahead(store: Store, *, use_cache: bool, needs_samples: bool) -> Iterator[ReadingAhead]:
    """Have files read ahead until the end of the block."""
    ahead = ReadingAhead(store, use_cache, needs_samples)
    try:
        yield ahead
    finally:
        ahead.close()


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
