"""A book: the folder, its configuration, its database, its store and its journal.

Opening never creates and never changes. `labbook init` makes a book, `labbook rebuild` makes its database anew.
"""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import sqlalchemy as sa

from data_schema.engine import postgres_engine, reading, sqlite_engine
from data_schema.errors import BookMissing, BookVersion, UsageError, unknown_name
from data_schema.journal_file import JournalFile
from data_schema.schema import SCHEMA, schema_of
from ingest.store import Store
from labbook.book.proposing import propose
from labbook.book.write_session import WriteSession, write_session_of
from labbook.config.parsing import Configuration, parse_configuration

CONFIGURATION = "labbook.toml"
DATABASE = "labbook.db"
JOURNAL = "journal.jsonl"
UNFINISHED_RESTORE = ".labbook-restore.json"
"""Stands in the folder of a restore until it is done."""


@dataclass(frozen=True)
class Book:
    """An open book."""

    folder: Path
    configuration: Configuration
    engine: sa.Engine
    store: Store
    mirror: JournalFile

    def reading(self) -> contextlib.AbstractContextManager[sa.Connection]:
        """Open a reading transaction."""
        return reading(self.engine)

    @contextlib.contextmanager
    def session(self, person: str | None, *, correcting: bool = False) -> Iterator[WriteSession]:
        """Open a writing transaction for one person; first takes over what labbook.toml proposes anew.

        `correcting` is for statements that may settle what labbook.toml and the book disagree about.
        """
        speaker = self.speaker(person)
        with write_session_of(self.engine, self.store, self.mirror, speaker) as session:
            propose(session, self.configuration, correcting=correcting)
            yield session
            if correcting:
                propose(session, self.configuration, correcting=True)

    def speaker(self, person: str | None) -> str:
        """Return who speaks: the person named by name or initials, or the only one there is."""
        return speaker_of(self.configuration, person)

    def close(self) -> None:
        """Give the database connections back."""
        self.engine.dispose()


def speaker_of(configuration: Configuration, person: str | None) -> str:
    """Return whom a name or initials mean; None means the only one there is."""
    people = configuration.people
    if person is None:
        if len(people) == 1:
            return next(iter(people))
        raise UsageError(
            f"a statement needs a person and this book has {len(people)}: add --as with one of "
            f"{', '.join(repr(name) for name in people)}."
        )
    for name, initials in people.items():
        if person in (name, initials):
            return name
    raise unknown_name("person", person, people, "New people are added under [people] in labbook.toml.")


@contextlib.contextmanager
def opened(start: Path | None = None) -> Iterator[Book]:
    """Open the book that holds `start` (default: the current folder), and close it afterwards."""
    book = open_book(find_folder(start))
    try:
        yield book
    finally:
        book.close()


def find_folder(start: Path | None) -> Path:
    """Return the nearest folder, from `start` (default: the current folder) upward, that holds a labbook.toml.

    Raises `BookMissing` where there is none, and where a book that lost its own lies nearer: the one above is another.
    """
    start, lost = start or Path.cwd(), None
    for folder in (start.resolve(), *start.resolve().parents):
        if (folder / CONFIGURATION).is_file():
            if lost is None or store_of(folder, read_configuration(folder)).root.resolve() == lost:
                return folder
            break
        if lost is None and _has_pieces(folder):
            lost = folder
    if lost is not None:
        raise _without_configuration(start if lost == start.resolve() else lost)
    raise BookMissing(
        f"there is no book in {start} or above it: go to a book's folder, name one with --book DIR, or make one with "
        "`labbook init DIR`."
    )


def _has_pieces(folder: Path) -> bool:
    return any((folder / name).is_file() for name in (JOURNAL, DATABASE))


def _without_configuration(folder: Path) -> BookMissing:
    if not _has_pieces(folder):
        return BookMissing(f"there is no book in {folder}: name the folder that holds its {CONFIGURATION}.")
    left = JOURNAL if (folder / JOURNAL).is_file() else DATABASE
    written = f", or have `labbook init {folder} --as NAME` write the last one that it holds" if left == JOURNAL else ""
    return BookMissing(f"{folder} has a book's {left} and no {CONFIGURATION}: put that back from a backup{written}.")


def open_book(folder: Path) -> Book:
    """Open the book in a folder; raises when it is not there, or its database has another schema."""
    configuration = read_configuration(folder)
    engine = engine_of(folder, configuration)
    try:
        check_schema(engine)
    except BaseException:
        engine.dispose()
        raise
    return Book(
        folder,
        configuration,
        engine,
        store_of(folder, configuration),
        JournalFile(journal_path(folder, configuration)),
    )


def read_configuration(folder: Path) -> Configuration:
    """Read labbook.toml; raises `BookMissing` where there is none."""
    path = folder / CONFIGURATION
    try:
        return parse_configuration(path.read_text(encoding="utf-8"), str(path), folder)
    except FileNotFoundError as error:
        raise _without_configuration(folder) from error
    except UnicodeDecodeError as error:
        raise UsageError(f"{path} is not UTF-8 text (byte {error.start}): save it as UTF-8.") from error


def engine_of(folder: Path, configuration: Configuration) -> sa.Engine:
    """Return an engine on the book's database; a SQLite file must exist."""
    if configuration.database.url:
        return postgres_engine(configuration.database.url)
    path = folder / DATABASE
    if not path.exists() and (folder / UNFINISHED_RESTORE).exists():
        raise BookMissing(f"the restore to {folder} was cut off: give the same `labbook restore` again, it goes on.")
    if not path.exists():
        raise BookMissing(
            f"{path} is missing: run `labbook rebuild` to make it from the raw copies and the journal, or `labbook "
            "init` if this book was never made."
        )
    return sqlite_engine(path)


def store_of(folder: Path, configuration: Configuration) -> Store:
    """Return the store of files: in the book, or at [store] path."""
    return Store(folder / (configuration.store.path or ""))


def journal_path(folder: Path, configuration: Configuration) -> Path:
    """Return where the journal's mirror lies: beside the store that it belongs to."""
    return store_of(folder, configuration).root / JOURNAL


def check_schema(engine: sa.Engine) -> None:
    """Refuse a database that is not labbook's, or has another schema, with the next command to give."""
    with reading(engine) as connection:
        found = schema_of(connection)
        tables = sorted(sa.inspect(connection).get_table_names())
    if found is None or "journal" not in tables:
        what = "is empty" if not tables else f"was not made by labbook (it holds {', '.join(tables[:3])})"
        raise BookVersion(
            f"the database {shown(engine)} {what}: make a book with `labbook init DIR`, make it anew from "
            "journal.jsonl with `labbook rebuild`, or point [database] url in labbook.toml to the right one."
        )
    if found != SCHEMA:
        raise BookVersion(
            f"the database {shown(engine)} has schema {found}, and this labbook works with schema {SCHEMA}: make it "
            "anew from journal.jsonl with `labbook rebuild`, which keeps the old one."
        )


def shown(engine: sa.Engine) -> str:
    """Return the database's name without a password."""
    if engine.dialect.name == "sqlite":
        return DATABASE
    return engine.url.render_as_string(hide_password=True)
