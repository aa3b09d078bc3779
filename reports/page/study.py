"""The page of a study: its verdict, its figure, its table, and which bytes it comes from, on one sheet.

A long table and a long list of files stand behind it.
"""

from __future__ import annotations

import abc
import hashlib
import importlib.metadata
import io
import re
from collections.abc import Callable, Mapping, Sequence
from html import escape
from typing import Any, ClassVar

from matplotlib.figure import Figure

from data_schema.notebook import table_html
from reports.display import BESIDE, true_minus
from reports.figures.style import publication_style
from reports.page.sections import Bullets, Paragraph
from reports.page.writing import environment, inline_svg
from reports.tables.table import Column, Row, Table, words

MOST_ROWS, MOST_FILES = 12, 8
"""Longer tables in all, and a longer list of files, stand behind page one, which is one sheet."""
_NUMBER = re.compile(r"[<+\u2212\u2013-]? ?\d|\u2013$")


class Study(abc.ABC):
    """What came of a study: a frozen dataclass, whose fields are its JSON, with its words, tables and figure."""

    __slots__ = ()
    title: ClassVar[str]

    @abc.abstractmethod
    def sentences(self) -> list[str]:
        """Return what it says, the answer first."""

    @abc.abstractmethod
    def draw(self) -> Figure:
        """Draw its figure."""

    @abc.abstractmethod
    def caption(self) -> str:
        """Say what is drawn."""

    def table(self) -> Sequence[Sequence[str]]:
        """Return the table of what was measured, its heads first."""
        return ()

    def beside(self) -> Sequence[Sequence[str]]:
        """Return what was measured beside what the simulator gives and the thesis says, under `BESIDE`."""
        return ()

    def _repr_pretty_(self, printer: Any, _cycle: bool) -> None:
        """Print the sentences alone where a notebook or IPython shows text."""
        printer.text("\n".join(self.sentences()))

    def _repr_html_(self) -> str:
        """Return sentences, figure and table as notebooks show them."""
        sentences = "".join(f"<p>{escape(text)}</p>" for text in self.sentences())
        drawing = inline_svg(_svg(self.draw), "study", self.title, self.caption())
        head, *rows = self.table() or [()]
        return f"{sentences}{drawing}{table_html(head, rows) if rows else ''}"


def study_page(study: Study, sources: Sequence[tuple[str, str]], files: Sequence[tuple[str, str]], made_at: str) -> str:
    """Return the page's HTML, which asks nothing of the network.

    `sources` are of its book, by name: its configuration, its title ("Study"), the runs that were selected ("Runs");
    `files` the name and SHA-256 of each file read. `made_at` is a UTC time stamp.
    """
    answer, *others = map(true_minus, study.sentences())
    parts: list[dict[str, object]] = [{"kind": "Paragraph", "part": Paragraph(answer, lead=True)}]
    behind: list[dict[str, object]] = []
    if others:
        parts.append({"kind": "Bullets", "part": Bullets(tuple(map(Paragraph, others)))})
    caption = true_minus(study.caption())
    drawing = inline_svg(_svg(study.draw), "study", study.title, caption)
    parts.append({"kind": "FigureHere", "number": 1, "name": "study", "caption": caption, "drawing": drawing})
    table, beside = study.table(), study.beside()
    tables = [
        ("beside", "Beside the simulator and the thesis", [BESIDE, *beside], parts),
        ("study", "What was measured and found", table, parts if len(table) + len(beside) <= MOST_ROWS + 1 else behind),
    ]
    for number, (name, about, lines, place) in enumerate((one for one in tables if len(one[2]) > 1), start=1):
        place.append({"kind": "TableHere", "number": number, "table": _table(name, about, *lines)})
    facts, listed = _files(files)
    facts = [(name, text) for name, text in sources if name not in ("Study", "Runs")] + facts
    return (
        environment()
        .get_template("study.html.j2")
        .render(
            title=study.title,
            summary=_summary(dict(sources), made_at),
            parts=parts,
            behind=behind,
            facts=[*facts, ("Software", f"labbook {importlib.metadata.version('robot-labbook')}")],
            files=listed,
            known_ids=set(),
        )
    )


def _summary(of: Mapping[str, str], made_at: str) -> str:
    """Return the line under the title: which study and runs, and of when the page is."""
    runs = of.get("Runs")
    about = [text for text in (of.get("Study"), "all runs" if runs == "all" else runs) if text]
    date, _t, clock = made_at.partition("T")
    made = f"{'page' if about else 'Page'} of {date}, {clock[:5]} UTC"
    return f"{'; '.join([*about, made])}."


def _files(files: Sequence[tuple[str, str]]) -> tuple[list[tuple[str, str]], str]:
    """Return what page one says of the files read, and where they are many their list.

    The list is as `sha256sum -c` reads it, and page one has its hash.
    """
    if len(files) <= MOST_FILES:
        return [("File", f"{name}, SHA-256 {sha256}") for name, sha256 in files], ""
    listed = "".join(f"{sha256}  {name}\n" for name, sha256 in files)
    digest = hashlib.sha256(listed.encode("utf-8")).hexdigest()
    return [("Files", f"{files[0][0]} and {len(files) - 1} more, SHA-256 of their list {digest}")], listed


def _svg(draw: Callable[[], Figure]) -> bytes:
    written = io.BytesIO()
    with publication_style():
        draw().savefig(written, format="svg")
    return written.getvalue()


def _table(name: str, caption: str, head: Sequence[str], *rows: Sequence[str]) -> Table:
    columns = tuple(
        Column(title, (title,), numeric=place > 0 and all(map(_NUMBER.match, column)))
        for place, (title, *column) in enumerate(zip(head, *rows, strict=True))
    )
    return Table(name, caption, columns, tuple(Row(tuple(words(true_minus(cell)) for cell in row)) for row in rows))
