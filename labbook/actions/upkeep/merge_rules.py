"""Compare an entry of another book with this one: it is new, it is here already, or it contradicts what is here.

Things that two books name alike are one thing: a run by its name, a level by its label, a file by its bytes. Statements
about them in both books must agree; those in one book only are taken over.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import sqlalchemy as sa

from data_schema.errors import UnknownName
from data_schema.journal import Entry, canonical
from data_schema.queries.charges import charges_of_run
from data_schema.queries.facts import find_uid, read_fact
from data_schema.queries.imported_files import Link, find_files, links_of_file
from data_schema.queries.imports import refused_with
from data_schema.queries.study import config_in_force, planned_runs
from data_schema.vocabulary import Action, ChargeState, IngestStatus
from labbook.statements.apply_context import derived_uid
from labbook.statements.counted_charges import same_value
from labbook.statements.importing import without_name


@dataclass(frozen=True, slots=True)
class AlreadyHere:
    """This book has it, under a uid of its own where it is a thing."""

    uid: str | None = None


@dataclass(frozen=True, slots=True)
class Conflict:
    """The two books contradict each other; `uid` is the thing in this book that the other has too."""

    sentence: str
    uid: str | None = None


USING = (Action.WITHDRAW, Action.DISMISS, Action.RESTORE)
"""Statements on whether a file or a charge counts."""
CHANGES = (Action.CORRECT, Action.VOID, Action.ASSIGN, *USING)
"""Statements about a thing that is there."""

IN_USE = "in use"
"""Stands beside the columns of a file or charge that was withdrawn, dismissed or restored."""


@dataclass(frozen=True, slots=True)
class TargetBook:
    """This book while entries of another come in.

    `entries` is its journal before that, `news` what the other book does not know of it; `readings` are its entries on
    each file, by SHA-256, and grow with those that come in; `ends` is what columns of things and readings of files come
    to at the end of the other book, by uid or SHA-256: where this book has the same end, the steps on the way need not
    agree.
    """

    connection: sa.Connection
    entries: Sequence[Entry]
    news: Sequence[Entry]
    readings: dict[str, list[Entry]] = field(default_factory=dict, init=False)
    declared: dict[str, Entry] = field(default_factory=dict, init=False)
    ends: dict[str, Any] = field(default_factory=dict, init=False)
    changes: dict[str, list[Entry]] = field(default_factory=dict, init=False)
    remarks: dict[tuple[str, ...], str] = field(default_factory=dict, init=False)

    def __post_init__(self) -> None:
        """Index the entries by files and things."""
        for entry in self.news:
            self.changes.setdefault(entry.entity_uid, []).append(entry)
            if entry.action in (Action.DECLARE, Action.NOTE):
                self.remarks[_remark(entry)] = entry.entity_uid
        for entry in self.entries:
            self.record(entry)
            if entry.action is Action.DECLARE:
                self.declared[entry.entity_uid] = entry

    def changes_here(self, uid: str) -> list[Entry]:
        """Return the changes that this book made to a thing of both, and the other book does not know."""
        return [entries for entries in self.changes.get(uid, ()) if entries.action in CHANGES]

    def record(self, entry: Entry) -> None:
        """Take note of an entry that has taken effect."""
        if entry.action in (Action.INGEST, Action.READ):
            self.readings.setdefault((entry.new or {})["sha256"], []).append(entry)


def compare_entry(here: TargetBook, entry: Entry) -> AlreadyHere | Conflict | None:
    """Compare an entry, its uids being those of this book, with this book; None where it is to be taken over."""
    rule = _RULES.get(entry.action)
    return None if rule is None else rule(here, entry)


def display_name(connection: sa.Connection, kind: str, uid: str) -> str:
    """Return the name of a thing for people: a run or a level by its name, a charge by its uid and its run."""
    try:
        found = read_fact(connection, kind, uid)
    except (UnknownName, KeyError):
        return f"{kind} {uid}"
    if kind == "charge":
        return f"charge:{uid}" + (f" of {display_name(connection, 'run', found['run'])}" if found["run"] else "")
    name = next((found[name] for name in ("name", "label", "key", "date_local") if found.get(name)), uid)
    return f"{kind} {name}"


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


def _declare(here: TargetBook, entry: Entry) -> AlreadyHere | Conflict | None:
    kind, new = entry.entity_kind, entry.new or {}
    if kind == "config":  # the two in force are the same, and a file's entry holds how it was read
        in_force = config_in_force(here.connection)
        return AlreadyHere(None if in_force is None else in_force.uid)
    if kind == "plan":
        return _plan(here, entry)
    if kind == "charge":
        for row in charges_of_run(here.connection, new["run"]):
            if row.added == new.get("added", 0) and all(
                same_value(getattr(row, name), new[name]) for name in ("charge_mah", "mode")
            ):
                return AlreadyHere(row.uid)
        return None
    if kind not in _NATURAL:
        return _repeated_remark(here, entry)
    uid = find_uid(here.connection, kind, **{name: new[name] for name in _NATURAL[kind]})
    if uid is None:
        return None
    stands = read_fact(here.connection, kind, uid)
    differing = sorted(name for name in stands.keys() & new.keys() if stands[name] != new[name])
    if not differing or (uid in here.declared and here.declared[uid].new == new):
        return AlreadyHere(uid)
    words = "; ".join(
        f"{name} {_shown(here, stands[name], name)} here, {_shown(here, new[name], name)} there" for name in differing
    )
    name = display_name(here.connection, kind, uid)
    remedy = (
        f"if they are two runs, name this book's otherwise (`labbook correct {new['name']} name=... --why ...`); if "
        "they are one, correct it here to what the other book says"
        if kind == "run"
        else "correct it here to what the other book says"
    )
    return Conflict(f"{name} is in both books, {words}: {remedy}.", uid)


def _plan(here: TargetBook, entry: Entry) -> AlreadyHere | Conflict | None:
    new = dict(entry.new or {})
    for uid, declared in here.declared.items():
        if declared.entity_kind == "plan" and {**(declared.new or {}), "created_utc": new["created_utc"]} == new:
            return AlreadyHere(uid)
    taken = {row.name for row in planned_runs(here.connection)}
    both = [run["name"] for run in new["runs"] if run["name"] in taken]
    if not both:
        return None
    return Conflict(
        f"runs {both[0]} to {both[-1]} are planned in both books, with seed {new['seed']} there: withdraw what is left "
        'of the plan of this book, `labbook plan --withdraw --why "..."`.'
    )


def _repeated_remark(here: TargetBook, entry: Entry) -> AlreadyHere | None:
    """Find a remark, or a check of a day, that the same person made in both books."""
    uid = here.remarks.get(_remark(entry))
    return None if uid is None else AlreadyHere(uid)


def _remark(entry: Entry) -> tuple[str, ...]:
    return entry.entity_kind, entry.person, canonical(entry.new)


def _ingest(here: TargetBook, entry: Entry) -> AlreadyHere | Conflict | None:
    new = entry.new or {}
    readings = here.readings.get(new["sha256"])
    if not readings:
        return None
    name, uid = new["original_name"], readings[0].entity_uid
    if all(how_read(reading) != how_read(entry) for reading in readings):
        return Conflict(
            f"file {name} is in both books and was read otherwise in each: have it read here as there, `labbook files "
            f"reread {name}` with what is declared about it there.",
            uid,
        )
    run = new.get("run") or _named_run(here, entry)
    links = links_of_file(here.connection, derived_uid("file", new["sha256"]))
    same = [reading for reading in readings if run in ((reading.new or {}).get("run"), _named_run(here, reading))]
    if run and not same and all(link.run_uid != run for link in links):
        return _other_run_conflict(here, name, links, run, uid)
    return AlreadyHere(uid)


def _named_run(here: TargetBook, entry: Entry) -> str | None:
    name = (entry.new or {}).get("stated_run")
    return find_uid(here.connection, "run", name=name) if name else None


def _read(here: TargetBook, entry: Entry) -> AlreadyHere | Conflict | None:
    new = entry.new or {}
    readings = here.readings.get(new["sha256"], [])
    name = new["original_name"]
    if not readings:
        return Conflict(f"file {name} was read again there and is not here: check the other book, `labbook db check`.")
    if how_read(readings[-1]) == how_read(entry):
        return AlreadyHere(readings[-1].entity_uid)
    if any(news.action is Action.READ and (news.new or {})["sha256"] == new["sha256"] for news in here.news):
        if how_read(readings[-1]) == here.ends.get(new["sha256"]):
            return AlreadyHere(readings[-1].entity_uid)
        return Conflict(
            f"file {name} was read again in both books, with other declarations in each: have it read here as there, "
            f"`labbook files reread {name}` with what is declared about it there."
        )
    return None


def how_read(entry: Entry) -> str:
    """Return an entry's settings of reading in a form to compare; the file's name does not count."""
    return canonical(without_name((entry.new or {})["settings"]))


def _refuse(here: TargetBook, entry: Entry) -> AlreadyHere | None:
    new = entry.new or {}
    before = refused_with(here.connection, new["sha256"], new["reader"], canonical(new["options"]))
    return AlreadyHere() if without_name(new["settings"]) in map(without_name, before) else None


def _assign(here: TargetBook, entry: Entry) -> AlreadyHere | Conflict | None:
    new, old = entry.new or {}, entry.old or {}
    if entry.entity_kind == "charge":
        return _change(here, entry)
    part = new.get("part")
    links = [link for link in links_of_file(here.connection, entry.entity_uid) if part in (None, link.part)]
    runs = {link.run_uid for link in links}
    if (new["run"] is None and not runs) or new["run"] in runs:
        return AlreadyHere()
    if runs <= (set() if new["run"] is not None else set(old.get("runs", ()))):
        return None
    name = next((row.name for row in find_files(here.connection, entry.entity_uid)), entry.entity_uid)
    return _other_run_conflict(here, name, links, new["run"])


def _other_run_conflict(
    here: TargetBook, name: str, links: Sequence[Link], run: str | None, uid: str | None = None
) -> Conflict:
    """Return the conflict of a file, linked so here, that belongs to another run there, or to none."""
    stands = ", ".join(sorted({f"run {link.run_name}" for link in links})) or "no run"
    there = "no run" if run is None else display_name(here.connection, "run", run)
    word = "none" if run is None else there.removeprefix("run ")
    return Conflict(
        f"file {name} belongs to {stands} here and to {there} there: `labbook assign {name} {word} --why ...` says so "
        "here.",
        uid,
    )


def _change(here: TargetBook, entry: Entry) -> AlreadyHere | Conflict | None:
    """Compare a row with what an entry found and with what it made of it."""
    kind, uid, new, old = entry.entity_kind, entry.entity_uid, entry.new or {}, entry.old or {}
    try:
        stands = read_fact(here.connection, kind, uid, list(new))
    except UnknownName:  # it may be of a file that waits for a declaration
        return None
    ends = {**new, **here.ends.get(uid, {})}
    changed = {name for statement in here.changes_here(uid) for name in statement.new or {}} & new.keys()
    contrary = sorted(name for name in changed if stands[name] != ends[name])
    if not contrary and all(name in changed or stands[name] == new[name] for name in new):
        return AlreadyHere()
    if not contrary and all(name in changed or stands[name] == old.get(name) for name in new):
        return None
    words = "; ".join(
        f"{name} is {_shown(here, stands[name], name)} here and became {_shown(here, ends[name], name)} there"
        for name in contrary or sorted(name for name in new if stands[name] != new[name])
    )
    return Conflict(
        f"{display_name(here.connection, kind, uid)}: {words}: correct it here to what the other book says."
    )


def _void(here: TargetBook, entry: Entry) -> AlreadyHere | Conflict | None:
    if entry.new:
        return _change(here, entry)
    same = (Action.VOID, entry.entity_uid)
    return AlreadyHere() if any((past.action, past.entity_uid) == same for past in here.entries) else None


def _use(here: TargetBook, entry: Entry) -> AlreadyHere | Conflict | None:
    """Compare whether a file (withdrawn or restored) or a charge of the inbox (dismissed or restored) is in use."""
    kind, uid = entry.entity_kind, entry.entity_uid
    run = None
    if kind == "file":
        (file,) = find_files(here.connection, uid)
        name, used = f"file {file.name}", file.status is not IngestStatus.WITHDRAWN
    else:
        try:
            charge = read_fact(here.connection, kind, uid, ["state", "run"])
        except UnknownName:  # it may be of a file that waits for a declaration
            return None
        name, used, run = f"charge:{uid}", charge["state"] != ChargeState.DISMISSED, charge["run"]
    ends = here.ends[uid][IN_USE]
    decided_here = any(statement.action in USING for statement in here.changes_here(uid))
    if used == (ends if decided_here else entry.action is Action.RESTORE):
        return AlreadyHere()
    if not decided_here and run is None:
        return None
    stands = f"of {display_name(here.connection, 'run', run)}" if run else _USED[used]
    return Conflict(f"{name} is {stands} here and {_USED[ends]} there: settle it here as it is there.")


_USED = {True: "in use", False: "out of use"}


_RULES: Mapping[Action, Callable[[TargetBook, Entry], AlreadyHere | Conflict | None]] = {
    Action.DECLARE: _declare,
    Action.NOTE: _repeated_remark,
    Action.INGEST: _ingest,
    Action.READ: _read,
    Action.REFUSE: _refuse,
    Action.ASSIGN: _assign,
    Action.CORRECT: _change,
    Action.VOID: _void,
    **dict.fromkeys(USING, _use),
}
"""Verdicts and reports are only ever added; whether verdicts agree is asked when all are there."""


def _shown(here: TargetBook, value: Any, column: str) -> str:
    """Return a value as people know it; for a uid the name of the thing, without its kind where the column has that."""
    if isinstance(value, str):
        for kind in ("run", "condition", "day", "battery", "robot"):
            name = display_name(here.connection, kind, value)
            if name != f"{kind} {value}":
                return name.removeprefix(f"{column} ")
    return "nothing" if value is None else str(value)
