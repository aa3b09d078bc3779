"""`labbook merge`: the entries that only another book of the same study has are added to this one, all or none.

The other book is only read. Its entries after the common beginning come in as one command, each with its own time and
person and with its number and hash there as origin; no entry of this book changes. First they are applied on trial and
rolled back, to find what this book has already and what contradicts it.

An entry of the other book is new, here already, or contradicts what is here; after all are in, the two must agree on
verdicts, and on the logs and charge of a run.

Things that two books name alike are one thing: a run by its name, a level by its label, a file by its bytes. Statements
about them in both books must agree; those in one book only are taken over.
"""

from __future__ import annotations

import contextlib
import tempfile
import tomllib
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, TypeVar

import sqlalchemy as sa

from data_schema import journal
from data_schema.errors import BookError, InputRefused, UnknownName, UsageError
from data_schema.grouping import grouped
from data_schema.journal import GENESIS, Entry, canonical
from data_schema.journal_rules import checked, wrong_kinds_refused
from data_schema.queries.charges import charges_by_run, charges_of_run, waiting_charges
from data_schema.queries.facts import find_uid, read_fact
from data_schema.queries.files import Link, find_files, links_of_file, logs_by_run, refused_with
from data_schema.queries.study import config_in_force, planned_runs
from data_schema.vocabulary import USING, Action, ChargeMode, ChargeState, IngestStatus
from ingest.store import Store, raw_path
from labbook.book.copies.backing_up import MARKER as OF_BACKUP
from labbook.book.copies.copying import refuse_cut_journal
from labbook.book.naming import words_of
from labbook.book.opening import CONFIGURATION, Book, open_book
from labbook.book.write_session import DryRun, Statement, WriteSession, apply, new_uid
from labbook.statements.apply_context import derived_uid
from labbook.statements.counted_charges import same_value
from labbook.statements.importing import without_name

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
    if (folder / OF_BACKUP).is_file():
        raise UsageError(
            f"{folder} is a backup: make a book of it with `labbook restore {folder} DIR`, and merge that."
        )
    if folder.resolve() == book.folder.resolve():
        raise UsageError(f"{folder} is the book that the other one is to be merged into: name the other one.")
    with _errors_named_after(folder):
        other = open_book(folder)
    with contextlib.suppress(DryRun), contextlib.closing(other):
        with _errors_named_after(folder):
            with other.reading() as there:
                known = journal.head(there)  # before the file is read, which is never behind
            theirs = list(checked(other.mirror.entries()))
            refuse_cut_journal(
                theirs,
                known,
                f"{other.mirror.path} has no such entry {known[0]} as the database: write the file anew from the "
                "database with `labbook rebuild --journal` there, and merge then.",
            )
        with other.reading() as there, book.session(person) as session:
            done = _Merging(book, other, session, there, theirs).run(dry_run=dry_run)
            if dry_run:
                raise DryRun
    return done


@contextlib.contextmanager
def _errors_named_after(folder: Path) -> Iterator[None]:
    """Name the other book's folder in errors that come from it."""
    try:
        yield
    except BookError as error:
        raise type(error)(f"in {folder}: {error}") from error


@dataclass(frozen=True, slots=True)
class _AlreadyHere:
    """This book has what an entry says, under a uid of its own where it is a thing."""

    uid: str | None = None


@dataclass(frozen=True, slots=True)
class _Conflict:
    """The two books contradict each other; `uid` is that of the thing here that the other has too."""

    sentence: str
    uid: str | None = None


IN_USE = "in use"
"""Stands beside the columns of a run, plan, file or charge that was excluded or included."""
_USED = {True: "in use", False: "out of use"}

_NATURAL: Mapping[str, tuple[str, ...]] = {
    "person": ("name",),
    "study": ("name",),
    "factor": ("study", "name"),
    "level": ("factor", "label"),
    "condition": ("study", "key"),
    "day": ("study", "date_local"),
    "robot": ("name", "valid_from_utc"),
    "battery": ("name",),
    "instrument": ("name",),
    "run": ("study", "name"),
}
"""By which columns two books call the same thing by the same name."""


class _Merging:
    """One merge: two books, the journal of the other, and which of its uids are others here.

    `news` are this book's entries that the other does not know, `changes` and `remarks` those on a thing and in words;
    `readings` are its entries on each file, by SHA-256, and grow with those that come in; `ends` is what columns of
    things and readings of files come to at the end of the other book, by uid or SHA-256: where this book has the same
    end, the steps on the way need not agree.
    """

    def __init__(
        self, book: Book, other: Book, session: WriteSession, there: sa.Connection, theirs: Sequence[Entry]
    ) -> None:
        self.book, self.other, self.session, self.there, self.theirs = book, other, session, there, theirs
        self.connection = session.connection
        self.ours = list(journal.stored(self.connection))
        self.uids: dict[str, str] = {}
        self.taken: list[Entry] = []
        self.conflicts: dict[str, None] = {}
        self.ends: dict[str, Any] = {}
        self.had = 0
        self.common = _common(self.ours, theirs)
        known_there = max([self.common, *(_merged_until(entry, self.ours) for entry in theirs)])
        known = set(map(_original_hash, theirs))
        self.news = [entry for entry in self.ours[known_there:] if _original_hash(entry) not in known]
        changing = [entry for entry in self.news if not entry.makes]
        self.changes = grouped(changing, [entry.entity_uid for entry in changing])
        said = (entry for entry in self.news if entry.action in (Action.SET, Action.NOTE))
        self.remarks = {_remark(entry): entry.entity_uid for entry in said}
        reading = [entry for entry in self.ours if entry.reads]
        self.readings = grouped(reading, [_new(entry)["sha256"] for entry in reading])
        self.declared = {entry.entity_uid: entry for entry in reversed(self.ours)}

    def run(self, *, dry_run: bool) -> Merged:
        """Apply the entries on trial; then, unless it is a dry run, state them."""
        self._refuse_other_configuration()
        known_till = self.common
        for entry in self.ours:  # what came in before, and the uids that it has here
            if until := _merged_until(entry, self.theirs):
                known_till = max(known_till, until)
                self.uids |= _new(entry)["uids"]
        known = {_original_hash(entry) for entry in self.ours} | {entry.hash for entry in self.ours}
        self._try(
            [
                entry
                for entry in self.theirs[known_till:]
                if _original_hash(entry) not in known and entry.action is not Action.MERGE
            ]
        )
        store = self.book.store
        copies = [sha256 for sha256 in _read_from(self.taken) if not (store.root / raw_path(sha256)).exists()]
        if not dry_run and self.conflicts:
            several = f"{len(self.conflicts)} things stand" if len(self.conflicts) > 1 else "1 thing stands"
            listed = "".join(f"\n  {sentence}" for sentence in self.conflicts)
            raise InputRefused(f"{several} in the way of the merge, and nothing was written:{listed}")
        if not dry_run and self.taken:
            for sha256 in copies:
                store.put_raw(self.other.store.raw(raw_path(sha256), sha256), sha256)
            last, name = self.theirs[-1], self.other.folder.resolve().name
            new = {"other": name, "until": {"seq": last.seq, "hash": last.hash}, "uids": self.uids}
            self.session.state(Statement(Action.MERGE, "book", new_uid(), new=new))
            self.session.merge(self.taken)
        return Merged(
            str(self.other.folder),
            self.common,
            dict(Counter(words_of(entry).listed or entry.entity_kind for entry in self.taken)),
            self.had,
            len(copies),
            tuple(self.conflicts),
        )

    def _refuse_other_configuration(self) -> None:
        """Raise `InputRefused` unless both books stand under the same labbook.toml, but for where they lie."""
        in_force, folder = config_in_force(self.connection), self.other.folder
        texts = [_new(entry)["text"] for entry in self.theirs if entry.entity_kind == "config"]
        if in_force is None or not texts:
            raise InputRefused(f"{folder} describes no study yet: there is nothing to merge.")
        here, there = _described(in_force.text), _described((folder / CONFIGURATION).read_text(encoding="utf-8"))
        names = [tables.get("study", {}).get("name") for tables in (here, there)]
        if names[0] != names[1]:
            raise InputRefused(
                f"{folder} is the book of study {names[1]!r}, this is the one of {names[0]!r}: only books of one study "
                "can be merged."
            )
        differing = sorted(name for name in here.keys() | there.keys() if here.get(name) != there.get(name))
        if differing:
            tables = ", ".join(f"[{name}]" for name in differing)
            raise InputRefused(
                f"labbook.toml of {folder} says otherwise than this book's under {tables}: write the same in both, "
                "have each book take it over with any command that writes (`labbook check`, `labbook note`), and merge "
                "again."
            )
        if _described(texts[-1]) != there:
            raise InputRefused(
                f"labbook.toml of {folder} was changed since that book was last written to: have it take the change "
                "over with any command that writes there (`labbook check`, `labbook note`), and merge again."
            )

    def _try(self, fresh: Sequence[Entry]) -> None:
        """Apply entries to this book, and take all of it back."""
        connection = self.connection
        charges, logs = charges_by_run(connection), logs_by_run(connection)
        number = journal.head(connection)[0] + len(self.session.entries)
        ends = _final_states(fresh)
        self.ends.update({uid: end for uid, end in ends.items() if isinstance(end, str)})
        with self._scratch(fresh) as store:
            trial = connection.begin_nested()
            for entry in fresh:
                ours = self._with_our_uids(entry)
                self.ends[ours.entity_uid] = _substituted(ends.get(entry.entity_uid, {}), self.uids)
                found = _RULES.get(ours.entity_kind, _Merging._set)(self, ours)
                if found is not None:
                    self._skip(entry, found)
                    continue
                self.taken.append(ours)
                self._apply(store, replace(ours, seq=number + len(self.taken), following=0, prev_hash=GENESIS))
            found_last = [
                *self._verdicts_that_differ(),
                *self._second_charges(charges, self._of_our_runs(charges_by_run(self.there))),
                *self._second_logs(logs, self._of_our_runs(logs_by_run(self.there))),
            ]
            self.conflicts |= dict.fromkeys(found_last)
            trial.rollback()

    def _of_our_runs(self, by_run: Mapping[str, _T]) -> dict[str, _T]:
        return {self.uids.get(uid, uid): found for uid, found in by_run.items()}

    def _apply(self, store: Store, entry: Entry) -> None:
        """Let one entry take effect on trial, and stand in the journal for the next."""
        try:
            with self.connection.begin_nested(), wrong_kinds_refused():
                apply(self.connection, store, entry)
                journal.insert(self.connection, [entry])
            if entry.reads:
                self.readings.setdefault(_new(entry)["sha256"], []).append(entry)
        except (InputRefused, UsageError) as error:
            seq = (entry.origin or {})["seq"]
            sentence = (
                f"entry {seq} there ({words_of(entry).did} {entry.entity_kind}, {entry.person}, {entry.at_utc[:10]}) "
                f"has no place here ({error}): settle in one of the books what it is about."
            )
            self.conflicts[sentence] = None

    def _skip(self, entry: Entry, found: _AlreadyHere | _Conflict) -> None:
        """Note an entry that is not taken over: later ones refer to this book's thing; a conflict is listed."""
        if isinstance(found, _Conflict):
            self.conflicts[found.sentence] = None
        else:
            self.had += 1
        if found.uid is None or found.uid == entry.entity_uid:
            return
        self.uids[entry.entity_uid] = found.uid
        if entry.entity_kind == "plan":
            for place in range(1, len(_new(entry)["runs"]) + 1):
                planned = [derived_uid("planned_run", uid, place) for uid in (entry.entity_uid, found.uid)]
                self.uids[planned[0]] = planned[1]

    def _with_our_uids(self, entry: Entry) -> Entry:
        """Return an entry of the other book with the uids that its things have here, and where it comes from."""
        uid = entry.entity_uid
        if entry.entity_kind == "run_file":
            # made from the uids of its run and file: where the run's is another here, so is the link's
            with contextlib.suppress(UnknownName):  # the file was taken off the run since
                link = read_fact(self.there, "run_file", uid, ["file", "part"])
                for there, here in list(self.uids.items()):
                    if derived_uid("run_file", there, link["file"], link["part"]) == uid:
                        self.uids[uid] = derived_uid("run_file", here, link["file"], link["part"])
        return replace(
            entry,
            entity_uid=self.uids.get(uid, uid),
            old=_substituted(entry.old, self.uids),
            new=_substituted(entry.new, self.uids),
            origin=entry.origin or {"seq": entry.seq, "hash": entry.hash},
            schema=None,
        )

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
            yield Store(Path(name), of_links=True)

    def _called(self, kind: str, uid: str) -> str:
        """Return the name of a thing for people: a run or a level by its name, a charge by its uid and its run."""
        try:
            found = read_fact(self.connection, kind, uid)
        except (UnknownName, KeyError):
            return f"{kind} {uid}"
        if kind == "charge":
            return f"charge:{uid}" + (f" of {self._called('run', found['run'])}" if found["run"] else "")
        name = next((found[name] for name in ("name", "label", "key", "date_local") if found.get(name)), uid)
        return f"{kind} {name}"

    def _shown(self, value: Any, column: str) -> str:
        """Return a value as people know it; of a uid the thing's name, without its kind where the column has that."""
        if isinstance(value, str):
            for kind in ("run", "condition", "day", "battery", "robot"):
                name = self._called(kind, value)
                if name != f"{kind} {value}":
                    return name.removeprefix(f"{column} ")
        return "nothing" if value is None else str(value)

    def _set(self, entry: Entry) -> _AlreadyHere | _Conflict | None:
        kind, new = entry.entity_kind, _new(entry)
        if kind == "charge" and entry.action in USING:
            return self._use(entry)
        if not entry.makes:
            return self._change(entry)
        if kind == "config":  # the two in force are the same, and a file's entry holds how it was read
            in_force = config_in_force(self.connection)
            return _AlreadyHere(None if in_force is None else in_force.uid)
        if kind == "charge":
            for row in charges_of_run(self.connection, new["run"]):
                if row.added == new.get("added", 0) and all(
                    same_value(getattr(row, name), new[name]) for name in ("charge_mah", "mode")
                ):
                    return _AlreadyHere(row.uid)
            return None
        if kind not in _NATURAL:
            return self._repeated_remark(entry)
        uid = find_uid(self.connection, kind, **{name: new[name] for name in _NATURAL[kind]})
        if uid is None:
            return None
        stands = read_fact(self.connection, kind, uid)
        differing = sorted(name for name in stands.keys() & new.keys() if stands[name] != new[name])
        if not differing or (uid in self.declared and self.declared[uid].new == new):
            return _AlreadyHere(uid)
        words = "; ".join(
            f"{name} {self._shown(stands[name], name)} here, {self._shown(new[name], name)} there" for name in differing
        )
        remedy = "correct it here to what the other book says"
        if kind == "run":
            remedy = (
                f"if they are two runs, name this book's otherwise (`labbook correct {new['name']} name=... --why "
                f"...`); if they are one, {remedy}"
            )
        return _Conflict(f"{self._called(kind, uid)} is in both books, {words}: {remedy}.", uid)

    def _plan(self, entry: Entry) -> _AlreadyHere | _Conflict | None:
        new, withdrawn = _new(entry), (Action.EXCLUDE, entry.entity_uid)
        if entry.action is Action.EXCLUDE:
            return _AlreadyHere() if any((past.action, past.entity_uid) == withdrawn for past in self.ours) else None
        for uid, declared in self.declared.items():
            if declared.entity_kind == "plan" and {**_new(declared), "created_utc": new["created_utc"]} == new:
                return _AlreadyHere(uid)
        taken = {row.name for row in planned_runs(self.connection)}
        both = [run["name"] for run in new["runs"] if run["name"] in taken]
        if not both:
            return None
        return _Conflict(
            f"runs {both[0]} to {both[-1]} are planned in both books, with seed {new['seed']} there: withdraw "
            'what is left of the plan of this book, `labbook plan --withdraw --why "..."`.'
        )

    def _repeated_remark(self, entry: Entry) -> _AlreadyHere | None:
        """Find a remark, or a check of a day, that the same person made in both books."""
        uid = self.remarks.get(_remark(entry))
        return None if uid is None else _AlreadyHere(uid)

    def _ingest(self, entry: Entry) -> _AlreadyHere | _Conflict | None:
        new, connection = _new(entry), self.connection
        if not entry.reads:
            before = refused_with(connection, new["sha256"], new["reader"], canonical(new["options"]))
            return _AlreadyHere() if without_name(new["settings"]) in map(without_name, before) else None
        if not entry.makes:
            return self._read_again(entry)
        readings = self.readings.get(new["sha256"])
        if not readings:
            return None
        name, uid = new["original_name"], readings[0].entity_uid
        if all(how_read(reading) != how_read(entry) for reading in readings):
            return _Conflict(
                f"file {name} is in both books and was read otherwise in each: have it read here as there, `labbook "
                f"files reread {name}` with what is declared about it there.",
                uid,
            )
        named = [self._named_run(reading) for reading in readings]
        run = new.get("run") or self._named_run(entry)
        links = links_of_file(connection, derived_uid("file", new["sha256"]))
        same = any(run in (_new(reading).get("run"), of) for reading, of in zip(readings, named, strict=True))
        if run and not same and all(link.run_uid != run for link in links):
            return self._other_run(name, links, run, uid)
        return _AlreadyHere(uid)

    def _named_run(self, entry: Entry) -> str | None:
        name = _new(entry).get("stated_run")
        return find_uid(self.connection, "run", name=name) if name else None

    def _read_again(self, entry: Entry) -> _AlreadyHere | _Conflict | None:
        sha256, name = _new(entry)["sha256"], _new(entry)["original_name"]
        readings = self.readings.get(sha256, [])
        if not readings:
            return _Conflict(
                f"file {name} was read again there and is not here: check the other book, `labbook db check`."
            )
        last = how_read(readings[-1])
        again_here = any(one.reads and not one.makes and _new(one)["sha256"] == sha256 for one in self.news)
        if last == how_read(entry) or (again_here and last == self.ends.get(sha256)):
            return _AlreadyHere(readings[-1].entity_uid)
        if not again_here:
            return None
        return _Conflict(
            f"file {name} was read again in both books, with other declarations in each: have it read here as "
            f"there, `labbook files reread {name}` with what is declared about it there."
        )

    def _file(self, entry: Entry) -> _AlreadyHere | _Conflict | None:
        new, old, uid = _new(entry), entry.old or {}, entry.entity_uid
        if entry.action in USING:
            return self._use(entry)
        part = new.get("part")
        links = [link for link in links_of_file(self.connection, uid) if part in (None, link.part)]
        runs = {link.run_uid for link in links}
        if (new["run"] is None and not runs) or new["run"] in runs:
            return _AlreadyHere()
        if runs <= (set() if new["run"] is not None else set(old.get("runs", ()))):
            return None
        return self._other_run(next((row.name for row in find_files(self.connection, uid)), uid), links, new["run"])

    def _other_run(self, name: str, links: Sequence[Link], run: str | None, uid: str | None = None) -> _Conflict:
        """Return the conflict of a file, linked so here, that belongs to another run there, or to none."""
        stands = ", ".join(sorted({f"run {link.run_name}" for link in links})) or "no run"
        there = "no run" if run is None else self._called("run", run)
        word = "none" if run is None else there.removeprefix("run ")
        return _Conflict(
            f"file {name} belongs to {stands} here and to {there} there: `labbook assign {name} {word} --why ...` says "
            "so here.",
            uid,
        )

    def _change(self, entry: Entry) -> _AlreadyHere | _Conflict | None:
        """Compare a row with what an entry found and with what it made of it."""
        kind, uid, new, old = entry.entity_kind, entry.entity_uid, _new(entry), entry.old or {}
        try:
            stands = read_fact(self.connection, kind, uid, list(new))
        except UnknownName:  # it may be of a file that waits for a declaration
            return None
        ends = {**new, **self.ends.get(uid, {})}
        changed = {name for statement in self.changes.get(uid, ()) for name in _new(statement)} & new.keys()
        contrary = sorted(name for name in changed if stands[name] != ends[name])
        if not contrary and all(name in changed or stands[name] == new[name] for name in new):
            return _AlreadyHere()
        if not contrary and all(name in changed or stands[name] == old.get(name) for name in new):
            return None
        words = "; ".join(
            f"{name} is {self._shown(stands[name], name)} here and became {self._shown(ends[name], name)} there"
            for name in contrary or sorted(name for name in new if stands[name] != new[name])
        )
        return _Conflict(f"{self._called(kind, uid)}: {words}: correct it here to what the other book says.")

    def _use(self, entry: Entry) -> _AlreadyHere | _Conflict | None:
        """Compare whether a file (withdrawn or restored) or a charge of the inbox (dismissed or restored) is in use."""
        kind, uid, run = entry.entity_kind, entry.entity_uid, None
        if kind == "file":
            (file,) = find_files(self.connection, uid)
            name, used = f"file {file.name}", file.status is not IngestStatus.WITHDRAWN
        else:
            try:
                charge = read_fact(self.connection, kind, uid, ["state", "run"])
            except UnknownName:  # it may be of a file that waits for a declaration
                return None
            name, used, run = f"charge:{uid}", charge["state"] != ChargeState.DISMISSED, charge["run"]
        ends = self.ends[uid][IN_USE]
        decided_here = any(statement.action in USING for statement in self.changes.get(uid, ()))
        if used == (ends if decided_here else entry.action is Action.INCLUDE):
            return _AlreadyHere()
        if not decided_here and run is None:
            return None
        stands = f"of {self._called('run', run)}" if run else _USED[used]
        return _Conflict(f"{name} is {stands} here and {_USED[ends]} there: settle it here as it is there.")

    def _second_charges(self, before: Mapping[str, Sequence[Any]], there: Mapping[str, Sequence[Any]]) -> Iterator[str]:
        """Say which runs would have a charge of each book, where neither has two; all by the uids of runs here.

        The charge of this book waits then, for the other was given to the run later.
        """
        waiting = {*waiting_charges(self.connection)}
        for uid, charges in charges_by_run(self.connection).items():
            own = before.get(uid, ())
            own_waiting = [row for row in own if row.uid in waiting]
            some = [row for row in [*own_waiting, *charges] if row.mode == ChargeMode.CHARGE]
            if len(some) > max(1, len(own), len(there.get(uid, ()))):
                of_own = {row.uid for row in own}
                words = " and ".join(
                    f"{row.charge_mah:g} mAh {'here' if row.uid in of_own else 'there'}, charge:{row.uid}"
                    for row in some
                )
                yield (
                    f"{self._called('run', uid)} has a charge in each book ({words}): take the wrong one off in its "
                    "book, `labbook correct charge:UID run=none --why ...`."
                )

    def _second_logs(self, before: Mapping[str, Sequence[Link]], there: Mapping[str, Sequence[Link]]) -> Iterator[str]:
        """Say which runs would have a log that only this book has and one that only the other has.

        Where one book took a log off and put another in its place, the run has one. All by the uids of runs here.
        """
        now = logs_by_run(self.connection)
        for uid, logs in now.items():
            here, other, both = ({log.file_uid for log in some.get(uid, ())} for some in (before, there, now))
            if both <= other or both <= here:
                continue
            names = {log.file_uid: find_files(self.connection, log.file_uid)[0].name for log in logs}
            words = " and ".join(f"{name} {'here' if file in here else 'there'}" for file, name in names.items())
            run = logs[0].run_name
            yield (
                f"run {run} has a log in each book ({words}): take the wrong one off in its book, `labbook assign FILE "
                f"none --why ...`; where both are of this run, have this book read the other too, `labbook ingest FILE "
                f"--run {run}`."
            )

    def _verdicts_that_differ(self) -> Iterator[str]:
        """Say on what the last verdicts differ that people gave in two books without knowing of each other."""
        standing = _last_verdicts(self.news)
        for place, other in _last_verdicts(self.taken).items():
            for where, own in standing.items():
                one, two = map(_verdict_text, (own, other))
                if where[:3] == place[:3] and abs(where[3] - place[3]) < SAME_JUMP_S and one != two:
                    kind, uid = place[:2]
                    what = self._called("run" if kind == "jump" else kind, uid)
                    what = f"the jump of {what} at {place[3]:.3f} s" if kind == "jump" else what
                    yield (
                        f"{what} has two verdicts: {one} here ({own.person}, {own.at_utc[:10]}), {two} there "
                        f"({other.person}, {other.at_utc[:10]}): agree, and give the same verdict in both books."
                    )


_RULES: Mapping[str, Callable[[_Merging, Entry], _AlreadyHere | _Conflict | None]] = {
    "ingest": _Merging._ingest,
    "file": _Merging._file,
    "plan": _Merging._plan,
    "note": _Merging._repeated_remark,
    **dict.fromkeys(("decision", "report"), lambda _here, _entry: None),
}
"""By kind. Verdicts and reports are only ever added; whether verdicts agree is asked when all are there."""


def _new(entry: Entry) -> Mapping[str, Any]:
    return entry.new or {}


def _common(ours: Sequence[Entry], theirs: Sequence[Entry]) -> int:
    """Return how many entries two journals begin with in common; as each holds the hash before it, all or none fit."""
    pairs = zip(ours, theirs, strict=False)
    return next((place for place, (one, two) in enumerate(pairs) if one.hash != two.hash), min(len(ours), len(theirs)))


def _merged_until(entry: Entry, other: Sequence[Entry]) -> int:
    """Return up to which entry of the other journal a merge took it over; 0 where an entry is no merge with it."""
    until = _new(entry)["until"] if entry.action is Action.MERGE else None
    if not until or until["seq"] > len(other) or other[until["seq"] - 1].hash != until["hash"]:
        return 0
    return int(until["seq"])


def _original_hash(entry: Entry) -> str:
    """Return the hash of an entry in the book where it was first made."""
    return entry.hash if entry.origin is None else str(entry.origin["hash"])


def _read_from(entries: Sequence[Entry]) -> list[str]:
    """Return the SHA-256 of the files that entries are read from."""
    return list(dict.fromkeys(_new(entry)["sha256"] for entry in entries if entry.reads))


def _final_states(entries: Sequence[Entry]) -> dict[str, Any]:
    """Return what columns of things, by uid, and readings of files, by SHA-256, come to."""
    found: dict[str, Any] = {}
    for entry in entries:
        if entry.reads and not entry.makes:
            found[_new(entry)["sha256"]] = how_read(entry)
        elif not entry.makes:
            end = found.setdefault(entry.entity_uid, {})
            end.update(_new(entry))
            if entry.action in USING:
                end[IN_USE] = entry.action is Action.INCLUDE
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


def _remark(entry: Entry) -> tuple[str, ...]:
    return entry.entity_kind, entry.person, canonical(entry.new)


def how_read(entry: Entry) -> str:
    """Return an entry's settings of reading in a form to compare; the file's name does not count."""
    return canonical(without_name(_new(entry)["settings"]))


SAME_JUMP_S = 0.05
"""Verdicts whose anchors lie closer than this are on the same jump, whichever detector found it."""


def _verdict_text(entry: Entry) -> str:
    """Return a verdict in words, with the time at which it puts an apex."""
    verdict, at_s = _new(entry)["verdict"], _new(entry).get("at_s")
    return str(verdict) if at_s is None else f"{verdict} to {at_s:.3f} s"


def _last_verdicts(entries: Iterable[Entry]) -> dict[tuple[str, str, str, float], Entry]:
    found = {}
    for entry in entries:
        if entry.entity_kind == "decision":
            new = _new(entry)
            place = (new["target_kind"], new["target_uid"], new.get("signal_sha256") or "", new.get("anchor_s") or 0.0)
            found[place] = entry
    return found
