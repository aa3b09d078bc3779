"""Writes the tables in `docs/statistics`, and what `docs/statistics.md` shows of them.

The page is written by hand but for what stands between markers, which is taken from the tables.

python benchmarks/statistics_document.py [TABLE...]
"""

from __future__ import annotations

import csv
import os
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

from benchmarks.document import table_text
from benchmarks.section import Table
from benchmarks.worlds.rows import rows as worlds

PAGE = Path(__file__).resolve().parents[1] / "docs" / "statistics.md"
FOLDER = PAGE.with_suffix("")
DECISIONS, WORLDS = "decisions", "worlds"
TABLES = (DECISIONS, WORLDS)
"""Files of the folder: what the long test of the decision finds, and what campaigns of known truth give."""
_YARDSTICK = "tests/stats/days/test_decision_yardstick.py"

Rows = Sequence[Mapping[str, str]]

SHOWN_LAYOUTS = (
    "5 days 4+11 3+11 3+11 4+12 2+5",
    "4 days 3+10",
    "3 days 12+2 3+20 1+28",
    "3 days 1+3",
    "2 days 3+10, 2 of AD",
    "1 day 8+20",
    "5 of CE, 5 of AD",
)
"""Layouts of days that the page shows; the file has all."""

SHOWN_WORLDS = (
    ("drift of 1 SD a day, controls first, 5 days", "5 %"),
    ("drift of 1 SD a day, random order, 5 days", "5 %"),
    ("charger's steps 1 mAh, SD of runs 0.5 %, 5 days", "5 %"),
    ("ten looks, none planned", "0 %"),
    ("five planned looks", "0 %"),
    ("2 groups on the same 6 days", "5 % and 0 %"),
    ("2 x 2 x 6: interaction with the foot, 5 days", "3 points"),
    ("2 x 2 x 6: trend for each 100 of gain, 5 days", "1.9 points"),
)
"""Worlds and true effects that the page shows; the file has all."""


def main(names: list[str]) -> None:
    """Make the tables named anew, or all; the page follows them, its own words stay."""
    unknown = [name for name in names if name not in TABLES]
    if unknown:
        sys.exit(f"there is no table {unknown[0]!r}: there are {', '.join(TABLES)}.")
    for name in names or TABLES:
        print(f"== {name}", flush=True)
        path = FOLDER / f"{name}.csv"
        if name == DECISIONS:
            environment = {**os.environ, "LABBOOK_DECISIONS": str(path)}
            subprocess.run(
                [sys.executable, "-m", "pytest", "-q", "-m", "soak", _YARDSTICK], env=environment, check=True
            )
        else:
            write(path, worlds())
    PAGE.write_text(page(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
    print(f"wrote {PAGE}")


def write(path: Path, rows: Rows) -> None:
    """Write a table of the folder."""
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, list(rows[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


def read(name: str) -> Rows:
    """Return the rows of a table of the folder."""
    with (FOLDER / f"{name}.csv").open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def page(text: str) -> str:
    """Return the page with what stands between its markers taken from the tables."""
    shown = {DECISIONS: decisions_table(read(DECISIONS)), WORLDS: worlds_table(read(WORLDS))}
    for name, table in shown.items():
        before, first, rest = text.partition(f"<!-- from {name}.csv -->\n")
        _old, last, after = rest.partition("<!-- end -->")
        text = before + first + table + last + after
    return text


def _share(text: str) -> str:
    return f"{float(text):.3f}".removeprefix("0") if text else ""


def decisions_table(rows: Rows) -> str:
    """Return what the deciding test does on campaigns of each layout of days."""
    shares = ("coverage", "size", "equivalent_at_bound", "found")
    shown = (row for row in rows if row["layout"] in SHOWN_LAYOUTS)
    lines = ((row["layout"], row["rule"], *(_share(row[share]) for share in shares)) for row in shown)
    head = ("runs of each day", "rule", "covers", "errs", "TOST errs", "finds 11 %")
    return table_text(Table(head, tuple(lines), ""))


def worlds_table(rows: Rows) -> str:
    """Return what the first page says of simulated campaigns of known truth."""
    shown = (row for row in rows if (row["world"], row["truth"]) in SHOWN_WORLDS)
    lines = []
    for row in shown:
        needed = " (needed)" if row["warning_needed"] == "yes" else ""
        shares = (_share(row["coverage"]), _share(row["finds"]), f"{_share(row['warns'])}{needed}")
        lines.append((row["world"], row["truth"], *shares))
    return table_text(Table(("world", "true effect", "covers", "claims it", "warns"), tuple(lines), ""))


if __name__ == "__main__":
    main(sys.argv[1:])
