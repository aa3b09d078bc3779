"""The journal played back into an empty database: for a rebuild, or beside a book to see what should stand in it."""

from __future__ import annotations

import contextlib
import itertools
import tempfile
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import sqlalchemy as sa

from data_schema import journal
from data_schema.engine import sqlite_engine, writing
from data_schema.errors import BookDamaged, InputRefused, UsageError
from data_schema.journal import Entry
from data_schema.journal_file import NOTHING, JournalFile, LeftOut
from ingest.store import Store
from labbook.book.making import fill_sqlite
from labbook.book.opening import DATABASE
from labbook.book.reading_ahead import reading_ahead
from labbook.book.write_session import apply_again
from labbook.statements.reading_cache import forget_unused

_ENTRIES_AT_ONCE = 500
"""Commands of so many entries are one transaction: committing and hashing rows for each takes a third of its time."""


@dataclass
class Replay:
    """The journal file played back into empty tables, as far as it goes at the moment.

    With `use_cache` files are read only where the cache of readings has them not; where the replay `needs_samples`,
    also those whose samples are not in the store.
    """

    store: Store
    mirror: JournalFile
    step: Callable[[str], None]
    use_cache: bool = True
    needs_samples: bool = True
    hashes: list[str] = field(default_factory=list)
    """Of the entries that were applied, in their order."""
    without_rows: list[Entry] = field(default_factory=list)
    left_out: LeftOut = NOTHING

    def apply_to(self, engine: sa.Engine, until: int | None = None) -> None:
        """Apply what the journal holds beyond what was applied before, many commands in one transaction.

        Nothing after entry number `until`, where that is given.
        """
        last = self.mirror.last()
        seq, last_hash = self.reached
        if last is None or seq >= (last.seq if until is None else min(last.seq, until)):
            return
        total = last.seq if until is None else min(last.seq, until)
        entries = journal.verified_chain(self.mirror.tail(seq), (seq, last_hash)) if seq else self.mirror.entries()
        new = itertools.takewhile(lambda entry: entry.seq <= total, entries)
        forget_unused()
        with reading_ahead(self.store, use_cache=self.use_cache, needs_samples=self.needs_samples) as ahead:
            for some in _batched(journal.commands(ahead.pass_on(new))):
                with writing(engine) as connection:
                    for command in some:
                        self.without_rows += self._applied(connection, command, ahead.take)
                        self.step(f"{command[-1].seq}/{total} {command[-1].action} {command[-1].entity_kind}")
                self.hashes += [entry.hash for command in some for entry in command]

    def _applied(
        self, connection: sa.Connection, command: list[Entry], prepared: Callable[[Entry], object]
    ) -> list[Entry]:
        try:
            return apply_again(connection, self.store, command, prepared)
        except (InputRefused, UsageError) as error:
            raise BookDamaged(
                f"entry {command[0].seq} of {self.mirror.path} cannot take effect ({error}): the journal is not as "
                "labbook wrote it, restore it from a backup."
            ) from error

    @property
    def reached(self) -> tuple[int, str]:
        """Number and hash of the last entry that was applied."""
        return (len(self.hashes), self.hashes[-1]) if self.hashes else (0, journal.GENESIS)

    def finish(self, engine: sa.Engine, standing: tuple[int, str] | None) -> None:
        """Apply the last entries while nobody can write; `standing` is how far the old database goes, if known."""
        self.apply_to(engine)
        self.left_out = self.mirror.left_out()
        if standing is None or standing[0] == 0:
            return
        seq, last_hash = standing
        if seq > len(self.hashes):
            raise BookDamaged(
                f"{self.mirror.path} ends at entry {len(self.hashes)}, the database at {seq}: write the file anew "
                "from the database with `labbook rebuild --journal`, or restore it from a backup; nothing was changed."
            )
        if self.hashes[seq - 1] != last_hash:
            raise BookDamaged(
                f"entry {seq} of {self.mirror.path} is not entry {seq} of the database: the two belong to different "
                "books; put the right ones together; nothing was changed."
            )


def _batched(commands: Iterable[list[Entry]]) -> Iterator[list[list[Entry]]]:
    """Gather commands until they have enough entries."""
    some: list[list[Entry]] = []
    for command in commands:
        some.append(command)
        if sum(map(len, some)) >= _ENTRIES_AT_ONCE:
            yield some
            some = []
    if some:
        yield some


@contextlib.contextmanager
def replayed(
    store: Store, mirror: JournalFile, until: int, step: Callable[[str], None], *, use_cache: bool
) -> Iterator[tuple[sa.Engine, Replay]]:
    """Make the database that raw copies and the first `until` entries of the journal give, for as long as it is used.

    It lies in a temporary folder of the system, with the samples of what was read. Of the book, only raw copies and
    journal are read; with `use_cache`, no raw copies but of files that the cache of readings has not.
    """
    with tempfile.TemporaryDirectory(prefix="labbook-replay-") as name:
        folder = Path(name)
        (folder / "raw").symlink_to((store.root / "raw").resolve())
        fill_sqlite(folder / DATABASE)
        engine = sqlite_engine(folder / DATABASE, scratch=True)
        try:
            replay = Replay(Store(folder), mirror, step, use_cache=use_cache, needs_samples=False)
            replay.apply_to(engine, until)
            yield engine, replay
        finally:
            engine.dispose()
