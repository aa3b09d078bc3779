"""Copying the essential files of a book, its journal and the raw copies that this names, into a backup or out of one.

A raw copy that is there already is read and compared with its hash, never trusted by its name. Each file appears whole
or not at all, so a copying that was cut off is completed by the next.
"""

from __future__ import annotations

import contextlib
import errno
import shutil
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from data_schema.disk import (
    is_special,
    make_folder,
    partial_path,
    path_in_errors,
    put_in_place,
    read_json,
    sync_names,
    write_json,
    write_whole,
)
from data_schema.errors import BookDamaged, UsageError
from data_schema.journal import Entry
from data_schema.journal_file import JournalFile
from ingest.store import Store, raw_path
from labbook.config.model import Configuration

Counted = Callable[[int], AbstractContextManager[Callable[[str], None]]]
"""Shows that so many steps will be made, and takes each."""


@dataclass(frozen=True, slots=True)
class CopiedRaw:
    """How many raw copies are there now, how many of them and how many bytes were written, and the problems.

    `replaced` of the copies that were written replaced a damaged one.
    """

    raw_copies: int
    written: int
    replaced: int
    n_bytes: int
    problems: tuple[str, ...]


def raw_of(entries: Iterable[Entry]) -> list[str]:
    """Return the SHA-256 of every raw copy that entries of a journal name, in the order of their first import."""
    read = (entry.new or {} for entry in entries if entry.reads)
    return list(dict.fromkeys(str(new["sha256"]) for new in read if "sha256" in new))


def copy_raw(source: Store, target: Store, wanted: Sequence[str], counted: Counted) -> CopiedRaw:
    """Copy raw copies to another store; one that cannot be copied is a problem, and does not stop the others."""
    written = replaced = n_bytes = 0
    problems = []
    with counted(len(wanted)) as step:
        for sha256 in wanted:
            place = target.root / raw_path(sha256)
            there = place.exists()
            if not (there and _holds(target, place, sha256)):
                try:
                    _bring(source, place, target, sha256)
                except BookDamaged as error:
                    problems.append(str(error))
                else:
                    written, replaced, n_bytes = written + 1, replaced + there, n_bytes + place.stat().st_size
            step(sha256)
    for folder in {(target.root / raw_path(sha256)).parent for sha256 in wanted}:
        if folder.exists():  # also of copies that were there: who made them may have been killed before that
            sync_names(folder, target.root)
    return CopiedRaw(len(wanted), written, replaced, n_bytes, tuple(problems))


def _holds(store: Store, place: Path, sha256: str) -> bool:
    try:
        store.raw(str(place.relative_to(store.root)), sha256)
    except BookDamaged:
        return False
    return True


def _bring(source: Store, place: Path, target: Store, sha256: str) -> None:
    """Copy one file, read the copy, and only then give it its name."""
    make_folder(place.parent)
    part = partial_path(place)
    part.unlink(missing_ok=True)  # one that was cut off may be read-only
    with contextlib.suppress(FileNotFoundError), _naming(place):
        copied = source.root / raw_path(sha256)
        if not is_special(copied):
            shutil.copyfile(copied, part)
        if _holds(target, part, sha256):
            with contextlib.suppress(OSError):  # some sticks and drives know no permissions
                part.chmod(part.stat().st_mode & 0o444)
            put_in_place(place)
            return
    part.unlink(missing_ok=True)
    source.raw(raw_path(sha256), sha256)  # raises an error that names what is wrong with it
    raise BookDamaged(f"{place} was not written as it was read: check the disk that it lies on.")


@contextlib.contextmanager
def _naming(target: Path) -> Iterator[None]:
    """Name the file that could not be written: where the disk is full, Python names the one that was read."""
    try:
        yield
    except OSError as error:
        if error.errno in (errno.ENOSPC, errno.EDQUOT, errno.EFBIG):
            raise OSError(error.errno, error.strerror, target) from error
        raise


def put_journal(path: Path, entries: Sequence[Entry]) -> None:
    """Write a whole journal file; raises `UsageError` where an existing one holds entries that this one lacks."""
    if not begins_with(entries, readable_hashes(path) or []):
        raise UsageError(
            f"{path} holds entries that the journal to be written there does not: they belong to another book, or to "
            "this one at another time; name another folder."
        )
    make_folder(path.parent)
    with path_in_errors(path):
        with partial_path(path).open("wb") as part:
            part.writelines(f"{entry.line}\n".encode() for entry in entries)
        put_in_place(path)


def refuse_cut_journal(entries: Sequence[Entry], known: tuple[int, str], sentence: str) -> None:
    """Raise `BookDamaged` with a sentence unless the entries reach a known number of entries and last hash.

    A hash of "" is not known.
    """
    seq, last_hash = known
    if seq > len(entries) or (seq and last_hash not in ("", entries[seq - 1].hash)):
        raise BookDamaged(sentence)


def put_scene(folder: Path, configuration: Configuration) -> str | None:
    """Write the book's own scene file under its name in labbook.toml; returns the name of one outside the book."""
    simulation = configuration.simulation
    if simulation is None or simulation.scene_toml is None:
        return None
    path = folder / simulation.scene
    if not path.resolve().is_relative_to(folder.resolve()):
        return simulation.scene
    write_whole(path, simulation.scene_toml.encode())
    return None


def readable_hashes(path: Path) -> list[str] | None:
    """Return the hashes of the entries of a journal file; None where there is none, or where it is damaged."""
    try:
        return [entry.hash for entry in JournalFile(path).entries()]
    except BookDamaged:
        return None


def begins_with(entries: Sequence[Entry], hashes: Sequence[str]) -> bool:
    """Tell whether a journal begins with the entries that have these hashes; each holds the one before it."""
    return not hashes or (len(hashes) <= len(entries) and entries[len(hashes) - 1].hash == hashes[-1])


def claim(folder: Path, marker: str, mine: dict[str, Any], whose: str, refused: str) -> Path:
    """Mark a folder as in use by a small file in it, before anything else is written there; returns the file.

    A folder that holds other things is `refused`; so is one that is marked for another use, with the message `whose`.
    """
    path = folder / marker
    recorded = read_json(path)
    if any(key in recorded and recorded[key] != value for key, value in mine.items()):
        raise UsageError(whose)
    if recorded:
        return path
    if folder.exists() and any(found not in (path, partial_path(path)) for found in folder.iterdir()):
        raise UsageError(refused)
    try:
        write_json(path, mine)
    except FileNotFoundError as error:
        if not folder.exists():
            raise UsageError(f"the folder {folder} cannot be made here: name one on another disk.") from error
        return claim(folder, marker, mine, whose, refused)  # another program claims the folder, and was quicker
    return path
