"""The journal: every statement of a person, one line each, in an order that cannot be changed unseen.

A line is canonical JSON (sorted keys, no blanks, UTF-8) and carries the hash of the line before it; its own hash is
the SHA-256 of the line without the hash. The same entries stand in the table `journal` and in `journal.jsonl`; the
file is written and synced before the database commits, so it is never behind: an entry that the file has and the
database lacks was cut off between the two and is applied when the book is next written to.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields
from io import FileIO
from pathlib import Path
from typing import Any, Self

import sqlalchemy as sa

from data_schema.errors import BookDamaged
from data_schema.tables.people import journal, person
from data_schema.vocabulary import Action

GENESIS = "0" * 64
"""The hash that the first entry follows."""


@dataclass(frozen=True, slots=True)
class Entry:
    """One statement: who said when that which thing is what, what it was before, and why.

    `old` and `new` hold columns by name; a reference to another row is that row's uid.
    """

    seq: int
    at_utc: str
    person: str
    action: Action
    entity_kind: str
    entity_uid: str
    old: Mapping[str, Any] | None
    new: Mapping[str, Any] | None
    reason: str | None
    prev_hash: str

    @property
    def hash(self) -> str:
        """SHA-256 over the canonical line without the hash itself."""
        return hashlib.sha256(canonical(self._body()).encode()).hexdigest()

    @property
    def line(self) -> str:
        """The line of `journal.jsonl`, without its newline."""
        return canonical({**self._body(), "hash": self.hash})

    @classmethod
    def from_line(cls, text: str) -> Self:
        """Read a line back; raises `BookDamaged` when it is not what was written."""
        try:
            record = json.loads(text)
            stated = record.pop("hash")
            entry = cls(**{**record, "action": Action(record["action"])})
        except (ValueError, KeyError, TypeError, AttributeError) as error:
            raise BookDamaged(
                f"a journal line cannot be read ({error}): {text[:80]!r}; restore it from a backup."
            ) from error
        if entry.hash != stated or entry.line != text:
            raise BookDamaged(
                f"journal entry {entry.seq} was changed after it was written (its hash does not fit): restore "
                "journal.jsonl from a backup."
            )
        return entry

    def _body(self) -> dict[str, Any]:
        return {field.name: getattr(self, field.name) for field in fields(self)}


def canonical(value: object) -> str:
    """Return the one JSON text of a value: sorted keys, no blanks, no NaN."""
    return json.dumps(value, sort_keys=True, separators=(",", ":"), ensure_ascii=False, allow_nan=False)


def chained(entries: Iterator[Entry]) -> Iterator[Entry]:
    """Pass entries on while each follows the one before it; raises `BookDamaged` at the first that does not."""
    seq, previous = 0, GENESIS
    for entry in entries:
        if entry.seq != seq + 1 or entry.prev_hash != previous:
            raise BookDamaged(
                f"journal entry {entry.seq} does not follow entry {seq}: a line is missing or was changed; restore "
                "journal.jsonl from a backup."
            )
        seq, previous = entry.seq, entry.hash
        yield entry


def head(connection: sa.Connection) -> tuple[int, str]:
    """Return number and hash of the last entry in the database; (0, GENESIS) when there is none."""
    row = connection.execute(sa.select(journal.c.seq, journal.c.hash).order_by(journal.c.seq.desc()).limit(1)).first()
    return (int(row.seq), str(row.hash)) if row else (0, GENESIS)


def insert(connection: sa.Connection, entry: Entry) -> None:
    """Write one entry to the table; its person must be known by then."""
    connection.execute(
        journal.insert().values(
            seq=entry.seq,
            at_utc=entry.at_utc,
            person=sa.select(person.c.id).where(person.c.name == entry.person).scalar_subquery(),
            action=str(entry.action),
            entity_kind=entry.entity_kind,
            entity_uid=entry.entity_uid,
            old_json=None if entry.old is None else canonical(entry.old),
            new_json=None if entry.new is None else canonical(entry.new),
            reason=entry.reason,
            prev_hash=entry.prev_hash,
            hash=entry.hash,
        )
    )


def stored(connection: sa.Connection) -> Iterator[Entry]:
    """Read all entries of the database in order; raises `BookDamaged` at one that is not what was written."""
    query = sa.select(journal, person.c.name.label("person_name")).join(person).order_by(journal.c.seq)
    for row in connection.execute(query):
        entry = Entry(
            seq=row.seq,
            at_utc=row.at_utc,
            person=row.person_name,
            action=Action(row.action),
            entity_kind=row.entity_kind,
            entity_uid=row.entity_uid,
            old=None if row.old_json is None else json.loads(row.old_json),
            new=None if row.new_json is None else json.loads(row.new_json),
            reason=row.reason,
            prev_hash=row.prev_hash,
        )
        if entry.hash != row.hash:
            raise BookDamaged(
                f"journal entry {entry.seq} of the database was changed after it was written (its hash does not fit): "
                "run `labbook rebuild` to make the database anew from journal.jsonl."
            )
        yield entry


class JournalFile:
    """The mirror of the journal on disk, append-only."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def entries(self) -> Iterator[Entry]:
        """Read and verify every complete line; a last line without newline was cut off and does not count."""
        yield from chained(Entry.from_line(line) for line in self._complete_lines())

    def tail(self, after_seq: int) -> list[Entry]:
        """Return the complete entries after `after_seq`, reading from the end of the file."""
        newest: list[Entry] = []
        for line in reversed(self._complete_lines(last_bytes=1 << 20)):
            entry = Entry.from_line(line)
            if entry.seq <= after_seq:
                break
            newest.append(entry)
        if newest and newest[-1].seq != after_seq + 1:
            return [entry for entry in self.entries() if entry.seq > after_seq]
        return newest[::-1]

    def last(self) -> Entry | None:
        """Return the last complete entry."""
        lines = self._complete_lines(last_bytes=1 << 20)
        return Entry.from_line(lines[-1]) if lines else None

    def append(self, entries: list[Entry]) -> None:
        """Write entries at the end and sync them to the disk, all or none; a cut-off last line is removed first."""
        lines = "".join(entry.line + "\n" for entry in entries).encode()
        with self.path.open("r+b", buffering=0) as handle:
            if not _ends_with_newline(handle):
                handle.seek(0)
                handle.truncate(handle.read().rfind(b"\n") + 1)
            end = handle.seek(0, os.SEEK_END)
            try:
                written = 0
                while written < len(lines):
                    written += handle.write(lines[written:])
                os.fsync(handle.fileno())
            except BaseException:
                handle.truncate(end)
                raise

    def _complete_lines(self, last_bytes: int | None = None) -> list[str]:
        try:
            with self.path.open("rb") as handle:
                size = handle.seek(0, os.SEEK_END)
                start = 0 if last_bytes is None else max(0, size - last_bytes)
                handle.seek(start)
                data = handle.read()
        except FileNotFoundError as error:
            raise BookDamaged(
                f"{self.path} is missing: restore it from a backup, or write it anew from the database with "
                "`labbook rebuild --journal`."
            ) from error
        if start:
            first = data.find(b"\n")
            if first < 0 or data.count(b"\n") < 2:
                return self._complete_lines()
            data = data[first + 1 :]
        try:
            return data[: data.rfind(b"\n") + 1].decode().split("\n")[:-1]
        except UnicodeDecodeError as error:
            raise BookDamaged(
                f"{self.path} is not the text that was written (byte {error.start + start}): restore it from a backup, "
                "or write it anew from the database with `labbook rebuild --journal`."
            ) from error


def _ends_with_newline(handle: FileIO) -> bool:
    """Look at the last byte; an empty file has no cut-off line."""
    if handle.seek(0, os.SEEK_END) == 0:
        return True
    handle.seek(-1, os.SEEK_END)
    return handle.read(1) == b"\n"
