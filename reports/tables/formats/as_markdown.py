"""A table as Markdown: its caption, then its rows; the last cell of a strong row is bold."""

from __future__ import annotations

from reports.tables.table import Table


def markdown_text(table: Table) -> str:
    """Write the columns of a table that are shown, heads with their units."""
    head, *rows = table.texts
    lines = [f"| {' | '.join(head)} |", "|" + "---|" * len(head)]
    for row, cells in zip(table.rows, rows, strict=True):
        texts = [text.replace("|", "\\|") for text in cells]
        if row.strong:
            texts[-1] = f"**{texts[-1]}**"
        lines.append(f"| {' | '.join(texts)} |")
    return "\n".join([f"{table.caption}\n", *lines, ""])
