"""Writes the tables in `docs/statistics`, and what `docs/statistics.md` shows of them.

python benchmarks/statistics_document.py [TABLE...]
"""

from __future__ import annotations

import sys

from benchmarks.stats_evidence.document import PAGE, TABLES, measure, page


def main(names: list[str]) -> None:
    """Make the tables named anew, or all; the page follows them, its own words stay."""
    unknown = [name for name in names if name not in TABLES]
    if unknown:
        sys.exit(f"there is no table {unknown[0]!r}: there are {', '.join(TABLES)}.")
    for name in names or TABLES:
        print(f"== {name}", flush=True)
        measure(name)
    PAGE.write_text(page(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
    print(f"wrote {PAGE}")


if __name__ == "__main__":
    main(sys.argv[1:])
