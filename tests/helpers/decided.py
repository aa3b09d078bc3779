"""A book whose analysis was decided on before its first run was ingested."""

from __future__ import annotations

from pathlib import Path

from tests.helpers.books import SmallBook, ingest_all, small_book

DECIDED = '\n[analysis]\nexclusions = ["misfire"]\napex_bounds_percent = [-3, 3]\n'


def decided_book(folder: Path, analysis: str = DECIDED) -> SmallBook:
    """Return a small book of two feet; nothing was decided where `analysis` is empty."""
    made = small_book(folder, ingested=False)
    made.toml.write_text(made.toml.read_text() + analysis)
    with made.open() as book:
        ingest_all(book, made.instruments)
    return made
