"""Where the sheet of a study is read: in a file that is named, or in the copy that the book keeps of one."""

from __future__ import annotations

import contextlib
import functools
import hashlib
import json
import os
import shlex
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import sqlalchemy as sa

from data_schema.errors import InputRefused, LabbookError, UsageError
from data_schema.queries.imported_files import find_files
from data_schema.queries.readings import ReadingRow, last_reading, readings_in_force
from ingest.formats.study_sheets import is_readable, may_be_cut, read_trials, read_walks
from ingest.store import Store, raw_path
from ingest.text.source import DEFAULT_PAGE
from labbook.actions.files.named_files import decoded, file_named, own_name, read_file, readable
from labbook.actions.studies.of_book import LEVEL, SHEETS, book_sources, first_given
from labbook.book.opening import opened
from labbook.config.model import StudyProtocol
from stats.checks import as_level


@dataclass(frozen=True, slots=True)
class SheetSource:
    """A study's sheet, its table in labbook.toml, and the decimal sign asked for, of all its files.

    `read` gives a file's bytes. `declared` gives what a file of the book was ingested with: the page of a text that is
    neither UTF-8 nor UTF-16, None where such text is refused, and its decimal sign, None where it shows. `complete`
    means that a last line without line end is whole. `paths` are the files that were read, by their hash.
    """

    sheet: Path
    protocol: StudyProtocol
    asked: str | None
    read: Callable[[Path], bytes]
    declared: Callable[[Path], tuple[str | None, str | None]] = lambda _path: (None, None)
    of_book: tuple[tuple[str, str], ...] = ()
    complete: bool = True
    paths: dict[str, Path] = field(default_factory=dict)

    def text(self, path: Path) -> str:
        """Return the text of the sheet, or of a log that it names.

        Raises `InputRefused` where it may be cut, or has the bytes of a file before: it would count twice.
        """
        data = self.read(path)
        sha256 = hashlib.sha256(data).hexdigest()
        if (before := self.paths.setdefault(sha256, path)) != path:
            same = " and ".join(_from(log, self.sheet) for log in (before, path))
            raise InputRefused(
                f"{own_name(self.sheet)} names {same}, which are the same bytes: what was recorded once would count "
                "twice; name, or ingest, the log that was recorded, or drop the row."
            )
        text = decoded(path, data, marked_utf_16=True, page=self.declared(path)[0])
        if not self.complete and text and (unended := may_be_cut(text, own_name(path))) is not None:
            raise InputRefused(unended)
        return text

    def decimal(self, path: Path) -> str | None:
        """Return the decimal sign of the sheet, or of a log that it names; None: as it shows."""
        return self.asked or self.declared(path)[1]

    def level(self, option: float | None) -> float:
        """Return the level of the intervals: the option's, else the protocol's, else 0.95."""
        return as_level("--level", first_given(option, self.protocol.level, LEVEL))

    def grain_mm(self, option: float | None) -> float:
        """Return the grains' diameter; raises `UsageError` where it is not given."""
        found = self.protocol.grain_mm if option is None else option
        if found is None:
            raise UsageError(
                "the grains' diameter is not known: add --grain 3.4, in mm, or write grain_mm = 3.4 below "
                "[studies.compaction] of labbook.toml."
            )
        return found

    @property
    def files(self) -> tuple[tuple[str, str], ...]:
        """The files that were read, by name, with their SHA-256."""
        return tuple((path.name, sha256) for sha256, path in self.paths.items())


def _from(log: Path, sheet: Path) -> str:
    """Return the path of a log as it counts from the folder of the sheet that names it."""
    return readable(Path(os.path.relpath(log, sheet.parent)))


@contextlib.contextmanager
def sheet_source(
    study: str, file: Path | None, book_folder: Path | None, decimal: str | None, *, complete: bool = False
) -> Iterator[SheetSource]:
    """Open the sheet of a study: `file` as it is, or without one the book's, of which ingest knew whether it is whole.

    Raises `UsageError` where both are named or the book has several, `InputRefused` where it has none.
    """
    if file is not None:
        if book_folder is not None:
            raise UsageError(f"{file} is read as it is, without a book: leave out --book, or the file.")
        yield SheetSource(file, StudyProtocol(), decimal, read_file, complete=complete)
        return
    with opened(book_folder) as book, book.reading() as connection:
        protocol = book.configuration.studies.get(study, StudyProtocol())
        found = _sheet(connection, book.store, study, protocol)
        sheet = Path(found.name)

        @functools.cache
        def reading_of(path: Path) -> ReadingRow:
            return found if path == sheet else _log(connection, path.name, found.name)

        def read(path: Path) -> bytes:
            return _bytes(book.store, reading_of(path))

        def declared(path: Path) -> tuple[str | None, str | None]:
            return _declared(reading_of(path))

        sources = book_sources(connection, book.configuration, None)
        yield SheetSource(sheet, protocol, decimal or protocol.decimal, read, declared, sources)


def _declared(reading: ReadingRow) -> tuple[str, str | None]:
    """Return the page that a file was ingested with, and its decimal sign."""
    declared = json.loads(reading.settings_json)["declared"]
    return declared.get("encoding") or DEFAULT_PAGE, declared.get("decimal_sign")


def _bytes(store: Store, reading: ReadingRow) -> bytes:
    return bytes(store.raw(raw_path(reading.sha256), reading.sha256))


def _sheet_of_book(store: Store, reading: ReadingRow) -> tuple[str, str, str | None]:
    """Return what reads the sheet of a book: its text, its name, its decimal sign."""
    page, decimal = _declared(reading)
    return decoded(Path(reading.name), _bytes(store, reading), marked_utf_16=True, page=page), reading.name, decimal


def logs_of_sheets(connection: sa.Connection, store: Store) -> dict[str, str]:
    """Return by name, without folders, the logs that sheets in the book name, and the sheet; none of damaged sheets."""
    found: dict[str, str] = {}
    for row in readings_in_force(connection, list(_LOGS)):
        for sign in (",", "."):  # words are the same with either
            with contextlib.suppress(LabbookError):
                text, name, decimal = _sheet_of_book(store, row)
                found |= {Path(log).name: name for log in _LOGS[row.reader](text, name, decimal or sign)}
    return found


_LOGS: Mapping[str, Callable[[str, str, str | None], Sequence[str]]] = {
    "walk_sheet": lambda *asked: read_walks(*asked).logs,
    "trial_sheet": lambda *asked: read_trials(*asked).words["file"],
}


def _sheet(connection: sa.Connection, store: Store, study: str, protocol: StudyProtocol) -> ReadingRow:
    """Return the reading of the book's sheet."""
    format_name, header = SHEETS[study]
    if protocol.sheet is not None:
        named = last_reading(connection, file_named(connection, protocol.sheet).sha256)
        if named is None or named.reader != format_name:
            found = "unread file" if named is None else named.reader
            raise UsageError(
                f"sheet = {protocol.sheet!r} of [studies.{study}] in labbook.toml is read as {found}, and the study "
                f"needs a {format_name}: name one, or take the line out."
            )
        return named
    rows = readings_in_force(connection, [format_name])
    if not rows:
        raise InputRefused(
            f"the book has no sheet of the {study} study: ingest one with the header {header}, or name a file as in "
            f"`labbook study {study} sheet.csv`."
        )
    if len(rows) > 1:
        readable = [row for row in rows if is_readable(row.reader, *_sheet_of_book(store, row))]
        listed = ", ".join(
            f"{row.name} ({row.file_uid}{'' if row in readable else ', which cannot be read'})" for row in rows
        )
        raise UsageError(
            f"the book has {len(rows)} sheets of the {study} study, {listed}: say which one is meant with "
            f'sheet = "{(readable or rows)[-1].file_uid}" below [studies.{study}] of labbook.toml, or withdraw the '
            "others with `labbook files withdraw`."
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
