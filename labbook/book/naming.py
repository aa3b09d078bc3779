"""From the names that people use to the rows they mean, and back to words that describe a change.

Missing days and conditions are stated where they are needed.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any, NamedTuple

import sqlalchemy as sa

from data_schema.errors import UnknownName, UsageError, unknown_name
from data_schema.journal import Entry
from data_schema.queries.facts import find_uid, read_fact
from data_schema.queries.history import EntryRow
from data_schema.queries.runs import RunRow, find_run, run_names
from data_schema.queries.study import StudyRow, conditions_by_key, day_uids, factors, open_plans, the_study
from data_schema.vocabulary import Action
from labbook.book.write_session import WriteSession
from labbook.config.local_time import local_text
from labbook.config.parsing import Configuration
from labbook.config.run_names import composed


def study_of(connection: sa.Connection) -> StudyRow:
    """Return the book's study."""
    study = the_study(connection)
    if study is None:
        raise UsageError("the book has no study yet: describe it under [study] in labbook.toml.")
    return study


def run_named(connection: sa.Connection, name: str) -> RunRow:
    """Return a run by name; an unknown one is refused with the nearest, one that is only planned as such."""
    found = find_run(connection, composed(name))
    if found is None:
        if any(name in plan.to_be_made for plan in open_plans(connection)):
            raise UnknownName(
                f"run {name} is planned and was not made yet: import its filled-in line of the run sheet with "
                "`labbook runs import`."
            )
        raise unknown_name("run", name, run_names(connection), "List them with `labbook runs list`.")
    return found


def refuse_empty(option: str, text: str) -> None:
    """Raise `UsageError` for an empty reason: the journal keeps reasons for those who come later."""
    if not text.strip():
        raise UsageError(f"{option} is empty: say it in a few words, the journal keeps them.")


def named_uid(connection: sa.Connection, kind: str, name: str, known: Mapping[str, Any]) -> str:
    """Return the uid of a robot, battery or instrument that labbook.toml names."""
    uid = find_uid(connection, kind, name=name)
    if uid is None:
        table = {"battery": "batteries"}.get(kind, f"{kind}s")
        raise unknown_name(kind, name, known, f"Add it under [{table}.{name}] in labbook.toml.")
    return uid


def ensure_day(session: WriteSession, study_uid: str, date_local: str) -> str:
    """Return the uid of a day; a day comes into being with its first run or check."""
    return day_uids(session.connection).get(date_local) or session.declare(
        "day", study=study_uid, date_local=date_local
    )


def condition_key(levels: Mapping[str, str]) -> str:
    """Return the canonical name of a condition: "foot=small k_gain=400 b_ad_gain=50", in the factors' order."""
    return " ".join(f"{name}={label}" for name, label in levels.items())


def ensure_condition(
    session: WriteSession, configuration: Configuration, study_uid: str, levels: Mapping[str, str]
) -> str:
    """Return the uid of the condition with these levels; raises for a factor or level that does not exist."""
    uids = []
    ordered: dict[str, str] = {}
    rows = [row for row in factors(session.connection) if row.name in configuration.factors]
    for name in levels:
        if name not in {row.name for row in rows}:
            raise unknown_name("factor", name, [row.name for row in rows], "Factors are declared in labbook.toml.")
    for row in rows:
        named = {level.label for level in configuration.factors[row.name].levels}
        known = {item.label: item.uid for item in row.levels if item.label in named}
        if row.name not in levels:
            raise UsageError(f"a condition needs a level of {row.name}: give one of {', '.join(known)}.")
        label = levels[row.name]
        if label not in known:
            remedy = f"Levels are declared under [factors.{row.name}] in labbook.toml."
            raise unknown_name(f"level of {row.name}", label, known, remedy)
        uids.append(known[label])
        ordered[row.name] = label
    key = condition_key(ordered)
    standing = conditions_by_key(session.connection).get(key)
    if standing is not None:
        return standing
    control = any(
        factor.control is not None and ordered.get(name) == factor.control
        for name, factor in configuration.factors.items()
    )
    return session.declare("condition", study=study_uid, key=key, is_control=int(control), levels=uids)


def old_values(connection: sa.Connection, kind: str, uid: str, new: Mapping[str, Any]) -> dict[str, Any]:
    """Return what stands now in the columns that are about to change."""
    return read_fact(connection, kind, uid, list(new))


_UTC = "_utc"


class Words(NamedTuple):
    """What people call an entry: what it did, what such entries are in a list, what became of their file or jump.

    Without `listed` they are listed as things of their kind; without `became` nothing did that a number can move by.
    """

    did: str
    listed: str | None = None
    became: str | None = None


_VOID = Words("declared void", "void run or plan")
_CORRECTED = Words("corrected", "correction")
_RESTORED = Words("restored", "file or charge restored", "taken into use again")
_WORDS: Mapping[tuple[Action, str], Words] = {
    (Action.INGEST, "first"): Words("took in", "file", "ingested"),
    (Action.INGEST, "again"): Words("read again", "file read again", "read anew"),
    (Action.INGEST, "refused"): Words("refused", "refused file"),
    (Action.SET, "first"): Words("declared"),
    (Action.SET, "again"): _CORRECTED,
    (Action.SET, "its run"): Words("assigned", "assignment"),
    (Action.SET, "move"): Words("moved", "verdict", "given another apex"),
    (Action.SET, "add"): Words("added", "verdict", "added"),
    (Action.SET, "clear"): Words("cleared", "verdict", "left to the protocol again"),
    (Action.EXCLUDE, "reject"): Words("rejected", "verdict", "rejected"),
    (Action.EXCLUDE, "run"): _VOID,
    (Action.EXCLUDE, "plan"): _VOID,
    (Action.EXCLUDE, "file"): Words("withdrew", "file withdrawn", "withdrawn"),
    (Action.EXCLUDE, "charge"): Words("dismissed", "charge dismissed"),
    (Action.INCLUDE, "accept"): Words("accepted", "verdict", "accepted"),
    (Action.INCLUDE, "run"): _CORRECTED,
    (Action.INCLUDE, "file"): _RESTORED,
    (Action.INCLUDE, "charge"): _RESTORED,
    (Action.NOTE, "note"): Words("noted"),
    (Action.PLAN, "plan"): Words("declared"),
    (Action.REPORT, "report"): Words("wrote", "report"),
    (Action.MERGE, "book"): Words("merged"),
}


def words_of(entry: Entry | EntryRow) -> Words:
    """Return what people call an entry, by what commands are called."""
    old, new = entry.old or {}, entry.new or {}
    kind = entry.entity_kind if isinstance(entry, Entry) else entry.kind
    case = new["verdict"] if kind == "decision" else kind
    if kind == "ingest" and "findings" in new:
        case = "refused"
    elif entry.action in (Action.INGEST, Action.SET) and case == kind:
        # a charge gets a run, or loses the one that it had: to move it is to correct that
        given = new.keys() <= {"run", "added"} and None in (old.get("run", ""), new.get("run", ""))
        case = "its run" if given or kind == "file" else "first" if entry.makes else "again"
    return _WORDS[entry.action, case]


NAME_OF = {"condition": "key", "day": "date_local", "robot": "name", "battery": "name", "run": "name", "study": "name"}
"""The column that has what people call a thing of a kind."""


def changes_in_words(connection: sa.Connection, old: Mapping[str, object], new: Mapping[str, object]) -> str:
    """Say what columns are now, and were where that is known.

    What they refer to is called by its name; instants are local, and their columns called `started`, not `started_utc`.
    """
    changes = []
    for name, value in new.items():
        before = f"{_named(connection, name, old[name])} to " if name in old else ""
        if value is not None or before:
            changes.append(f"{name.removesuffix(_UTC)} {before}{_named(connection, name, value)}")
    return ", ".join(changes)


def _named(connection: sa.Connection, name: str, value: object) -> str:
    """Return what people call a thing that the journal names by its uid."""
    if value is None:
        return "none" if name == "run" else "unknown"
    if name.endswith(_UTC) and value:
        return local_text(str(value), study_of(connection).time_zone)
    if name in NAME_OF and re.fullmatch("[0-9a-f]{12}", str(value)):
        return str(read_fact(connection, name, str(value), [NAME_OF[name]])[NAME_OF[name]])
    return f"{value:g}" if isinstance(value, float) else str(value)
