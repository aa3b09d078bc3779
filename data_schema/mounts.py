"""Where a file lies: SQLite's locks cannot be trusted on network drives, so a book is never opened on one."""

from __future__ import annotations

import re
from pathlib import Path

from data_schema.errors import UsageError

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
