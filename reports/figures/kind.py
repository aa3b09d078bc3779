"""What a figure is to a report: a name, a drawing, a caption, words for those who cannot see it."""

from __future__ import annotations

import io
import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

import numpy as np

from data_schema.errors import UsageError
from data_schema.outcomes import Outcome
from reports.figures.style import GREY, lay_out, new_figure, publication_style
from reports.results import EMPTY, StudyResults

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.figure import Figure

FORMS = (".png", ".svg", ".pdf")
"""Endings of files that a figure is written to, in either case."""
_PNG_DOTS_PER_IN = 300
_MANY_POINTS = 2000
"""Of so many points a figure has a picture at that resolution: a browser takes seconds for each as a shape."""


def check_form(option: str, path: Path | None, forms: tuple[str, ...] = FORMS) -> None:
    """Raise `UsageError` where the file that an option names does not end in one of these, or cannot be written."""
    if path is None:
        return
    if path.is_dir():
        raise UsageError(f"{option} {path} is a folder: name a file in it, such as {path / f'figure{forms[0]}'}.")
    if path.suffix.lower() not in forms:
        raise UsageError(f"{option} {path} does not say which form: end it in {', '.join(forms)}.")
    if not path.parent.is_dir():
        raise UsageError(f"{option} {path} is in a folder that is not there: make {path.parent} first.")
    if not os.access(path if path.exists() else path.parent, os.W_OK):
        raise UsageError(f"{option} {path} may not be written: name a place where you may write.")


@dataclass(frozen=True, slots=True)
class FigureKind:
    """One figure: `draw(results, width_in)`; `absent` gives the reason when there is nothing to draw.

    `shows` names the fields of the results that are drawn: nothing else reaches `draw`, and where they are what they
    were, so is the drawing. `outcome` is the only one whose conditions and comparisons the figure shows; without one it
    knows conditions by their levels alone. It stands at the end of the page's `section` of this anchor, where there is
    something to draw; without one `reports.page.sections` says where.
    """

    name: str
    title: str
    draw: Callable[[StudyResults, float], Figure]
    caption: Callable[[StudyResults], str]
    alternative: Callable[[StudyResults], str]
    absent: Callable[[StudyResults], str | None]
    shows: Sequence[str]
    outcome: Outcome | None = None
    section: str = ""

    def drawn(self, results: StudyResults) -> StudyResults:
        """Return the results with nothing in them but what the figure draws."""
        shown = {name: getattr(results, name) for name in self.shows}
        if "conditions" in shown:
            shown["conditions"] = tuple(
                replace(one, summaries={key: own for key, own in one.summaries.items() if key is self.outcome})
                for one in results.conditions
            )
        if "comparisons" in shown and self.outcome is not None:
            shown["comparisons"] = tuple(one for one in results.comparisons if one.quantity is self.outcome)
        return replace(EMPTY, **shown)


def absence_text(results: StudyResults, what: str) -> str:
    """Say that something is missing without guessing why: the reasons are in the list of limitations."""
    reasons = "; the reasons are listed under Limitations" if results.limitations else ""
    return f"There {what} for this selection{reasons}."


def draw_figure(kind: FigureKind, results: StudyResults, width_in: float) -> Figure:
    """Draw a figure at a width in inches; where it has nothing to show, its reason is drawn instead.

    So a paper that includes the file still compiles when a selection leaves nothing to draw.
    """
    with publication_style():
        reason = kind.absent(results)
        if reason is None:
            return kind.draw(kind.drawn(results), width_in)
        figure = new_figure(width_in, 0.6)
        figure.text(0.5, 0.5, reason, ha="center", va="center", color=GREY, wrap=True)
        return figure


def svg_bytes(figure: Figure) -> bytes:
    """Write a figure as SVG, glyphs as outlines; the same figure gives the same bytes."""
    text = io.StringIO()  # into bytes matplotlib would encode each of its many words alone
    _write(figure, text, "svg", {"Date": None})
    return text.getvalue().encode("utf-8")


def pdf_bytes(figure: Figure) -> bytes:
    """Write a figure as PDF with embedded TrueType fonts; the same figure gives the same bytes."""
    stream = io.BytesIO()
    _write(figure, stream, "pdf", {"CreationDate": None})
    return stream.getvalue()


def write_figure(figure: Figure, path: Path) -> None:
    """Write a figure as SVG, PDF or PNG, as the end of the file's name says."""
    match path.suffix.lower():
        case ".svg":
            path.write_bytes(svg_bytes(figure))
        case ".pdf":
            path.write_bytes(pdf_bytes(figure))
        case _:
            with publication_style():
                figure.savefig(path, dpi=_PNG_DOTS_PER_IN)


def _write(figure: Figure, stream: IO[Any], suffix: str, metadata: dict[str, str | None]) -> None:
    with publication_style():
        lay_out(figure)
        for points in figure.findobj(_has_many_points):
            points.set_rasterized(True)
        figure.savefig(stream, format=suffix, metadata=metadata, dpi=_PNG_DOTS_PER_IN)


def _has_many_points(artist: Artist) -> bool:
    from matplotlib.collections import PathCollection
    from matplotlib.lines import Line2D

    if isinstance(artist, Line2D):
        return artist.get_linestyle() == "None" and np.shape(artist.get_xydata())[0] > _MANY_POINTS
    return isinstance(artist, PathCollection) and np.shape(artist.get_offsets())[0] > _MANY_POINTS
