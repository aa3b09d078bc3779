"""Files of the journal are read in other processes while their rows are written in this one.

Reading a stored copy and finding its jumps takes most of the time of a rebuild and needs no database. Each process
reads every n-th file that is to come; what it found is taken in the order of the journal, of which no more is in memory
than that needs. What it cannot read, for whatever reason, is read here when its turn comes, so that an error is the
same one. A process ends when its input does, also where this one was killed.
"""

from __future__ import annotations

import contextlib
import fcntl
import gc
import os
import pickle
import queue
import signal
import subprocess
import sys
import threading
from collections import deque
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import IO, Any, TypeAlias

from data_schema.journal import Entry
from data_schema.vocabulary import Action
from ingest.store import Store
from labbook.statements.importing import PreparedImport, ReadSettings, reread_stored, sample_counts, with_counts

FEWEST = 64
"""With fewer files, starting processes takes longer than it saves."""
AHEAD = 256
"""So many files are asked for before the first is taken: they are read while the rows of a run sheet are written."""
_PIPE_BYTES = 1 << 19
"""What was read of half of them waits in a pipe; in a usual one there is place for a dozen, then the reader waits."""
_MOST_WAITING = 5000
"""So many entries wait at most for more files to be read."""
_MOST_PROCESSES = 4
"""More would wait for the rows to be written."""

_Asked: TypeAlias = tuple[Path, int, str, dict[str, Any]]
"""Where the store is, the number of an entry, the file's SHA-256, and how it is to be read."""

_COMMAND = (sys.executable, "-P", "-c", "from labbook.book.reading_ahead import serve; serve()")


@dataclass
class ReadingAhead:
    """Passes entries on some time after it has seen them; the files that they name are read meanwhile."""

    store: Store
    _readers: list[_Reader] = field(default_factory=list)
    _reader_of: dict[int, _Reader] = field(default_factory=dict)
    _count: int = 0

    def pass_on(self, entries: Iterable[Entry]) -> Iterator[Entry]:
        """Pass entries on in their order."""
        waiting: deque[Entry] = deque()
        to_read = 0
        for entry in entries:
            waiting.append(entry)
            if self._is_wanted(entry):
                to_read += 1
                if self._readers:
                    self._ask(entry)
                elif to_read == FEWEST and self._start():
                    for one in waiting:
                        if self._is_wanted(one):
                            self._ask(one)
            while to_read >= AHEAD or len(waiting) >= _MOST_WAITING:
                to_read -= self._is_wanted(waiting[0])
                yield waiting.popleft()
        yield from waiting

    def take(self, entry: Entry) -> PreparedImport | None:
        """Return what was read of an entry's file, waiting for it; None where it must be read in this process."""
        reader = self._reader_of.pop(entry.seq, None)
        return None if reader is None else reader.take(entry.seq)

    def close(self) -> None:
        """Let the processes end."""
        for reader in self._readers:
            reader.close()

    def _is_wanted(self, entry: Entry) -> bool:
        return entry.action in (Action.INGEST, Action.READ)

    def _start(self) -> bool:
        """Start processes where there are processors for them; one alone reads no faster than this."""
        count = min(_processors(), _MOST_PROCESSES)
        if count > 1 and sys.executable:
            with contextlib.suppress(OSError):  # with fewer processes, or none, files are read when their turn comes
                for _ in range(count):
                    self._readers.append(_Reader(self.store.root.resolve()))
        return bool(self._readers)

    def _ask(self, entry: Entry) -> None:
        reader = self._readers[self._count % len(self._readers)]
        self._count += 1
        self._reader_of[entry.seq] = reader
        reader.ask(entry)


@contextlib.contextmanager
def reading_ahead(store: Store) -> Iterator[ReadingAhead]:
    """Have files read ahead until the end of the block."""
    ahead = ReadingAhead(store)
    try:
        yield ahead
    finally:
        ahead.close()


def _processors() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _enlarge(pipe: IO[bytes]) -> None:
    """Let a pipe hold more, where the system has such pipes and this user may still have one."""
    if hasattr(fcntl, "F_SETPIPE_SZ"):
        with contextlib.suppress(OSError):
            fcntl.fcntl(pipe, fcntl.F_SETPIPE_SZ, _PIPE_BYTES)


class _Reader:
    """A process that reads files in the order in which it is asked for them."""

    def __init__(self, root: Path) -> None:
        self._root = root
        self._found: dict[int, PreparedImport | None] = {}
        self._broken = False
        self._process = subprocess.Popen(
            _COMMAND,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            env={**os.environ, "PYTHONPATH": os.pathsep.join(place for place in sys.path if place)},
        )
        assert self._process.stdin is not None  # noqa: S101 - they were asked for
        assert self._process.stdout is not None  # noqa: S101
        self._questions, self._answers = self._process.stdin, self._process.stdout
        for pipe in (self._questions, self._answers):
            _enlarge(pipe)

    def ask(self, entry: Entry) -> None:
        """Ask for the file of an entry that says how it was read."""
        assert entry.new is not None  # noqa: S101
        try:
            pickle.dump((self._root, entry.seq, entry.new["sha256"], entry.new["settings"]), self._questions)
            self._questions.flush()
        except OSError:
            self._broken = True

    def take(self, seq: int) -> PreparedImport | None:
        """Return what was read for an entry, waiting for it; None where it could not be."""
        while seq not in self._found and not self._broken:
            try:
                number, done, counts = pickle.load(self._answers)  # noqa: S301 - of a process of our own
            except (OSError, EOFError, pickle.UnpicklingError):
                self._broken = True
            else:
                self._found[number] = done and replace(done, read=with_counts(done.read, counts))
        return self._found.pop(seq, None)

    def close(self) -> None:
        """Let the process end after the file that it is reading."""
        with contextlib.suppress(OSError):
            self._questions.close()
        self._answers.close()
        self._process.wait()


def serve() -> None:
    """Read the files that standard input asks for and answer on standard output, until the input ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # whoever asks ends the input
    gc.set_threshold(100_000)
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # what a plug-in prints is no answer
    asked: queue.SimpleQueue[_Asked | None] = queue.SimpleQueue()
    ended = threading.Event()
    threading.Thread(target=_listen, args=(asked, ended), daemon=True).start()
    with contextlib.suppress(BrokenPipeError):
        while (one := asked.get()) is not None and not ended.is_set():
            answers.write(_answer(*one))
            answers.flush()
    os._exit(0)  # what is left to be written is for nobody


def _listen(asked: queue.SimpleQueue[_Asked | None], ended: threading.Event) -> None:
    """Take all that is asked at once: who asks must never wait for who answers."""
    with contextlib.suppress(EOFError, OSError):
        while True:
            asked.put(pickle.load(sys.stdin.buffer))  # noqa: S301 - of the process that started this one
    ended.set()
    asked.put(None)


def _answer(root: Path, seq: int, sha256: str, settings: dict[str, Any]) -> bytes:
    from ingest.store import raw_path

    store = Store(root)
    try:
        data = store.raw(raw_path(sha256), sha256)
        done = reread_stored(store, data, sha256, ReadSettings.from_json(settings))
        counts = sample_counts(done.read)
        return pickle.dumps((seq, replace(done, read=with_counts(done.read, [0] * len(counts))), counts))
    except Exception:
        return pickle.dumps((seq, None, []))
