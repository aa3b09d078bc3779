"""What an entry of another book meets in this one: it is new, it is here already, or it contradicts what is here.

Things that two books name alike are one thing: a run by its name, a level by its label, a file by its bytes. What was
said of them in both must agree; what was said in one only is taken over.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import sqlalchemy as sa

from data_schema.errors import UnknownName
from data_schema.journal import Entry, canonical
from data_schema.queries.charges import ChargeOfRun, charges_of_run
from data_schema.queries.facts import find_uid, read_fact
from data_schema.queries.imported_files import find_files, links_of_file
from data_schema.queries.imports import refused_before
from data_schema.queries.people import config_in_force
from data_schema.queries.plans import planned_runs
from data_schema.vocabulary import Action, ChargeMode, ChargeState, IngestStatus
from labbook.statements.scene import derived_uid


@dataclass(frozen=True, slots=True)
class Already:
    """This book has it, under a uid of its own where it is a thing."""

    uid: str | None = None


@dataclass(frozen=True, slots=True)
class Conflict:
    """The two books contradict each other; `uid` is the thing in this book that the other has too."""

    sentence: str
    uid: str | None = None


@dataclass(frozen=True, slots=True)
class Here:
    """This book while entries of another come in.

    `said` is its journal before that, `news` what the other book does not know of it; `readings` are its entries on
    each file, by SHA-256, and grow with those that come in.
    """

    connection: sa.Connection
    said: Sequence[Entry]
    news: Sequence[Entry]
    readings: dict[str, list[Entry]] = field(default_factory=dict)
    declared: dict[str, Entry] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Find what was said about files and things."""
        for entry in self.said:
            self.heard(entry)
            if entry.action is Action.DECLARE:
                self.declared[entry.entity_uid] = entry

    def heard(self, entry: Entry) -> None:
        """Take note of an entry that has taken effect."""
        if entry.action in (Action.INGEST, Action.READ):
            self.readings.setdefault((entry.new or {})["sha256"], []).append(entry)


def meets(here: Here, entry: Entry) -> Already | Conflict | None:
    """Return what an entry, its uids being those of this book, meets here; None where it is to be taken over."""
    rule = _RULES.get(entry.action)
    return None if rule is None else rule(here, entry)


def called(connection: sa.Connection, kind: str, uid: str) -> str:
    """Return what people call a thing: a run or a level by its name, a charge by its uid."""
    try:
        found = read_fact(connection, kind, uid)
    except (UnknownName, KeyError):
        return f"{kind} {uid}"
    if kind == "charge":
        return f"charge:{uid}"
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
        same = [row for row in charges_of_run(here.connection, new["run"]) if _alike(row, new, ("charge_mah", "mode"))]
        return Already(same[0].uid) if same else None
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
        f"{name} {_shown(here, stands[name])} here, {_shown(here, new[name])} there" for name in differing
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
    for said in here.news:
        if (said.entity_kind, said.person, said.new) == (entry.entity_kind, entry.person, entry.new):
            return Already(said.entity_uid)
    return None


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
        stands = ", ".join(sorted({f"run {link.run_name}" for link in links})) or "no run"
        there = called(here.connection, "run", run)
        return Conflict(
            f"file {name} belongs to {stands} here and to {there} there: `labbook assign {name} "
            f"{there.removeprefix('run ')} --why ...` says so here.",
            uid,
        )
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
    settings = new["settings"]
    return canonical({**settings, "declared": {**settings["declared"], "file_name": None}})


def _refuse(here: Here, entry: Entry) -> Already | None:
    new = entry.new or {}
    known = refused_before(here.connection, new["sha256"], new["reader"], canonical(new["options"]))
    return Already() if known else None


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
    there = "no run" if new["run"] is None else called(here.connection, "run", new["run"])
    stands = ", ".join(sorted({f"run {link.run_name}" for link in links}))
    word = "none" if new["run"] is None else there.removeprefix("run ")
    return Conflict(
        f"file {name} belongs to {stands} here and to {there} there: `labbook assign {name} {word} --why ...` says so "
        "here."
    )


def _change(here: Here, entry: Entry) -> Already | Conflict | None:
    """Compare a row with what an entry found and with what it made of it."""
    kind, uid, new, old = entry.entity_kind, entry.entity_uid, entry.new or {}, entry.old or {}
    try:
        stands = read_fact(here.connection, kind, uid, list(new))
    except UnknownName:  # it may be of a file that waits for a declaration
        return None
    differing = sorted(name for name in new if stands[name] != new[name])
    if not differing:
        return Already()
    if all(stands[name] == old.get(name) for name in new):
        return None
    words = "; ".join(
        f"{name} is {_shown(here, stands[name])} here and became {_shown(here, new[name])} there ({entry.person}, "
        f"{entry.at_utc[:10]})"
        for name in differing
    )
    return Conflict(f"{called(here.connection, kind, uid)}: {words}: correct it here to what the other book says.")


def _void(here: Here, entry: Entry) -> Already | Conflict | None:
    if entry.new:
        return _change(here, entry)
    same = (Action.VOID, entry.entity_uid)
    return Already() if any((said.action, said.entity_uid) == same for said in here.said) else None


def _use(here: Here, entry: Entry) -> Already | Conflict | None:
    """Files are withdrawn and restored, charges of the inbox dismissed and restored."""
    if entry.entity_kind == "file":
        withdrawn = any(row.status is IngestStatus.WITHDRAWN for row in find_files(here.connection, entry.entity_uid))
        return Already() if withdrawn == (entry.action is Action.WITHDRAW) else None
    try:
        stands = read_fact(here.connection, "charge", entry.entity_uid, ["state", "run"])
    except UnknownName:
        return None
    if (stands["state"] == ChargeState.DISMISSED) == (entry.action is Action.DISMISS):
        return Already()
    if stands["run"] is None:
        return None
    run = called(here.connection, "run", stands["run"])
    return Conflict(
        f"charge:{entry.entity_uid} was dismissed there, and belongs to {run} here: `labbook correct "
        f"charge:{entry.entity_uid} run=none --why ...` takes it off."
    )


_RULES: Mapping[Action, Callable[[Here, Entry], Already | Conflict | None]] = {
    Action.DECLARE: _declare,
    Action.NOTE: _said_too,
    Action.INGEST: _ingest,
    Action.READ: _read,
    Action.REFUSE: _refuse,
    Action.ASSIGN: _assign,
    Action.CORRECT: _change,
    Action.VOID: _void,
    Action.WITHDRAW: _use,
    Action.RESTORE: _use,
    Action.DISMISS: _use,
}
"""Verdicts and reports are only ever added; whether verdicts agree is asked when all are there."""


def _alike(row: object, values: Mapping[str, Any], names: Collection[str]) -> bool:
    return all(getattr(row, name) == values[name] for name in names)


def _shown(here: Here, value: Any) -> str:
    """Return a value as people know it; a uid is what it leads to."""
    if isinstance(value, str):
        for kind in ("run", "condition", "day", "battery", "robot"):
            name = called(here.connection, kind, value)
            if name != f"{kind} {value}":
                return name
    return "nothing" if value is None else str(value)


Charges = Mapping[str, Sequence[ChargeOfRun]]
"""The charges that count, by the uid of their run."""


def second_charges(connection: sa.Connection, before: Charges, there: Charges, now: Charges) -> list[str]:
    """Say which runs would have a charge of each book, where neither has two; uids `there` are those of this book."""
    found = []
    for uid, charges in now.items():
        some = [row for row in charges if row.mode == ChargeMode.CHARGE]
        if len(some) > max(1, len(before.get(uid, ())), len(there.get(uid, ()))):
            own = {row.uid for row in before.get(uid, ())}
            words = " and ".join(
                f"{row.charge_mah:g} mAh {'here' if row.uid in own else 'there'}, charge:{row.uid}" for row in some
            )
            found.append(
                f"{called(connection, 'run', uid)} has a charge in each book ({words}): take the wrong one off in its "
                "book, `labbook correct charge:UID run=none --why ...`."
            )
    return found


SAME_JUMP_S = 0.05
"""Verdicts whose anchors lie closer than this are on the same jump, whichever detector found it."""


def verdicts_that_differ(connection: sa.Connection, here: Iterable[Entry], there: Iterable[Entry]) -> list[str]:
    """Say on what the last verdicts differ that people gave in two books without knowing of each other."""
    standing, found = _last_verdicts(here), []
    for place, other in _last_verdicts(there).items():
        for where, own in standing.items():
            if where[:3] == place[:3] and abs(where[3] - place[3]) < SAME_JUMP_S and _verdict(own) != _verdict(other):
                kind, uid = place[:2]
                what = called(connection, "run" if kind == "jump" else kind, uid)
                what = f"the jump of {what} at {place[3]:.3f} s" if kind == "jump" else what
                one, two = ((said.new or {})["verdict"] for said in (own, other))
                found.append(
                    f"{what} has two verdicts: {one} here ({own.person}, {own.at_utc[:10]}), {two} there "
                    f"({other.person}, {other.at_utc[:10]}): agree, and give the same verdict in both books."
                )
    return found


def _last_verdicts(entries: Iterable[Entry]) -> dict[tuple[str, str, str, float], Entry]:
    found = {}
    for entry in entries:
        if entry.action is Action.DECIDE:
            new = entry.new or {}
            place = (new["target_kind"], new["target_uid"], new.get("signal_sha256") or "", new.get("anchor_s") or 0.0)
            found[place] = entry
    return found


def _verdict(entry: Entry) -> tuple[Any, Any]:
    new = entry.new or {}
    return new["verdict"], new.get("new_value")
