"""Files of the journal are read in other processes while their rows are written in this one.

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
from collections.abc import Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from data_schema.journal import Entry
from data_schema.vocabulary import Action
from ingest.store import Store, raw_path
from labbook.statements.importing import PreparedImport, ReadSettings, reread_stored, sample_counts, with_counts

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
    """Passes entries on some time after it has seen them; the files that they name are read meanwhile."""

    store: Store
    _pool: ProcessPoolExecutor | None = None
    _asked: dict[int, Future[tuple[PreparedImport, Sequence[int]]]] = field(default_factory=dict)

    def pass_on(self, entries: Iterable[Entry]) -> Iterator[Entry]:
        """Pass entries on in their order."""
        waiting: deque[Entry] = deque()
        to_read = 0
        for entry in entries:
            waiting.append(entry)
            if _names_file(entry):
                to_read += 1
                if self._pool is not None:
                    self._ask(self._pool, entry)
                elif to_read == FEWEST and _processors() > 1 and sys.executable:
                    self._pool = ProcessPoolExecutor(
                        min(_processors(), _MOST_PROCESSES), multiprocessing.get_context("spawn"), _begin
                    )
                    for one in filter(_names_file, waiting):
                        self._ask(self._pool, one)
            while to_read >= AHEAD or len(waiting) >= _MOST_WAITING:
                to_read -= _names_file(waiting[0])
                yield waiting.popleft()
        yield from waiting

    def take(self, entry: Entry) -> PreparedImport | None:
        """Return what was read of an entry's file, waiting for it; None where it must be read in this process."""
        asked = self._asked.pop(entry.seq, None)
        if asked is None:
            return None
        try:
            done, counts = asked.result()
        except Exception:
            return None
        return replace(done, read=with_counts(done.read, counts))

    def close(self) -> None:
        """Let the processes end after the files that they are reading."""
        if self._pool is not None:
            self._pool.shutdown(cancel_futures=True)

    def _ask(self, pool: ProcessPoolExecutor, entry: Entry) -> None:
        new = entry.new or {}
        with contextlib.suppress(BrokenProcessPool, OSError):  # then files are read when their turn comes
            root = self.store.root.resolve()
            self._asked[entry.seq] = pool.submit(_read, root, new["sha256"], new["settings"])


@contextlib.contextmanager
def reading_ahead(store: Store) -> Iterator[ReadingAhead]:
    """Have files read ahead until the end of the block."""
    ahead = ReadingAhead(store)
    try:
        yield ahead
    finally:
        ahead.close()


def _names_file(entry: Entry) -> bool:
    return entry.action in (Action.INGEST, Action.READ)


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


def _read(root: Path, sha256: str, settings: Mapping[str, Any]) -> tuple[PreparedImport, Sequence[int]]:
    """Read a stored copy; its samples are in the store, so that their numbers alone are sent."""
    store = Store(root)
    done = reread_stored(store, store.raw(raw_path(sha256), sha256), sha256, ReadSettings.from_json(settings))
    counts = sample_counts(done.read)
    return replace(done, read=with_counts(done.read, [0] * len(counts))), counts
