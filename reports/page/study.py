"""The page of a study: its verdict, its figure, its table, and which bytes it comes from, on one sheet.

A long table and a long list of files stand behind it.
"""

from __future__ import annotations

import hashlib
import importlib.metadata
import io
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from matplotlib.figure import Figure

from reports.display import BESIDE, true_minus
from reports.figures.style import publication_style
from reports.page.sections import Bullets, Paragraph
from reports.page.writing import environment, inline_svg
from reports.tables.table import Column, Row, Table, words

MOST_ROWS, MOST_FILES = 12, 8
"""Longer tables in all, and a longer list of files, stand behind page one, which is one sheet."""
_NUMBER = re.compile(r"[<+\u2212\u2013-]? ?\d|\u2013$")


@dataclass(frozen=True, slots=True)
class StudyPage:
    """What a page shows: `sentences` with the answer first, a figure with its caption, a table that may have no rows.

    `sources` are of its book, by name: its configuration, its title ("Study"), the runs that were selected ("Runs").
    `files` has name and SHA-256 of each file read. `made_at` is a UTC time stamp. `beside` has rows of `BESIDE`.
    """

    title: str
    sentences: Sequence[str]
    draw: Callable[[], Figure]
    caption: str
    head: Sequence[str]
    rows: Sequence[Sequence[str]]
    sources: Sequence[tuple[str, str]]
    made_at: str
    beside: Sequence[Sequence[str]] = ()
    files: Sequence[tuple[str, str]] = ()


def study_page(page: StudyPage) -> str:
    """Return the page's HTML, which asks nothing of the network."""
    answer, *others = map(true_minus, page.sentences)
    parts: list[dict[str, object]] = [{"kind": "Paragraph", "part": Paragraph(answer, lead=True)}]
    behind: list[dict[str, object]] = []
    if others:
        parts.append({"kind": "Bullets", "part": Bullets(tuple(map(Paragraph, others)))})
    drawing = inline_svg(_svg(page.draw), "study", page.title, page.caption)
    caption = true_minus(page.caption)
    parts.append({"kind": "FigureHere", "number": 1, "name": "study", "caption": caption, "drawing": drawing})
    tables = [
        (_table("beside", "Beside the simulator and the thesis", BESIDE, page.beside), parts),
        (
            _table("study", "What was measured and found", page.head, page.rows),
            parts if len(page.rows) + len(page.beside) <= MOST_ROWS else behind,
        ),
    ]
    for number, (table, place) in enumerate((one for one in tables if one[0].rows), start=1):
        place.append({"kind": "TableHere", "number": number, "table": table})
    facts, files = _facts(page)
    return (
        environment()
        .get_template("study.html.j2")
        .render(
            title=page.title,
            summary=_summary(page),
            parts=parts,
            behind=behind,
            facts=[*facts, ("Software", f"labbook {importlib.metadata.version('robot-labbook')}")],
            files=files,
            known_ids=set(),
        )
    )


def _summary(page: StudyPage) -> str:
    """Return the line under the title: which study and runs, and of when the page is."""
    of = dict(page.sources)
    runs = of.get("Runs")
    about = [text for text in (of.get("Study"), "all runs" if runs == "all" else runs) if text]
    date, _t, clock = page.made_at.partition("T")
    made = f"{'page' if about else 'Page'} of {date}, {clock[:5]} UTC"
    return f"{'; '.join([*about, made])}."


def _facts(page: StudyPage) -> tuple[list[tuple[str, str]], str]:
    """Return what page one says of the sources, and the list of their files where it is long.

    The list is as `sha256sum -c` reads it, and page one has its hash.
    """
    facts, files = [(name, text) for name, text in page.sources if name not in ("Study", "Runs")], page.files
    if len(files) <= MOST_FILES:
        return facts + [("File", f"{name}, SHA-256 {sha256}") for name, sha256 in files], ""
    listed = "".join(f"{sha256}  {name}\n" for name, sha256 in files)
    digest = hashlib.sha256(listed.encode("utf-8")).hexdigest()
    return [*facts, ("Files", f"{files[0][0]} and {len(files) - 1} more, SHA-256 of their list {digest}")], listed


def _svg(draw: Callable[[], Figure]) -> bytes:
    written = io.BytesIO()
    with publication_style():
        draw().savefig(written, format="svg")
    return written.getvalue()


def _table(name: str, caption: str, head: Sequence[str], rows: Sequence[Sequence[str]]) -> Table:
    cells = list(zip(*rows, strict=True)) if rows else [()] * len(head)
    columns = tuple(
        Column(title, (title,), numeric=place > 0 and all(map(_NUMBER.match, column)))
        for place, (title, column) in enumerate(zip(head, cells, strict=True))
    )
    return Table(name, caption, columns, tuple(Row(tuple(words(true_minus(cell)) for cell in row)) for row in rows))
