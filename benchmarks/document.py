"""The document `docs/performance.md`, and the same as text for the terminal."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence

from benchmarks.section import Budget, Section, Table

INTRODUCTION = """\
# Performance

Written by `make bench`; do not edit. A budget is a promise about a ratio where that is possible, since a ratio to a
known peer measured in the same run means the same on another machine. No test fails on time: a missed budget is stated
here, and is work to do.
"""

NOISE = """\
## How noise was handled

Pieces of one comparison take turns, round by round, so that whatever else the machine does falls on all of them alike;
the first round does not count. Minimum and median of the repeats are given, and unless it says otherwise a budget is
judged by minima, which other programs disturb least. Where the medians tell another story, the sentence under the table
says so. Processor time is that of all threads together, the least of the repeats: it hardly depends on what else runs.
The load at each benchmark's start (processes that wanted a core, mean of the last minute) stands beside its title: on
an idle machine it is below the number of cores. Files are in the page cache when they are read.
"""


def document(machine: Sequence[tuple[str, str]], sections: Sequence[tuple[Section, float]]) -> str:
    """Return the whole document; each section with the load at its start."""
    budgets = [(section, budget) for section, _load in sections for budget in section.budgets]
    parts = [
        INTRODUCTION,
        "## Machine\n\n" + table_text(Table(("", ""), tuple(machine), "")),
        "## Budgets\n\n" + _budgets_text(budgets),
        NOISE,
        *(_section_text(section, load) for section, load in sections),
    ]
    return "\n".join(part.rstrip("\n") + "\n" for part in parts)


def verdict_line(budget: Budget) -> str:
    """Return one line for the terminal."""
    return f"{budget.verdict.upper()}: {budget.what}: {budget.measured_text} (budget: {budget.limit_text})"


def table_text(table: Table) -> str:
    """Return a table in Markdown, its columns aligned."""
    rows = [table.head, *table.rows]
    widths = [max(3, *(len(row[column]) for row in rows)) for column in range(len(table.head))]
    lines = [
        "| " + " | ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)) + " |" for row in rows
    ]
    lines.insert(1, "|" + "|".join("-" * (width + 2) for width in widths) + "|")
    return "\n".join(lines) + "\n"


def _row_text(cells: Sequence[str]) -> str:
    return "| " + " | ".join(cells) + " |"


def _budgets_text(budgets: Sequence[tuple[Section, Budget]]) -> str:
    missed = sum(budget.verdict == "missed" for _section, budget in budgets)
    rows = tuple((budget.what, budget.limit_text, budget.measured_text, budget.verdict) for _section, budget in budgets)
    summary = f"{len(budgets)} budgets, {missed} missed." if missed else f"{len(budgets)} budgets, none missed."
    return summary + "\n\n" + table_text(Table(("budget", "limit", "measured", "verdict"), rows, ""))


def _section_text(section: Section, load: float) -> str:
    parts = [f"## {section.title}", f"Load at its start: {load:.1f}.", _filled(section.measured)]
    if section.budgets:
        parts.append("\n".join(f"- {verdict_line(budget)}" for budget in section.budgets))
    for table in section.tables:
        parts += [table_text(table).rstrip("\n"), _filled(table.shows)]
    return "\n\n".join(parts)


def _filled(text: str) -> str:
    """Break prose into lines; names of commands stay whole."""
    return textwrap.fill(text, 120, break_long_words=False, break_on_hyphens=False)
