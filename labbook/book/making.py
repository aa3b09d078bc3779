"""Making a book: `labbook init`, the only place where a database comes into being (with `labbook rebuild`)."""

from __future__ import annotations

import secrets
import sqlite3
from contextlib import closing
from pathlib import Path

import sqlalchemy as sa

from data_schema import migrations
from data_schema.disk import sync
from data_schema.engine import reading, sqlite_engine, translated
from data_schema.errors import UsageError
from labbook.book.opening import (
    CONFIGURATION,
    DATABASE,
    engine_of,
    journal_path,
    open_book,
    read_configuration,
    shown,
    speaker_of,
)
from labbook.config.parsing import Configuration, template


def make_book(folder: Path, person: str | None) -> None:
    """Make a book in `folder` from its labbook.toml, or from a commented template where there is none.

    `person` speaks first; None takes the only one whom an existing labbook.toml names.
    """
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / CONFIGURATION
    if not path.exists():
        if person is None:
            raise UsageError("a new book needs a person: add --as NAME.")
        path.write_text(template(folder.resolve().name, person), encoding="utf-8")
    configuration = read_configuration(folder)
    speaker_of(configuration, person)  # before anything is made that a wrong name would leave behind
    refuse_existing(folder, configuration)
    mirror = journal_path(folder, configuration)
    mirror.parent.mkdir(parents=True, exist_ok=True)
    mirror.touch()
    make_database(folder, configuration)
    book = open_book(folder)
    try:
        with book.desk(person):
            pass
    finally:
        book.close()


def refuse_existing(folder: Path, configuration: Configuration) -> None:
    """Refuse to make a book where there is one, or where a journal waits to be rebuilt from."""
    mirror = journal_path(folder, configuration)
    if not configuration.database_url and (folder / DATABASE).exists():
        raise UsageError(f"{folder} holds a book already: open it, or name an empty folder.")
    if mirror.exists() and mirror.stat().st_size:
        raise UsageError(
            f"{mirror} holds the journal of a book: run `labbook rebuild` to make its database anew, or name an "
            "empty folder."
        )


def make_database(folder: Path, configuration: Configuration) -> None:
    """Make an empty database of this labbook's revision; a SQLite file appears complete or not at all."""
    if configuration.database_url:
        engine = engine_of(folder, configuration)
        try:
            with reading(engine) as connection:
                tables = sa.inspect(connection).get_table_names()
            if tables:
                raise UsageError(
                    f"the database {shown(engine)} is not empty (it holds {', '.join(sorted(tables)[:3])}): give "
                    "[database] url of an empty one."
                )
            make_tables(engine)
        finally:
            engine.dispose()
        return
    make_sqlite(folder / DATABASE)


def make_sqlite(path: Path) -> None:
    """Make an empty database file of this labbook's revision under a temporary name, then rename it."""
    temporary = path.with_name(f".{path.name}.{secrets.token_hex(4)}")
    try:
        fill_sqlite(temporary)
        temporary.rename(path)
        sync(path.parent)
    finally:
        temporary.unlink(missing_ok=True)


def fill_sqlite(path: Path) -> None:
    """Make an empty database of this labbook's revision in a file that is not there yet, step by step."""
    path.touch()  # where that is not allowed, the system says why
    with translated(), closing(sqlite3.connect(path)) as fresh:
        fresh.execute("PRAGMA journal_mode = wal")
    engine = sqlite_engine(path)
    try:
        make_tables(engine)
    finally:
        engine.dispose()


def make_tables(engine: sa.Engine) -> None:
    """Make all tables in an empty database."""
    with translated(), engine.connect().execution_options(labbook_writes=True) as connection, connection.begin():
        migrations.upgrade(connection)
