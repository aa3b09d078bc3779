"""Where the sheet of a study is read: in a file that is named, or in the copy that the book keeps of one."""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import shlex
from collections.abc import Callable, Iterator
from dataclasses import field
from pathlib import Path

import sqlalchemy as sa

from data_schema.errors import InputRefused, UsageError
from data_schema.frozen import frozen
from data_schema.queries.files import ReadingRow, find_files, last_reading, readings_in_force
from ingest.store import raw_path
from ingest.tables.sheet import SheetFile
from labbook.actions.files.named_files import file_named, own_name, read_bytes, readable
from labbook.book.opening import opened
from labbook.config.model import StudyProtocol
from labbook.config.studies import STUDIES
from labbook.studies.study import Asked, book_sources

_Contents = tuple[bytes, str | None, str | None]
"""A file's bytes, the page of a text that is neither UTF-8 nor UTF-16, and its decimal sign; None: as it shows."""


@frozen
class SheetSource:
    """A study's sheet at `path`, and the `options` it is asked with.

    `contents` returns what a file holds and how it was ingested. `paths` are the files that were read, by their hash.
    """

    path: Path
    options: StudyProtocol
    contents: Callable[[Path], _Contents]
    complete: bool = True
    sources: tuple[tuple[str, str], ...] = ()
    paths: dict[str, Path] = field(default_factory=dict)

    def file(self, path: Path) -> SheetFile:
        """Return the sheet, or a log that it names; raises `InputRefused` where it has the bytes of a file before: it
        would count twice.
        """
        data, page, decimal = self.contents(path)
        sha256 = hashlib.sha256(data).hexdigest()
        if (before := self.paths.setdefault(sha256, path)) != path:
            same = " and ".join(readable(Path(os.path.relpath(log, self.path.parent))) for log in (before, path))
            raise InputRefused(
                f"{own_name(self.path)} names {same}, which are the same bytes: what was recorded once would count "
                "twice; name, or ingest, the log that was recorded, or drop the row."
            )
        return SheetFile(own_name(path), data, page, self.options.decimal or decimal, self.complete)

    @property
    def files(self) -> tuple[tuple[str, str], ...]:
        """The files that were read, by name, with their SHA-256."""
        return tuple((path.name, sha256) for sha256, path in self.paths.items())


@contextlib.contextmanager
def sheet_source(study: str, asked: Asked) -> Iterator[SheetSource]:
    """Open the sheet of a study: the file as it is, or without one the book's, of which ingest knew if it is whole.

    Raises `UsageError` where both are named or the book has several, `InputRefused` where it has none.
    """
    if asked.file is not None:
        if asked.book is not None:
            raise UsageError(f"{asked.file} is read as it is, without a book: leave out --book, or the file.")
        yield SheetSource(asked.file, asked.options, lambda path: (read_bytes(path), None, None), asked.complete)
        return
    with opened(asked.book) as book, book.reading() as connection:
        options = asked.settled(study, book.configuration)
        sheet = _sheet(connection, study, options.sheet)

        def contents(path: Path) -> _Contents:
            row = sheet if path == Path(sheet.name) else _log(connection, path.name, sheet.name)
            declared = json.loads(row.settings_json)["declared"]
            data = bytes(book.store.raw(raw_path(row.sha256), row.sha256))
            return data, declared.get("encoding"), declared.get("decimal_sign")

        yield SheetSource(Path(sheet.name), options, contents, sources=book_sources(connection, book.configuration))


def _sheet(connection: sa.Connection, study: str, wanted: str | None) -> ReadingRow:
    """Return the reading of the book's sheet, of the one that `sheet` of labbook.toml wants where it does."""
    entry = STUDIES[study]
    if wanted is not None:
        named = last_reading(connection, file_named(connection, wanted).sha256)
        if named is None or named.reader != entry.sheet:
            found = "unread file" if named is None else named.reader
            raise UsageError(
                f"sheet = {wanted!r} of [studies.{study}] in labbook.toml is read as {found}, and the study "
                f"needs a {entry.sheet}: name one, or take the line out."
            )
        return named
    rows = readings_in_force(connection, [entry.sheet])
    if not rows:
        raise InputRefused(
            f"the book has no sheet of the {study} study: ingest one with the header {entry.header}, or name a file as "
            f"in `labbook study {study} sheet.csv`."
        )
    if len(rows) > 1:
        listed = ", ".join(f"{row.name} ({row.file_uid})" for row in rows)
        raise UsageError(
            f"the book has {len(rows)} sheets of the {study} study, {listed}: say which one is meant with "
            f'sheet = "{rows[-1].file_uid}" below [studies.{study}] of labbook.toml, or withdraw the others with '
            "`labbook files withdraw`."
        )
    return rows[0]


def _log(connection: sa.Connection, name: str, sheet: str) -> ReadingRow:
    """Return the reading of a log that a sheet names."""
    named = last_reading(connection, file_named(connection, name).sha256) if find_files(connection, name) else None
    if named is None:
        raise InputRefused(
            f"the book has no log {name!r}, which {sheet} names: ingest it with "
            f"`labbook ingest {shlex.quote(name)} --format study_log`."
        )
    return named
