"""Tables as a Word document, for papers that are written there: each with its caption, its blocks and its footnotes."""

from __future__ import annotations

import io
from collections.abc import Iterable
from datetime import datetime
from typing import TYPE_CHECKING, Any

from data_schema.libraries import optional
from reports.results import StudyResults
from reports.tables.table import Cell, Table

if TYPE_CHECKING:
    from docx.document import Document
    from docx.table import _Cell

WORD = "tables.docx"
"""The file's name in the folder of a report."""
_STYLE = "Light List"


def word_bytes(results: StudyResults, tables: Iterable[Table]) -> bytes:
    """Return the tables of a report that have rows, as a Word document; the text of cells is that of the page.

    Raises `UsageError` where python-docx is not installed.
    """
    document: Document = optional("docx", "--docx", "export").Document()
    document.core_properties.created = document.core_properties.modified = datetime.fromisoformat(results.made_at)
    document.core_properties.title, document.core_properties.author = results.title, ", ".join(results.people)
    document.add_heading(results.title, level=1)
    for number, table in enumerate((table for table in tables if table.rows), start=1):
        document.add_paragraph(f"Table {number}. {table.caption}", style="Caption")
        _add(document, table)
        for mark, note in table.explained.items():
            _superscript(document.add_paragraph(), mark).add_run(f" {note}")
    stream = io.BytesIO()
    document.save(stream)
    return stream.getvalue()


def _add(document: Document, table: Table) -> None:
    """Add a table with its heads, and each block under its name."""
    heads = [column.head for column in table.heads]
    drawn = document.add_table(rows=1, cols=len(heads), style=_STYLE)
    for place, head in zip(drawn.rows[0].cells, heads, strict=True):
        place.text = head
    for block, rows in table.blocks:
        if block:
            cells = drawn.add_row().cells
            cells[0].merge(cells[-1]).text = block
        for row in rows:
            for place, cell in zip(drawn.add_row().cells, table.cells(row), strict=True):
                _fill(place, cell, table)


def _fill(place: _Cell, cell: Cell, table: Table) -> None:
    place.text = cell.text
    if cell.note:
        _superscript(place.paragraphs[0], table.footnotes[cell.note])


def _superscript(paragraph: Any, mark: str) -> Any:
    paragraph.add_run(mark).font.superscript = True
    return paragraph
