"""The journal as a person reads it: a line a command, the newest first."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby

import sqlalchemy as sa

from data_schema.queries.facts import read_fact
from data_schema.queries.files import find_files
from data_schema.queries.history import EntryRow, ends_of_commands, entries_between
from data_schema.vocabulary import Action
from labbook.book.naming import NAME_OF, changes_in_words, words_of


@dataclass(frozen=True, slots=True)
class CommandLine:
    """What one command stated, in its entries `first` to `last`; `run` names the run where all of them are of one."""

    first: int
    last: int
    at_utc: str
    person: str
    what: str
    why: str
    run: str | None


def newest_commands(connection: sa.Connection, most: int, before: int | None = None) -> list[CommandLine]:
    """Return the last commands, the newest first; with `before` those that ended before that entry."""
    ends = ends_of_commands(connection, most + 1, before)
    if not ends:
        return []
    entries = entries_between(connection, ends[most] if len(ends) > most else 0, ends[0])
    commands = [list(of) for _command, of in groupby(entries, lambda entry: entry.command)]
    return [_line(connection, of) for of in reversed(commands)]


def _line(connection: sa.Connection, entries: Sequence[EntryRow]) -> CommandLine:
    last = entries[-1]
    by = next((entry for entry in entries if entry.action is Action.MERGE), last)  # of others are what it brought
    own = [entry for entry in entries if entry.kind != "config"] or entries  # what labbook.toml added comes beside
    runs = {_run_uid(connection, entry) for entry in own}
    (run_uid,) = runs if len(runs) == 1 else (None,)
    run = None if run_uid is None else str(read_fact(connection, "run", run_uid, ["name"])["name"])
    reasons = dict.fromkeys(entry.reason for entry in entries if entry.reason)
    if len(own) == 1:
        what = _what(connection, own[0], run)
    else:  # the kinds in the order in which they came
        counts = Counter((words_of(one).did, _KINDS.get(one.kind, one.kind).replace("_", " ")) for one in own)
        what = ", ".join(
            f"{done} {n} {kind if n == 1 else _PLURALS.get(kind, f'{kind}s')}" for (done, kind), n in counts.items()
        )
    what += ", and took over labbook.toml" if len(own) < len(entries) else ""
    return CommandLine(entries[0].seq, last.seq, by.at_utc, by.person, what, "; ".join(reasons), run)


def _run_uid(connection: sa.Connection, entry: EntryRow) -> str | None:
    """Return the uid of the run that an entry is about."""
    if entry.kind == "run":
        return entry.uid
    new = entry.new
    if new.get("target_kind") in ("run", "jump"):
        return str(new["target_uid"])
    if entry.kind in ("charge", "run_file"):
        uid = new["run"] if "run" in new else read_fact(connection, entry.kind, entry.uid, ["run"])["run"]
        return None if uid is None else str(uid)
    return None


_KINDS = {"ingest": "file", "decision": "jump", "config": "labbook.toml", "run_file": "file"}


_PLURALS = {"person": "people", "battery": "batteries"}


def _what(connection: sa.Connection, entry: EntryRow, run: str | None) -> str:
    """Say what one entry did; a run is not named, it stands beside."""
    new, done = entry.new, words_of(entry).did
    if entry.kind == "decision":
        blind = ", blind" if new.get("blind") else ""
        return f"{done} a jump ({str(new['reason_code']).replace('_', ' ')}{blind})"
    if entry.action is Action.NOTE:
        return f"noted: {new['text']}"
    if entry.action is Action.REPORT:
        return f"wrote the report {new['folder']}"
    if "original_name" in new:
        return f"{done} {new['original_name']}"
    kind = "" if entry.kind == "run" else _KINDS.get(entry.kind, entry.kind).replace("_", " ")
    name = "" if run is not None else _name(connection, entry)
    changes = changes_in_words(connection, entry.old, new) if entry.old and entry.action is not Action.EXCLUDE else ""
    return " ".join(word for word in (done, kind, name) if word) + (f": {changes}" if changes else "")


def _name(connection: sa.Connection, entry: EntryRow) -> str:
    """Return what a person calls the thing of an entry: its name, or its uid."""
    if entry.kind == "file":
        return next((one.name for one in find_files(connection, entry.uid)), entry.uid)
    stated = next((entry.new[key] for key in ("name", "key", "label", "date_local") if entry.new.get(key)), None)
    if stated is None and entry.kind in NAME_OF:
        stated = read_fact(connection, entry.kind, entry.uid, [NAME_OF[entry.kind]])[NAME_OF[entry.kind]]
    return "" if entry.kind == "config" else str(stated or entry.uid)
