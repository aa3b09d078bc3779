"""A book's labbook.toml, changed as a person would."""

from __future__ import annotations

import re
from pathlib import Path


def without(folder: Path, pattern: str, instead: str = "") -> None:
    """Replace the one place of a book's labbook.toml that a pattern matches; "." matches line ends too."""
    path = folder / "labbook.toml"
    changed, n = re.subn(pattern, instead, path.read_text(encoding="utf-8"), flags=re.DOTALL)
    assert n == 1
    path.write_text(changed, encoding="utf-8")
