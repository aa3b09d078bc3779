"""The force-plate study of a book (thesis 3.2.2)."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from data_schema.errors import UsageError
from labbook.actions.studies.of_book import OfBook, book_sources
from labbook.analysis.studies.force_plate import WINDOWS, ForcePlateStudy
from labbook.analysis.studies.plate_runs import force_plate_study
from labbook.book.opening import opened
from stats.checks import as_level


def force_plate_of(
    book_folder: Path | None, where: str | None, window: int | None, level: float, progress: Callable[[str], None]
) -> OfBook[ForcePlateStudy]:
    """Open the book and compare joules estimated from the plate's forces with those of the battery.

    Raises `UsageError` for a window that is even or none, and as `force_plate_study` does.
    """
    level = as_level("--level", level)
    if window is not None and window not in WINDOWS:
        raise UsageError(
            f"--window {window}: give an odd number of samples from {WINDOWS[0]} to {WINDOWS[-1]}; an even one would "
            "shift the force in time."
        )
    with opened(book_folder) as book, book.reading() as connection:
        study = force_plate_study(connection, book.store, book.configuration, where, window, level, progress)
        return OfBook(study, book_sources(connection, book.configuration, where))
