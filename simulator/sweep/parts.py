"""The unfinished sweep on disk: a folder beside the file to come, with one file for each chunk that is done.

A chunk is written under another name, synced and renamed: it is there whole or not at all, whenever the program dies.
"""

from __future__ import annotations

import contextlib
import fcntl
import json
import os
import shutil
import threading
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray

from data_schema.errors import UsageError
from simulator.sweep.chunks import Chunks
from simulator.sweep.disk import sync
from simulator.sweep.identity import Identity, differences

PLAN, LOCK = "sweep.json", "lock"
_SUFFIX = ".f64"
_TYPE = np.dtype("<f8")

Block = NDArray[np.float64]


def part_folder(out: Path) -> Path:
    """Return the folder of the unfinished sweep whose result will be `out`."""
    return out.with_name(f"{out.name}.part")


@dataclass(frozen=True, slots=True)
class Parts:
    """Chunks on disk; `row_shape` is that of one row of the sweep, (jumps, outputs)."""

    folder: Path
    chunks: Chunks
    row_shape: tuple[int, int]

    def missing(self) -> list[int]:
        """Return the numbers of the chunks that are not done."""
        sizes = {entry.name: entry.stat().st_size for entry in os.scandir(self.folder)}
        row_size = self.row_shape[0] * self.row_shape[1] * _TYPE.itemsize
        return [
            number
            for number in range(self.chunks.count)
            if sizes.get(_name(number)) != (self.chunks.bounds(number)[1] - self.chunks.bounds(number)[0]) * row_size
        ]

    def keep(self, number: int, block: Block) -> None:
        """Put a chunk on disk; several threads may do so at once."""
        made = self.folder / f".{_name(number)}.{threading.get_ident()}"
        with made.open("wb") as handle:
            handle.write(np.ascontiguousarray(block, _TYPE).data)
            handle.flush()
            os.fsync(handle.fileno())
        made.replace(self.folder / _name(number))  # a name that a power cut takes back costs one chunk, so no sync

    def read(self, start: int, stop: int) -> Block:
        """Return the rows from `start` to before `stop`, shape (rows, jumps, outputs)."""
        each, numbers = self.chunks.rows_each, self.row_shape[0] * self.row_shape[1]
        found = []
        for number in range(start // each, -(-stop // each)):
            first, after = self.chunks.bounds(number)
            begin, end = max(start, first), min(stop, after)
            offset = (begin - first) * numbers * _TYPE.itemsize
            found.append(np.fromfile(self.folder / _name(number), _TYPE, (end - begin) * numbers, offset=offset))
        return np.concatenate(found).reshape(stop - start, *self.row_shape)


def _name(number: int) -> str:
    return f"{number:08d}{_SUFFIX}"


@contextlib.contextmanager
def opened_parts(out: Path, identity: Identity, chunks: Chunks, row_shape: tuple[int, int]) -> Iterator[Parts]:
    """Open the unfinished sweep beside `out`, or begin one, and let nobody else work on it meanwhile.

    Raises `UsageError` where another sweep was left there, or another program is at work.
    """
    folder = part_folder(out)
    with _alone(folder):
        _check_same(folder, identity)
        for entry in folder.iterdir():
            if entry.name.startswith("."):
                _remove(entry)  # what was being written when a program died
        yield Parts(folder, chunks, row_shape)


def remove_parts(folder: Path) -> None:
    """Remove an unfinished sweep that is open; the file that says what it is goes last, and then the lock."""
    for entry in folder.iterdir():
        if entry.name not in (PLAN, LOCK):
            _remove(entry)
    for name in (PLAN, LOCK):
        (folder / name).unlink(missing_ok=True)
    with contextlib.suppress(OSError):  # another program has a lock of its own there already: the folder is its now
        folder.rmdir()


def _check_same(folder: Path, identity: Identity) -> None:
    plan = folder / PLAN
    if plan.exists():
        there = json.loads(plan.read_text(encoding="utf-8"))
        if there != identity:
            raise UsageError(
                f"{folder} holds an unfinished sweep that differs in {differences(there, identity)}: give the command "
                "that began it, or another --out, or remove that folder."
            )
        return
    if any(not entry.name.startswith(".") and entry.name != LOCK for entry in folder.iterdir()):
        raise UsageError(f"{folder} is in the way and is no unfinished sweep: remove it, or give another --out.")
    made = folder / f".{PLAN}"
    made.write_text(json.dumps(dict(identity), ensure_ascii=False, indent=1), encoding="utf-8")
    sync(made)
    made.replace(plan)
    sync(folder)


def _remove(entry: Path) -> None:
    if entry.is_dir():
        shutil.rmtree(entry)
    else:
        entry.unlink()


@contextlib.contextmanager
def _alone(folder: Path) -> Iterator[None]:
    """Make the folder where it is not there, and hold its lock."""
    while (handle := _locked(folder)) is None:
        pass
    with handle:
        yield


def _locked(folder: Path) -> BinaryIO | None:
    """Return the folder's lock, held; None where the program before has removed the folder meanwhile."""
    with contextlib.suppress(FileExistsError):
        folder.mkdir()
    with contextlib.ExitStack() as stack, contextlib.suppress(FileNotFoundError):
        handle = stack.enter_context((folder / LOCK).open("wb"))
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError as error:
            raise UsageError(
                f"another program is working on {folder}: wait until it has finished, or give another --out."
            ) from error
        if os.path.samestat(os.fstat(handle.fileno()), (folder / LOCK).stat()):
            stack.pop_all()
            return handle
    return None
