"""The document `docs/performance.md`, and the same as text for the terminal.

The document is where measurements are kept: benchmarks that were not run keep their sections as they stand in it, and
the table of budgets is gathered from all sections.
"""

from __future__ import annotations

import re
import sys
import textwrap
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from benchmarks.section import Budget, Section, Table

INTRODUCTION = """\
# Performance

Written by `make bench`, section by section by `python benchmarks/run.py NAME`; do not edit. A budget is a promise about
a ratio where that is possible, since a ratio to a known peer measured in the same run means the same on another
machine. No test fails on time: a missed budget is stated here, and is work to do.
"""

NOISE = """\
## How noise was handled

Pieces of one comparison take turns, round by round, so that whatever else the machine does falls on all of them alike;
the first round does not count. Minimum and median of the repeats are given, and unless it says otherwise a budget is
judged by minima, which other programs disturb least. Where the medians tell another story, the sentence under the table
says so. Processor time is that of all threads together, the least of the repeats: it hardly depends on what else runs.
Under each title stand the day, the load at the benchmark's start (processes that wanted a core, mean of the last
minute: below the number of cores on an idle machine) and the machine. Files are in the page cache when they are read.
"""

_MARK = re.compile(r"^<!-- benchmark: ([\w-]+) -->\n", re.MULTILINE)
_BUDGET = re.compile(r"^- (MET|MISSED|NOT MEASURED): (.+): (.+) \(budget: (.+)\)$", re.MULTILINE)
"""A line of `verdict_line` in the document."""


def document(known: str, measured: Mapping[str, str], names: Iterable[str]) -> str:
    """Return the document with sections anew.

    `known` is the document as it is, `measured` the text of new sections by the name of their benchmark; all stand in
    the order of `names`, and what is of no benchmark there goes.
    """
    sections = {**_sections(known), **measured}
    kept = {name: sections[name] for name in names if name in sections}
    parts = [
        INTRODUCTION,
        "## Budgets\n\n" + _budgets_text(_BUDGET.findall("\n".join(kept.values()))),
        NOISE,
        *(f"<!-- benchmark: {name} -->\n{text}" for name, text in kept.items()),
    ]
    return "\n".join(part.rstrip("\n") + "\n" for part in parts)


def _sections(known: str) -> dict[str, str]:
    """Return the sections of a document by the names of their benchmarks."""
    _head, *found = _MARK.split(known)
    return dict(zip(found[::2], found[1::2], strict=True))


def verdict_line(budget: Budget) -> str:
    """Return one line for the terminal."""
    return f"{budget.verdict.upper()}: {budget.what}: {budget.measured_text} (budget: {budget.limit_text})"


def replace_between(document: Path, first: str, last: str, lines: Iterable[str]) -> None:
    """Write lines between two lines of a document; ends the program where they are not there, each once."""
    text = document.read_text(encoding="utf-8")
    if text.count(first) != 1 or text.count(last) != 1:
        sys.exit(f"{document} has no place for the results: put the lines {first} and {last} into it.")
    before, after = text.split(first)[0], text.split(last)[1]
    document.write_text("\n".join([before + first, "", *lines, last]) + after, encoding="utf-8")


def table_text(table: Table) -> str:
    """Return a table in Markdown, its columns aligned."""
    rows = [table.head, *table.rows]
    widths = [max(3, *(len(row[column]) for row in rows)) for column in range(len(table.head))]
    lines = [
        "| " + " | ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)) + " |" for row in rows
    ]
    lines.insert(1, "|" + "|".join("-" * (width + 2) for width in widths) + "|")
    return "\n".join(lines) + "\n"


def section_text(section: Section, measured_on: str) -> str:
    """Return a section; `measured_on` says when, under which load and on what."""
    parts = [f"## {section.title}", _filled(measured_on), _filled(section.measured)]
    if section.budgets:
        parts.append("\n".join(f"- {verdict_line(budget)}" for budget in section.budgets))
    for table in section.tables:
        parts += [table_text(table).rstrip("\n"), _filled(table.shows)]
    return "\n\n".join(parts)


def _budgets_text(budgets: Sequence[tuple[str, str, str, str]]) -> str:
    """Return the table of (verdict, what, measured, limit)."""
    missed = sum(verdict == "MISSED" for verdict, *_rest in budgets)
    rows = tuple((what, limit, measured, verdict.lower()) for verdict, what, measured, limit in budgets)
    summary = f"{len(budgets)} budgets, {missed} missed." if missed else f"{len(budgets)} budgets, none missed."
    return summary + "\n\n" + table_text(Table(("budget", "limit", "measured", "verdict"), rows, ""))


def _filled(text: str) -> str:
    """Break prose into lines; names of commands stay whole."""
    return textwrap.fill(text, 120, break_long_words=False, break_on_hyphens=False)
