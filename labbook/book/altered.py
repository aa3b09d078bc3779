"""Rows altered outside labbook: the tables of a book compared with those that its journal gives, played back.

Private keys are left out: a reference is the uid of the row that it leads to. So a book has the same rows on any
engine, and two rows cannot change places unseen. Only the order of the keys counts, which says what was stated later.

Also what a rebuild made otherwise than it was made the first time: a newer labbook may read files otherwise, and the
journal has how a file was read, so that this can be compared with what came of it now.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import cache
from itertools import chain, takewhile, zip_longest
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import sqlalchemy as sa

from data_schema.engine import reading
from data_schema.journal import Entry, head
from data_schema.queries.facts import fact_exists
from data_schema.queries.files import readings, waiting_files
from data_schema.queries.history import list_reports
from data_schema.tables import FACTS, METADATA
from data_schema.tables.base import TEXT
from data_schema.tables.plain import scan
from labbook.book.naming import words_of
from labbook.book.report_numbers import readable_numbers

if TYPE_CHECKING:
    from labbook.book.replaying import Replay

MOST_NAMED = 20
"""So many rows are described with the reports that depend on them; a careless command alters all there are."""

MOST_FOLLOWED = 200
"""What so many altered rows bear on is looked up; of more, every number is taken to depend on the rest."""

_Row: TypeAlias = Mapping[str, Any]

_NOT_COMPARED = ("labbook", "journal")
"""The schema's number, and the chain of entries, whose hashes show what was altered."""
_OF_READINGS = ("ingest", "finding", "run_file", "signal", "channel", "gap", "detection", "jump", "charge")
"""The tables whose rows another version of a reader may give otherwise."""
_INPUTS = ("study", "condition", "run", "charge", "decision", "robot", "signal")
"""What numbers name as their inputs."""
_OF_EVERYTHING = ("person", "config")
_OF_ALL_NUMBERS = ("config",)
_NTH = "nth"
"""Of the rows that belong to one, and have no name of their own."""
_NAMES = ("name", "original_name", "label", "key", "date_local", "part", "line", "number", "position")
"""Columns by which a person knows a row, the best first."""
_MOST_SHOWN = 60


class Misfit(StrEnum):
    """How a row differs from what should stand there."""

    ALTERED = "altered in"
    ADDED = "added to"
    REMOVED = "removed from"
    MOVED = "moved in"
    """Its private key has another place in the order of writing than its entry has in the journal."""


@dataclass(frozen=True, slots=True)
class AlteredRow:
    """A row that is not what labbook wrote, as it stands and as it should be, and the reports that depend on it."""

    table: str
    how: Misfit
    stands: _Row
    should_be: _Row
    reports: tuple[str, ...] = ()

    @property
    def sentence(self) -> str:
        """Say what was altered, and the reports that rest on it."""
        printed = f"; reports that rest on it: {', '.join(self.reports)}" if self.reports else ""
        return f"{self.how} the database: {self.table} {self._name}{self._what}{printed}."

    @property
    def columns(self) -> list[str]:
        """The columns with another value than they should have."""
        return [name for name in self.stands if self.stands[name] != self.should_be.get(name)]

    @property
    def _name(self) -> str:
        row = self.stands or self.should_be
        known = next((f" ({name} {row[name]})" for name in _NAMES if row.get(name) is not None), "")
        return f"{row['uid'] if 'uid' in row else f'of {next(iter(row.values()))}'}{known}"

    @property
    def _what(self) -> str:
        if self.how is not Misfit.ALTERED:
            return {
                Misfit.ADDED: " should not be there",
                Misfit.REMOVED: " is missing",
                Misfit.MOVED: " stands after what was stated later",
            }[self.how]
        pairs = [(name, *shortened_pair(self.stands[name], self.should_be[name])) for name in self.columns]
        return ": " + "; ".join(f"{name} is {stands} and should be {right}" for name, stands, right in pairs)


def altered_rows(book: sa.Connection, fresh: sa.Connection) -> list[AlteredRow]:
    """Compare all tables of a book with those that should stand there."""
    tables = (table for table in METADATA.sorted_tables if table.name not in _NOT_COMPARED)
    return [row for table in tables for row in _altered(table, book, fresh)]


def but_of_readings(rows: Iterable[AlteredRow]) -> list[AlteredRow]:
    """Leave out what another version of a reader may have made."""
    return [row for row in rows if row.table not in _OF_READINGS]


def altered_since(book: sa.Connection, engine: sa.Engine, replay: Replay) -> tuple[list[AlteredRow], int]:
    """Compare the tables of a book with its journal file, played back to where the table of entries ends.

    Where entries were removed from that table and their rows stand, the rows of the whole file are those that should
    stand there. Returns also how many entries were removed so; the replay ends at what was compared with.
    """
    seq = head(book)[0]
    replay.apply_to(engine, seq)
    with reading(engine) as fresh:
        found = altered_rows(book, fresh)
    last = replay.mirror.last()
    if found and last is not None and last.seq > seq:
        replay.apply_to(engine, last.seq)
        with reading(engine) as fresh:
            of_all = altered_rows(book, fresh)
        if len(of_all) < len(found):
            return of_all, last.seq - seq
    return found, 0


def inputs_altered(book: sa.Connection, fresh: sa.Connection, rows: Sequence[AlteredRow]) -> list[set[str] | None]:
    """Return for each altered row the uids and hashes of the inputs of numbers that it bears on; None for all."""
    return [
        None
        if row.table in _OF_ALL_NUMBERS or place >= MOST_FOLLOWED
        else {
            name
            for connection, one in ((book, row.stands), (fresh, row.should_be))
            if one
            for name in _input_names(connection, METADATA.tables[row.table], one, set())
        }
        for place, row in enumerate(rows)
    ]


def with_reports(
    store: Path, book: sa.Connection, fresh: sa.Connection, rows: Sequence[AlteredRow]
) -> list[AlteredRow]:
    """Add to the first rows the reports of the book with numbers that depend on them."""
    some, made = rows[:MOST_NAMED], list_reports(book)
    names = inputs_altered(book, fresh, some)
    inputs = {
        report.called: {
            row.input_uid for one in numbers.results.values() for row in one.inputs if row.input_kind != "result"
        }
        for report, numbers in readable_numbers(store, made, set().union(*filter(None, names)))
    }
    return [
        replace(
            row,
            reports=tuple(
                report.called for report in made if of_row is None or of_row & inputs.get(report.called, set())
            ),
        )
        for row, of_row in zip(some, names, strict=True)
    ]


def _altered(table: sa.Table, book: sa.Connection, fresh: sa.Connection) -> Iterator[AlteredRow]:
    """Compare the rows of a table one by one; only those out of step are kept, to be matched by their keys."""
    query = _public(table).order_by(*table.primary_key.columns)
    here, there = (chain.from_iterable(scan(connection, query)) for connection in (book, fresh))
    key, names = _key(table), list(query.selected_columns.keys())
    left: dict[tuple[Any, ...], _Row] = {}
    right: dict[tuple[Any, ...], _Row] = {}
    for row, other in zip_longest(here, there):
        if row != other:
            for some, one in ((left, row), (right, other)):
                if one is not None:
                    named = dict(zip(names, one, strict=True))
                    some[tuple(named[name] for name in key)] = named
    places = {key: place for place, key in enumerate(right)}
    latest = 0
    for key_of_row in {**left, **right}:
        stands, should_be = left.get(key_of_row, {}), right.get(key_of_row, {})
        if stands != should_be:
            how = Misfit.REMOVED if not stands else Misfit.ADDED if not should_be else Misfit.ALTERED
            yield AlteredRow(table.name, how, stands, should_be)
        elif places[key_of_row] < latest:
            yield AlteredRow(table.name, Misfit.MOVED, stands, should_be)
        latest = max(latest, places.get(key_of_row, 0) if stands else 0)


def _key(table: sa.Table) -> list[str]:
    """Return the columns by which a row is found in another database."""
    if "uid" in table.c:
        return ["uid"]
    own = [column.name for column in table.primary_key.columns]
    return [_owner(table).name, _NTH] if own == ["id"] else own


def _owner(table: sa.Table) -> sa.Column[Any]:
    """Return the reference to the row that a row belongs to, which stands first."""
    return next(column for column in table.c if column.foreign_keys)


@cache
def _public(table: sa.Table) -> sa.Select[Any]:
    """Select the rows of a table without private keys: references are uids, in columns of the same names."""
    source: sa.FromClause = table
    columns: list[sa.ColumnElement[Any]] = []
    for column in table.c:
        referred = _referred(column)
        if referred is not None:
            other = referred.alias(f"of_{column.name}")
            source = source.outerjoin(other, column == other.c.id)
            or_nowhere = sa.func.coalesce(other.c.uid, sa.cast(column, TEXT))
            columns.append(or_nowhere.label(column.name))
        elif column.name != "id":
            columns.append(column)
    if _NTH in _key(table):
        columns.append(sa.func.row_number().over(partition_by=_owner(table), order_by=table.c.id).label(_NTH))
    return sa.select(*columns).select_from(source)


def _referred(column: sa.Column[Any]) -> sa.Table | None:
    return next((key.column.table for key in column.foreign_keys), None)


def _input_names(connection: sa.Connection, table: sa.Table, row: _Row, met: set[tuple[str, str]]) -> Iterator[str]:
    """Give the uids and hashes under which numbers name a row, what it is a part of, or what refers to it."""
    yield from (row[name] for name in ("uid", "sha256", "signal_sha256", "target_uid", "run") if row.get(name))
    if table.name in (*_INPUTS, *_OF_EVERYTHING):
        return
    others = []
    if table.name not in FACTS:
        owner = _owner(table)
        others = [(other, other.c.uid == row[owner.name]) for other in [_referred(owner)] if other is not None]
    if "uid" in row:
        key = sa.select(table.c.id).where(table.c.uid == row["uid"]).scalar_subquery()
        others += [
            (other, column == key)
            for other in METADATA.sorted_tables
            for column in other.c
            if _referred(column) is table and other.name not in _NOT_COMPARED
        ]
    for other, on in others:
        for found in map(dict, connection.execute(_public(other).where(on)).mappings()):
            seen = (other.name, str(found))
            if seen not in met:
                met.add(seen)
                yield from _input_names(connection, other, found, met)


def shortened_pair(stands: Any, should_be: Any) -> tuple[str, str]:
    """Return two values to be read side by side; of long texts what is around the first difference."""
    texts = [str(value) for value in (stands, should_be)]
    if max(map(len, texts)) <= _MOST_SHOWN:
        return repr(stands), repr(should_be)
    same = sum(1 for _pair in takewhile(lambda pair: pair[0] == pair[1], zip(*texts, strict=False)))
    begin = max(0, same - _MOST_SHOWN // 3)
    shown = [
        f"{'...' if begin else ''}{text[begin : begin + _MOST_SHOWN]!r}"
        f"{'...' if len(text) > begin + _MOST_SHOWN else ''}"
        for text in texts
    ]
    return shown[0], shown[1]


@dataclass(frozen=True, slots=True)
class Differences:
    """Counts; all are 0 where this labbook reads what the earlier ones did.

    `files_read_anew` were read by another version of their reader,
    `files_changed` of them gave other rows or samples. `files_waiting` has for each file that this labbook refuses, and
    an earlier one read, what it waits for. `without_rows` names each statement about a charge or a part of a file that
    no reading gives now. `other_versions`: another version of a reader made some of it.
    """

    files_read_anew: int = 0
    files_changed: int = 0
    files_waiting: tuple[str, ...] = ()
    without_rows: tuple[str, ...] = ()
    other_versions: bool = False

    @property
    def sentences(self) -> list[str]:
        """Return a sentence for each difference; none where all agrees."""
        found = []
        if self.files_read_anew:
            result = (
                f"{self.files_changed} of them with another result" if self.files_changed else "with the same result"
            )
            found.append(
                f"{_counted(self.files_read_anew, 'file')} went through another version of their reader than at their "
                f"import, {result}."
            )
        return [*found, *self.files_waiting, *self.without_rows]


def differences(connection: sa.Connection, entries: Iterable[Entry], without_rows: Sequence[Entry] = ()) -> Differences:
    """Compare a rebuilt database with the entries of its journal on files.

    `without_rows` are the statements about rows that were not there when they were replayed; those about charges have
    taken effect where a later reading gave the charge.
    """
    now = readings(connection)
    anew = []
    for entry in entries:
        if entry.reads and entry.entity_uid in now:
            content, reading = entry.new or {}, now[entry.entity_uid]
            if (content["reader"], content["reader_version"]) != (reading.reader, reading.reader_version):
                anew.append((content["rows"], content["signals"]) != (reading.rows, reading.signals))
    return Differences(
        files_read_anew=len(anew),
        files_changed=sum(anew),
        other_versions=bool(anew),
        files_waiting=tuple(f"{waiting.why.reason}." for waiting in waiting_files(connection)),
        without_rows=tuple(
            _without_row(entry)
            for entry in without_rows
            if entry.entity_kind != "charge" or not fact_exists(connection, "charge", entry.entity_uid)
        ),
    )


def _without_row(entry: Entry) -> str:
    why = f" ({entry.reason})" if entry.reason else ""
    return (
        f"Entry {entry.seq} of {entry.person}, {words_of(entry).did} {entry.entity_kind} {entry.entity_uid}{why}, "
        "speaks of what no reading of its file gives now: it has no effect until one does, see `labbook files show`."
    )


def _counted(count: int, what: str) -> str:
    return f"{count} {what}" if count == 1 else f"{count} {what}s"
