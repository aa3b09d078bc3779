"""What lies in a folder, to see that nothing in it changed; and where folders of tests are made."""

from __future__ import annotations

import hashlib
import os
import shutil
from pathlib import Path

MEMORY = Path("/dev/shm")


def folder_in_memory(room_bytes: int) -> Path:
    """Return the system's folder in memory where that has so much room, else /tmp."""
    roomy = MEMORY.is_dir() and os.access(MEMORY, os.W_OK) and shutil.disk_usage(MEMORY).free > room_bytes
    return MEMORY if roomy else Path("/tmp")


def contents(folder: Path) -> dict[str, str]:
    """SHA-256 of every file by its path below the folder; folders stand with an empty text.

    What labbook remembers of a journal that it found whole is left out: it changes with the file's time.
    """
    return {
        str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest() if path.is_file() else ""
        for path in sorted(folder.rglob("*"))
        if path.name != ".whole.journal.jsonl"
    }
