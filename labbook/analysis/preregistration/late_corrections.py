"""What was corrected after the first measurement of what an analysis rests on, and what that took out of it.

Only what differs in the end is told: who takes a correction back has changed nothing. A correction that leaves a run
without a number it would have had otherwise takes it out; one that keeps it in may well be right, and is told. What
differs from what a report saw is told by `moved_later` and `replaced_later`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import sqlalchemy as sa

from data_schema.outcomes import Outcome
from data_schema.queries.changes import Change, words_by_uid
from data_schema.queries.charges import ChargeOfRun
from data_schema.queries.conditions import conditions_by_key
from data_schema.queries.runs import RunRow
from data_schema.vocabulary import RunKind, RunState
from labbook.analysis.preregistration.departures import Analysable, Departure
from labbook.analysis.preregistration.late_replacements import replacements
from labbook.analysis.preregistration.moved_runs import conditions_at_reports
from labbook.analysis.preregistration.study_history import StudyHistory
from labbook.analysis.preregistration.unassigned_logs import UnassignedLog, unassigned_logs

_WATCHED: Mapping[str, tuple[str, ...]] = {
    "run": ("kind", "condition", "jumps_made", "starts", "duration_s", "day", "robot", "battery"),
    "charge": ("run", "charge_mah", "mode"),
}
_NAMED_IN: Mapping[str, str] = {"day": "date_local", "robot": "name", "battery": "name"}
"""Columns that refer to another row, and which column of that says what it is."""


@dataclass(frozen=True, slots=True)
class _Changed:
    """A column that says otherwise in the end: what it said at the first measurement, and who changed it last."""

    kind: str
    uid: str
    column: str
    was: Any
    now: Any
    last: Change


@dataclass(frozen=True, slots=True)
class _Names:
    """What is shown for a uid, by the column that holds it."""

    words: Mapping[str, Mapping[str, str]]

    def shown(self, column: str, value: Any) -> str:
        if value is None or value == "":
            return "none"
        known = self.words.get(column, {})
        return known.get(str(value), f"{value:g}" if isinstance(value, float) else str(value))


def late_corrections(connection: sa.Connection, study_history: StudyHistory, now: Analysable) -> list[Departure]:
    """List what was corrected after the entry of the first measurement."""
    if not study_history.changes:
        return []
    changed = _columns(study_history.changes)
    names = _names(connection, changed, now)
    left = unassigned_logs(connection, study_history)
    before = _before(now, study_history, changed, left, names)
    lost = _lost(now, before, {item.run for item in left})
    old_keys = {run.uid: run.condition_key for run in before.runs}
    missing = replacements(study_history, now)
    told = {(arrival.uid, item.run.uid) for item in missing for arrival in item.gone if item.came}
    seen = {(arrival.uid, item.run.uid) for item in missing for arrival in item.gone if not item.came}
    moved = conditions_at_reports(study_history, now)
    found = []
    for item in changed:
        if (item.column == "condition" and item.uid in moved) or (
            item.column == "run" and not item.now and (item.uid, item.was) in told
        ):
            continue
        owners, of = _owners(item, study_history.charges), _of(item, study_history.charges, names)
        was, is_now = names.shown(item.column, item.was), names.shown(item.column, item.now)
        said = f"{item.column} of {of} was {was} and is {is_now}"
        found.append(_departure(said, item.last, owners, _taken(item, lost), old_keys, now))
    for gone in left:
        if gone.to is None and (gone.file_uid, gone.run) in told:
            continue
        given = "" if gone.to is None else f" and given to run {names.shown('run', gone.to)}"
        words = f"{gone.name} was taken off run {names.shown('run', gone.run)}{given}"
        heights = {uid: tuple(item for item in lost[uid] if item is Outcome.APEX) for uid in lost}
        owners = [gone.run] if gone.to is None else [gone.run, gone.to]
        departure = _departure(words, gone.change, owners, heights, old_keys, now)
        if (gone.file_uid, gone.run) in seen:
            departure = _of_fewer_logs(departure, gone, now)
        found.append(departure)
    return found


def _of_fewer_logs(told: Departure, gone: UnassignedLog, now: Analysable) -> Departure:
    """Make exploratory what rests on a run that keeps some of the logs that it had when a report was made."""
    (run,) = [run for run in now.runs if run.uid == gone.run]
    said = f"{told.sentence}, after a report had been made: run {run.name} keeps its other logs"
    return Departure(said, (Outcome.APEX,), (*(told.conditions or ()), run.condition_key))


def _names(connection: sa.Connection, changed: Sequence[_Changed], now: Analysable) -> _Names:
    """Read the words for the columns that changed, each once."""
    columns = {item.column for item in changed}
    words = {column: words_by_uid(connection, column, name) for column, name in _NAMED_IN.items() if column in columns}
    words["condition"] = {uid: key for key, uid in conditions_by_key(connection).items()}
    return _Names(words | {"run": {run.uid: run.name for run in now.runs}})


def _owners(item: _Changed, charges: Mapping[str, ChargeOfRun]) -> list[str]:
    """Return the runs that a changed column is about."""
    if item.kind == "run":
        return [item.uid]
    return [charges[item.uid].run_uid, *([item.was] if item.column == "run" else [])]


def _of(item: _Changed, charges: Mapping[str, ChargeOfRun], names: _Names) -> str:
    if item.kind == "run":
        return f"run {names.shown('run', item.uid)}"
    return "a charge" if item.column == "run" else f"the charge of run {names.shown('run', charges[item.uid].run_uid)}"


def _columns(changes: Sequence[Change]) -> list[_Changed]:
    """Return each watched column whose value is another than at the first measurement."""
    found: dict[tuple[str, str, str], _Changed] = {}
    for change in changes:
        for column in _WATCHED.get(change.kind, ()):
            key = (change.kind, change.uid, column)
            if column not in change.new or (column not in change.old and key not in found):
                continue  # an assignment of what belonged to no run yet
            said = change.new[column]
            was = found[key].was if key in found else change.old[column]
            found[key] = _Changed(*key, was, said, change)
    return [item for item in found.values() if item.was != item.now]


def _before(
    now: Analysable,
    study_history: StudyHistory,
    changed: Sequence[_Changed],
    left: Sequence[UnassignedLog],
    names: _Names,
) -> Analysable:
    """Return what would be there if nothing had been corrected, less the logs that runs lost."""
    values: dict[tuple[str, str], dict[str, Any]] = {}
    for item in changed:
        values.setdefault((item.kind, item.uid), {})[item.column] = item.was
    runs = tuple(_run_before(run, values.get(("run", run.uid), {}), names) for run in now.runs)
    by_run: dict[str, list[ChargeOfRun]] = {}
    for charge in study_history.charges.values():
        old = values.get(("charge", charge.uid), {})
        as_it_was = replace(
            charge,
            run_uid=old.get("run", charge.run_uid) or "",
            charge_mah=old.get("charge_mah", charge.charge_mah),
            mode=old.get("mode", charge.mode),
        )
        by_run.setdefault(as_it_was.run_uid, []).append(as_it_was)
    given = {(item.to, sample) for item in left for sample in study_history.heights.get(item.file_uid, ())}
    logs = {uid: [log for log in logs if (uid, log.sha256) not in given] for uid, logs in now.logs.items()}
    return Analysable(runs, by_run, logs)


def _run_before(run: RunRow, old: Mapping[str, Any], names: _Names) -> RunRow:
    values = {name: value for name, value in old.items() if name in ("jumps_made", "starts", "duration_s")}
    if "kind" in old:
        values["kind"] = RunKind(old["kind"])
    if "condition" in old:
        values |= {
            "condition_uid": old["condition"],
            "condition_key": names.words["condition"].get(old["condition"], ""),
        }
    return replace(run, **values)


def _lost(now: Analysable, before: Analysable, without_log: set[str]) -> dict[str, tuple[Outcome, ...]]:
    """Return what runs that count would give as they were before and do not give now, by the run's uid."""
    found = {}
    for run, was in zip(now.runs, before.runs, strict=True):
        if run.state is RunState.VOID:
            continue  # told as what was left out
        had = before.given(was) | ({Outcome.APEX} if run.uid in without_log and was.kind is RunKind.JUMPS else set())
        has = now.given(run) if run.kind is was.kind else frozenset()
        found[run.uid] = tuple(item for item in Outcome if item in had - has)
    return found


def _taken(item: _Changed, lost: Mapping[str, tuple[Outcome, ...]]) -> dict[str, tuple[Outcome, ...]]:
    """Return of what runs lost the part that a change of this column can have taken."""
    joules_gone = item.column in ("run", "mode") or (item.column in ("jumps_made", "duration_s") and not item.now)
    can = {
        Outcome.JOULES: joules_gone or item.column == "kind",
        Outcome.APEX: item.column in ("kind", "starts"),
    }
    return {uid: tuple(quantity for quantity in quantities if can[quantity]) for uid, quantities in lost.items()}


def _departure(
    words: str,
    last: Change,
    owners: Sequence[str],
    lost: Mapping[str, tuple[Outcome, ...]],
    old_keys: Mapping[str, str],
    now: Analysable,
) -> Departure:
    """Tell a correction; where a run that it is about lost numbers, its comparisons are exploratory."""
    said = f"corrected after the first measurement: {words} ({last.person}, {last.at_utc[:10]})"
    out = [run for run in now.runs if run.uid in owners and lost.get(run.uid)]
    if not out:
        return Departure(said)
    quantities = tuple(item for item in Outcome if any(item in lost[run.uid] for run in out))
    listed = " and ".join(map(str, quantities))
    keys = tuple(old_keys[run.uid] for run in out)
    return Departure(
        f"{said}, which leaves run {', '.join(run.name for run in out)} without {listed}",
        quantities,
        keys if all(keys) else None,  # an idle run has no condition, and all joules rest on it
    )
