"""Where the sheet of a study is read: in a file that is named, or in the copy that the book keeps of one."""

from __future__ import annotations

import contextlib
import hashlib
import json
import shlex
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import sqlalchemy as sa

from data_schema.errors import InputRefused, UsageError
from data_schema.queries.imported_files import find_files
from data_schema.queries.readings import last_readings
from data_schema.vocabulary import IngestStatus
from ingest.store import raw_path
from ingest.text.source import DEFAULT_PAGE
from labbook.actions.files.named_files import decoded, file_named, read_file
from labbook.actions.studies.of_book import LEVEL, SHEETS, book_sources, first_given
from labbook.book.opening import Book, opened
from labbook.config.model import StudyProtocol
from stats.checks import as_level


@dataclass(frozen=True, slots=True)
class SheetSource:
    """A study's sheet, what labbook.toml says of the study, the sheet's decimal sign (None: as it shows), its sources.

    `page` is the encoding of a text that is neither UTF-8 nor UTF-16, None where such text is refused.

    `text` reads the sheet and the files beside it; each that was read is among `sources`, by its hash.
    """

    sheet: Path
    protocol: StudyProtocol
    decimal: str | None
    read: Callable[[Path], bytes]
    of_book: tuple[tuple[str, str], ...] = ()
    page: str | None = None
    hashes: dict[str, str] = field(default_factory=dict)

    def text(self, path: Path) -> str:
        """Return the text of the sheet, or of a file that it names."""
        data = self.read(path)
        self.hashes[path.name] = hashlib.sha256(data).hexdigest()
        try:
            return decoded(path, data, marked_utf_16=True)
        except InputRefused:
            if self.page is None:
                raise
            return data.decode(self.page, errors="replace")

    def level(self, option: float | None) -> float:
        """Return the level of the intervals: the option's, else the protocol's, else 0.95."""
        return as_level("--level", first_given(option, self.protocol.level, LEVEL))

    def grain_mm(self, option: float | None) -> float:
        """Return the grains' diameter; raises `UsageError` where nobody says it."""
        found = self.protocol.grain_mm if option is None else option
        if found is None:
            raise UsageError(
                "the grains' diameter is not known: add --grain 3.4, in mm, or write grain_mm = 3.4 below "
                "[studies.compaction] of labbook.toml."
            )
        return found

    @property
    def sources(self) -> tuple[tuple[str, str], ...]:
        """What the study comes from, by name."""
        return (*self.of_book, *(("File", f"{name}, SHA-256 {sha256}") for name, sha256 in self.hashes.items()))


@contextlib.contextmanager
def sheet_source(study: str, file: Path | None, book_folder: Path | None, decimal: str | None) -> Iterator[SheetSource]:
    """Open the sheet of a study: `file` as it is, or without one the book's.

    Raises `UsageError` where both are named or the book has several, `InputRefused` where it has none.
    """
    if file is not None:
        if book_folder is not None:
            raise UsageError(f"{file} is read as it is, without a book: leave out --book, or the file.")
        yield SheetSource(file, StudyProtocol(), decimal, read_file)
        return
    with opened(book_folder) as book, book.reading() as connection:
        protocol = book.configuration.studies.get(study, StudyProtocol())
        name, declared = _sheet(connection, study, protocol)
        sheet = Path(name)
        yield SheetSource(
            sheet,
            protocol,
            decimal or protocol.decimal or declared.get("decimal_sign"),
            lambda path: _copy(book, connection, path.name, sheet),
            book_sources(connection, book.configuration, None),
            declared.get("encoding") or DEFAULT_PAGE,
        )


def _sheet(connection: sa.Connection, study: str, protocol: StudyProtocol) -> tuple[str, dict[str, Any]]:
    """Return the name or uid of the book's sheet, and what was declared with it."""
    format_name, header = SHEETS[study]
    rows = [row for row in last_readings(connection) if row.status is IngestStatus.IMPORTED]
    if protocol.sheet is not None:
        meant = file_named(connection, protocol.sheet).uid
        rows = [row for row in rows if row.file_uid == meant]
        kinds = {reader for reader, _header in SHEETS.values()} - {format_name}
        if rows and rows[0].reader in kinds:
            raise UsageError(
                f"sheet = {protocol.sheet!r} of [studies.{study}] in labbook.toml names a {rows[0].reader}, and the "
                f"study needs a {format_name}: name that one, or take the line out."
            )
    else:
        rows = [row for row in rows if row.reader == format_name]
    if not rows:
        raise InputRefused(
            f"the book has no sheet of the {study} study: ingest one with the header {header}, or name a file as in "
            f"`labbook study {study} sheet.csv`."
        )
    if len(rows) > 1:
        listed = ", ".join(f"{row.name} ({row.file_uid})" for row in rows)
        raise UsageError(
            f"the book has {len(rows)} sheets of the {study} study, {listed}: say which one is meant with "
            f'sheet = "{rows[-1].file_uid}" below [studies.{study}] of labbook.toml, or withdraw the others with '
            "`labbook files withdraw`."
        )
    (row,) = rows
    settings = json.loads(row.settings_json or "{}")
    names = [other.name for other in last_readings(connection)]
    name = row.name if names.count(row.name) == 1 else row.file_uid or row.name
    return name, settings.get("declared", {})


def _copy(book: Book, connection: sa.Connection, name: str, sheet: Path) -> bytes:
    if name != sheet.name and not find_files(connection, name):
        raise InputRefused(
            f"the book has no log {name!r}, which {sheet.name} names: ingest it with "
            f"`labbook ingest {shlex.quote(name)} --format study_log`."
        )
    sha256 = file_named(connection, name).sha256
    return bytes(book.store.raw(raw_path(sha256), sha256))
