"""Making a book: `labbook init`, the only place where a database comes into being (with `labbook rebuild`)."""

from __future__ import annotations

import secrets
import sqlite3
from collections.abc import Iterable
from contextlib import closing
from pathlib import Path

import sqlalchemy as sa

from data_schema import journal
from data_schema.disk import make_folder, path_in_errors, sync, write_whole
from data_schema.engine import POSTGRES_SCHEMA, reading, refuse_unfinished, sqlite_engine, translated_errors
from data_schema.errors import UsageError
from data_schema.journal import Entry
from data_schema.journal_file import JournalFile
from data_schema.schema import create_tables
from labbook.book.opening import (
    CONFIGURATION,
    DATABASE,
    JOURNAL,
    engine_of,
    journal_path,
    open_book,
    read_configuration,
    shown,
    speaker_of,
)
from labbook.config.parsing import Configuration, template
from labbook.config.places import with_places


def make_book(folder: Path, person: str | None, database_url: str | None = None, store: Path | None = None) -> bool:
    """Make a book in `folder` from its labbook.toml, or from a commented template where there is none.

    The template names the database and the store where these are not in the folder; what is given must agree with an
    existing labbook.toml.

    `person` speaks first; None takes the only one whom an existing labbook.toml names. A book that is there already
    stays as it is, one whose making was cut off is finished; returns whether anything was made.
    """
    make_folder(folder)
    path = folder / CONFIGURATION
    if not path.exists():
        write_whole(path, _first_configuration(folder, person, database_url, store).encode())
    configuration = read_configuration(folder)
    for what, given, in_file in (
        ("[database] url", database_url, configuration.database.url),
        ("[store] path", None if store is None else str(store), configuration.store.path),
    ):
        if given is not None and given != in_file:
            raise UsageError(
                f"{path} is there and says {what} {in_file!r}, not {given!r}: correct it, or leave that out."
            )
    speaker_of(configuration, person)  # before anything is made that a wrong name would leave behind
    mirror = journal_path(folder, configuration)
    entries_before = mirror.stat().st_size if mirror.exists() else 0
    if not _database_stands(folder, configuration, empty=not entries_before):
        if entries_before:
            raise UsageError(
                f"{mirror} holds the journal of a book: run `labbook rebuild` to make its database anew, or name an "
                "empty folder."
            )
        make_folder(mirror.parent)
        mirror.touch()
        sync(mirror.parent)
        make_database(folder, configuration)
    book = open_book(folder)
    try:
        with book.session(person):
            pass
    finally:
        book.close()
    return not entries_before


def _first_configuration(folder: Path, person: str | None, database_url: str | None, store: Path | None) -> str:
    """Return the last labbook.toml that a journal in the folder holds, without one the template."""
    lost = None
    if (folder / JOURNAL).exists():
        lost = last_configuration(JournalFile(folder / JOURNAL).entries())
    if lost is not None:
        return lost
    if (folder / DATABASE).exists():
        raise UsageError(f"{folder} has a book's {DATABASE} and no {CONFIGURATION}: put that back from a backup.")
    if person is None:
        raise UsageError("a new book needs a person: add --as NAME.")
    return with_places(template(folder.resolve().name, person), database_url, store)


def last_configuration(entries: Iterable[Entry]) -> str | None:
    """Return the text of labbook.toml that was declared last in a journal, None where none was."""
    texts = [(entry.new or {})["text"] for entry in entries if entry.entity_kind == "config"]
    return texts[-1] if texts else None


def _database_stands(folder: Path, configuration: Configuration, *, empty: bool) -> bool:
    """Tell whether the book's database has been made; raises `UsageError` where it is that of something else.

    `empty`: nothing stands in the book's journal, so that a database in which something was stated is another book's.
    """
    if not configuration.database.url:
        return (folder / DATABASE).exists()
    engine = engine_of(folder, configuration)
    try:
        with reading(engine) as connection:
            tables = sorted(sa.inspect(connection).get_table_names())
            if tables and ("journal" not in tables or (empty and journal.head(connection)[0])):
                raise UsageError(
                    f"the database {shown(engine)} is not empty (it holds {', '.join(tables[:3])}): give [database] "
                    "url of an empty one."
                )
    finally:
        engine.dispose()
    return bool(tables)


def make_database(folder: Path, configuration: Configuration) -> None:
    """Make an empty database; a SQLite file appears complete or not at all."""
    if not configuration.database.url:
        make_sqlite(folder / DATABASE)
        return
    engine = engine_of(folder, configuration)
    try:
        with translated_errors(), engine.begin() as connection:
            connection.exec_driver_sql(f"CREATE SCHEMA IF NOT EXISTS {POSTGRES_SCHEMA}")
            create_tables(connection)
    finally:
        engine.dispose()


def make_sqlite(path: Path) -> None:
    """Make an empty database file under a temporary name, then rename it."""
    temporary = path.with_name(f".{path.name}.{secrets.token_hex(4)}")
    with path_in_errors(path):
        try:
            fill_sqlite(temporary)
            refuse_unfinished(temporary)
            temporary.rename(path)
            sync(path.parent)
        finally:
            for suffix in ("", "-wal", "-shm"):
                temporary.with_name(temporary.name + suffix).unlink(missing_ok=True)


def fill_sqlite(path: Path) -> None:
    """Make an empty database in a file that is not there yet, step by step."""
    path.touch()  # where that is not allowed, the system's error explains why
    with translated_errors(), closing(sqlite3.connect(path)) as fresh:
        fresh.execute("PRAGMA journal_mode = wal")
    engine = sqlite_engine(path)
    try:
        make_tables(engine)
    finally:
        engine.dispose()


def make_tables(engine: sa.Engine) -> None:
    """Make all tables in an empty database."""
    with translated_errors(), engine.connect().execution_options(labbook_writes=True) as connection, connection.begin():
        create_tables(connection)
