"""The journal's entries about runs, charges and files as changes of columns, and the rows that they led to."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import sqlalchemy as sa

from data_schema.queries import book_history as queries
from data_schema.queries.book_history import EntryRow, FileLink
from data_schema.queries.charges import ChargeOfRun, every_charge
from data_schema.queries.detections import jump_decisions
from data_schema.queries.runs import condition_columns, list_runs
from data_schema.queries.signals import SignalRow, signals_of_files
from data_schema.vocabulary import Action, FileRole, RunKind, RunState
from labbook.analysis.preregistration.book_state import NO_RUN, BookHistory, Change, ChangeKind, Part

_CHANGING = (Action.CORRECT, Action.VOID, Action.ASSIGN, Action.WITHDRAW, Action.RESTORE)
_OF_RUNS = ("kind", "state", "condition", "jumps_made", "starts", "duration_s", "day", "robot", "battery", "name",
            "position_in_day", "started_utc")  # fmt: skip
_NO_CONDITION: dict[str, Any] = {"condition_uid": None, "condition_key": "", "is_control": False, "levels": {}}


def read_history(connection: sa.Connection) -> BookHistory:
    """Read what the book's states follow from, in a few queries."""
    entries = queries.entries_about_runs(connection)
    files, links = queries.files_in_book(connection), queries.file_links(connection)
    sources = queries.files_of_charges(connection)
    run_of = {(link.file_uid, link.part): link.run_uid for link in links if files[link.file_uid].in_use}
    charges = {
        charge.uid: charge if sources[charge.uid][1] else replace(charge, run_uid=NO_RUN)
        for charge in every_charge(connection)
    }
    logs = {
        part: replace(signal, run_uid=run_of.get(part, NO_RUN))
        for part, signal in signals_of_files(connection, FileRole.LOG).items()
    }
    file_of = {uid: file_uid for uid, (file_uid, _) in sources.items()}
    changes = list(_changes(entries, links, charges, logs, file_of))
    read = queries.files_read(connection)
    seqs = {entry.uid: entry.seq for entry in entries if entry.action is Action.DECIDE}
    return BookHistory(
        runs={run.uid: run for run in list_runs(connection)},
        charges=charges,
        logs=logs,
        changes=changes,
        attributes=_attributes(connection, {change.column for _, change in changes}),
        since={
            read.get(entry.uid, entry.uid): entry
            for entry in entries
            if entry.action in (Action.DECLARE, Action.INGEST)
        },
        file_of=file_of,
        file_names={uid: file.name for uid, file in files.items()},
        reports=queries.reports_made(connection),
        verdicts={
            sha256: [(seqs[row.uid], row) for row in rows] for sha256, rows in jump_decisions(connection).items()
        },
        void=[entry for entry in entries if entry.action is Action.VOID],
    )


def _attributes(connection: sa.Connection, columns: set[str]) -> dict[str, dict[str | None, dict[str, Any]]]:
    """Read what the values of columns that changed stand for in a `RunRow`."""
    found: dict[str, dict[str | None, dict[str, Any]]] = {
        column: {str(word): {column: word} for word in words}
        for column, words in (("kind", RunKind), ("state", RunState))
    }
    for column, name in (("day", "date_local"), ("robot", "name"), ("battery", "name")):
        if column in columns:
            words = queries.words_by_uid(connection, column, name)
            found[column] = {uid: {column: word} for uid, word in words.items()}
    if "condition" in columns:
        found["condition"] = {None: _NO_CONDITION} | dict[str | None, dict[str, Any]](condition_columns(connection))
    for uid, robot in found.get("robot", {}).items():
        robot["robot_uid"] = uid
    return found


def _changes(
    entries: Sequence[EntryRow],
    links: Sequence[FileLink],
    charges: Mapping[str, ChargeOfRun],
    logs: Mapping[Part, SignalRow],
    file_of: Mapping[str, str | None],
) -> Iterator[tuple[EntryRow, Change]]:
    """Find what entries changed, from the last one to the first."""
    at: dict[str | Part, str] = {uid: row.run_uid for rows in (charges, logs) for uid, row in rows.items()}
    parts_of: dict[str, list[Part]] = {}
    for part in logs:
        parts_of.setdefault(part[0], []).append(part)
    part_of = {link.uid: (link.file_uid, link.part) for link in links}
    linked = {(link.file_uid, link.part): link.run_uid for link in links}
    taken_off: set[Part] = set()

    def one(runs: Sequence[str | None], part: Part) -> str:
        """Return the run of a part where an entry names those of its file."""
        run_uid = linked.get(part)
        return (run_uid if run_uid in runs else next(iter(runs), None)) or NO_RUN

    for entry in reversed(entries):
        if entry.action not in _CHANGING:
            continue
        old, new, moved = entry.old, entry.new, dict[str | Part, tuple[str, str]]()
        if entry.kind == "run":
            yield from (
                (entry, Change(ChangeKind.RUN, entry.uid, name, old.get(name), new[name]))
                for name in _OF_RUNS
                if name in new
            )
        elif entry.kind == "charge":
            yield from (
                (entry, Change(ChangeKind.CHARGE, entry.uid, name, old.get(name), new[name]))
                for name in ("charge_mah", "mode")
                if name in new and entry.uid in charges
            )
            moved = {entry.uid: (old.get("run") or NO_RUN, new["run"] or NO_RUN)} if "run" in new else {}
        elif entry.kind == "run_file":
            # A link that is gone names no file: it was of one that was taken off the run that it led to.
            gone = [part for part in taken_off if at[part] == new["run"]]
            parts = [part_of[entry.uid]] if entry.uid in part_of else gone
            moved = {part: (old["run"], new["run"]) for part in parts if len({file_uid for file_uid, _ in parts}) == 1}
        elif entry.kind == "file":
            runs = old.get("runs", [old.get("run")]), new.get("runs", [new.get("run")])
            parts = [part for part in parts_of.get(entry.uid, ()) if new.get("part") in (None, part[1])]
            moved = {part: (one(runs[0], part), one(runs[1], part)) for part in parts}
            taken_off |= {part for part in parts if moved[part][0] != NO_RUN}
            of_file = [old.get("charges", {}), new.get("charges", {})]
            moved |= {
                uid: (of_file[0].get(uid, NO_RUN), of_file[1].get(uid, NO_RUN)) for uid in {**of_file[0], **of_file[1]}
            }
            if entry.action is Action.ASSIGN and not old:  # a file's only charge goes with it
                moved |= {
                    uid: (NO_RUN, new["run"])
                    for uid, file_uid in file_of.items()
                    if file_uid == entry.uid and at[uid] == new["run"]
                }
        for uid, (was, now) in moved.items():
            if uid in at and was != now:
                at[uid] = was
                kind = ChangeKind.CHARGE if isinstance(uid, str) else ChangeKind.LOG
                yield entry, Change(kind, uid, "run_uid", was, now)
