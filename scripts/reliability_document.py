"""Put what the long trials counted into docs/reliability.csv, and as a table into docs/reliability.md.

LABBOOK_RELIABILITY=counts.jsonl python -m pytest -n 2 -m soak tests/labbook/book
python scripts/reliability_document.py counts.jsonl
"""

from __future__ import annotations

import csv
import json
import sys
from collections import defaultdict
from pathlib import Path

FIGURES = Path(__file__).parents[1] / "docs" / "reliability.csv"
DOCUMENT = FIGURES.with_suffix(".md")
BEGIN, END = "<!-- figures of the last run -->\n", "<!-- end of the figures -->\n"
COLUMNS = ("trial", "command", "engine", "tried", "cut_off", "written", "lost")
_SUMS = COLUMNS[3:]


def figures(lines: list[str]) -> list[dict[str, str]]:
    """Sum the counts of equal trials; one row each, sorted by trial, engine and command."""
    sums: dict[tuple[str, str, str], dict[str, int]] = defaultdict(lambda: dict.fromkeys(_SUMS, 0))
    for line in lines:
        count = json.loads(line)
        for name in _SUMS:
            sums[count["trial"], count["engine"], count["command"]][name] += count[name]
    return [
        {"trial": trial, "command": command, "engine": engine, **{name: str(found[name]) for name in _SUMS}}
        for (trial, engine, command), found in sorted(sums.items())
    ]


def table(rows: list[dict[str, str]]) -> str:
    """Return the rows as a table of Markdown, with the sum of each trial."""
    lines = ["| trial | command | engine | tried | cut off | of these already written | lost or broken |"]
    lines.append("|---|---|---|--:|--:|--:|--:|")
    for trial in dict.fromkeys(row["trial"] for row in rows):
        some = [row for row in rows if row["trial"] == trial]
        lines += ["| " + " | ".join(row[name] for name in COLUMNS) + " |" for row in some]
        sums = [f"**{sum(int(row[name]) for row in some)}**" for name in _SUMS]
        lines.append(f"| **{trial}** | all | | " + " | ".join(sums) + " |")
    return "\n".join(lines) + "\n"


def with_table(text: str, rows: list[dict[str, str]]) -> str:
    """Return the page with the table in its place."""
    before, rest = text.split(BEGIN)
    return before + BEGIN + "\n" + table(rows) + "\n" + END + rest.split(END)[1]


def main(path: Path) -> None:
    """Write both files."""
    rows = figures(path.read_text(encoding="utf-8").splitlines())
    with FIGURES.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    DOCUMENT.write_text(with_table(DOCUMENT.read_text(encoding="utf-8"), rows), encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
