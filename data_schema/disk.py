"""Write files so that they survive a power cut; a file that is replaced is kept under another name.

Also refuse network drives, on which SQLite's locks cannot be trusted.
"""

from __future__ import annotations

import contextlib
import fcntl
import json
import os
import re
import secrets
import stat
from collections.abc import Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from data_schema.errors import BookBusy, UsageError

PART = ".part"
"""The ending of the name of a file that is being written; the name begins with a dot."""

_SYNCED_AT_ONCE = 16


def sync(path: Path) -> None:
    """Sync a file's content to the disk, or the names in a folder."""
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def is_special(path: Path) -> bool:
    """Tell whether something else than a file of bytes is there: a pipe or device would be waited for without end, and
    a link leads out of the book.
    """
    try:
        return not stat.S_ISREG(path.lstat().st_mode)
    except FileNotFoundError:
        return False


SPECIAL = "is a link, a pipe or a device, and no file"


def make_folder(folder: Path) -> None:
    """Make a folder and those above it, so that none of the new names is lost in a power cut."""
    missing = [place for place in (folder, *folder.parents) if not place.exists()]
    folder.mkdir(parents=True, exist_ok=True)
    for place in missing:
        sync(place.parent)


def sync_names(folder: Path, root: Path) -> None:
    """Make the names in a folder survive a power cut, and those on the way to it from `root`.

    Also of existing folders: the program that made them may have been killed before they were synced.
    """
    while folder != root:
        sync(folder)
        folder = folder.parent
    sync(root)


def sync_all(folder: Path) -> None:
    """Make a folder survive a power cut with all that is in it."""
    with ThreadPoolExecutor(_SYNCED_AT_ONCE) as pool:  # one write of the file system's journal serves many files
        list(pool.map(sync, (*folder.rglob("*"), folder)))


def stamp() -> str:
    """Return the time as part of a name."""
    return f"{datetime.now(UTC):%Y%m%dT%H%M%S%f}Z"


def today_utc() -> str:
    """Return the day."""
    return f"{datetime.now(UTC):%Y-%m-%d}"


def partial_path(path: Path) -> Path:
    """Return the path at which a file is written until it is complete: always the same, so that none pile up."""
    return path.with_name(f".{path.name}{PART}")


@contextlib.contextmanager
def path_in_errors(path: Path) -> Iterator[None]:
    """Put the path of a file into errors of the system, which name its temporary part instead."""
    try:
        yield
    except OSError as error:
        raise OSError(error.errno, error.strerror, str(path)) from error


def put_in_place(path: Path) -> None:
    """Sync the completed part of a file and rename it to the file's name, replacing an existing file."""
    part = partial_path(path)
    sync(part)
    part.replace(path)
    sync(path.parent)


def write_whole(path: Path, content: bytes) -> None:
    """Write a file atomically: if the writing is cut off, the old content stays."""
    make_folder(path.parent)
    with path_in_errors(path):
        partial_path(path).write_bytes(content)
        put_in_place(path)


@contextlib.contextmanager
def replace_together(files: Mapping[Path, bytes]) -> Iterator[None]:
    """Write files under temporary names, run the body of the `with` statement, and only then rename them.

    A reader sees the old bytes of a file or the new, never a half; where one cannot be written none gets its name.
    """
    beside = {path: path.with_name(f".{path.name}.{secrets.token_hex(4)}{PART}") for path in files}
    try:
        for path, part in beside.items():
            with path_in_errors(path):
                part.write_bytes(files[path])
        yield
        for path, part in beside.items():
            with path_in_errors(path):
                part.replace(path)
    finally:
        for part in beside.values():
            with contextlib.suppress(OSError):  # nothing of it is there where nothing may be written
                part.unlink()


def read_json(path: Path) -> dict[str, Any]:
    """Return the content of a small JSON file of labbook's; an empty one where it cannot be read."""
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return content if isinstance(content, dict) else {}


def write_json(path: Path, content: dict[str, Any]) -> None:
    """Write such a file, whole or not at all."""
    write_whole(path, (json.dumps(content, indent=2, ensure_ascii=False) + "\n").encode())


@contextlib.contextmanager
def exclusive_lock(path: Path, otherwise: str) -> Iterator[None]:
    """Lock an existing file against other programs that lock it; raises `BookBusy` where one has it locked."""
    with path.open("r+b") as handle:
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError as error:
            raise BookBusy(otherwise) from error
        if not _is_at(handle.fileno(), path):  # who held it has removed it, or put another file in its place
            raise BookBusy(otherwise)
        yield


def _is_at(descriptor: int, path: Path) -> bool:
    try:
        return os.path.samestat(os.fstat(descriptor), path.stat())
    except FileNotFoundError:
        return False


MOUNTS = Path("/proc/mounts")
"""The system's table of mounts: a line each, `device mount-point file-system options ...`."""

NETWORK_FILE_SYSTEMS = frozenset(
    {"nfs", "nfs4", "cifs", "smb3", "smbfs", "afs", "9p", "davfs", "fuse.davfs2", "fuse.sshfs"}
)


def file_system_of(path: Path, mounts: Path = MOUNTS) -> str | None:
    """Return the kind of file system that `path` lies on; None on systems without a table of mounts.

    The longest mount point above the path decides, and of equal ones the last, which covers the others.
    """
    if not mounts.exists():
        return None
    resolved = path.resolve()
    best, kind = -1, None
    for line in mounts.read_text(encoding="utf-8", errors="replace").splitlines():
        _device, escaped, file_system, *_rest = line.split(" ")
        point = Path(_unescaped(escaped))
        if resolved.is_relative_to(point) and len(point.parts) >= best:
            best, kind = len(point.parts), file_system
    return kind


def refuse_network_drive(path: Path, mounts: Path = MOUNTS) -> None:
    """Raise `UsageError` when `path` lies on a network drive."""
    kind = file_system_of(path, mounts)
    if kind in NETWORK_FILE_SYSTEMS:
        raise UsageError(
            f"{path} lies on a network drive ({kind}), where SQLite can lose data: keep the book on a local disk, "
            "or share it through PostgreSQL with [database] url in labbook.toml."
        )


def _unescaped(text: str) -> str:
    """Undo the octal escapes of blanks and backslashes in a mount point, as in `/mnt/my\\040share`."""
    return re.sub(r"\\([0-7]{3})", lambda found: chr(int(found.group(1), 8)), text)
