"""What `labbook sim figures` does: the figures of ch. 3 drawn, its claims judged, both written to a folder."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from data_schema.errors import UsageError, unknown_name
from labbook.presenting.simulation.thesis_claims import claims_markdown, claims_table
from labbook.presenting.simulation.thesis_figures import THESIS_FIGURES, ThesisFigure
from reports.figures.kind import write_figure
from reports.tables.formats.as_csv import csv_bytes
from simulator.thesis.claims import Finding, claims, findings
from simulator.thesis.figures import ThesisFigures

FORMATS = ("png", "pdf", "svg")


@dataclass(frozen=True, slots=True)
class WrittenFigure:
    """A figure and its file."""

    figure: ThesisFigure
    file: Path


@dataclass(frozen=True, slots=True)
class WrittenThesis:
    """What was written: figures, the file of captions, and the claims with their files where there are any.

    `kept` are figures that the folder held before: captions and claims are about them, too. `claims_in_all`: how many
    claims there are about all figures.
    """

    figures: tuple[WrittenFigure, ...]
    kept: tuple[WrittenFigure, ...]
    captions: Path
    findings: tuple[Finding, ...]
    tables: tuple[Path, ...]
    claims_in_all: int


def write_thesis_figures(folder: Path, form: str, only: Sequence[str], step: Callable[[str], None]) -> WrittenThesis:
    """Simulate, draw and write the figures of these numbers (all without any), and judge the claims about them.

    Captions and claims cover what the folder then holds: figures of an earlier call, too.
    """
    if form not in FORMATS:
        raise unknown_name("format", form, FORMATS)
    for number in only:
        if number not in THESIS_FIGURES:
            raise UsageError(
                f"{number!r} is no figure of ch. 3 that a simulation makes: give one of {', '.join(THESIS_FIGURES)}."
            )
    chosen = [figure for number, figure in THESIS_FIGURES.items() if not only or number in only]
    folder.mkdir(parents=True, exist_ok=True)
    data = ThesisFigures()
    written = []
    for figure in chosen:
        file = folder / _file_name(figure, form)
        write_figure(figure.draw(data), file)
        written.append(WrittenFigure(figure, file))
        step(f"figure {figure.number}")
    kept = tuple(_kept(folder, chosen))
    shown = sorted((*written, *kept), key=lambda item: list(THESIS_FIGURES).index(item.figure.number))
    captions = folder / "figures.md"
    captions.write_text(_captions(shown, data), encoding="utf-8")
    found = findings(data, [item.figure.number for item in shown])
    step("claims")
    tables = (folder / "claims.csv", folder / "claims.md") if found else ()
    for path, content in zip(tables, (csv_bytes(claims_table(found)), claims_markdown(found).encode()), strict=False):
        path.write_bytes(content)
    return WrittenThesis(tuple(written), kept, captions, found, tables, len(claims()))


def _file_name(figure: ThesisFigure, form: str) -> str:
    return f"thesis_{figure.number.replace('.', '_')}_{figure.name}.{form}"


def _kept(folder: Path, drawn: Sequence[ThesisFigure]) -> Iterator[WrittenFigure]:
    """Yield the other figures that the folder holds, each in one of its forms."""
    for figure in THESIS_FIGURES.values():
        files = [folder / _file_name(figure, form) for form in FORMATS]
        file = next((file for file in files if file.exists()), None)
        if figure not in drawn and file is not None:
            yield WrittenFigure(figure, file)


def _captions(written: Sequence[WrittenFigure], data: ThesisFigures) -> str:
    """Write the figures with their captions as Markdown."""
    return "\n".join(
        f"## Figure {item.figure.number}: {item.figure.title}\n\n"
        f"![{item.figure.title}]({item.file.name})\n\n{item.figure.full_caption(data)}\n"
        for item in written
    )
