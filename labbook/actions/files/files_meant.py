"""The files that paths on the command line mean: regular ones, and what lies in folders but the book's own."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from data_schema.errors import InputRefused
from labbook.book.opening import CONFIGURATION, DATABASE, JOURNAL


def files_of(paths: Sequence[Path], book_folder: Path) -> list[Path]:
    """Return the files meant: those named, and all in the folders named, but hidden ones and the book's own."""
    found: list[Path] = []
    for path in paths:
        if not path.exists():
            raise InputRefused(f"{path} does not exist: check the name.")
        if not path.is_dir():
            refuse_special(path)
            found.append(path)
            continue
        inside = sorted(item for item in path.rglob("*") if item.is_file() and not _hidden(item, path))
        found += [item for item in inside if not _the_books_own(item, book_folder)]
    if not found:
        raise InputRefused(
            f"there is no file in {', '.join(map(str, paths))}: name the folder the instruments wrote to."
        )
    return list(dict.fromkeys(found))


def _hidden(path: Path, folder: Path) -> bool:
    return any(part.startswith(".") for part in path.relative_to(folder).parts)


def _the_books_own(path: Path, book_folder: Path) -> bool:
    try:
        first = path.resolve().relative_to(book_folder.resolve()).parts[0]
    except ValueError:
        return False
    return first in ("raw", "signals", "reports", CONFIGURATION, JOURNAL) or first.startswith(DATABASE)


def read_bytes(path: Path) -> bytes:
    """Read a file whole; raises `InputRefused` when it is no regular file."""
    if not path.exists():
        raise InputRefused(f"{path} does not exist: check the name.")
    refuse_special(path)
    return path.read_bytes()


def refuse_special(path: Path) -> None:
    """Raise `InputRefused` for a pipe, a device or a folder, before anything waits for its end."""
    if not path.is_file():
        raise InputRefused(f"{path} is not a regular file: name a file or a folder of files.")
