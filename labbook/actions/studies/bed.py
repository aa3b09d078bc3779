"""The bed study of a book (thesis ch. 5): what the report has of its runs, and of its sheet of flasks."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from data_schema.errors import InputRefused, UsageError
from data_schema.outcomes import Outcome
from data_schema.queries.readings import readings_in_force
from data_schema.queries.runs import refuse_empty_selection
from data_schema.rounding import level_text
from data_schema.vocabulary import FactorKind, StudyKind
from labbook.actions.studies.of_book import SHEETS, OfBook, book_sources, damping_factor, first_given
from labbook.actions.studies.sheet_source import sheet_source
from labbook.actions.studies.sheets import compaction_of
from labbook.analysis.studies.compaction import Compaction
from labbook.book.opening import opened
from labbook.book.write_session import now_utc
from labbook.config.model import StudyProtocol
from labbook.presenting.report.content import make_report
from labbook.presenting.studies.bed import BedStudy
from reports.display import list_text
from stats.checks import as_level


def bed_study_of(
    book_folder: Path | None, where: str | None, level: float | None, progress: Callable[[str], None]
) -> OfBook[BedStudy]:
    """Open the book and compare active damping with its control, as the report does; nothing is stored.

    None is the value of `[studies.bed]`, or all runs with the level that `[analysis]` decides. Raises `UsageError` for
    a book without an active-damping gain that has a control, `InputRefused` where none of its groups has joules of
    both.
    """
    with opened(book_folder) as book, book.reading() as connection:
        configuration = book.configuration
        protocol = configuration.studies.get("bed", StudyProtocol())
        where, level = where or protocol.where, first_given(level, protocol.level, None)
        level = None if level is None else as_level("--level", level)
        refuse_empty_selection(connection, where)
        damping = damping_factor(configuration, "0, 50, 100, 150, 200, 250")
        content = make_report(
            connection, book.store, configuration, where=where, made_at=now_utc(), progress=progress, level=level
        ).content
        if not any(one.quantity is Outcome.JOULES and one.opens for one in content.comparisons):
            why = [
                f"{n} run{'' if n == 1 else 's'}: {reason}"
                for reason, n in content.flow.runs_without[Outcome.JOULES].items()
            ]
            missing = f" Missing: {list_text(why)}; `labbook today` says more." if why else ""
            raise InputRefused(
                f"no group of the runs ({where or 'all'}) has joules of the control and of another {damping}, which the"
                f" study compares: run both, or select both by --where.{missing}"
            )
        has_flasks = bool(readings_in_force(connection, [SHEETS["compaction"][0]]))
        sources = book_sources(connection, configuration, where or "all")
    remarks = []
    if level is not None:
        remarks.append(
            f"Comparisons are of level {level_text(level)}, as asked, whatever [analysis] decides; means stay at 95 %."
        )
    if any(one.decision is None for one in content.comparisons):
        remarks.append(
            f"As [analysis] counts {content.counted}s, p is Welch's over them, not by shared days; so is the other p."
        )
    if configuration.simulation is None:
        remarks.append("Not simulated, and without published savings beside: labbook.toml has no [simulation].")
    grains, files = _grains(book_folder, level, remarks) if has_flasks else (None, ())
    named = tuple(name for name, factor in configuration.factors.items() if factor.kind is FactorKind.LABEL)
    on_bed = configuration.study.kind is StudyKind.BED
    return OfBook(BedStudy(content, on_bed, named, grains, tuple(remarks), files), sources)


def _grains(
    book_folder: Path | None, level: float | None, remarks: list[str]
) -> tuple[Compaction | None, tuple[tuple[str, str], ...]]:
    """Return the study of the book's flasks and its file; where it is refused, the reason goes to `remarks`."""
    try:
        with sheet_source("compaction", None, book_folder, None) as sheets:
            path = sheets.sheet
            text, decimal = sheets.text(path), sheets.decimal(path)
            return compaction_of(text, path, sheets.grain_mm(None), sheets.level(level), decimal), sheets.files
    except (InputRefused, UsageError) as error:
        remarks.append(f"How densely the grains lie is not told (labbook study compaction): {error}")
        return None, ()
