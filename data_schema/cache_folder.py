"""The user's cache folder: what was computed once, under a hash of what computed it, where nobody else may write."""

from __future__ import annotations

import contextlib
import os
import re
import shutil
import stat
from collections.abc import Iterator
from pathlib import Path

CACHE_VARIABLE = "LABBOOK_CACHE"
"""Environment variable with the folder for what is computed once; otherwise the user's cache folder is taken."""
_OTHERS_WRITE = stat.S_IWGRP | stat.S_IWOTH
_VERSION = re.compile("[0-9a-f]{20}")


def cache_folder(kind: str) -> Path:
    """Return the folder for all versions of what is cached of a kind, such as "kernels"."""
    if given := os.environ.get(CACHE_VARIABLE):
        return Path(given) / f"labbook-{kind}"
    home = os.environ.get("XDG_CACHE_HOME")
    return (Path(home) if home else Path.home() / ".cache") / "labbook" / kind


def make_version_folder(kind: str, version: str) -> Path:
    """Return the folder of a version, which is a hash of 20 hexadecimal digits; made where it is missing."""
    folder = cache_folder(kind) / version
    with for_nobody_else():
        folder.mkdir(parents=True, exist_ok=True)
    return folder


@contextlib.contextmanager
def for_nobody_else() -> Iterator[None]:
    """Make files and folders that nobody else can write to, whatever this user's usual rights are."""
    before = os.umask(0o077)
    os.umask(before | _OTHERS_WRITE)
    try:
        yield
    finally:
        os.umask(before)


def places_above(folder: Path) -> tuple[Path, ...]:
    """Return a version's folder and those above it in which somebody could put another in its place."""
    given = os.environ.get(CACHE_VARIABLE)
    return (folder, folder.parent, *([Path(given)] if given else []))


def why_not_trusted(place: Path) -> str | None:
    """Say who else could have put there what is read from a file or folder; None where nobody could."""
    found = place.stat()
    is_sticky = stat.S_ISDIR(found.st_mode) and found.st_mode & stat.S_ISVTX  # nobody replaces another's there
    if found.st_uid in (os.geteuid(), 0) and (is_sticky or not found.st_mode & _OTHERS_WRITE):
        return None
    return "others may write to it" if found.st_mode & _OTHERS_WRITE else "it belongs to somebody else"


def forget_old_versions(current: Path, n_retained: int) -> None:
    """Remove the folders of all but the `n_retained` latest versions, of which `current` is one."""
    others = [path for path in current.parent.iterdir() if _VERSION.fullmatch(path.name) and path != current]
    others.sort(key=lambda path: path.stat().st_mtime, reverse=True)
    for path in others[n_retained - 1 :]:
        shutil.rmtree(path, ignore_errors=True)
