"""Files as people name them: imported ones by name, uid or hash; on the command line paths, also of folders."""

from __future__ import annotations

import hashlib
import os
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import sqlalchemy as sa

from data_schema.errors import InputRefused, UsageError, unknown_name
from data_schema.queries.files import FileRow, find_files, imported_names
from data_schema.vocabulary import IngestStatus
from ingest.store import STORED
from labbook.book.opening import CONFIGURATION, DATABASE, JOURNAL
from labbook.terminal import listed


def file_named(connection: sa.Connection, name: str, *, withdrawn: bool = False) -> FileRow:
    """Return the one imported file meant by a name, a uid, the beginning of a hash, or a path of its bytes.

    Of several with one name it is the one in use. Raises where it is none, several, or (unless `withdrawn` ones will
    do) one that was taken out of use.
    """
    found = find_files(connection, name)
    path = Path(name)
    if not found and path.is_file():
        found = find_files(connection, hashlib.sha256(path.read_bytes()).hexdigest())
    if not found:
        raise unknown_name("imported file", name, imported_names(connection), "Ingest it first.")
    in_use = [row for row in found if row.status is not IngestStatus.WITHDRAWN]
    if not withdrawn and len(in_use) == 1:
        found = in_use
    if len(found) > 1:
        listed = ", ".join(f"{row.uid} ({row.at_utc})" for row in found)
        raise UsageError(f"{len(found)} imported files are called {name!r}: name one by its uid: {listed}.")
    (row,) = found
    if row.status is IngestStatus.WITHDRAWN and not withdrawn:
        raise UsageError(f"{row.name} was withdrawn: `labbook files restore {row.uid}` takes it into use again.")
    return row


@dataclass(frozen=True, slots=True)
class FoundFiles:
    """The files that paths mean, each with what messages call it; others in the folders named, each with why not."""

    names: dict[Path, str]
    skipped: dict[str, str]

    @property
    def files(self) -> list[Path]:
        """The files in the order in which they were named or found."""
        return list(self.names)

    @property
    def skipped_line(self) -> str:
        """Name what was skipped and why; "" where nothing was."""
        skipped = [f"{name} ({why})" for name, why in self.skipped.items()]
        return f"skipped ({len(skipped)}): {listed(skipped)}." if skipped else ""


def files_of(paths: Sequence[Path], book_folder: Path) -> FoundFiles:
    """Find the files meant: those named, and all in the folders named, but hidden ones and the book's own."""
    found: dict[Path, int] = {}
    skipped: dict[str, str] = {}
    for path in paths:
        if not path.exists():
            raise InputRefused(f"{path} does not exist: check the name.")
        if not path.is_dir():
            refuse_special(path)
            found[path] = 1
            continue
        for item in sorted(_below(path, skipped)):
            below = item.relative_to(path)
            if item.is_file():
                if not _is_of_book(item, book_folder):
                    found[item] = len(below.parts)
            elif why := _why_skipped(item):
                skipped[readable(below)] = why
    meant = FoundFiles(_names(found), skipped)
    if not found:
        where = ", ".join(map(str, paths))
        also = f"; {meant.skipped_line}" if skipped else "."
        raise InputRefused(f"there is no file in {where}: name the folder the instruments wrote to{also}")
    return meant


def _names(found: Mapping[Path, int]) -> dict[Path, str]:
    """Return what files are called: of each path so many last parts, and more where others would have the same name."""
    names = {path: readable(Path(*path.parts[-n_parts:])) for path, n_parts in found.items()}
    counts = Counter(names.values())
    longer = {path: n + 1 if counts[names[path]] > 1 and n < len(path.parts) else n for path, n in found.items()}
    return names if longer == found else _names(longer)


def readable(path: Path) -> str:
    """Return a path as text; bytes of its name that are not UTF-8 are written as `\\xf6`."""
    return os.fsencode(path).decode("utf-8", "backslashreplace")


def own_name(path: Path) -> str:
    """Return a file's own name as text: what the book and its messages say of where it lay."""
    return readable(Path(path.name))


def _why_skipped(path: Path) -> str | None:
    """Say why what stands in a folder and is no file is left out; None of a folder, which was gone through."""
    if path.is_symlink():
        return "a link to a folder: name that" if path.is_dir() else "a link to nothing"
    return None if path.is_dir() else "no regular file"


def _below(folder: Path, skipped: dict[str, str]) -> Iterator[Path]:
    """Give what stands in a folder and in those below, but what is hidden; a folder that cannot be read is skipped."""

    def skip(error: OSError) -> None:
        skipped[readable(Path(error.filename).relative_to(folder))] = f"cannot be read: {error.strerror}"

    for place, folders, files in os.walk(folder, onerror=skip):
        folders[:] = [name for name in folders if not name.startswith(".")]
        yield from (Path(place, name) for name in (*folders, *files) if not name.startswith("."))


def _is_of_book(path: Path, book_folder: Path) -> bool:
    try:
        first = path.resolve().relative_to(book_folder.resolve()).parts[0]
    except ValueError:
        return False
    return is_own_name(first)


def is_own_name(name: str) -> bool:
    """Tell whether what has this name in a book's folder is the book's own."""
    return name in (*STORED, "reports", CONFIGURATION, JOURNAL) or name.startswith(DATABASE)


def read_bytes(path: Path) -> bytes:
    """Read a file whole; raises `InputRefused` when it is no regular file."""
    if path.is_dir():
        raise InputRefused(f"{path} is a folder: name the file in it.")
    if not path.exists():
        raise InputRefused(f"{path} does not exist: check the name.")
    refuse_special(path)
    return path.read_bytes()


def refuse_special(path: Path) -> None:
    """Raise `InputRefused` for a pipe, a device or a folder, before anything waits for its end."""
    if not path.is_file():
        raise InputRefused(f"{path} is not a regular file: name a file or a folder of files.")
