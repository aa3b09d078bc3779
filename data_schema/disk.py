"""What must survive a power cut is synced to the disk; what something takes the place of is kept under another name."""

from __future__ import annotations

import os
from datetime import UTC, datetime
from pathlib import Path


def sync(path: Path) -> None:
    """Make the content of a file survive a power cut; of a folder, the names in it."""
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def make_folder(folder: Path) -> None:
    """Make a folder and those above it, so that none of the new names is lost in a power cut."""
    missing = [place for place in (folder, *folder.parents) if not place.exists()]
    folder.mkdir(parents=True, exist_ok=True)
    for place in missing:
        sync(place.parent)


def sync_names(folder: Path, root: Path) -> None:
    """Make the names in a folder survive a power cut, and those on the way to it from `root`.

    Also of folders that are there already: who made them may have been killed before they were synced.
    """
    while folder != root:
        sync(folder)
        folder = folder.parent
    sync(root)


def sync_all(folder: Path) -> None:
    """Make a folder survive a power cut with all that is in it."""
    for place in (*folder.rglob("*"), folder):
        sync(place)


def stamp() -> str:
    """Return the time as part of a name."""
    return f"{datetime.now(UTC):%Y%m%dT%H%M%S%f}Z"
