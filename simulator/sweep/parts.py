"""The unfinished sweep on disk: a folder beside the file to come, with the jumps of the chunks that are done.

A chunk is synced before it is marked as done, so that a mark stands for whole jumps whenever the program dies.
"""

from __future__ import annotations

import contextlib
import fcntl
import json
import math
import os
import shutil
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

import numpy as np

from data_schema.errors import UsageError
from simulator.sweep.chunks import Block, Chunks, Row
from simulator.sweep.identity import Identity, differences

PLAN, LOCK, COLUMNS, DONE = "sweep.json", "lock", "columns.f64", "done"
_TYPE = np.dtype("<f8")


def part_folder(out: Path) -> Path:
    """Return the folder of the unfinished sweep whose result will be `out`."""
    return out.with_name(f"{out.name}.part")


@dataclass(frozen=True, slots=True)
class Parts:
    """The outputs of a sweep on disk, one column after the other, and a byte a chunk: 1 where it is done.

    `row_shape`: how many jumps and outputs a row of the sweep has.
    """

    folder: Path
    chunks: Chunks
    row_shape: tuple[int, int]

    def missing(self) -> list[int]:
        """Return the numbers of the chunks that are not done."""
        return np.flatnonzero(np.fromfile(self.folder / DONE, np.uint8) == 0).tolist()

    def keep(self, number: int, block: Block) -> None:
        """Put a chunk on disk, shape (rows, jumps, outputs); several threads may do so at once."""
        first, _ = self.chunks.bounds(number)
        with (self.folder / COLUMNS).open("r+b", buffering=0) as columns:
            for place, column in enumerate(np.ascontiguousarray(np.moveaxis(block, -1, 0), _TYPE)):
                columns.seek((place * self.chunks.rows + first) * self.row_shape[0] * _TYPE.itemsize)
                columns.write(column.data)
            os.fsync(columns.fileno())
        with (self.folder / DONE).open("r+b", buffering=0) as done:
            done.seek(number)
            done.write(b"\1")  # a mark that a power cut takes back costs one chunk, so no sync

    def column(self, place: int) -> Row:
        """Return the output at this place among all, shape (rows * jumps,); it is read as it is looked at."""
        jumps = self.chunks.rows * self.row_shape[0]
        return np.memmap(self.folder / COLUMNS, _TYPE, "r", place * jumps * _TYPE.itemsize, jumps)

    def make_room(self) -> None:
        """Make the files where they are not there; nothing is done then."""
        numbers = self.chunks.rows * math.prod(self.row_shape)
        sizes = {COLUMNS: numbers * _TYPE.itemsize, DONE: self.chunks.count}
        if any(not (self.folder / name).exists() for name in sizes):
            for name, size in sizes.items():
                with (self.folder / name).open("wb") as file:
                    file.truncate(size)
            sync(self.folder)


@contextlib.contextmanager
def open_parts(out: Path, identity: Identity, chunks: Chunks, row_shape: tuple[int, int]) -> Iterator[Parts]:
    """Open the unfinished sweep beside `out`, or begin one, and let nobody else work on it meanwhile.

    Raises `UsageError` where another sweep was left there, or another program is at work.
    """
    folder = part_folder(out)
    with _alone(folder):
        _check_same(folder, identity)
        for entry in folder.iterdir():
            if entry.name.startswith("."):
                _remove(entry)  # what was being written when a program died
        parts = Parts(folder, chunks, row_shape)
        parts.make_room()
        yield parts


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


def sync(path: Path) -> None:
    """Make a file's content, or the names in a folder, survive a power cut."""
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


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
