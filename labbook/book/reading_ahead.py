"""Files of the journal are read in other processes while their rows are written in this one.

Reading a kept copy and finding its jumps takes most of the time of a rebuild and needs no database. Each process reads
every n-th file that is to come; what it found is taken in the order of the journal. What it cannot read, for whatever
reason, is read here when its turn comes, so that an error is the same one. A process ends when its input does, also
where this one was killed.
"""

from __future__ import annotations

import contextlib
import gc
import os
import pickle
import queue
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeAlias

from data_schema.journal import Entry
from data_schema.vocabulary import Action
from ingest.store import Store
from labbook.statements.importing import PreparedImport, ReadSettings, read_anew, sample_counts, with_counts

FEWEST = 64
"""With fewer files to read, starting processes takes longer than it saves."""
MOST_PROCESSES = 4
"""More would wait for the rows to be written."""
AHEAD = 8
"""So many files are waiting to be read, or to be taken, at each process."""

Take = Callable[[Entry], PreparedImport | None]
"""Gives what was read of an entry's file; None where it is to be read here."""

_Asked: TypeAlias = tuple[Path, int, str, dict[str, Any]]
"""Where the store is, the number of an entry, the file's SHA-256, and how it is to be read."""

_COMMAND = (sys.executable, "-P", "-c", "from labbook.book.reading_ahead import serve; serve()")


@contextlib.contextmanager
def reading_ahead(store: Store, entries: Sequence[Entry], left_out: Collection[int] = ()) -> Iterator[Take]:
    """Read the files of the entries that say how they were read, but for those `left_out`, where that saves time."""
    wanted = [entry for entry in entries if _says_how(entry) and entry.seq not in left_out]
    count = min(_processors(), MOST_PROCESSES)
    if len(wanted) < FEWEST or count < 2 or not sys.executable:
        yield lambda _entry: None
        return
    with contextlib.ExitStack() as stack:
        readers = [stack.enter_context(_Reader(store, wanted[place::count])) for place in range(count)]
        reader_of = {entry.seq: readers[place % count] for place, entry in enumerate(wanted)}

        def take(entry: Entry) -> PreparedImport | None:
            reader = reader_of.get(entry.seq)
            return None if reader is None else reader.take(entry.seq)

        yield take


def _says_how(entry: Entry) -> bool:
    return entry.action in (Action.INGEST, Action.READ) and "settings" in (entry.new or {})


def _processors() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


class _Reader:
    """A process that reads files, and those that it is still to be asked for."""

    def __init__(self, store: Store, wanted: Sequence[Entry]) -> None:
        self._root = store.root.resolve()
        self._wanted = iter(wanted)
        self._found: dict[int, PreparedImport | None] = {}
        self._broken = False

    def __enter__(self) -> _Reader:
        path = os.pathsep.join(place for place in sys.path if place)
        self._process = subprocess.Popen(
            _COMMAND,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            env={**os.environ, "PYTHONPATH": path},
        )
        for _ in range(AHEAD):
            self._ask()
        return self

    def __exit__(self, *_error: object) -> None:
        assert self._process.stdin is not None  # noqa: S101 - it was asked for
        assert self._process.stdout is not None  # noqa: S101
        with contextlib.suppress(OSError):
            self._process.stdin.close()
        self._process.stdout.close()
        self._process.wait()

    def take(self, seq: int) -> PreparedImport | None:
        """Return what was read for an entry, waiting for it; None where it could not be."""
        assert self._process.stdout is not None  # noqa: S101
        while seq not in self._found and not self._broken:
            try:
                number, done, counts = pickle.load(self._process.stdout)  # noqa: S301 - of a process of our own
            except (OSError, EOFError, pickle.UnpicklingError):
                self._broken = True
            else:
                self._found[number] = done and replace(done, read=with_counts(done.read, counts))
                self._ask()
        return self._found.pop(seq, None)

    def _ask(self) -> None:
        entry = next(self._wanted, None)
        if entry is None or self._broken:
            return
        assert entry.new is not None  # noqa: S101 - it says how it was read
        assert self._process.stdin is not None  # noqa: S101
        try:
            pickle.dump((self._root, entry.seq, entry.new["sha256"], entry.new["settings"]), self._process.stdin)
            self._process.stdin.flush()
        except OSError:
            self._broken = True


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
    from labbook.statements.ingesting import raw_path

    store = Store(root)
    try:
        data = store.raw(raw_path(sha256), sha256)
        done = read_anew(store, data, sha256, ReadSettings.from_json(settings))
        counts = sample_counts(done.read)
        return pickle.dumps((seq, replace(done, read=with_counts(done.read, [0] * len(counts))), counts))
    except Exception:
        return pickle.dumps((seq, None, []))
