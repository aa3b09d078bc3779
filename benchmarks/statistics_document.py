"""Writes `docs/statistics.md`: correct digits, weaknesses of others, size and coverage, speed.

python benchmarks/statistics_document.py [SECTION...]
"""

from __future__ import annotations

import sys
from pathlib import Path

from benchmarks.stats_evidence.document import SECTIONS, measured, parts, together

DOCUMENT = Path(__file__).resolve().parent.parent / "docs" / "statistics.md"


def main(names: list[str]) -> None:
    """Write the sections named, or all; the others stay as they are."""
    unknown = [name for name in names if name not in SECTIONS]
    if unknown:
        sys.exit(f"there is no section {unknown[0]!r}: there are {', '.join(SECTIONS)}.")
    sections = parts(DOCUMENT.read_text(encoding="utf-8")) if DOCUMENT.exists() else {}
    for name in names or SECTIONS:
        print(f"== {name}", flush=True)
        sections[name] = measured(name)
    DOCUMENT.write_text(together(sections), encoding="utf-8")
    print(f"wrote {DOCUMENT}")


if __name__ == "__main__":
    main(sys.argv[1:])
