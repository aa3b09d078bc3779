"""The force-plate study of a book (thesis 3.2.2)."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from data_schema.errors import UsageError
from data_schema.queries.runs import refuse_empty_selection
from labbook.actions.studies.of_book import LEVEL, OfBook, book_sources, first_given
from labbook.analysis.studies.force_plate import WINDOWS, ForcePlateStudy
from labbook.analysis.studies.plate_runs import force_plate_study
from labbook.book.opening import opened
from labbook.config.model import StudyProtocol
from stats.checks import as_level


def force_plate_of(
    book_folder: Path | None,
    where: str | None,
    window: int | None,
    level: float | None,
    progress: Callable[[str], None],
) -> OfBook[ForcePlateStudy]:
    """Open the book and compare joules estimated from the plate's forces with those of the battery.

    None is the value of `[studies.force-plate]`, or the default. Raises `UsageError` for a window that is even or none,
    and as `force_plate_study` does.
    """
    with opened(book_folder) as book, book.reading() as connection:
        protocol = book.configuration.studies.get("force-plate", StudyProtocol())
        where, window = where or protocol.where, protocol.window if window is None else window
        refuse_empty_selection(connection, where)
        level = as_level("--level", first_given(level, protocol.level, LEVEL))
        if window is not None and window not in WINDOWS:
            raise UsageError(
                f"--window {window}: give an odd number of samples from {WINDOWS[0]} to {WINDOWS[-1]}; an even one "
                "would shift the force in time."
            )
        study = force_plate_study(connection, book.store, book.configuration, where, window, level, progress)
        return OfBook(study, book_sources(connection, book.configuration, where or "all"))
