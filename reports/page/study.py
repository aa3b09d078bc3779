"""The page of a study: its verdict, its figure, its table, and which bytes it comes from, on one sheet."""

from __future__ import annotations

import importlib.metadata
import io
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from matplotlib.figure import Figure

from reports.figures.style import publication_style
from reports.page.sections import Bullets, Paragraph
from reports.page.writing import environment, inline_svg
from reports.tables.table import Column, Row, Table, words


@dataclass(frozen=True, slots=True)
class StudyPage:
    """What a page shows: `said` with the answer first, a figure with its caption, a table that may have no rows.

    `sources` are the inputs by name: files with their hashes, a book with its configuration.
    """

    title: str
    said: Sequence[str]
    draw: Callable[[], Figure]
    caption: str
    head: Sequence[str]
    rows: Sequence[Sequence[str]]
    sources: Sequence[tuple[str, str]]
    made_at: str


def study_page(page: StudyPage) -> str:
    """Return the page's HTML, which asks nothing of the network."""
    answer, *others = page.said
    parts: list[dict[str, object]] = [{"kind": "Paragraph", "part": Paragraph(answer, lead=True)}]
    if others:
        parts.append({"kind": "Bullets", "part": Bullets(tuple(map(Paragraph, others)))})
    drawing = inline_svg(_svg(page.draw), "study", page.title, page.caption)
    parts.append({"kind": "FigureHere", "number": 1, "name": "study", "caption": page.caption, "drawing": drawing})
    if page.rows:
        parts.append({"kind": "TableHere", "number": 1, "table": _table(page)})
    facts = [*page.sources, ("Software", f"labbook {importlib.metadata.version('robot-labbook')}")]
    template = environment().get_template("study.html.j2")
    return template.render(title=page.title, made_at=page.made_at, parts=parts, facts=facts, known_ids=set())


def _svg(draw: Callable[[], Figure]) -> bytes:
    written = io.BytesIO()
    with publication_style():
        draw().savefig(written, format="svg")
    return written.getvalue()


def _table(page: StudyPage) -> Table:
    columns = tuple(Column(head, (head,), numeric=place > 0) for place, head in enumerate(page.head))
    return Table(
        "study", "What was measured and found", columns, tuple(Row(tuple(map(words, row))) for row in page.rows)
    )
