"""What each study shows: its data, sentences, table and figure, computed from a sheet or from the book.

An option that is None is as `[studies.NAME]` of labbook.toml says, or as is usual.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from labbook.terminal import progress

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True, slots=True)
class ShownStudy:
    """What a study gives: data for programs, sentences with the answer first, a table, and a figure with its caption.

    `sources` says of which book it is, `files` has names and SHA-256 of its sheets and logs; `beside` has rows of what
    was measured, simulated and published.
    """

    title: str
    data: dict[str, Any]
    sentences: list[str]
    draw: Callable[[], Figure]
    caption: str
    sources: Sequence[tuple[str, str]]
    head: Sequence[str] = ()
    rows: Sequence[Sequence[str]] = ()
    beside: Sequence[Sequence[str]] = ()
    files: Sequence[tuple[str, str]] = ()


def compaction_shown(
    file: Path | None,
    grain: float | None,
    level: float | None,
    decimal: str | None,
    book: Path | None,
    complete: bool = False,
) -> ShownStudy:
    """Show how densely the grains lie, from a sheet of flasks."""
    from labbook.actions.studies.sheet_source import sheet_source
    from labbook.actions.studies.sheets import compaction_of
    from labbook.presenting.studies.compaction import HEAD, as_data, figure_data, rows, sentences
    from reports.figures.compaction import draw_compaction

    with sheet_source("compaction", file, book, decimal, complete=complete) as sheets:
        path, level = sheets.sheet, sheets.level(level)
        study = compaction_of(sheets.text(path), path, sheets.grain_mm(grain), level, sheets.decimal(path))
    return ShownStudy(
        "How densely the grains lie",
        as_data(study),
        sentences(study),
        lambda: draw_compaction(figure_data(study)),
        "Volume fractions over grain size / flask radius: flasks, lines, and the intervals without walls (at 0).",
        sheets.of_book,
        HEAD,
        rows(study),
        files=sheets.files,
    )


def field_shown(
    file: Path | None, level: float | None, decimal: str | None, book: Path | None, complete: bool = False
) -> ShownStudy:
    """Show what two robots need on the same walks, from a sheet of walks."""
    from labbook.actions.studies.sheet_source import sheet_source
    from labbook.actions.studies.sheets import field_study_of
    from labbook.presenting.studies.field import as_data, figure_data, sentences
    from reports.figures.field import draw_field

    with sheet_source("field", file, book, decimal, complete=complete) as sheets:
        path, level = sheets.sheet, sheets.level(level)
        study = field_study_of(path, sheets.text, level, sheets.decimal(path), sheets.decimal)
    return ShownStudy(
        "What two robots need on the same walks",
        as_data(study),
        sentences(study),
        lambda: draw_field(*figure_data(study)),
        "Specific resistance of both robots, each walk a line, and their ratio on each walk; geometric means with "
        "intervals, and the thesis's values.",
        sheets.of_book,
        files=sheets.files,
    )


def characterisation_shown(
    file: Path | None, level: float | None, decimal: str | None, book: Path | None, complete: bool = False
) -> ShownStudy:
    """Show what a leg's gains are, from a sheet of trials and their logs."""
    from labbook.actions.studies.sheet_source import sheet_source
    from labbook.actions.studies.sheets import characterisation_of
    from labbook.presenting.studies.characterisation import HEAD, as_data, figure_data, rows, sentences
    from reports.figures.characterisation import draw_characterisation

    with sheet_source("characterisation", file, book, decimal, complete=complete) as sheets:
        study = characterisation_of(sheets.sheet, sheets.text, sheets.level(level), sheets.decimal)
    return ShownStudy(
        "What the leg's gains are in N/m and kg/s",
        as_data(study),
        sentences(study),
        lambda: draw_characterisation(*figure_data(study)),
        "Force over compression where the leg is damped least, measured and fitted, one trajectory a mass; stiffness "
        "over position gain and damping over velocity gain, points of one mass each, filled where it has 250 points "
        "alone, lines through fits of all masses.",
        sheets.of_book,
        HEAD,
        rows(study),
        files=sheets.files,
    )


def force_plate_shown(
    where: str | None, window: int | None, level: float | None, book: Path | None, visible: bool
) -> ShownStudy:
    """Show the book's joules by plate and leg beside the battery's."""
    from labbook.actions.studies.force_plate import force_plate_of
    from labbook.analysis.studies.force_plate import FIRST_HOPS, SHOWN_HOPS
    from labbook.presenting.studies.force_plate import HEAD, as_data, comparison_rows, figure_data, rows, sentences
    from reports.figures.force_plate import draw_force_plate

    with progress("study force-plate", None, shown=visible) as step:
        found = force_plate_of(book, where, window, level, step)
    study = found.study
    return ShownStudy(
        "Joules of plate and leg against the battery's",
        as_data(study),
        sentences(study),
        lambda: draw_force_plate(*figure_data(study)),
        f"Force and leg length of up to {SHOWN_HOPS} hops of one run a condition, on one clock, since touchdown (bold "
        f"line); the first {FIRST_HOPS} (dashed, hollow) start from the hand, and lower. Joules of each hop and means "
        "of runs, over the measured ones; the line goes through the origin. What the next wider moving average changes "
        "of the force in stance, relative to the narrowest; the window used; the slope by window.",
        found.sources,
        HEAD,
        rows(study),
        comparison_rows(study),
    )


def emulator_shown(
    where: str | None,
    constant: float | None,
    ratio: float | None,
    same: float | None,
    level: float | None,
    book: Path | None,
    visible: bool,
) -> ShownStudy:
    """Show what active damping saves at each gain of the book."""
    from labbook.actions.studies.emulator import emulator_study_of
    from labbook.presenting.studies.emulator import HEAD, as_data, comparison_rows, figure_data, rows, sentences
    from reports.figures.emulator import draw_emulator

    with progress("study emulator", None, shown=visible) as step:
        found = emulator_study_of(book, where, constant, ratio, same, level, step)
    study = found.study
    return ShownStudy(
        "What active damping saves at each gain",
        as_data(study),
        sentences(study),
        lambda: draw_emulator(*figure_data(study)),
        "Joules and apexes by extension gain, means and standard errors over runs; savings over the apex under CE, and "
        "their line; apex lost. A mark without a bar has none, or one smaller than itself; controllers stand apart.",
        found.sources,
        HEAD,
        rows(study),
        comparison_rows(study),
    )


def bed_shown(where: str | None, level: float | None, book: Path | None, visible: bool) -> ShownStudy:
    """Show what active damping saves on the bed, and how densely its grains lie."""
    from labbook.actions.studies.bed import bed_study_of
    from labbook.presenting.studies.bed import HEAD, OUTCOMES, as_data, comparison_rows, figure_caption, rows, sentences
    from reports.figures.by_level import draw_side_by_side

    with progress("study bed", None, shown=visible) as step:
        found = bed_study_of(book, where, level, step)
    study = found.study
    return ShownStudy(
        "What active damping saves on the granular bed",
        as_data(study),
        sentences(study),
        lambda: draw_side_by_side(study.content, OUTCOMES),
        figure_caption(study),
        found.sources,
        HEAD,
        rows(study),
        comparison_rows(study),
        study.files,
    )


FROM_BOOK: Mapping[str, Callable[[Path | None, bool], ShownStudy]] = {
    "force-plate": lambda book, visible: force_plate_shown(None, None, None, book, visible),
    "characterisation": lambda book, _visible: characterisation_shown(None, None, None, book),
    "emulator": lambda book, visible: emulator_shown(None, None, None, None, None, book, visible),
    "bed": lambda book, visible: bed_shown(None, None, book, visible),
    "compaction": lambda book, _visible: compaction_shown(None, None, None, None, book),
    "field": lambda book, _visible: field_shown(None, None, None, book),
}
"""Each study of a book, by name; `visible`: it shows its progress."""
