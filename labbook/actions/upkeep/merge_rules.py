"""What an entry of another book meets in this one: it is new, it is here already, or it contradicts what is here.

Things that two books name alike are one thing: a run by its name, a level by its label, a file by its bytes. What was
said of them in both must agree; what was said in one only is taken over.
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
class Already:
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
class Here:
    """This book while entries of another come in.

    `said` is its journal before that, `news` what the other book does not know of it; `readings` are its entries on
    each file, by SHA-256, and grow with those that come in; `ends` is what columns of things and readings of files come
    to at the end of the other book, by uid or SHA-256: who said that here too need not say what was said on the way.
    """

    connection: sa.Connection
    said: Sequence[Entry]
    news: Sequence[Entry]
    readings: dict[str, list[Entry]] = field(default_factory=dict, init=False)
    declared: dict[str, Entry] = field(default_factory=dict, init=False)
    ends: dict[str, Any] = field(default_factory=dict, init=False)
    changes: dict[str, list[Entry]] = field(default_factory=dict, init=False)
    remarks: dict[tuple[str, ...], str] = field(default_factory=dict, init=False)

    def __post_init__(self) -> None:
        """Find what was said about files and things."""
        for entry in self.news:
            self.changes.setdefault(entry.entity_uid, []).append(entry)
            if entry.action in (Action.DECLARE, Action.NOTE):
                self.remarks[_remark(entry)] = entry.entity_uid
        for entry in self.said:
            self.heard(entry)
            if entry.action is Action.DECLARE:
                self.declared[entry.entity_uid] = entry

    def about(self, uid: str) -> list[Entry]:
        """Return what was stated here of a thing that is there, and the other book does not know."""
        return [said for said in self.changes.get(uid, ()) if said.action in CHANGES]

    def heard(self, entry: Entry) -> None:
        """Take note of an entry that has taken effect."""
        if entry.action in (Action.INGEST, Action.READ):
            self.readings.setdefault((entry.new or {})["sha256"], []).append(entry)


def meets(here: Here, entry: Entry) -> Already | Conflict | None:
    """Return what an entry, its uids being those of this book, meets here; None where it is to be taken over."""
    rule = _RULES.get(entry.action)
    return None if rule is None else rule(here, entry)


def called(connection: sa.Connection, kind: str, uid: str) -> str:
    """Return what people call a thing: a run or a level by its name, a charge by its uid and its run."""
    try:
        found = read_fact(connection, kind, uid)
    except (UnknownName, KeyError):
        return f"{kind} {uid}"
    if kind == "charge":
        return f"charge:{uid}" + (f" of {called(connection, 'run', found['run'])}" if found["run"] else "")
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
    "calibration": ("instrument", "quantity", "valid_from_utc"),
    "run": ("study", "name"),
}
"""By which columns two books call the same thing by the same name."""


def _declare(here: Here, entry: Entry) -> Already | Conflict | None:
    kind, new = entry.entity_kind, entry.new or {}
    if kind == "config":  # the two in force are the same, and a file's entry holds how it was read
        in_force = config_in_force(here.connection)
        return Already(None if in_force is None else in_force.uid)
    if kind == "plan":
        return _plan(here, entry)
    if kind == "charge":
        for row in charges_of_run(here.connection, new["run"]):
            if all(same_value(getattr(row, name), new[name]) for name in ("charge_mah", "mode")):
                return Already(row.uid)
        return None
    if kind not in _NATURAL:
        return _said_too(here, entry)
    uid = find_uid(here.connection, kind, **{name: new[name] for name in _NATURAL[kind]})
    if uid is None:
        return None
    stands = read_fact(here.connection, kind, uid)
    differing = sorted(name for name in stands.keys() & new.keys() if stands[name] != new[name])
    if not differing or (uid in here.declared and here.declared[uid].new == new):
        return Already(uid)
    words = "; ".join(
        f"{name} {_shown(here, stands[name], name)} here, {_shown(here, new[name], name)} there" for name in differing
    )
    name = called(here.connection, kind, uid)
    remedy = (
        f"if they are two runs, name this book's otherwise (`labbook correct {new['name']} name=... --why ...`); if "
        "they are one, correct it here to what the other book says"
        if kind == "run"
        else "correct it here to what the other book says"
    )
    return Conflict(f"{name} is in both books, {words}: {remedy}.", uid)


def _plan(here: Here, entry: Entry) -> Already | Conflict | None:
    new = dict(entry.new or {})
    for uid, said in here.declared.items():
        if said.entity_kind == "plan" and {**(said.new or {}), "created_utc": new["created_utc"]} == new:
            return Already(uid)
    taken = {row.name for row in planned_runs(here.connection)}
    both = [run["name"] for run in new["runs"] if run["name"] in taken]
    if not both:
        return None
    return Conflict(
        f"runs {both[0]} to {both[-1]} are planned in both books, with seed {new['seed']} there: withdraw what is left "
        'of the plan of this book, `labbook plan --withdraw --why "..."`.'
    )


def _said_too(here: Here, entry: Entry) -> Already | None:
    """A remark, or a check of a day, that one person made in both books is one."""
    uid = here.remarks.get(_remark(entry))
    return None if uid is None else Already(uid)


def _remark(entry: Entry) -> tuple[str, ...]:
    return entry.entity_kind, entry.person, canonical(entry.new)


def _ingest(here: Here, entry: Entry) -> Already | Conflict | None:
    new = entry.new or {}
    readings = here.readings.get(new["sha256"])
    if not readings:
        return None
    name, uid = new["original_name"], readings[0].entity_uid
    if all(how_read(said) != how_read(entry) for said in readings):
        return Conflict(
            f"file {name} is in both books and was read otherwise in each: have it read here as there, `labbook files "
            f"reread {name}` with what is declared about it there.",
            uid,
        )
    run = new.get("run") or _stated(here, entry)
    links = links_of_file(here.connection, derived_uid("file", new["sha256"]))
    same = [said for said in readings if run in ((said.new or {}).get("run"), _stated(here, said))]
    if run and not same and all(link.run_uid != run for link in links):
        return _elsewhere(here, name, links, run, uid)
    return Already(uid)


def _stated(here: Here, said: Entry) -> str | None:
    name = (said.new or {}).get("stated_run")
    return find_uid(here.connection, "run", name=name) if name else None


def _read(here: Here, entry: Entry) -> Already | Conflict | None:
    new = entry.new or {}
    readings = here.readings.get(new["sha256"], [])
    name = new["original_name"]
    if not readings:
        return Conflict(f"file {name} was read again there and is not here: check the other book, `labbook db check`.")
    if how_read(readings[-1]) == how_read(entry):
        return Already(readings[-1].entity_uid)
    if any(said.action is Action.READ and (said.new or {})["sha256"] == new["sha256"] for said in here.news):
        if how_read(readings[-1]) == here.ends.get(new["sha256"]):
            return Already(readings[-1].entity_uid)
        return Conflict(
            f"file {name} was read again in both books, with other declarations in each: have it read here as there, "
            f"`labbook files reread {name}` with what is declared about it there."
        )
    return None


def how_read(entry: Entry) -> str:
    """Return, to be compared, how an entry says that a file was read; under which name it came does not count."""
    new = entry.new or {}
    if "settings" not in new:
        return canonical(new["options"])
    return canonical(without_name(new["settings"]))


def _refuse(here: Here, entry: Entry) -> Already | None:
    new = entry.new or {}
    before = refused_with(here.connection, new["sha256"], new["reader"], canonical(new["options"]))
    return Already() if without_name(new.get("settings")) in map(without_name, before) else None


def _assign(here: Here, entry: Entry) -> Already | Conflict | None:
    new, old = entry.new or {}, entry.old or {}
    if entry.entity_kind == "charge":
        return _change(here, entry)
    part = new.get("part")
    links = [link for link in links_of_file(here.connection, entry.entity_uid) if part in (None, link.part)]
    runs = {link.run_uid for link in links}
    if (new["run"] is None and not runs) or new["run"] in runs:
        return Already()
    if runs <= (set() if new["run"] is not None else set(old.get("runs", ()))):
        return None
    name = next((row.name for row in find_files(here.connection, entry.entity_uid)), entry.entity_uid)
    return _elsewhere(here, name, links, new["run"])


def _elsewhere(here: Here, name: str, links: Sequence[Link], run: str | None, uid: str | None = None) -> Conflict:
    """Say that a file, linked so here, belongs to another run there, or to none."""
    stands = ", ".join(sorted({f"run {link.run_name}" for link in links})) or "no run"
    there = "no run" if run is None else called(here.connection, "run", run)
    word = "none" if run is None else there.removeprefix("run ")
    return Conflict(
        f"file {name} belongs to {stands} here and to {there} there: `labbook assign {name} {word} --why ...` says so "
        "here.",
        uid,
    )


def _change(here: Here, entry: Entry) -> Already | Conflict | None:
    """Compare a row with what an entry found and with what it made of it."""
    kind, uid, new, old = entry.entity_kind, entry.entity_uid, entry.new or {}, entry.old or {}
    try:
        stands = read_fact(here.connection, kind, uid, list(new))
    except UnknownName:  # it may be of a file that waits for a declaration
        return None
    ends = {**new, **here.ends.get(uid, {})}
    changed = {name for said in here.about(uid) for name in said.new or {}} & new.keys()
    contrary = sorted(name for name in changed if stands[name] != ends[name])
    if not contrary and all(name in changed or stands[name] == new[name] for name in new):
        return Already()
    if not contrary and all(name in changed or stands[name] == old.get(name) for name in new):
        return None
    words = "; ".join(
        f"{name} is {_shown(here, stands[name], name)} here and became {_shown(here, ends[name], name)} there"
        for name in contrary or sorted(name for name in new if stands[name] != new[name])
    )
    return Conflict(f"{called(here.connection, kind, uid)}: {words}: correct it here to what the other book says.")


def _void(here: Here, entry: Entry) -> Already | Conflict | None:
    if entry.new:
        return _change(here, entry)
    same = (Action.VOID, entry.entity_uid)
    return Already() if any((said.action, said.entity_uid) == same for said in here.said) else None


def _use(here: Here, entry: Entry) -> Already | Conflict | None:
    """Files are withdrawn and restored, charges of the inbox dismissed and restored."""
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
    said_here = any(said.action in USING for said in here.about(uid))
    if used == (ends if said_here else entry.action is Action.RESTORE):
        return Already()
    if not said_here and run is None:
        return None
    stands = f"of {called(here.connection, 'run', run)}" if run else _USED[used]
    return Conflict(f"{name} is {stands} here and {_USED[ends]} there: settle it here as it is there.")


_USED = {True: "in use", False: "out of use"}


_RULES: Mapping[Action, Callable[[Here, Entry], Already | Conflict | None]] = {
    Action.DECLARE: _declare,
    Action.NOTE: _said_too,
    Action.INGEST: _ingest,
    Action.READ: _read,
    Action.REFUSE: _refuse,
    Action.ASSIGN: _assign,
    Action.CORRECT: _change,
    Action.VOID: _void,
    **dict.fromkeys(USING, _use),
}
"""Verdicts and reports are only ever added; whether verdicts agree is asked when all are there."""


def _shown(here: Here, value: Any, column: str) -> str:
    """Return a value as people know it; a uid is what it leads to, without its kind where the column says that."""
    if isinstance(value, str):
        for kind in ("run", "condition", "day", "battery", "robot"):
            name = called(here.connection, kind, value)
            if name != f"{kind} {value}":
                return name.removeprefix(f"{column} ")
    return "nothing" if value is None else str(value)
