"""The figures of a report, in the order of the page, and drawing them; a new one is a file and a line here.

Only what changed is drawn: a file in the user's cache folder has as its name a hash of all that the drawing is made of,
what the figure shows of the report, and its width.
"""

from __future__ import annotations

import hashlib
import importlib
import mmap
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

from data_schema.file_cache import FileCache
from data_schema.second_process import has_core, run_in_fork
from reports.content import ReportContent
from reports.figures.by_level import BY_LEVEL
from reports.figures.estimation import ESTIMATIONS
from reports.figures.kind import FigureKind, draw_figure, pdf_bytes, svg_bytes
from reports.figures.limits_of_agreement import LIMITS_OF_AGREEMENT
from reports.figures.order import DAY_ORDER
from reports.figures.passive_drain import PASSIVE_DRAIN
from reports.figures.predictions import PREDICTIONS
from reports.figures.savings import SAVINGS
from reports.figures.sensitivity import SENSITIVITY

FIGURES: dict[str, FigureKind] = {
    kind.name: kind
    for kind in (
        SAVINGS,
        *(kind for of_outcome in zip(BY_LEVEL, ESTIMATIONS, strict=True) for kind in of_outcome),
        PREDICTIONS,
        LIMITS_OF_AGREEMENT,
        PASSIVE_DRAIN,
        DAY_ORDER,
        SENSITIVITY,
    )
}
"""Figure name -> figure; the name is also the file's."""


def figures_of(content: ReportContent) -> list[FigureKind]:
    """Return the figures of a report, those of outcomes that it has not left out."""
    return [kind for kind in FIGURES.values() if kind.outcome is None or kind.outcome in content.outcomes]


T = TypeVar("T")


def _sources() -> Iterable[Path]:
    """Every source of `reports` and of the words that it uses."""
    reports = Path(__file__).parents[1]
    return [*reports.rglob("*.py"), *(reports.parent / "data_schema").glob("*.py")]


DRAWN = FileCache("figures", _sources, ("matplotlib", "numpy", "kiwisolver", "contourpy", "jinja2"))


@dataclass(frozen=True, slots=True)
class Wanted:
    """A figure at a width in inches, and the formats that are wanted of it: "svg", "pdf"."""

    kind: FigureKind
    width_in: float
    formats: Sequence[str]


def cached_figures(
    content: ReportContent, wanted: Sequence[Wanted], meanwhile: Callable[[], T]
) -> tuple[list[dict[str, bytes]], T]:
    """Return figures of the report by format, in order: each as it was drawn before of the same, else drawn now, once.

    `meanwhile` is done too, and what it returns is returned. Where there is a core for it a second process draws from
    the first figure on, this one after that from the last on, until they meet. It hands its figures over in the folder;
    what does not arrive is drawn here.
    """
    names = [_names(content, one) for one in wanted]
    found = [_stored(one, some) for one, some in zip(wanted, names, strict=True)]
    missing = [place for place, known in enumerate(found) if known is None]
    shared = len(missing) > 1 and DRAWN.folder is not None and has_core()
    begun: mmap.mmap | bytearray = mmap.mmap(-1, len(wanted)) if shared else bytearray(len(wanted))

    def draw(places: Iterable[int]) -> None:
        for place in places:
            if not begun[place]:
                begun[place] = 1
                found[place] = _drawn_anew(content, wanted[place], names[place])

    if shared:
        importlib.import_module("matplotlib.backends.backend_svg")  # the copy has then all that drawing loads
    copy = run_in_fork(lambda: draw(missing)) if shared else None
    other = meanwhile()
    draw(reversed(missing))
    if copy:
        copy.result()
    for place in missing:
        if found[place] is None:
            found[place] = _stored(wanted[place], names[place]) or _drawn_anew(content, wanted[place], names[place])
    return [known for known in found if known is not None], other


def _names(content: ReportContent, wanted: Wanted) -> dict[str, str]:
    """Return the name of a figure's file in each format."""
    shown = wanted.kind.absent(content) or wanted.kind.drawn(content)
    key = hashlib.sha256(f"{wanted.kind.name} {wanted.width_in!r} {shown!r}".encode()).hexdigest()
    return {suffix: f"{key}.{suffix}" for suffix in wanted.formats}


def _stored(wanted: Wanted, names: Mapping[str, str]) -> dict[str, bytes] | None:
    """Return a figure from the cache, None where one of its formats is not there."""
    known = {suffix: data for suffix, name in names.items() if (data := DRAWN.read(name)) is not None}
    return known if len(known) == len(wanted.formats) else None


def _drawn_anew(content: ReportContent, wanted: Wanted, names: Mapping[str, str]) -> dict[str, bytes]:
    figure = draw_figure(wanted.kind, content, wanted.width_in)
    found = {"svg": svg_bytes(figure)}  # always first: the other format has its positions
    if "pdf" in wanted.formats:
        found["pdf"] = pdf_bytes(figure)
    for suffix, name in names.items():
        DRAWN.write(name, found[suffix])
    return {suffix: found[suffix] for suffix in wanted.formats}
