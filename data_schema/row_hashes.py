"""Hashes of rows, in a table of their own: a row that was altered outside labbook no longer fits its hash.

Rows that are written together have one hash under the uid of the row that they belong to: a reading of a file with its
findings, signals, channels and gaps; a detection with its jumps; a fact alone.
Code that writes rows calls `note_written`; `hashing_written_rows` wraps a writing transaction and hashes at its end
what is then in the tables. What is hashed has no private keys: a reference is the uid of the row that it leads to. So
the same book has the same hashes on any engine and after a rebuild, and two rows cannot change places unseen.
"""

from __future__ import annotations

import contextlib
import hashlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from functools import cache
from typing import Any

import sqlalchemy as sa

from data_schema.tables import FACTS, design, files, runs, signals
from data_schema.tables.base import CHUNK, in_chunks
from data_schema.tables.journal import config, journal, row_hash

_WRITTEN = "labbook_rows_written"
"""Under this name a connection keeps what its transaction has written."""


class Misfit(StrEnum):
    """How rows and their hash disagree."""

    ALTERED = "altered"
    ADDED = "added"
    REMOVED = "removed"
    MOVED = "moved"
    """Its private key has another place in the order of writing than its entry has in the journal."""


@dataclass(frozen=True, slots=True)
class Member:
    """Rows of a table that belong to an owner: how they are joined to it, and in which order they are hashed."""

    table: sa.Table
    joins: Sequence[tuple[sa.Table, sa.ColumnElement[bool]]]
    order: Sequence[sa.Column[Any]]


@dataclass(frozen=True, slots=True)
class Altered:
    """Rows that are not what labbook wrote, by the kind and the uid of their owner."""

    kind: str
    uid: str
    how: Misfit


def _below(table: sa.Table, owner: sa.Table, *order: sa.Column[Any]) -> Member:
    return Member(table, ((owner, table.c[owner.name] == owner.c.id),), order)


def _of_signal(table: sa.Table, place: sa.Column[Any]) -> Member:
    signal, reading = signals.signal, files.ingest
    joins = ((signal, table.c.signal == signal.c.id), (reading, signal.c.ingest == reading.c.id))
    return Member(table, joins, (table.c.signal, place))


_OWNERS = (*FACTS.values(), files.ingest, signals.detection)

_MEMBERS: Mapping[str, tuple[Member, ...]] = {
    "condition": (_below(design.condition_level, design.condition, design.condition_level.c.factor),),
    "ingest": (
        _below(files.finding, files.ingest, files.finding.c.id),
        _below(signals.signal, files.ingest, signals.signal.c.id),
        _of_signal(signals.channel, signals.channel.c.position),
        _of_signal(signals.gap, signals.gap.c.id),
    ),
    "detection": (_below(signals.jump, signals.detection, signals.jump.c.number),),
}
"""What belongs to an owner beside its own row, by its kind."""

GROUPS: Mapping[str, tuple[sa.Table, tuple[Member, ...]]] = {
    owner.name: (owner, (Member(owner, (), (owner.c.id,)), *_MEMBERS.get(owner.name, ()))) for owner in _OWNERS
}
"""The kinds of owners, each with the tables that its hash covers: all but the journal, which is a chain of its own."""


def note_written(connection: sa.Connection, kind: str, uids: Sequence[str]) -> None:
    """Note that rows of these owners were written."""
    connection.info[_WRITTEN].setdefault(kind, {}).update(dict.fromkeys(uids))


@contextlib.contextmanager
def hashing_written_rows(connection: sa.Connection) -> Iterator[None]:
    """Keep account of the rows that a transaction writes, and hash them at its end."""
    touched: dict[str, dict[str, None]] = {}
    connection.info[_WRITTEN] = touched
    try:
        yield
        for kind, uids in touched.items():
            for some in in_chunks(list(uids)):
                _keep(connection, kind, some)
    finally:
        del connection.info[_WRITTEN]


def altered_rows(connection: sa.Connection) -> list[Altered]:
    """Hash all rows anew and return those that do not fit the hash stored when they were written."""
    found = []
    kinds = connection.execute(sa.select(row_hash.c.kind).distinct()).scalars()
    for kind in dict.fromkeys((*GROUPS, *kinds)):
        expected, now = stored_hashes(connection, kind), row_hashes(connection, kind)
        for uid, sha256 in now.items():
            if expected.get(uid) != sha256:
                found.append(Altered(kind, uid, Misfit.ALTERED if uid in expected else Misfit.ADDED))
        found += [Altered(kind, uid, Misfit.REMOVED) for uid in expected if uid not in now]
    return found + [moved for owner in _LATEST_COUNTS for moved in _moved(connection, owner)]


_LATEST_COUNTS = (config, runs.decision, runs.note)
"""Of these the private key tells which came later; no hash covers it."""


def _moved(connection: sa.Connection, owner: sa.Table) -> Iterator[Altered]:
    """Find rows that stand behind one which the journal has after them."""
    statement_of_row = sa.and_(journal.c.entity_kind == owner.name, journal.c.entity_uid == owner.c.uid)
    latest = 0
    query = sa.select(owner.c.uid, journal.c.seq).join(journal, statement_of_row).order_by(owner.c.id)
    for uid, seq in connection.execute(query):
        if seq < latest:
            yield Altered(owner.name, uid, Misfit.MOVED)
        latest = max(latest, seq)


def stored_hashes(connection: sa.Connection, kind: str) -> dict[str, str]:
    """Return the hashes that were stored when the rows of a kind were written, by the uid of their owner."""
    query = sa.select(row_hash.c.uid, row_hash.c.sha256).where(row_hash.c.kind == kind)
    return dict(connection.execute(query).all())


def row_hashes(connection: sa.Connection, kind: str, uids: Sequence[str] | None = None) -> dict[str, str]:
    """Return the hashes of the rows as they stand, by the uid of their owner: of all of a kind, or of some."""
    queries = _queries_by_kind(connection.dialect.name).get(kind, [])
    given = {} if uids is None else {"uids": list(uids)}
    digests: dict[str, Any] = {}
    for name, every, some in queries:
        for rows in connection.execute(every if uids is None else some, given).partitions(CHUNK):
            for uid, *row in rows:
                digest = digests.get(uid)
                if digest is None:
                    digest = digests[uid] = hashlib.sha256()
                digest.update(name + repr(row).encode())
    return {uid: digest.hexdigest() for uid, digest in digests.items()}


def rows_of(connection: sa.Connection, kind: str, uid: str) -> list[tuple[str, dict[str, Any]]]:
    """Return what the hash of one owner covers: each row by column, after the name of its table."""
    return [
        (name.decode(), {column: value for column, value in row.items() if column != "owner"})
        for name, _every, some in _queries_by_kind(connection.dialect.name).get(kind, [])
        for row in connection.execute(some, {"uids": [uid]}).mappings()
    ]


def _queries(owner: sa.Table, member: Member, dialect: str) -> tuple[bytes, sa.Select[Any], sa.Select[Any]]:
    """Select the rows of all owners, and those of owners with one of the `uids`, texts ordered by their bytes."""
    source: sa.FromClause = member.table
    for table, on in member.joins:
        source = source.join(table, on)
    columns: list[sa.ColumnElement[Any]] = []
    for column in member.table.c:
        referred = next((key.column.table for key in column.foreign_keys), None)
        if referred is not None and referred is not owner:
            other = referred.alias()
            source = source.outerjoin(other, column == other.c.id)
            columns.append(other.c.uid.label(column.name))
        elif referred is None and column.name != "id":
            columns.append(column)
    order = [
        column.collate("C") if dialect == "postgresql" and isinstance(column.type, sa.Text) else column
        for column in member.order
    ]
    every = sa.select(owner.c.uid.label("owner"), *columns).select_from(source).order_by(*order)
    return member.table.name.encode(), every, every.where(owner.c.uid.in_(sa.bindparam("uids", expanding=True)))


@cache
def _queries_by_kind(dialect: str) -> dict[str, list[tuple[bytes, sa.Select[Any], sa.Select[Any]]]]:
    """Build the queries once: an ingest of many files asks them for each, and building one takes longer than asking."""
    return {kind: [_queries(owner, member, dialect) for member in members] for kind, (owner, members) in GROUPS.items()}


def _keep(connection: sa.Connection, kind: str, uids: Sequence[str]) -> None:
    connection.execute(row_hash.delete().where(row_hash.c.kind == kind, row_hash.c.uid.in_(uids)))
    found = row_hashes(connection, kind, uids)
    if found:
        rows = [{"kind": kind, "uid": uid, "sha256": sha256} for uid, sha256 in found.items()]
        connection.execute(row_hash.insert(), rows)
