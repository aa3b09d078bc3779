"""The figures of a report, in the order of the page, and drawing them; a new one is a file and a line here.

Only what changed is drawn: a file in the user's cache folder has as its name a hash of all that the drawing is made of,
what the figure shows of the report, and its width.
"""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass

from data_schema.file_cache import FileCache
from reports.figures.by_level import BY_LEVEL
from reports.figures.kind import FigureKind, draw_figure, pdf_bytes, svg_bytes
from reports.figures.passive_drain import PASSIVE_DRAIN
from reports.figures.predictions import PREDICTIONS
from reports.figures.savings import SAVINGS
from reports.figures.sensitivity import SENSITIVITY
from reports.results import StudyResults

FIGURES: dict[str, FigureKind] = {
    kind.name: kind
    for kind in (
        SAVINGS,
        *BY_LEVEL,
        PREDICTIONS,
        PASSIVE_DRAIN,
        SENSITIVITY,
    )
}
"""Figure name -> figure; the name is also the file's."""


def figures_of(results: StudyResults) -> list[FigureKind]:
    """Return the figures of a report, those of outcomes that it has not left out."""
    return [kind for kind in FIGURES.values() if kind.outcome is None or kind.outcome in results.outcomes]


DRAWN = FileCache(
    "figures",
    ("reports/**/*.py", "data_schema/*.py"),
    ("matplotlib", "numpy", "kiwisolver", "contourpy", "jinja2"),
)


@dataclass(frozen=True, slots=True)
class Wanted:
    """A figure at a width in inches, and the formats that are wanted of it: "svg", "pdf"."""

    kind: FigureKind
    width_in: float
    formats: Sequence[str]


def cached_figure(results: StudyResults, wanted: Wanted) -> dict[str, bytes]:
    """Return a figure of the report by format: as it was drawn before of the same, else drawn now."""
    shown = wanted.kind.absent(results) or wanted.kind.drawn(results)
    key = hashlib.sha256(f"{wanted.kind.name} {wanted.width_in!r} {shown!r}".encode()).hexdigest()
    names = {suffix: f"{key}.{suffix}" for suffix in wanted.formats}
    known = {suffix: data for suffix, name in names.items() if (data := DRAWN.read(name)) is not None}
    if len(known) == len(wanted.formats):
        return known
    figure = draw_figure(wanted.kind, results, wanted.width_in)
    found = {"svg": svg_bytes(figure)}  # always first: the other format has its positions
    if "pdf" in wanted.formats:
        found["pdf"] = pdf_bytes(figure)
    for suffix, name in names.items():
        DRAWN.write(name, found[suffix])
    return {suffix: found[suffix] for suffix in wanted.formats}
