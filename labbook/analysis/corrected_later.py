"""What was corrected after the first measurement of what an analysis rests on, and what that took out of it.

Only what differs in the end is told: who takes a correction back has changed nothing. A correction that leaves a run
without a number it would have had otherwise takes it out; one that keeps it in may well be right, and is told. A run
that was moved to another condition after a report had been made could have been moved to please, and both conditions
are exploratory.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import sqlalchemy as sa

from data_schema.queries.arrivals import reports_made
from data_schema.queries.changes import Change, changes_after, file_links, roles_and_names_of_files
from data_schema.queries.charges import ChargeOfRun, every_charge
from data_schema.queries.conditions import conditions_by_key
from data_schema.queries.facts import read_fact
from data_schema.queries.runs import RunRow
from data_schema.vocabulary import FileRole, RunKind, RunState
from labbook.analysis.departures import Analysable, Departure
from reports.numbers import Quantity

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
    connection: sa.Connection
    runs: Mapping[str, str]
    conditions: Mapping[str, str]

    def shown(self, column: str, value: Any) -> str:
        if value is None or value == "":
            return "none"
        if column in _NAMED_IN:
            (word,) = read_fact(self.connection, column, str(value), [_NAMED_IN[column]]).values()
            return str(word)
        known = {"run": self.runs, "condition": self.conditions}.get(column, {})
        return known.get(str(value), f"{value:g}" if isinstance(value, float) else str(value))


def corrected_later(connection: sa.Connection, first_seq: int, now: Analysable) -> list[Departure]:
    """List what was corrected after the entry of the first measurement."""
    changes = changes_after(connection, first_seq)
    if not changes:
        return []
    charges = every_charge(connection)
    names = _Names(
        connection,
        {run.uid: run.name for run in now.runs},
        {uid: key for key, uid in conditions_by_key(connection).items()},
    )
    changed = _columns(changes)
    before = _before(now, charges, changed, names)
    left = _logs_that_left(connection, changes)
    lost = _lost(now, before, {run for _name, run, _change in left})
    old_keys = {run.uid: run.condition_key for run in before.runs}
    run_of_charge = {item.uid: item.run_uid for item in charges}
    found = []
    reported = reports_made(connection)
    for item in changed:
        owners = (
            [item.uid]
            if item.kind == "run"
            else [run_of_charge[item.uid], *([item.was] if item.column == "run" else [])]
        )
        of = f"run {names.shown('run', item.uid)}" if item.kind == "run" else _charge_words(item, run_of_charge, names)
        was, is_now = names.shown(item.column, item.was), names.shown(item.column, item.now)
        told = _departure(
            f"{item.column} of {of} was {was} and is {is_now}", item.last, owners, _taken(item, lost), old_keys, now
        )
        if item.column == "condition" and not told.quantities and any(made < item.last.seq for made in reported):
            told = _moved(told, item.uid, (was, is_now), now)
        found.append(told)
    for name, run_uid, change in left:
        words = f"{name} was taken off run {names.shown('run', run_uid)}"
        heights = {uid: tuple(item for item in lost[uid] if item is Quantity.APEX) for uid in lost}
        found.append(_departure(words, change, [run_uid], heights, old_keys, now))
    return found


def _moved(told: Departure, run_uid: str, keys: tuple[str, str], now: Analysable) -> Departure:
    """Make exploratory what rests on both conditions of a run that was moved when a report had been made."""
    given = {quantity for run in now.runs if run.uid == run_uid for quantity in now.given(run)}
    quantities = tuple(item for item in Quantity if item in given)
    return Departure(f"{told.sentence}, after a report had been made", quantities, keys if quantities else None)


def _charge_words(item: _Changed, run_of_charge: Mapping[str, str], names: _Names) -> str:
    run = item.was if item.column == "run" else run_of_charge[item.uid]
    return "a charge" if item.column == "run" else f"the charge of run {names.shown('run', run)}"


def _columns(changes: Sequence[Change]) -> list[_Changed]:
    """Return each watched column whose value is another than at the first measurement."""
    found: dict[tuple[str, str, str], _Changed] = {}
    for change in changes:
        for column in _WATCHED.get(change.kind, ()):
            if column not in change.new or column not in change.old:
                continue  # an assignment of what belonged to no run yet
            key, said = (change.kind, change.uid, column), change.new[column]
            was = found[key].was if key in found else change.old[column]
            found[key] = _Changed(*key, was, said, change)
    return [item for item in found.values() if item.was != item.now]


def _before(now: Analysable, charges: Sequence[ChargeOfRun], changed: Sequence[_Changed], names: _Names) -> Analysable:
    """Return what would be there if nothing had been corrected; files apart."""
    values: dict[tuple[str, str], dict[str, Any]] = {}
    for item in changed:
        values.setdefault((item.kind, item.uid), {})[item.column] = item.was
    runs = tuple(_run_before(run, values.get(("run", run.uid), {}), names) for run in now.runs)
    by_run: dict[str, list[ChargeOfRun]] = {}
    for charge in charges:
        old = values.get(("charge", charge.uid), {})
        as_it_was = replace(
            charge,
            run_uid=old.get("run", charge.run_uid) or "",
            charge_mah=old.get("charge_mah", charge.charge_mah),
            mode=old.get("mode", charge.mode),
        )
        by_run.setdefault(as_it_was.run_uid, []).append(as_it_was)
    return Analysable(runs, by_run, now.logs)


def _run_before(run: RunRow, old: Mapping[str, Any], names: _Names) -> RunRow:
    values = {name: value for name, value in old.items() if name in ("jumps_made", "starts", "duration_s")}
    if "kind" in old:
        values["kind"] = RunKind(old["kind"])
    if "condition" in old:
        values |= {"condition_uid": old["condition"], "condition_key": names.conditions.get(old["condition"], "")}
    return replace(run, **values)


def _logs_that_left(connection: sa.Connection, changes: Sequence[Change]) -> list[tuple[str, str, Change]]:
    """Return the logs that a run had and has no more: (name, the run's uid, what took it off)."""
    links = file_links(connection)
    linked, file_of = {(link.file_uid, link.run_uid) for link in links}, {link.uid: link.file_uid for link in links}
    known = roles_and_names_of_files(connection)
    found: dict[tuple[str, str], tuple[str, str, Change]] = {}
    for change in changes:
        if change.kind not in ("file", "run_file"):
            continue
        file_uid = change.uid if change.kind == "file" else file_of.get(change.uid, "")
        # A link that is gone names no file any more: what it was is not known, that it was taken off is.
        role, name = known.get(file_uid, (str(FileRole.LOG), "a file"))
        if role != FileRole.LOG:
            continue
        for run_uid in change.old.get("runs", [change.old["run"]] if change.old.get("run") else []):
            if (file_uid, run_uid) not in linked:
                found[file_uid or change.uid, run_uid] = (name, run_uid, change)
    return list(found.values())


def _lost(now: Analysable, before: Analysable, without_log: set[str]) -> dict[str, tuple[Quantity, ...]]:
    """Return what runs that count would give as they were before and do not give now, by the run's uid."""
    found = {}
    for run, was in zip(now.runs, before.runs, strict=True):
        if run.state is RunState.VOID:
            continue  # told as what was left out
        had = before.given(was) | ({Quantity.APEX} if run.uid in without_log and was.kind is RunKind.JUMPS else set())
        has = now.given(run) if run.kind is was.kind else frozenset()
        found[run.uid] = tuple(item for item in Quantity if item in had - has)
    return found


def _taken(item: _Changed, lost: Mapping[str, tuple[Quantity, ...]]) -> dict[str, tuple[Quantity, ...]]:
    """Return of what runs lost the part that a change of this column can have taken."""
    joules_gone = item.column in ("run", "mode") or (item.column in ("jumps_made", "duration_s") and not item.now)
    can = {
        Quantity.JOULES: joules_gone or item.column == "kind",
        Quantity.APEX: item.column in ("kind", "starts"),
    }
    return {uid: tuple(quantity for quantity in quantities if can[quantity]) for uid, quantities in lost.items()}


def _departure(
    words: str,
    last: Change,
    owners: Sequence[str],
    lost: Mapping[str, tuple[Quantity, ...]],
    old_keys: Mapping[str, str],
    now: Analysable,
) -> Departure:
    """Tell a correction; where a run that it is about lost numbers, its comparisons are exploratory."""
    said = f"corrected after the first measurement: {words} ({last.person}, {last.at_utc[:10]})"
    out = [run for run in now.runs if run.uid in owners and lost.get(run.uid)]
    if not out:
        return Departure(said)
    quantities = tuple(item for item in Quantity if any(item in lost[run.uid] for run in out))
    listed = " and ".join(map(str, quantities))
    keys = tuple(old_keys[run.uid] for run in out)
    return Departure(
        f"{said}, which leaves run {', '.join(run.name for run in out)} without {listed}",
        quantities,
        keys if all(keys) else None,  # an idle run has no condition, and all joules rest on it
    )
