"""What a study is asked with, where its sheet is read, and what of its book it comes from.

A sheet is read in a file that is named, or in the copy that the book keeps of one. What a study shows is
`reports.page.study.Study`.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import shlex
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Generic, TypeVar

import sqlalchemy as sa

from data_schema import journal
from data_schema.errors import InputRefused, UsageError
from data_schema.queries.files import ReadingRow, find_files, last_reading, readings_in_force
from data_schema.vocabulary import FactorKind
from ingest.store import raw_path
from ingest.tables.sheet import SheetFile
from labbook.actions.files.named_files import file_named, own_name, read_bytes, readable
from labbook.analysis.comparison.pairing import swept_factor
from labbook.book.opening import opened
from labbook.config.model import Configuration, StudyProtocol
from labbook.config.studies import STUDIES
from reports.page.study import Study
from stats.checks import as_level

S_co = TypeVar("S_co", bound=Study, covariant=True)
V = TypeVar("V")


@dataclass(frozen=True, slots=True)
class Asked:
    """What a study is asked: of `book`, None being the one that holds this folder, or of the sheet `file`.

    `options` are those of the command line, None where `[studies.NAME]` of labbook.toml decides. `complete`: the last
    line of a file is whole without a line end. `step` is told what is being done.
    """

    book: Path | None = None
    file: Path | None = None
    options: StudyProtocol = field(default_factory=StudyProtocol)
    complete: bool = False
    step: Callable[[str], None] = lambda _what: None

    def settled(self, study: str, configuration: Configuration) -> StudyProtocol:
        """Return the options, each as given, else as `[studies.NAME]` says."""
        of_book = configuration.studies.get(study, StudyProtocol())
        given = {one.name: getattr(self.options, one.name) for one in fields(StudyProtocol)}
        return replace(of_book, **{name: value for name, value in given.items() if value is not None})


def first_given(option: V | None, usual: V) -> V:
    """Return an option, or what is usual where it was not given."""
    return usual if option is None else option


def level_of(options: StudyProtocol) -> float:
    """Return the level of a study's intervals, 0.95 where nothing else is asked."""
    return as_level("--level", first_given(options.level, 0.95))


@dataclass(frozen=True, slots=True)
class Found(Generic[S_co]):
    """A study with what it comes from: by name the facts of its book, and the files read with their SHA-256."""

    study: S_co
    sources: tuple[tuple[str, str], ...]
    files: tuple[tuple[str, str], ...] = ()


def book_sources(
    connection: sa.Connection, configuration: Configuration, runs: str | None = None
) -> tuple[tuple[str, str], ...]:
    """Name the sources of a study, in the reading transaction that it is computed in; `runs` selects runs, if any."""
    entries, head = journal.head(connection)
    return (
        ("Study", configuration.study.name),
        *((("Runs", runs),) if runs is not None else ()),
        ("labbook.toml", f"SHA-256 {configuration.sha256}"),
        ("Journal", f"{entries} entries, the last {head}, which name every file by its hash"),
    )


def damping_factor(configuration: Configuration, levels: str) -> str:
    """Return the name of the factor of the active-damping gain; a refusal suggests `levels` for it."""
    damping = swept_factor(configuration)
    if damping is None or configuration.factors[damping].kind is not FactorKind.NUMBER:
        raise UsageError(
            "the study compares active-damping gains with a control, and labbook.toml has none: write "
            f'[factors.{damping or "b_ad_gain"}] with kind = "number", levels = [{levels}] and control = 0.'
        )
    return damping


_Contents = tuple[bytes, str | None, str | None]
"""A file's bytes, the page of a text that is neither UTF-8 nor UTF-16, and its decimal sign; None: as it shows."""


@dataclass(frozen=True, slots=True)
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
