"""Which charge of a run counts: `places`, one function of all rows about the run, and what it finds in them.

A run has one charge, and what a person added to it where the pack was charged in parts. The last one that a person
gave to it comes first, else the first that came and names it. A row that says the same as one before it is known and
counts nowhere; one that differs waits in the inbox. Whatever is said of a charge, or of its sheet, `settle` applies the
function anew: nothing is remembered from the time before.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import sqlalchemy as sa

from data_schema.journal import Entry, canonical
from data_schema.queries.charges import SheetRow, assignments_to, rows_about, rows_with_uids
from data_schema.queries.facts import fact_exists, find_uid, read_fact, update_fact
from data_schema.vocabulary import Action, ChargeMode, ChargeState
from labbook.statements.apply_context import ApplyContext, missing_row


@dataclass(frozen=True, slots=True)
class Place:
    """Where a charge stands: its state, the run that it counts for, and the charge that it repeats or contradicts."""

    row: SheetRow
    state: ChargeState
    run: str | None = None
    other: SheetRow | None = None

    @property
    def columns(self) -> dict[str, Any]:
        """The place as the table of charges takes it."""
        repeats = self.other.uid if self.other is not None and self.state is ChargeState.KNOWN else None
        return {"state": str(self.state), "run": self.run, "repeats": repeats}


def places(rows: Sequence[SheetRow], run: str | None) -> dict[str, Place]:
    """Place the rows that name one run, or a name that no run has, and those that a person gave to that run.

    They go by the order in which they came. Rows that were given to another run are placed with those of that one, and
    may be repeated here all the same, as those that a person took off or dismissed.
    """
    found: dict[str, Place] = {}
    counting: list[SheetRow] = []  # but for what was added
    standing: list[SheetRow] = []  # what others may repeat
    given = [row for row in rows if row.assigned_run is not None and row.assigned_run == run and not row.dismissed]
    for row in sorted(given, key=lambda row: -row.assigned):
        rival = None if row.added else next((other for other in counting if _second(row, other)), None)
        found[row.uid] = Place(row, ChargeState.COUNTED, run if rival is None else None, rival)
        standing.append(row)
        counting += [] if row.added or rival is not None else [row]
    for row in rows:
        if row.dismissed or (row.assigned and row.assigned_run is None):
            found[row.uid] = Place(row, ChargeState.DISMISSED if row.dismissed else ChargeState.COUNTED)
        standing += [row] if (row.dismissed or row.assigned) and row not in given else []
    by_sheets = [row for row in rows if not (row.assigned or row.dismissed)]
    for row in sorted(by_sheets, key=lambda row: _rank(row, rows)):
        # What was added to a charge is repeated only where that is there: else the row may be the one it was added to.
        repeatable = (other for other in standing if counting or not (other.added and other.assigned_run == run))
        same = next((other for other in repeatable if same_charge(row, other) or _said_before(row, other)), None)
        if same is not None:
            found[row.uid] = Place(row, ChargeState.KNOWN, None, same)
            continue
        rival = counting[0] if counting else None
        found[row.uid] = Place(row, ChargeState.COUNTED, run if rival is None else None, rival)
        standing.append(row)
        counting += [] if run is None or rival is not None else [row]
    return found


def _rank(row: SheetRow, rows: Iterable[SheetRow]) -> tuple[int, bool, int]:
    """Order rows as they came; one that a person corrected comes before those of other sheets that said the same."""
    same = (other.order for other in rows if _said_before(other, row))
    return min([row.order, *same]), not row.corrected, row.order


def _second(row: SheetRow, other: SheetRow) -> bool:
    """Tell whether a person who gives one to the run of the other would be refused: a discharge is no second charge."""
    return row.mode == other.mode == ChargeMode.CHARGE


COMPARED = ("charge_mah", "end_voltage_v", "mode")
_ROUNDING = 1e-12


def same_charge(row: SheetRow, other: SheetRow) -> bool:
    """Tell whether two rows have the same charge, mode and end voltage, which may be missing in one of them."""
    voltages = (row.end_voltage_v, other.end_voltage_v)
    voltages_agree = None in voltages or same_value(*voltages)
    return same_value(row.charge_mah, other.charge_mah) and row.mode == other.mode and voltages_agree


def _said_before(row: SheetRow, other: SheetRow) -> bool:
    """Tell whether a row says what one of another sheet said before a person corrected it."""
    read = {name: other.corrected[name][0] for name in COMPARED if name in other.corrected}
    of_other_sheet = row.file_uid is not None and other.file_uid not in (None, row.file_uid)
    return bool(read) and of_other_sheet and same_charge(row, replace(other, **read))


def same_value(value: Any, other: Any) -> bool:
    """Tell whether two values are the same but for rounding: 0.0561 Ah is read as 56.099999999999994 mAh."""
    if isinstance(value, float) and isinstance(other, float):
        return math.isclose(value, other, rel_tol=_ROUNDING)
    return bool(value == other)


def settle(connection: sa.Connection, uids: Sequence[str], before: Sequence[SheetRow] = ()) -> dict[str, Place]:
    """Place anew all charges about the runs that these concern, as they were `before` and as they are; returns them."""
    changed = rows_with_uids(connection, uids)
    placed = placed_about(connection, changed, before)
    for uid, place in placed.items():
        stands = {"state": str(place.row.state), "run": place.row.run_uid, "repeats": place.row.repeats}
        if stands != place.columns:
            update_fact(connection, "charge", uid, place.columns)
    return placed


def placed_about(
    connection: sa.Connection, changed: Sequence[SheetRow], before: Sequence[SheetRow] = (), *, in_book: bool = True
) -> dict[str, Place]:
    """Place all charges about the runs and names that these concern; those `changed` come last if not `in_book` yet."""
    concerned = [*before, *changed]
    runs = sorted({run for row in concerned for run in (row.named_run, row.assigned_run) if run is not None})
    names = sorted({row.stated_run for row in concerned if row.named_run is None and row.stated_run is not None})
    groups: dict[tuple[str | None, str | None], list[SheetRow]] = {}
    for row in [*rows_about(connection, runs, names), *(() if in_book else changed)]:
        named = (row.named_run, None if row.named_run else row.stated_run)
        for group in {named, (row.assigned_run, None)}:
            groups.setdefault(group, []).append(row)
    placed: dict[str, Place] = {}
    for group in [*((run, None) for run in runs), *((None, name) for name in names)]:
        placed |= places(groups.get(group, ()), group[0])
    for row in changed:  # one that names no run is alone
        if row.uid not in placed and row.state is not ChargeState.GONE:
            placed |= places([row], None)
    return placed


def apply_to_charge(context: ApplyContext, entry: Entry, _prepared: object = None) -> None:
    """Let what a person said of a charge take effect."""
    if fact_exists(context.connection, "charge", entry.entity_uid):
        state_of_charge(context.connection, entry.entity_uid, entry.new or {}, entry.action)
    else:
        missing_row(context, entry)


def state_of_charge(connection: sa.Connection, uid: str, new: Mapping[str, Any], action: Action = Action.SET) -> None:
    """Write down what a person said of a charge, and place anew what it concerns."""
    before = rows_with_uids(connection, [uid])
    write_statement(connection, uid, new, action)
    settle(connection, [uid], before)


def write_statement(connection: sa.Connection, uid: str, new: Mapping[str, Any], action: Action) -> None:
    """Write down what a person said of a charge: that it is dismissed or not, its run, or values that are right."""
    values: dict[str, Any] = {}
    if action is not Action.SET:
        values["dismissed"] = int(action is Action.EXCLUDE)
    if right := {name: new[name] for name in new if name not in ("run", "added")}:
        stands = read_fact(connection, "charge", uid, [*right, "corrected"])
        read = json.loads(stands["corrected"] or "{}")
        corrected = {name: (read[name][0] if name in read else stands[name], value) for name, value in right.items()}
        values |= {**right, "corrected": canonical({**read, **corrected})}
        if "stated_run" in right:
            values["named_run"] = find_uid(connection, "run", name=right["stated_run"])
    if "run" in new:
        times = assignments_to(connection, new["run"]) if new["run"] else 0
        values |= {"assigned": times + 1, "assigned_run": new["run"], "added": int(bool(new.get("added")))}
        values |= {"dismissed": 0} if new["run"] else {}
    if values:
        update_fact(connection, "charge", uid, values)


def name_charges(connection: sa.Connection, uids: Sequence[str], run_uid: str) -> None:
    """Say that charges name a run, which was not known when they were read."""
    for uid in uids:
        update_fact(connection, "charge", uid, {"named_run": run_uid})
    settle(connection, uids)
