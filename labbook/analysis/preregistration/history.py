"""The journal's entries about runs, charges and files as changes of columns, and the rows that they led to."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from math import inf
from typing import Any

import sqlalchemy as sa

from data_schema.queries import history as queries
from data_schema.queries.charges import ChargeOfRun, every_charge
from data_schema.queries.detections import jump_decisions
from data_schema.queries.history import EntryRow, FileLink
from data_schema.queries.runs import condition_columns, list_runs
from data_schema.queries.signals import SignalRow, signals_of_files
from data_schema.vocabulary import Action, FileRole, RunKind, RunState
from labbook.analysis.preregistration.book_state import NO_RUN, BookHistory, Change, ChangeKind, Part

_UNDONE = (Action.CORRECT, Action.VOID, Action.ASSIGN, Action.WITHDRAW, Action.RESTORE)
_OF_RUNS = ("kind", "state", "condition", "jumps_made", "starts", "duration_s", "day", "robot", "battery", "name",
            "position_in_day", "started_utc")  # fmt: skip
_NAMED_BY = {"day": "date_local", "robot": "name", "battery": "name"}
_NO_CONDITION: dict[str, Any] = {"condition_uid": None, "condition_key": "", "is_control": False, "levels": {}}


def read_history(connection: sa.Connection) -> BookHistory:
    """Read what the book's states follow from, in a few queries."""
    entries, links = queries.entries_about_runs(connection), queries.file_links(connection)
    sources, readings = queries.files_of_charges(connection), queries.files_read(connection)
    run_of = {link.part: link.run_uid for link in links if link.in_use}
    charges = {item.uid: item for item in every_charge(connection)}
    charges |= {uid: replace(item, run_uid=NO_RUN) for uid, item in charges.items() if not sources[uid][1]}
    logs = {
        part: replace(log, run_uid=run_of.get(part, NO_RUN))
        for role in (FileRole.LOG, FileRole.FORCE)
        for part, log in signals_of_files(connection, role).items()
    }
    file_of = {uid: file_uid for uid, (file_uid, _) in sources.items()}
    changes = list(_changes(entries, links, charges, logs, file_of))
    came = [entry for entry in entries if entry.action in (Action.DECLARE, Action.INGEST)]
    file_read = {uid: file_uid for uid, file_uid, _ in readings}
    seqs = {entry.uid: entry.seq for entry in entries if entry.action is Action.DECIDE}
    verdicts = {  # one that is being stated has no entry yet
        sha256: [(seqs.get(row.uid, inf), row) for row in rows] for sha256, rows in jump_decisions(connection).items()
    }
    return BookHistory(
        runs={run.uid: run for run in list_runs(connection)},
        charges=charges,
        logs=logs,
        changes=changes,
        attributes=_attributes(connection, {change.column for _, change in changes}),
        since={file_read.get(entry.uid, entry.uid): entry for entry in came},
        file_of=file_of,
        file_names={file_uid: name for _, file_uid, name in readings},
        reports=queries.reports_made(connection),
        verdicts=verdicts,
        void=[entry for entry in entries if entry.action is Action.VOID],
    )


def _attributes(connection: sa.Connection, columns: Collection[str]) -> dict[str, dict[Any, dict[str, Any]]]:
    """Read what the values of columns that changed stand for in a `RunRow`."""
    found: dict[str, dict[Any, dict[str, Any]]] = {
        "kind": {str(kind): {"kind": kind} for kind in RunKind},
        "state": {str(state): {"state": state} for state in RunState},
    }
    for column in _NAMED_BY.keys() & columns:
        words = queries.words_by_uid(connection, column, _NAMED_BY[column])
        further = {uid: {"robot_uid": uid} if column == "robot" else {} for uid in words}
        found[column] = {uid: {column: word, **further[uid]} for uid, word in words.items()}
    if "condition" in columns:
        found["condition"] = {None: _NO_CONDITION, **condition_columns(connection)}
    return found


def _changes(
    entries: Sequence[EntryRow],
    links: Sequence[FileLink],
    charges: Mapping[str, ChargeOfRun],
    logs: Mapping[Part, SignalRow],
    file_of: Mapping[str, str | None],
) -> Iterator[tuple[EntryRow, Change]]:
    """Find what entries changed, from the last one to the first: columns, and the runs of charges and logs."""
    at: dict[str | Part, str] = {uid: row.run_uid for rows in (charges, logs) for uid, row in rows.items()}
    in_file: dict[str | None, list[str | Part]] = {}
    for uid in at:
        in_file.setdefault(file_of[uid] if isinstance(uid, str) else uid[0], []).append(uid)
    part_of, linked = {link.uid: link.part for link in links}, {link.part: link.run_uid for link in links}
    taken_off: set[Part] = set()

    def run_of(part: Part, said: Mapping[str, Any]) -> str:
        """Return the run of a part where an entry says those of its file, or the one of the file."""
        runs = said.get("runs", [said.get("run")])
        return (linked.get(part) if linked.get(part) in runs else next(iter(runs), None)) or NO_RUN

    for entry in reversed(entries):
        if entry.action not in _UNDONE:
            continue
        old, new, moved = entry.old, entry.new, dict[str | Part, tuple[str, str]]()
        if entry.kind in ("run", "charge"):
            names = _OF_RUNS if entry.kind == "run" else ("charge_mah", "mode") if entry.uid in charges else ()
            for name in (name for name in names if name in new):
                yield entry, Change(ChangeKind(entry.kind), entry.uid, name, old.get(name), new[name])
            if entry.kind == "charge" and "run" in new:
                moved = {entry.uid: (old.get("run") or NO_RUN, new["run"] or NO_RUN)}
        elif entry.kind == "run_file":
            # A link that is gone names no file: it was of one that was taken off the run that it led to.
            gone = [part for part in taken_off if at[part] == new["run"]]
            parts = [part_of[entry.uid]] if entry.uid in part_of else gone
            moved = {part: (old["run"], new["run"]) for part in parts if len({file_uid for file_uid, _ in parts}) == 1}
        elif entry.kind == "file":
            items = in_file.get(entry.uid, ())
            parts = [item for item in items if not isinstance(item, str) and new.get("part") in (None, item[1])]
            moved = {part: (run_of(part, old), run_of(part, new)) for part in parts}
            taken_off |= {part for part in parts if moved[part][0] != NO_RUN}
            had, has = old.get("charges", {}), new.get("charges", {})
            if entry.action is Action.ASSIGN and not old:  # the only charge of a file went with it
                has = {item: new["run"] for item in items if isinstance(item, str) and at[item] == new["run"]}
            moved |= {uid: (had.get(uid, NO_RUN), has.get(uid, NO_RUN)) for uid in {**had, **has}}
        for uid, (was, now) in moved.items():
            if uid in at and was != now:
                at[uid] = was
                kind = ChangeKind.CHARGE if isinstance(uid, str) else ChangeKind.LOG
                yield entry, Change(kind, uid, "run_uid", was, now)
