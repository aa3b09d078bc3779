"""The session: where statements become journal entries and rows, all of them or none.

One way in for everything a person states. A statement is applied to the tables at once, so that the next one can build
on it. When the session closes, all its statements are one command: its entries get their places in the chain, are
written to the table `journal`, appended to `journal.jsonl` and synced, and only then all of it is committed. `labbook
rebuild` applies the same entries with the same functions, which is why it arrives at the same rows.
"""

from __future__ import annotations

import contextlib
import logging
import secrets
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from datetime import UTC, datetime
from typing import Any

import sqlalchemy as sa

from data_schema import journal
from data_schema.disk import sync
from data_schema.engine import reading, writing
from data_schema.errors import BookDamaged, BookError, InputRefused, UsageError
from data_schema.journal import Entry
from data_schema.journal_file import JournalFile
from data_schema.journal_rules import checked, wrong_kinds_refused
from data_schema.queries.history import last_stated_utc
from data_schema.vocabulary import Action
from ingest.store import Store
from labbook.statements import ApplyContext, apply_entry

_LOG = logging.getLogger("labbook.book")


class DryRun(Exception):
    """Raised inside a session to see what would happen and keep nothing."""


@dataclass(frozen=True, slots=True)
class Statement:
    """What a person is about to state; `prepared` is work already done for it, never part of the record."""

    action: Action
    kind: str
    uid: str
    new: Mapping[str, Any] | None = None
    old: Mapping[str, Any] | None = None
    reason: str | None = None
    prepared: object = None


@dataclass
class WriteSession:
    """An open writing transaction in which one person makes statements."""

    connection: sa.Connection
    store: Store
    person: str
    entries: list[Entry] = field(default_factory=list)
    merged: list[Entry] = field(default_factory=list)

    def state(self, statement: Statement) -> None:
        """Apply one statement; raises a `LabbookError` when it cannot be accepted.

        Its entry gets its place in the chain when the session closes.
        """
        refuse_unwritable_text([statement.old, statement.new, statement.reason])
        entry = Entry(
            seq=0,
            following=0,
            at_utc=now_utc(),
            person=self.person,
            action=statement.action,
            entity_kind=statement.kind,
            entity_uid=statement.uid,
            old=statement.old,
            new=statement.new,
            reason=statement.reason,
            prev_hash=journal.GENESIS,
        )
        apply(self.connection, self.store, entry, statement.prepared)
        self.entries.append(entry)

    def declare(self, entity: str, /, **values: Any) -> str:
        """State that a thing exists; returns its new uid."""
        uid = new_uid()
        self.state(Statement(Action.PLAN if entity == "plan" else Action.SET, entity, uid, new=values))
        return uid

    def merge(self, entries: Iterable[Entry]) -> None:
        """Take over entries of another book, each with its time, its person and its origin.

        They take effect in their order when the session closes, after all that was stated here.
        """
        self.merged += entries


def refuse_unwritable_text(value: object) -> None:
    """Raise `InputRefused` for texts that no journal can hold: bytes that are not UTF-8, and NUL."""
    if isinstance(value, Mapping):
        value = [*value.keys(), *value.values()]
    if isinstance(value, list | tuple):
        for part in value:
            refuse_unwritable_text(part)
    elif isinstance(value, str) and ("\0" in value or _surrogates(value)):
        shown = value.encode("utf-8", "backslashreplace").decode().replace("\0", "\\0")
        raise InputRefused(f"'{shown}' holds a byte that is not text: write it in UTF-8 and without NUL.")


def _surrogates(text: str) -> bool:
    """Tell whether a text holds bytes that the terminal could not decode."""
    return any("\ud800" <= letter <= "\udfff" for letter in text)


def apply(connection: sa.Connection, store: Store, entry: Entry, prepared: object = None) -> None:
    """Let one entry take effect while a person speaks."""
    apply_entry(ApplyContext(connection, store), entry, prepared)


def apply_again(
    connection: sa.Connection,
    store: Store,
    entries: Iterable[Entry],
    prepared: Callable[[Entry], object] = lambda _entry: None,
    lost: frozenset[str] = frozenset(),
) -> list[Entry]:
    """Let commands of the journal file take effect and stand in the journal table, as they did the first time.

    A command's entries stand there when all have taken effect, as when it was first made. Those that were merged from
    another book come last, and each stands there for the next, as in that book. `prepared` gives work that was done for
    an entry already; files of the SHA-256 in `lost` are not read. Returns the entries that speak of a charge or a link
    which is not there now.
    """
    without_rows: list[Entry] = []
    context = ApplyContext(connection, store, without_rows, lost)
    with wrong_kinds_refused():
        for command in journal.commands(entries):
            own = [entry for entry in command if entry.origin is None]
            for entry in own:
                apply_entry(context, entry, prepared(entry))
            journal.insert(connection, own)
            _take_effect(context, command, prepared)
    return without_rows


def _take_effect(
    context: ApplyContext, command: Iterable[Entry], prepared: Callable[[Entry], object] = lambda _entry: None
) -> None:
    """Let the merged entries of a command take effect, one after the other."""
    for entry in command:
        if entry.origin is not None:
            apply_entry(context, entry, prepared(entry))
            journal.insert(context.connection, [entry])


@contextlib.contextmanager
def write_session_of(engine: sa.Engine, store: Store, mirror: JournalFile, person: str) -> Iterator[WriteSession]:
    """Open a session: catch up with the journal file, let statements be made, write and sync the journal, commit.

    Whatever a statement is checked against has to be looked up in the session, or again there.
    """
    written = False
    try:
        apply_waiting(engine, store, mirror)
        with writing(engine) as connection:
            catch_up(connection, store, mirror)  # with what came in between
            for damage in (mirror.damage(), journal.damage_at_end(connection)):
                if damage is not None:
                    _LOG.warning("warning: %s What is stated now is added all the same.", damage)
            session = WriteSession(connection, store, person)
            yield session
            if session.entries or session.merged:
                _warn_of_clock(connection, session.entries)
                entries = journal.chain_entries([*session.entries, *session.merged], journal.head(connection))
                journal.insert(connection, entries[: len(session.entries)])
                _take_effect(ApplyContext(connection, store), entries)
                mirror.append(entries)
                written = True
    except BookError as error:
        if not written:
            raise
        # the database may or may not have committed; the file is never taken back, for it must not be behind
        raise type(error)(
            f"{error} What was said stands in journal.jsonl already: do not say it again, the next command applies it."
        ) from error


def apply_waiting(engine: sa.Engine, store: Store, mirror: JournalFile) -> None:
    """Catch up with the journal file in a transaction of its own: a command that is refused next does not undo it."""
    last = mirror.last()
    with reading(engine) as connection:
        behind = last is not None and last.seq > journal.head(connection)[0]
    if behind:
        with writing(engine) as connection:
            catch_up(connection, store, mirror)


_CLOCKS_DIFFER_S = 60.0
"""Clocks of machines that share a book differ by less."""


def _warn_of_clock(connection: sa.Connection, entries: list[Entry]) -> None:
    """Say where the clock stands before the last time that something was stated here."""
    last = last_stated_utc(connection)
    if last is None or not entries:
        return
    first, back_s = entries[0].at_utc, 0.0
    with contextlib.suppress(ValueError, TypeError):  # the time was altered, which `labbook db check` tells
        back_s = (datetime.fromisoformat(last) - datetime.fromisoformat(first)).total_seconds()
    if back_s > _CLOCKS_DIFFER_S:
        _LOG.warning(
            "warning: this machine's clock says %s, and the last statement is of %s: one of the two clocks is wrong. "
            "What is stated now gets the time of this one; set it if it is wrong.",
            first,
            last,
        )


def catch_up(connection: sa.Connection, store: Store, mirror: JournalFile) -> int:
    """Apply commands that reached the file but not the database before a crash; returns how many entries.

    Raises `BookDamaged` when file and database tell different stories.
    """
    seq, last_hash = journal.head(connection)
    last = mirror.last()
    if last is None or last.seq < seq:
        if seq == 0:
            return 0
        raise BookDamaged(
            f"journal.jsonl ends at entry {last.seq if last else 0}, the database at {seq}: restore the file from a "
            "backup, or write it anew from the database with `labbook rebuild --journal`."
        )
    if last.seq == seq:
        if last.hash != last_hash:
            raise BookDamaged(
                f"entry {seq} of journal.jsonl is not entry {seq} of the database: the two belong to different books; "
                "put the right files together."
            )
        return 0
    missing = mirror.tail(seq)
    if missing[0].prev_hash != last_hash:
        raise BookDamaged(
            f"entry {missing[0].seq} of journal.jsonl does not follow entry {seq} of the database: the two belong to "
            "different books; put the right files together."
        )
    sync(mirror.path)  # who wrote them may have been killed before that
    try:
        apply_again(connection, store, checked(journal.verified_chain(missing, (seq, last_hash)), mirror.remedy))
    except (InputRefused, UsageError) as error:
        raise BookDamaged(
            f"entry {missing[0].seq} of journal.jsonl, which the database lacks, cannot take effect there ({error}): "
            "run `labbook rebuild` to make the database anew from journal.jsonl."
        ) from error
    return len(missing)


def now_utc() -> str:
    """Return the time as ISO-8601 in UTC, to the millisecond."""
    return datetime.now(UTC).isoformat(timespec="milliseconds").replace("+00:00", "Z")


def new_uid() -> str:
    """Return a random name of 12 hexadecimal digits."""
    return secrets.token_hex(6)
