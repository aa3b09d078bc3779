"""A book whose analysis was decided on before its first run was ingested."""

from __future__ import annotations

import zlib
from pathlib import Path

from tests.helpers.books import SmallBook, copy_of, ingest_all, small_book

DECIDED = '\n[analysis]\nexclusions = ["misfire"]\napex_bounds_percent = [-3, 3]\n'


def decided_book(folder: Path, analysis: str = DECIDED, *, without: str = "") -> SmallBook:
    """Return a small book of two feet, of the caller's own; nothing was decided where `analysis` is empty.

    The log `without` is not ingested, but lies beside the others as `loose.csv`.
    """

    def make(above: Path) -> SmallBook:
        made = small_book(above, ingested=False)
        made.toml.write_text(made.toml.read_text() + analysis)
        if without:
            (made.instruments / "logs" / without).rename(made.instruments / "loose.csv")
        with made.open() as book:
            ingest_all(book, made.instruments)
        return made

    return copy_of(f"decided-{zlib.crc32(analysis.encode())}-{without}", make, folder)
