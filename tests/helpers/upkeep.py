"""What is done to a whole book: it is checked, backed up, rebuilt, and its rows are compared."""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from pathlib import Path

from data_schema.engine import postgres_engine, sqlite_engine
from data_schema.journal import Entry
from labbook.actions.upkeep.health import Health, check_book
from labbook.book.copies.backing_up import Backup, back_up
from labbook.book.rebuilding import Place, Rebuilt, rebuild_database
from tests.helpers.books import SmallBook
from tests.helpers.databases import Rows, all_rows, all_rows_by_name
from tests.helpers.journals import renumbered
from tests.helpers.statements import in_file


def untold(_total: int) -> contextlib.nullcontext[Callable[[str], None]]:
    """Show no progress."""
    return contextlib.nullcontext(lambda _step: None)


def health(book: SmallBook | Path, *, deep: bool = False) -> Health:
    return check_book(book if isinstance(book, Path) else book.folder, untold, deep=deep)


def backed_up(folder: Path, destination: Path) -> Backup:
    return back_up(folder, destination, untold)


def rebuilt(book: SmallBook, place: Place | None = None) -> Rebuilt:
    return rebuild_database(book.folder, lambda _step: None, place)


def rebuilt_as_said(book: SmallBook, said: Callable[[Entry], Entry]) -> Rebuilt:
    """Rebuild from the journal that another labbook would have written, the database lost."""
    with book.open() as standing:
        entries = renumbered([said(entry) for entry in in_file(standing)])
    book.journal.write_text("".join(entry.line + "\n" for entry in entries), encoding="utf-8")
    book.database.unlink()
    return rebuilt(book)


def rebuilt_alike(book: SmallBook) -> None:
    """Check that a rebuild makes the same rows."""
    with book.open() as standing:
        before = all_rows_by_name(standing.engine)
    rebuilt(book)
    with book.open() as standing:
        assert all_rows_by_name(standing.engine) == before


def rows_with_keys(database: Path) -> dict[str, Rows]:
    """Every row of a SQLite file, private keys included."""
    engine = sqlite_engine(database)
    try:
        return all_rows(engine)
    finally:
        engine.dispose()


def rows_by_name(folder: Path, url: str | None = None) -> dict[str, Rows]:
    """Every row of the book in a folder, or in a PostgreSQL database, without private keys."""
    engine = postgres_engine(url) if url else sqlite_engine(folder / "labbook.db")
    try:
        return all_rows_by_name(engine)
    finally:
        engine.dispose()
