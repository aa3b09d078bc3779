"""Prose and tables of the document as lines."""

from __future__ import annotations

import textwrap

from benchmarks.document import table_text
from benchmarks.section import Table

WIDTH = 120


def filled(text: str) -> list[str]:
    """Return a paragraph as lines; names of commands stay whole."""
    return textwrap.wrap(text.strip(), WIDTH, break_long_words=False, break_on_hyphens=False)


def table_lines(table: Table) -> list[str]:
    """Return a table as lines of Markdown."""
    return table_text(table).rstrip("\n").splitlines()
