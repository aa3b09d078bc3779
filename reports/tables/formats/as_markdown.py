"""A table as Markdown: its caption, then its rows; the last cell of a strong row is bold."""

from __future__ import annotations

from reports.tables.table import Table


def markdown_text(table: Table) -> str:
    """Write the columns of a table that are shown, heads with their units."""
    lines = [f"| {' | '.join(column.head for column in table.heads)} |", "|" + "---|" * len(table.heads)]
    for row in table.rows:
        texts = [cell.text.replace("|", "\\|") for cell in table.cells(row)]
        if row.strong:
            texts[-1] = f"**{texts[-1]}**"
        lines.append(f"| {' | '.join(texts)} |")
    return "\n".join([f"{table.caption}\n", *lines, ""])
