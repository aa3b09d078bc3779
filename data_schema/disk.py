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


def stamp() -> str:
    """Return the time as part of a name."""
    return f"{datetime.now(UTC):%Y%m%dT%H%M%S%f}Z"
