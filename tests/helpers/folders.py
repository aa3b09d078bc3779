"""What lies in a folder, to see that nothing in it changed."""

from __future__ import annotations

import hashlib
from pathlib import Path


def contents(folder: Path) -> dict[str, str]:
    """SHA-256 of every file by its path below the folder; folders stand with an empty text.

    What labbook remembers of a journal that it found whole is left out: it changes with the file's time.
    """
    return {
        str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest() if path.is_file() else ""
        for path in sorted(folder.rglob("*"))
        if path.name != ".whole.journal.jsonl"
    }
