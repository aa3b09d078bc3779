"""The state of the book at any entry of its journal, and what differs between two states.

The journal does not repeat what the instruments' files hold. So a state is the book as it is now with the later entries
undone, the last one first; no raw file is read. A file that was read again has its last samples and charges throughout.

The journal's entries about runs, charges and files as changes of columns, and the rows that they led to.
"""

from __future__ import annotations

import sys
from bisect import bisect
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
from functools import cache
from math import inf
from typing import Any, TypeVar

import sqlalchemy as sa

from data_schema.grouping import grouped
from data_schema.outcomes import Outcome
from data_schema.queries import history as queries
from data_schema.queries.charges import ChargeOfRun, every_charge
from data_schema.queries.detections import DecisionRow, jump_decisions
from data_schema.queries.history import EntryRow, FileLink
from data_schema.queries.runs import RunRow, condition_columns, list_runs
from data_schema.queries.signals import SignalRow, signals_of_files
from data_schema.vocabulary import Action, ChargeMode, FileRole, RunKind, RunState, Undefined, Verdict
from labbook.analysis.outcomes.run_apexes import UNKNOWN_FLIGHT_S, usable_logs
from labbook.analysis.outcomes.run_energy import recharge_of, usable_charge
from labbook.analysis.outcomes.run_force import usable_force
from labbook.analysis.study_data import records

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
    file_read = {uid: file_uid for uid, file_uid, _ in readings}
    came = [entry for entry in entries if entry.makes and (entry.uid in file_read or entry.kind in ("run", "charge"))]
    seqs = {entry.uid: entry.seq for entry in entries if entry.kind == "decision"}
    verdicts = {  # one that is being recorded has no entry yet
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
        void=[entry for entry in entries if entry.kind == "run" and entry.action is Action.EXCLUDE],
    )


def _attributes(connection: sa.Connection, columns: Collection[str]) -> dict[str, dict[Any, dict[str, Any]]]:
    """Read which attributes of a `RunRow` each value of a changed column stands for."""
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
    in_file = grouped(at, [file_of[uid] if isinstance(uid, str) else uid[0] for uid in at])
    partial_path, linked = {link.uid: link.part for link in links}, {link.part: link.run_uid for link in links}
    taken_off: set[Part] = set()
    parts_of_charges = {uid for uid, row in charges.items() if row.added}

    def run_of(part: Part, values: Mapping[str, Any]) -> str:
        """Return the run of a part where an entry names the runs of its file, or the one run of the file."""
        runs = values.get("runs", [values.get("run")])
        return (linked.get(part) if linked.get(part) in runs else next(iter(runs), None)) or NO_RUN

    for entry in reversed(entries):
        if entry.makes:
            continue
        old, new, moved = entry.old, entry.new, dict[str | Part, tuple[str, str]]()
        if entry.kind in ("run", "charge"):
            names = _OF_RUNS if entry.kind == "run" else ("charge_mah", "mode", "added") if entry.uid in charges else ()
            for name in (name for name in names if name in new):
                yield entry, Change(ChangeKind(entry.kind), entry.uid, name, old.get(name), new[name])
            if entry.kind == "charge" and "run" in new:
                moved = {entry.uid: (old.get("run") or NO_RUN, new["run"] or NO_RUN)}
                parts_of_charges = parts_of_charges - {entry.uid} | ({entry.uid} if old.get("added") else set())
        elif entry.kind == "run_file":
            # A link that is gone names no file: it was of one that was taken off the run that it led to.
            gone = [part for part in taken_off if at[part] == new["run"]]
            parts = [partial_path[entry.uid]] if entry.uid in partial_path else gone
            moved = {part: (old["run"], new["run"]) for part in parts if len({file_uid for file_uid, _ in parts}) == 1}
        elif entry.kind == "file":
            items = in_file.get(entry.uid, ())
            parts = [item for item in items if not isinstance(item, str) and new.get("part") in (None, item[1])]
            moved = {part: (run_of(part, old), run_of(part, new)) for part in parts}
            taken_off |= {part for part in parts if moved[part][0] != NO_RUN}
            had, has = old.get("charges", {}), new.get("charges", {})
            if entry.action is Action.SET and not old.get("runs"):  # the only charge of a file went with it
                has = {item: new["run"] for item in items if isinstance(item, str) and at[item] == new["run"]}
            moved |= {uid: (had.get(uid, NO_RUN), has.get(uid, NO_RUN)) for uid in {**had, **has}}
        back = {was for uid, (was, _now) in moved.items() if uid in charges and uid not in parts_of_charges} - {NO_RUN}
        for uid, run in at.items() if back else ():  # a run has one charge: this one stepped in for that which left
            if run in back and uid in charges and uid not in moved and uid not in parts_of_charges:
                moved[uid] = (NO_RUN, run)
        for uid, (was, now) in moved.items():
            if uid in at and was != now:
                at[uid] = was
                kind = ChangeKind.CHARGE if isinstance(uid, str) else ChangeKind.LOG
                yield entry, Change(kind, uid, "run_uid", was, now)


NO_RUN = ""
"""Stands for the uid of a run where a charge or a log belongs to none."""
Part = tuple[str, str]
"""What a log is, of heights or of forces: the uid of a file, and the name of a part of it."""


_Item = TypeVar("_Item", ChargeOfRun, SignalRow)


class ChangeKind(StrEnum):
    """What changed."""

    RUN = "run"
    CHARGE = "charge"
    LOG = "log"
    EXCLUSION = "exclusion"


@dataclass(frozen=True, slots=True)
class Change:
    """A column that says otherwise in a later state, or from an entry on.

    `uid` is that of a run or a charge, or the part that a log is. "run_uid" of the latter two is `NO_RUN` for none. The
    column of an exclusion is its reason, and None stands where it was not made.
    """

    kind: ChangeKind
    uid: str | Part
    column: str
    was: Any
    now: Any

    @property
    def item(self) -> str:
        """The uid of the run, the charge, or the file of the log."""
        return self.uid if isinstance(self.uid, str) else self.uid[0]


@dataclass(frozen=True, slots=True)
class BookState:
    """What the book held at one entry: runs and charges by uid, logs by part, and which of these belong to each run.

    `exclusions` are the jumps rejected, by the run's uid and the reason; 0 where the run is void for it.
    """

    runs: Mapping[str, RunRow]
    charges: Mapping[str, ChargeOfRun]
    logs: Mapping[Part, SignalRow]
    charges_of: Mapping[str, Sequence[str]]
    logs_of: Mapping[str, Sequence[Part]]
    exclusions: Mapping[tuple[str, str], int]
    given_before: dict[tuple[str, bool], frozenset[Outcome]] = field(
        init=False, default_factory=dict, compare=False, repr=False
    )
    """What `given` has found, which is asked for again and again."""

    def has(self, run_uid: str, item: str) -> bool:
        """Tell whether a charge, or the file of a log, belongs to a run."""
        return item in self.charges_of.get(run_uid, ()) or any(uid == item for uid, _ in self.logs_of.get(run_uid, ()))

    def contents(self, run_uid: str, source: FileRole) -> dict[str, frozenset[Any]]:
        """Return what a run's number comes from: the mAh of charges, or the samples' hashes by files with logs.

        A file all of whose samples are in those before it is left out.
        """
        if source is FileRole.CHARGE:
            charges = [self.charges[uid] for uid in self.charges_of.get(run_uid, ())]
            return {item.uid: frozenset([item.charge_mah]) for item in charges if item.mode == ChargeMode.CHARGE}
        samples: dict[str, set[str]] = {}
        for part in self.logs_of.get(run_uid, ()):
            if records(self.logs[part], source):
                samples.setdefault(part[0], set()).add(self.logs[part].sha256)
        found: dict[str, frozenset[str]] = {}
        for file_uid, some in samples.items():
            found |= {file_uid: frozenset(some)} if some.difference(*found.values()) else {}
        return found

    def most(self, run_uid: str, source: FileRole) -> int:
        """Return how many charges, or files with logs, a run can have and still give a number; charges are added up."""
        if source is FileRole.CHARGE:
            return sys.maxsize
        return max(self.runs[run_uid].starts, 1) if source is FileRole.LOG else 1

    def given(self, run_uid: str, *, surplus: bool = True) -> frozenset[Outcome]:
        """Return the outcomes that have a number from a run; an idle run gives to those that share its error.

        Without `surplus`, charges and logs that are more than a run can have do not take its number away.
        """
        asked = run_uid, surplus
        if asked not in self.given_before:
            self.given_before[asked] = self._given(run_uid, surplus=surplus)
        return self.given_before[asked]

    def _given(self, run_uid: str, *, surplus: bool) -> frozenset[Outcome]:
        run = self.runs[run_uid]
        if run.state is RunState.VOID:
            return frozenset()

        def few(source: FileRole) -> list[str]:
            return list(self.contents(run_uid, source))[: None if surplus else self.most(run_uid, source)]

        def signals(source: FileRole) -> list[SignalRow]:
            files = few(source)
            logs = {part: self.logs[part] for part in self.logs_of[run_uid] if part[0] in files}
            return [log for log in logs.values() if records(log, source)]

        charges = [self.charges[uid] for uid in few(FileRole.CHARGE)]
        if run.kind is RunKind.IDLE:
            return frozenset() if isinstance(recharge_of(run, charges), Undefined) else _sharing_errors()
        usable: dict[FileRole, object] = {FileRole.CHARGE: usable_charge(run, charges)}
        if run_uid in self.logs_of:
            usable[FileRole.LOG] = usable_logs(run, signals(FileRole.LOG))
            usable[FileRole.FORCE] = usable_force(signals(FileRole.FORCE))
        return _outcomes_of(*(source for source, found in usable.items() if not isinstance(found, Undefined)))


@cache  # a set that many runs share
def _outcomes_of(*sources: FileRole) -> frozenset[Outcome]:
    return frozenset(outcome for outcome in Outcome if outcome.source in sources)


@cache
def _sharing_errors() -> frozenset[Outcome]:
    return frozenset(outcome for outcome in Outcome if outcome.shares_error)


_COLUMNS: Mapping[ChangeKind, Sequence[str]] = {
    ChangeKind.RUN: ("kind", "condition_key", "jumps_made", "starts", "duration_s", "day", "robot", "battery"),
    ChangeKind.CHARGE: ("run_uid", "charge_mah", "mode"),
    ChangeKind.LOG: ("run_uid",),
}


def difference(before: BookState, after: BookState) -> list[Change]:
    """Return what of runs, charges and logs that both states have is otherwise in the later one, and the exclusions."""
    rows: Sequence[tuple[ChangeKind, Mapping[Any, Any], Mapping[Any, Any]]] = (
        (ChangeKind.RUN, before.runs, after.runs),
        (ChangeKind.CHARGE, before.charges, after.charges),
        (ChangeKind.LOG, before.logs, after.logs),
    )
    found = [
        Change(kind, uid, column, was, now)
        for kind, old, new in rows
        for uid, row in new.items()
        if uid in old and old[uid] is not row
        for column in _COLUMNS[kind]
        for was, now in [(getattr(old[uid], column), getattr(row, column))]
        if was != now
    ]
    return found + [
        Change(ChangeKind.EXCLUSION, run_uid, reason, was, now)
        for run_uid, reason in {**before.exclusions, **after.exclusions}
        for was, now in [[state.exclusions.get((run_uid, reason)) for state in (before, after)]]
        if was != now
    ]


@dataclass(frozen=True, slots=True)
class BookHistory:
    """The book as it is now, and what led to it.

    `runs`, `charges` and `logs` go by their own uids; what does not count belongs to no run. `changes` are what entries
    changed, the last one first, columns by the journal's names; `attributes` are what references of runs stand for, by
    column and uid. `since` has the entry that a run, a typed charge or a file came with, `file_of` the file of each
    charge, `file_names` its name; `reports` the numbers of the entries of reports, `verdicts` those on jumps with the
    numbers of theirs, by the samples' hash, and `void` the entries that made runs void.
    """

    runs: Mapping[str, RunRow]
    charges: Mapping[str, ChargeOfRun]
    logs: Mapping[Part, SignalRow]
    changes: Sequence[tuple[EntryRow, Change]]
    attributes: Mapping[str, Mapping[Any, Mapping[str, Any]]]
    since: Mapping[str, EntryRow]
    file_of: Mapping[str, str | None]
    file_names: Mapping[str, str]
    reports: Sequence[int]
    verdicts: Mapping[str, Sequence[tuple[float, DecisionRow]]]
    void: Sequence[EntryRow]

    def entry_of(self, item: str) -> EntryRow | None:
        """Return the entry that brought a run, a charge or a file into the book; None where the book does not say."""
        return self.since.get(self.file_of.get(item) or item)


def state_at(history: BookHistory, seq: int | None = None, *, arrivals: bool = True) -> BookState:
    """Return what the book held at an entry, now without one.

    Where `arrivals` are not undone, what came later is there as it was first recorded: runs, charges and logs with the
    run that they were first given to.
    """
    runs, charges, logs = dict(history.runs), dict(history.charges), dict(history.logs)
    rows: Mapping[ChangeKind, dict[Any, Any]] = dict(zip(ChangeKind, (runs, charges, logs), strict=False))
    for entry, change in history.changes:
        if seq is None or entry.seq <= seq:
            break
        if arrivals or change.was != NO_RUN:
            values = history.attributes.get(change.column, {}).get(change.was, {change.column: change.was})
            rows[change.kind][change.uid] = replace(rows[change.kind][change.uid], **values)
    if seq is not None and arrivals:
        later = {uid for uid, entry in history.since.items() if entry.seq > seq}
        runs = {uid: run for uid, run in runs.items() if uid not in later}
        charges = {uid: _at(item, later) for uid, item in charges.items() if not later & {uid, history.file_of[uid]}}
        logs = {part: _at(log, later) for part, log in logs.items() if part[0] not in later}
    charges_of = grouped(charges, [charge.run_uid for charge in charges.values()])
    logs_of = grouped(logs, [log.run_uid for log in logs.values()])
    return BookState(runs, charges, logs, charges_of, logs_of, _exclusions(history, seq, runs, logs))


def reported_states(history: BookHistory) -> dict[int, BookState]:
    """Return what the book held at its reports by their entries' numbers; of those that saw the same, at the last."""
    seqs = sorted([*(entry.seq for entry, _ in history.changes), *(entry.seq for entry in history.since.values())])
    same = {bisect(seqs, seq): seq for seq in history.reports}
    return {seq: state_at(history, seq) for seq in same.values()}


def _at(item: _Item, later: Collection[str]) -> _Item:
    return replace(item, run_uid=NO_RUN) if item.run_uid in later else item


def _exclusions(
    history: BookHistory, seq: int | None, runs: Mapping[str, RunRow], logs: Mapping[Part, SignalRow]
) -> dict[tuple[str, str], int]:
    reasons = {entry.uid: entry.reason or "" for entry in history.void if seq is None or entry.seq <= seq}
    found = {(uid, reason): 0 for uid, reason in reasons.items() if uid in runs and runs[uid].state is RunState.VOID}
    for log in logs.values():
        if log.sha256 in history.verdicts and log.run_uid in runs and runs[log.run_uid].state is not RunState.VOID:
            verdicts_on_log = [item for made, item in history.verdicts[log.sha256] if seq is None or made <= seq]
            for verdict in in_force(verdicts_on_log):
                if verdict.verdict is Verdict.REJECT:
                    key = log.run_uid, str(verdict.reason_code)
                    found[key] = found.get(key, 0) + 1
    return found


def in_force(decisions: Sequence[DecisionRow]) -> list[DecisionRow]:
    """Return the verdicts on one signal that stand: a later one about the same moment replaces an earlier one."""
    found: list[DecisionRow] = []
    for decision in decisions:
        found = [item for item in found if abs(item.anchor_s - decision.anchor_s) > UNKNOWN_FLIGHT_S / 2.0]
        found.append(decision)
    return found
