"""The journal: every statement of a person, one line each, in an order that cannot be changed unseen.

A line is canonical JSON (sorted keys, no blanks, UTF-8) and carries the hash of the line before it; its own hash is
the SHA-256 of the line without the hash. The same entries stand in the table `journal` and in `journal.jsonl`; the
file is written and synced before the database commits, so it is never behind: an entry that the file has and the
database lacks was cut off between the two and is applied when the book is next written to.

The statements of one command are accepted or refused as a whole, so every entry also counts how many of its command
follow. A power cut can leave the first lines of a command in the file; they do not count, as half a line does not, and
the next command sets them aside. Such a command never reported success, for its database transaction never began to
commit. The first line carries the number of the form that all of them have.
"""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property
from json.encoder import encode_basestring
from typing import Any, Self

import msgspec
import sqlalchemy as sa

from data_schema.errors import BookDamaged, BookVersion
from data_schema.tables.journal import journal, person
from data_schema.tables.plain import insert as insert_row
from data_schema.vocabulary import USING, Action

JOURNAL_SCHEMA = 4
"""The number of the form of a journal's lines: rises with what an earlier labbook could not read."""
GENESIS = "0" * 64
"""The hash that the first entry follows."""

MEND_FILE = "write journal.jsonl anew from the database with `labbook rebuild --journal`, or restore it from a backup"
MEND_BOTH = "journal.jsonl is damaged too: make the book anew from a backup with `labbook restore`"
MEND_TABLE = "run `labbook rebuild` to make the database anew from journal.jsonl"


@dataclass(frozen=True)
class Entry:
    """One statement: person, time, the thing it is about, its values before and after, and the reason.

    `old` and `new` hold columns by name; a reference to another row is that row's uid. `following` is the number of
    entries of the same command that come after this one. Until its command is complete, an entry has no place in the
    chain; `chain_entries` gives it one. `origin` is number and hash of the entry of another book that this one was
    merged from. `schema` stands in the first entry alone. A line names neither where there is none.
    """

    seq: int
    following: int
    at_utc: str
    person: str
    action: Action
    entity_kind: str
    entity_uid: str
    old: Mapping[str, Any] | None
    new: Mapping[str, Any] | None
    reason: str | None
    prev_hash: str
    origin: Mapping[str, Any] | None = None
    schema: int | None = None

    @cached_property
    def hash(self) -> str:
        """SHA-256 over the canonical line without the hash itself."""
        return _sha256(self._unhashed)

    @property
    def reads(self) -> bool:
        """Whether it is of a reading of a file; that of a refused one holds the findings."""
        return self.action is Action.INGEST and "findings" not in (self.new or {})

    @property
    def makes(self) -> bool:
        """Whether a thing, or a file, first comes in with it."""
        return is_new(self.action, self.entity_kind, self.old)

    @cached_property
    def line(self) -> str:
        """The line of `journal.jsonl`, without its newline: canonical, too, with the hash among its sorted keys."""
        before, name, after = self._unhashed.partition('"new":')
        return f'{before}"hash":"{self.hash}",{name}{after}'

    @classmethod
    def from_line(cls, text: str, remedy: str = MEND_FILE) -> Self:
        """Read a line back; raises `BookDamaged`, with the `remedy`, when it is not what was written.

        Raises `BookVersion` for the first line of a journal of another form.
        """
        try:
            record = _value(text)
            recorded, schema = record.pop("hash"), record.get("schema")
            before, _hash, after = text.partition(f'"hash":"{recorded}",')
            fits = _sha256(before + after) == recorded
            if record["seq"] == 1 and schema != JOURNAL_SCHEMA and fits:
                raise BookVersion(
                    f"journal.jsonl has schema {'none' if schema is None else schema}, and this labbook reads schema "
                    f"{JOURNAL_SCHEMA}: work with the labbook that wrote it, or name another book."
                )
            if record["seq"] != 1 and schema is not None:
                raise ValueError("schema stands in the first entry alone")
            if any(name in record and record[name] is None for name in _LEFT_OUT):
                raise ValueError("it names what it has not")
            record["action"] = action_of(record["action"])
            entry = cls(**record)
        except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
            raise BookDamaged(f"a line of journal.jsonl cannot be read ({error}): {text[:80]!r}; {remedy}.") from error
        if not fits:
            raise BookDamaged(
                f"journal entry {entry.seq} was changed after it was written (its hash does not fit): {remedy}."
            )
        vars(entry).update(hash=recorded, line=text)
        return entry

    @cached_property
    def _unhashed(self) -> str:
        """The canonical line without the hash."""
        return _object({name: _text(getattr(self, name)) for name in _FIELDS})


_ACTIONS = {str(action): action for action in Action}
_FIELDS = tuple(sorted(field.name for field in fields(Entry)))
_LEFT_OUT = ("origin", "schema")
"""Fields that a line has only where they have a value."""


def _object(texts: Mapping[str, str]) -> str:
    """Return the canonical text of an entry without its hash from those of all its fields."""
    given = (name for name in _FIELDS if texts[name] != "null" or name not in _LEFT_OUT)
    return "{" + ",".join([f'"{name}":{texts[name]}' for name in given]) + "}"


def is_new(action: Action, kind: str, old: object) -> bool:
    """Tell whether a thing of this kind, or a file, first comes in with an entry; that of a verdict is always new."""
    return old is None and (kind == "decision" or action not in USING)


def action_of(text: str) -> Action:
    """Return the action of this word, sooner than `Action` does."""
    return _ACTIONS.get(text) or Action(text)


def _text(value: object) -> str:
    if isinstance(value, str):
        return encode_basestring(value)
    return "null" if value is None else str(value) if type(value) is int else canonical(value)


def _sha256(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()


def canonical(value: object) -> str:
    """Return the one JSON text of a value: sorted keys, no blanks, no NaN."""
    return _CANONICAL.encode(value)


def _value(text: str) -> Any:
    """Return the value of a canonical text; raises `ValueError` where it is another than `canonical` writes.

    msgspec reads and writes in a fifth of the time; it writes very small and very large numbers otherwise.
    """
    value = _VALUES.decode(text)
    as_msgspec = _WRITER.encode(value) == text.encode()
    if not (as_msgspec and _OTHERWISE.search(text) is None) and canonical(value) != text:
        raise ValueError("it is not as labbook writes it")
    return value


_CANONICAL = json.JSONEncoder(sort_keys=True, separators=(",", ":"), ensure_ascii=False, allow_nan=False)
_OTHERWISE = re.compile(r"(?:^|[:,\[])-?(?:\d+(?:\.\d+)?e(?:\d|-\d\b)|0\.0000|\d{17,}\.)")
"""Finds a number as msgspec writes it and `canonical` does not."""
_WRITER = msgspec.json.Encoder(order="sorted")
_VALUES = msgspec.json.Decoder()


class _Texts(msgspec.Struct):
    """The fields of a line that the table holds as JSON, each as it stands there."""

    new: msgspec.Raw
    old: msgspec.Raw
    origin: msgspec.Raw = msgspec.Raw(b"null")


_TEXTS = msgspec.json.Decoder(_Texts)


def chain_entries(entries_of_command: Sequence[Entry], after: tuple[int, str]) -> list[Entry]:
    """Give the entries of one complete command their places after an entry of this number and hash."""
    seq, previous = after
    entries: list[Entry] = []
    for number, entry in enumerate(entries_of_command, start=seq + 1):
        following = seq + len(entries_of_command) - number
        schema = JOURNAL_SCHEMA if number == 1 else None
        entries.append(replace(entry, seq=number, following=following, prev_hash=previous, schema=schema))
        previous = entries[-1].hash
    return entries


def verified_chain(
    entries: Iterable[Entry], after: tuple[int, str] = (0, GENESIS), remedy: str = MEND_FILE
) -> Iterator[Entry]:
    """Pass entries on while each follows the one before it; raises `BookDamaged` at the first that does not.

    `after` is number and hash of an entry that was the last of its command; `remedy` says what mends the place that
    the entries are read from.
    """
    seq, previous = after
    awaited = 0
    for entry in entries:
        if entry.seq != seq + 1 or entry.prev_hash != previous or (awaited and entry.following != awaited - 1):
            raise BookDamaged(
                f"journal entry {entry.seq} does not follow entry {seq}: one is missing or was changed; {remedy}."
            )
        seq, previous, awaited = entry.seq, entry.hash, entry.following
        yield entry


def commands(entries: Iterable[Entry]) -> Iterator[list[Entry]]:
    """Gather entries by the command that made them."""
    command: list[Entry] = []
    for entry in entries:
        command.append(entry)
        if entry.following == 0:
            yield command
            command = []


def head(connection: sa.Connection) -> tuple[int, str]:
    """Return number and hash of the last entry in the database; (0, GENESIS) when there is none."""
    row = connection.execute(sa.select(journal.c.seq, journal.c.hash).order_by(journal.c.seq.desc()).limit(1)).first()
    return (int(row.seq), str(row.hash)) if row else (0, GENESIS)


def insert(connection: sa.Connection, entries: Sequence[Entry]) -> None:
    """Write entries to the table; their persons must be known by then."""
    for entry in entries:
        insert_row(connection, _INSERT, _row_of(entry))


_PLAIN = ("seq", "following", "at_utc", "entity_kind", "entity_uid", "reason", "prev_hash", "hash")
_JSON = ("old", "new", "origin")


def _row_of(entry: Entry) -> dict[str, Any]:
    texts = _TEXTS.decode(entry.line)
    return {
        **{name: getattr(entry, name) for name in _PLAIN},
        **{
            f"{name}_json": None if getattr(entry, name) is None else str(getattr(texts, name), "utf-8")
            for name in _JSON
        },
        "person_name": entry.person,
        "action": str(entry.action),
    }


# Built once: a rebuild writes thousands of entries, and building a query takes longer than asking it.
_INSERT = journal.insert().values(
    person=sa.select(person.c.id).where(person.c.name == sa.bindparam("person_name")).scalar_subquery()
)


def stored(connection: sa.Connection, after_seq: int = 0, action: Action | None = None) -> Iterator[Entry]:
    """Read the entries of the database in order, all or those after one, or of one action.

    Raises `BookDamaged` at an entry that is not what was written.
    """
    query = sa.select(journal, person.c.name.label("person_name")).join(person).order_by(journal.c.seq)
    query = query if action is None else query.where(journal.c.action == action)
    for row in connection.execute(query.where(journal.c.seq > after_seq)):
        try:
            entry = _entry_of(row)
            changed = entry.hash != row.hash
        except (ValueError, TypeError, RecursionError):
            changed = True
        if changed:
            raise BookDamaged(
                f"journal entry {row.seq} of the database was changed after it was written (its hash does not fit): "
                f"{MEND_TABLE}."
            )
        yield entry


def damage_at_end(connection: sa.Connection) -> str | None:
    """Say what is wrong with the last entries of the database, None where nothing is.

    A connection reports it once: commands that write ask with each session.
    """
    if _LOOKED_AT in connection.info:
        return None
    connection.info[_LOOKED_AT] = True
    first = max(0, head(connection)[0] - _LAST_ENTRIES)
    before = connection.execute(sa.select(journal.c.hash).where(journal.c.seq == first)).scalar() or GENESIS
    try:
        for _entry in verified_chain(stored(connection, first), (first, before), MEND_TABLE):
            pass
    except BookDamaged as error:
        return str(error)
    return None


_LAST_ENTRIES = 100
"""How many are checked before a statement, which takes milliseconds; `labbook db check` checks all."""
_LOOKED_AT = "labbook_journal_looked_at"


def _entry_of(row: Any) -> Entry:
    values = {name: getattr(row, name) for name in _PLAIN if name != "hash"}
    values |= {"person": row.person_name, "action": row.action, "schema": JOURNAL_SCHEMA if row.seq == 1 else None}
    written = {name: getattr(row, f"{name}_json") for name in _JSON}
    texts = {name: _text(value) for name, value in values.items()}
    texts |= {name: "null" if text is None else text for name, text in written.items()}
    values |= {name: _value(texts[name]) for name in _JSON} | {"action": action_of(row.action)}
    entry = Entry(**values)
    vars(entry)["_unhashed"] = _object(texts)
    return entry
