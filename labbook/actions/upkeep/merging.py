"""`labbook merge`: the entries that only another book of the same study has are added to this one, all or none.

The other book is only read. Its entries after the common beginning come in as one command, each with its own time and
person and with its number and hash there as origin; no entry of this book changes. First they are applied on trial and
rolled back, to find what this book has already and what contradicts it.
"""

from __future__ import annotations

import contextlib
import tempfile
import tomllib
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, TypeVar

import sqlalchemy as sa

from data_schema import journal
from data_schema.errors import BookError, InputRefused, UnknownName, UsageError
from data_schema.journal import GENESIS, Entry
from data_schema.queries.charges import charges_by_run
from data_schema.queries.facts import read_fact
from data_schema.queries.imported_files import logs_by_run
from data_schema.queries.study import config_in_force
from data_schema.vocabulary import Action
from ingest.store import Store, raw_path
from labbook.actions.upkeep.merge_agreement import second_charges, second_logs, verdicts_that_differ
from labbook.actions.upkeep.merge_rules import (
    CHANGES,
    IN_USE,
    USING,
    AlreadyHere,
    Conflict,
    TargetBook,
    compare_entry,
    how_read,
)
from labbook.book.copies.backing_up import MARKER as OF_BACKUP
from labbook.book.copies.copying import refuse_cut_journal
from labbook.book.opening import CONFIGURATION, Book, open_book
from labbook.book.write_session import DryRun, Statement, WriteSession, apply, new_uid
from labbook.statements.apply_context import derived_uid

_T = TypeVar("_T")


@dataclass(frozen=True, slots=True)
class Merged:
    """What came of a merge: entries by what they are, how many this book had already, what stands in the way."""

    other: str
    common: int
    entries: Mapping[str, int] = field(default_factory=dict)
    there_already: int = 0
    raw_copies: int = 0
    conflicts: tuple[str, ...] = ()


def merge(book: Book, folder: Path, person: str | None, *, dry_run: bool = False) -> Merged:
    """Bring in the new entries of the book in a folder; raises `InputRefused` with all contradictions at once.

    A dry run returns them, and writes nothing.
    """
    with contextlib.suppress(DryRun), _opened(book, folder) as other:
        with _errors_named_after(folder):
            with other.reading() as there:
                known = journal.head(there)  # before the file is read, which is never behind
            theirs = list(other.mirror.entries())
            refuse_cut_journal(
                theirs,
                known,
                f"{other.mirror.path} has no such entry {known[0]} as the database: write the file anew from the "
                "database with `labbook rebuild --journal` there, and merge then.",
            )
        with other.reading() as there, book.session(person) as session:
            run = _Merging(book, other, session, there, theirs).run(dry_run=dry_run)
            if dry_run:
                raise DryRun
    return run


@contextlib.contextmanager
def _opened(book: Book, folder: Path) -> Iterator[Book]:
    if (folder / OF_BACKUP).is_file():
        raise UsageError(
            f"{folder} is a backup: make a book of it with `labbook restore {folder} DIR`, and merge that."
        )
    if folder.resolve() == book.folder.resolve():
        raise UsageError(f"{folder} is the book that the other one is to be merged into: name the other one.")
    with _errors_named_after(folder):
        other = open_book(folder)
    try:
        yield other
    finally:
        other.close()


@contextlib.contextmanager
def _errors_named_after(folder: Path) -> Iterator[None]:
    """Name the other book's folder in errors that come from it."""
    try:
        yield
    except BookError as error:
        raise type(error)(f"in {folder}: {error}") from error


@dataclass
class _Merging:
    """One merge: two books, the journal of the other, and which of its uids are others here."""

    book: Book
    other: Book
    session: WriteSession
    there: sa.Connection
    theirs: Sequence[Entry]
    uids: dict[str, str] = field(default_factory=dict)
    taken: list[Entry] = field(default_factory=list)
    had: int = 0
    conflicts: list[str] = field(default_factory=list)

    def run(self, *, dry_run: bool) -> Merged:
        """Apply the entries on trial; then, unless it is a dry run, state them."""
        ours = list(journal.stored(self.session.connection))
        common = _common(ours, self.theirs)
        self._refuse_other_configuration()
        known_till = self._merged_before(ours, common)
        known = {_original_hash(entry) for entry in ours} | {entry.hash for entry in ours}
        fresh = [
            entry
            for entry in self.theirs[known_till:]
            if _original_hash(entry) not in known and entry.action is not Action.MERGE
        ]
        self._try(fresh, TargetBook(self.session.connection, ours, _unknown_there(ours, self.theirs, common)))
        copies = [sha256 for sha256 in _read_from(self.taken) if not (self.book.store.root / raw_path(sha256)).exists()]
        if not dry_run and self.conflicts:
            several = f"{len(self.conflicts)} things stand" if len(self.conflicts) > 1 else "1 thing stands"
            listed = "".join(f"\n  {sentence}" for sentence in self.conflicts)
            raise InputRefused(f"{several} in the way of the merge, and nothing was written:{listed}")
        if not dry_run and self.taken:
            for sha256 in copies:
                path = raw_path(sha256)
                self.book.store.put_raw(self.other.store.raw(path, sha256), sha256)
            self._state()
        return Merged(
            str(self.other.folder),
            common,
            dict(Counter(_WORDS.get(entry.action, entry.entity_kind) for entry in self.taken)),
            self.had,
            len(copies),
            tuple(self.conflicts),
        )

    def _refuse_other_configuration(self) -> None:
        """Raise `InputRefused` unless both books stand under the same labbook.toml, but for where they lie."""
        in_force = config_in_force(self.session.connection)
        texts = [(entry.new or {})["text"] for entry in self.theirs if entry.entity_kind == "config"]
        if in_force is None or not texts:
            raise InputRefused(f"{self.other.folder} describes no study yet: there is nothing to merge.")
        now = (self.other.folder / CONFIGURATION).read_text(encoding="utf-8")
        here, there = _described(in_force.text), _described(now)
        names = [tables.get("study", {}).get("name") for tables in (here, there)]
        if names[0] != names[1]:
            raise InputRefused(
                f"{self.other.folder} is the book of study {names[1]!r}, this is the one of {names[0]!r}: only books "
                "of one study can be merged."
            )
        differing = sorted(name for name in here.keys() | there.keys() if here.get(name) != there.get(name))
        if differing:
            tables = ", ".join(f"[{name}]" for name in differing)
            raise InputRefused(
                f"labbook.toml of {self.other.folder} says otherwise than this book's under {tables}: write the same "
                "in both, have each book take it over with any command that writes (`labbook check`, `labbook note`), "
                "and merge again."
            )
        if _described(texts[-1]) != there:
            raise InputRefused(
                f"labbook.toml of {self.other.folder} was changed since that book was last written to: have it take "
                "the change over with any command that writes there (`labbook check`, `labbook note`), and merge again."
            )

    def _merged_before(self, ours: Sequence[Entry], common: int) -> int:
        """Return how many entries of the other book came in before; the uids they have here are known again."""
        known_till = common
        for entry in ours:
            if until := _merged_until(entry, self.theirs):
                known_till = max(known_till, until)
                self.uids |= (entry.new or {})["uids"]
        return known_till

    def _try(self, fresh: Sequence[Entry], here: TargetBook) -> None:
        """Apply entries to this book, and take all of it back."""
        connection = self.session.connection
        charges, logs = charges_by_run(connection), logs_by_run(connection)
        number = journal.head(connection)[0] + len(self.session.entries)
        verdicts, ends = [], _final_states(fresh)
        here.ends.update({uid: end for uid, end in ends.items() if isinstance(end, str)})
        with self._scratch(fresh) as store:
            trial = connection.begin_nested()
            for entry in fresh:
                ours = self._with_our_uids(entry)
                here.ends[ours.entity_uid] = _substituted(ends.get(entry.entity_uid, {}), self.uids)
                found = compare_entry(here, ours)
                if found is not None:
                    self._skip(entry, found)
                    continue
                self.taken.append(ours)
                verdicts += [ours] if ours.action is Action.DECIDE else []
                self._apply(store, replace(ours, seq=number + len(self.taken), following=0, prev_hash=GENESIS), here)
            self.conflicts += verdicts_that_differ(connection, here.news, verdicts)
            there = self._of_our_runs(charges_by_run(self.there))
            self.conflicts += second_charges(connection, charges, there, charges_by_run(connection))
            self.conflicts += second_logs(
                connection, logs, self._of_our_runs(logs_by_run(self.there)), logs_by_run(connection)
            )
            trial.rollback()

    def _of_our_runs(self, by_run: Mapping[str, _T]) -> dict[str, _T]:
        return {self.uids.get(uid, uid): found for uid, found in by_run.items()}

    def _apply(self, store: Store, entry: Entry, here: TargetBook) -> None:
        """Let one entry take effect on trial, and stand in the journal for the next."""
        connection = self.session.connection
        try:
            with connection.begin_nested():
                apply(connection, store, entry)
                journal.insert(connection, [entry])
            here.record(entry)
        except (InputRefused, UsageError) as error:
            seq = (entry.origin or {})["seq"]
            self.conflicts.append(
                f"entry {seq} there ({entry.action} {entry.entity_kind}, {entry.person}, {entry.at_utc[:10]}) has no "
                f"place here ({error}): settle in one of the books what it is about."
            )

    def _skip(self, entry: Entry, found: AlreadyHere | Conflict) -> None:
        """Note an entry that is not taken over: later ones refer to this book's thing; a conflict is listed."""
        if isinstance(found, Conflict):
            self.conflicts += [found.sentence] if found.sentence not in self.conflicts else []
        else:
            self.had += 1
        if found.uid is None or found.uid == entry.entity_uid:
            return
        self.uids[entry.entity_uid] = found.uid
        if entry.entity_kind == "plan":
            for place in range(1, len((entry.new or {})["runs"]) + 1):
                planned = [derived_uid("planned_run", uid, place) for uid in (entry.entity_uid, found.uid)]
                self.uids[planned[0]] = planned[1]

    def _with_our_uids(self, entry: Entry) -> Entry:
        """Return an entry of the other book with the uids that its things have here, and where it comes from."""
        if entry.entity_kind == "run_file":
            self._find_link(entry.entity_uid)
        return replace(
            entry,
            entity_uid=self.uids.get(entry.entity_uid, entry.entity_uid),
            old=_substituted(entry.old, self.uids),
            new=_substituted(entry.new, self.uids),
            origin=entry.origin or {"seq": entry.seq, "hash": entry.hash},
            schema=None,
        )

    def _find_link(self, uid: str) -> None:
        """A link's uid is made from those of its run and file: where the run's is another here, so is the link's."""
        try:
            link = read_fact(self.there, "run_file", uid, ["file", "part"])
        except UnknownName:  # the file was taken off the run since
            return
        for there, here in list(self.uids.items()):
            if derived_uid("run_file", there, link["file"], link["part"]) == uid:
                self.uids[uid] = derived_uid("run_file", here, link["file"], link["part"])

    @contextlib.contextmanager
    def _scratch(self, fresh: Sequence[Entry]) -> Iterator[Store]:
        """Make a store that nothing else reads, with the raw copies of both books that entries speak of."""
        with tempfile.TemporaryDirectory(prefix="labbook-merge-") as name:
            for sha256 in _read_from(fresh):
                path = raw_path(sha256)
                copy = self.book.store.root / path
                if not copy.exists():
                    copy = self.other.store.root / path
                    with _errors_named_after(self.other.folder):
                        self.other.store.raw(path, sha256)
                link = Path(name) / path
                link.parent.mkdir(parents=True, exist_ok=True)
                link.symlink_to(copy.resolve())
            yield Store(Path(name))

    def _state(self) -> None:
        """State that this book has the other one until its last entry, and add what is new."""
        last = self.theirs[-1]
        new = {
            "other": self.other.folder.resolve().name,
            "until": {"seq": last.seq, "hash": last.hash},
            "uids": self.uids,
        }
        self.session.state(Statement(Action.MERGE, "book", new_uid(), new=new))
        self.session.merge(self.taken)


def _common(ours: Sequence[Entry], theirs: Sequence[Entry]) -> int:
    """Return how many entries two journals begin with in common; as each holds the hash before it, all or none fit."""
    pairs = zip(ours, theirs, strict=False)
    return next((place for place, (one, two) in enumerate(pairs) if one.hash != two.hash), min(len(ours), len(theirs)))


def _unknown_there(ours: Sequence[Entry], theirs: Sequence[Entry], common: int) -> list[Entry]:
    """Return the entries of this book that the other one does not have."""
    common = max([common, *(_merged_until(entry, ours) for entry in theirs)])
    known = {_original_hash(entry) for entry in theirs}
    return [entry for entry in ours[common:] if _original_hash(entry) not in known]


def _merged_until(entry: Entry, other: Sequence[Entry]) -> int:
    """Return up to which entry of the other journal a merge took it over; 0 where an entry is no merge with it."""
    until = (entry.new or {})["until"] if entry.action is Action.MERGE else None
    if not until or until["seq"] > len(other) or other[until["seq"] - 1].hash != until["hash"]:
        return 0
    return int(until["seq"])


def _original_hash(entry: Entry) -> str:
    """Return the hash of an entry in the book where it was first made."""
    return entry.hash if entry.origin is None else str(entry.origin["hash"])


def _read_from(entries: Sequence[Entry]) -> list[str]:
    """Return the SHA-256 of the files that entries are read from."""
    reading = (Action.INGEST, Action.READ)
    return list(dict.fromkeys((entry.new or {})["sha256"] for entry in entries if entry.action in reading))


def _final_states(entries: Sequence[Entry]) -> dict[str, Any]:
    """Return what columns of things, by uid, and readings of files, by SHA-256, come to."""
    found: dict[str, Any] = {}
    for entry in entries:
        if entry.action is Action.READ:
            found[(entry.new or {})["sha256"]] = how_read(entry)
        elif entry.action in CHANGES:
            end = found.setdefault(entry.entity_uid, {})
            end.update(entry.new or {})
            if entry.action in USING:
                end[IN_USE] = entry.action is Action.RESTORE
    return found


def _substituted(value: Any, uids: Mapping[str, str]) -> Any:
    if isinstance(value, str):
        return uids.get(value, value)
    if isinstance(value, Mapping):
        return {name: _substituted(item, uids) for name, item in value.items()}
    return [_substituted(item, uids) for item in value] if isinstance(value, list | tuple) else value


def _described(text: str) -> dict[str, Any]:
    """Return the tables of labbook.toml, but for those on where the book's database and files lie."""
    return {name: table for name, table in tomllib.loads(text).items() if name not in ("database", "store")}


_WORDS: Mapping[Action, str] = {
    Action.INGEST: "file",
    Action.READ: "file read again",
    Action.REFUSE: "refused file",
    Action.CORRECT: "correction",
    Action.VOID: "void run or plan",
    Action.ASSIGN: "assignment",
    Action.DECIDE: "verdict",
    Action.REPORT: "report",
    Action.WITHDRAW: "file withdrawn",
    Action.RESTORE: "file or charge restored",
    Action.DISMISS: "charge dismissed",
}
"""The words for entries that do not declare a thing of a kind."""
