"""Which charge of a run counts: worked out anew for the rows of sheets that are new, changed, lost or back.

A row goes to the run that a person assigned it to, or that it belonged to before it was lost, or that it names. A run
has one charge, and what a person added to it where the pack was charged in parts: a row equal to what the run has, or
to what waits for it, is known; one that differs waits in the inbox, until a person decides or its sheet is read again.
Known rows are placed anew when the row that they repeat counts no more.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import sqlalchemy as sa

from data_schema.queries.charges import SheetRow, repeating, rows_about, rows_with_uids
from data_schema.queries.facts import read_fact, update_fact
from data_schema.queries.history import EntryRow, history_of_charges
from data_schema.queries.runs import run_uids_by_name
from data_schema.vocabulary import Action, ChargeMode, ChargeState, Severity
from ingest.findings import MORE_LINES
from ingest.model import ChargeRow, Finding
from labbook.statements.apply_context import ApplyContext
from labbook.statements.importing import finding_values


@dataclass
class Placement:
    """What placing rows came to: the runs concerned, and which rows are known or contradict what a run has.

    `copies` are the uids of known rows that repeat a row of no run: one that waits in the inbox, or was dismissed.
    """

    runs: list[str] = field(default_factory=list)
    known: list[SheetRow] = field(default_factory=list)
    copies: set[str] = field(default_factory=set)
    findings: list[dict[str, Any]] = field(default_factory=list)

    def all_findings(self) -> list[dict[str, Any]]:
        """Return the findings, those on known rows folded into one."""
        if not self.known:
            return self.findings
        return [*self.findings, finding_values(_known_already(self.known, self.copies))]


def _known_already(known: Sequence[SheetRow], copies: Collection[str]) -> Finding:
    """Say that rows are known, and whether what they repeat is a charge of their run."""
    lines = [row.line for row in known if row.line is not None]
    what = "1 row is" if len(known) == 1 else f"{len(known)} rows are"
    repeated = sum(row.uid in copies for row in known)
    if not repeated:
        why = "the book has these charges of these runs"
    elif repeated < len(known):
        why = f"the book has these charges, {repeated} of them of no run (`labbook runs inbox`)"
    else:
        why = f"the book has {'it' if repeated == 1 else 'them'} as of no run (`labbook runs inbox`)"
    message = f"{what} known already: {why}, so nothing is added."
    first, more = (lines[0], tuple(lines[1 : MORE_LINES + 1])) if lines else (None, ())
    return Finding(Severity.NOTE, "charge_known", message, first, None, None, len(known), more)


def mark_gone(context: ApplyContext, rows: Sequence[SheetRow], placed: Placement) -> None:
    """Set rows to the state gone; they keep their run for when they are back. `place_charges` lets others step in."""
    for row in rows:
        placed.runs += [row.run_uid] if row.run_uid and row.state is ChargeState.COUNTED else []
        update_fact(context.connection, "charge", row.uid, {"state": str(ChargeState.GONE)})


def place_charges(
    context: ApplyContext,
    uids: Sequence[str],
    placed: Placement,
    *,
    others: Sequence[str] = (),
    of_file: str | None = None,
) -> None:
    """Give each of these charges its place, none of which counts meanwhile, and then those that repeat one of them.

    `others` were lost or have other values now, so that what repeats them is placed too; `of_file` is the run that a
    file of one charge belongs to.
    """
    queue = list(uids)
    while queue or others:
        rows = rows_with_uids(context.connection, queue)
        manual = manual_changes(context, queue)
        for row in rows:
            if row.state is not ChargeState.GONE:
                update_fact(context.connection, "charge", row.uid, {"state": str(ChargeState.GONE)})
        rows = [replace(row, state=ChargeState.GONE) for row in rows]
        rows.sort(key=lambda row: (not manual[row.uid].assigned, row.order))
        run_uids = [row.run_uid for row in rows] + [manual[row.uid].run_uid for row in rows] + [of_file]
        around = RelatedRows(context, rows, manual, [uid for uid in run_uids if uid])
        for row in rows:
            run_uid = manual[row.uid].run_uid if manual[row.uid].assigned else row.run_uid
            if not manual[row.uid].assigned and run_uid is None:
                run_uid = around.runs.get(row.stated_run or "") or of_file
            _place(context, around, row, run_uid, placed)
        queue, others = _orphaned_repeats(context, [*queue, *others]), ()


def _place(context: ApplyContext, around: RelatedRows, row: SheetRow, run_uid: str | None, placed: Placement) -> None:
    manual = around.manual[row.uid]
    if manual.dismissed:
        around.set(row, ChargeState.DISMISSED, None)
        return
    rows_of_run = [other for other in around.rows_of_run(run_uid, row.stated_run) if other.uid != row.uid]
    first = [other for other in rows_of_run if not other.added]
    # What was added to a charge is repeated only where that is there: else the row may be the one it was added to.
    repeatable = rows_of_run if any(other.run_uid is not None for other in first) else first
    same = next((other for other in repeatable if _repeats_uncorrected(row, other, around.manual[other.uid])), None)
    if same is not None and not manual.assigned:
        around.set(row, ChargeState.KNOWN, None, same.uid)
        placed.known.append(row)
        placed.copies |= {row.uid} if same.run_uid is None else set()
        return
    standing = [
        other
        for other in first
        if other.run_uid is not None and not manual.added and (not manual.assigned or _second(row, other))
    ]
    around.set(row, ChargeState.COUNTED, None if standing else run_uid, row.repeats, added=manual.added)
    if standing:
        name = read_fact(context.connection, "run", standing[0].run_uid or "", ["name"])["name"]
        placed.findings.append(finding_values(_contradicts(row, name, standing[0])))
    elif run_uid is not None:
        placed.runs.append(run_uid)


def _contradicts(
    row: SheetRow, run: str, other: SheetRow, *, item: str | None = None, of_same_sheet: bool = False
) -> Finding:
    """Say that a run has another charge than a row differing; one of the same sheet is not in the book yet.

    `item` is what the row is called where it is not in the book either.
    """
    where = other.uid if of_same_sheet else f"charge:{other.uid}"
    names = ("charge_mah", "end_voltage_v", "mode")
    compared = [(name, getattr(row, name), getattr(other, name)) for name in names]
    differing = {name: value for name, value, before in compared if value is not None and not same_value(value, before)}
    fields = " ".join(
        f"{name}={value:.12g}" if isinstance(value, float) else f"{name}={value}" for name, value in differing.items()
    )
    cure = "correct the sheet"
    if not of_same_sheet:
        cure = f"`labbook correct {where} {fields} --why ...`, which settles the row"
    message = (
        f"Run {run} has a charge of {other.charge_mah:g} mAh ({where}); this row waits in the inbox: if that charge is "
        f"wrong, {cure}; if the pack was charged in two parts, add this one, `labbook assign "
        f"{item or f'charge:{row.uid}'} {run} --add`; else `labbook runs dismiss` it."
    )
    return Finding(Severity.NOTE, "charge_contradicts", message, row.line, None, f"{row.charge_mah:g} mAh", 1, ())


def predicted_findings(connection: sa.Connection, charges: Sequence[ChargeRow]) -> list[Finding]:
    """Return the findings that `place_charges` would make on the charges of a file that is not in the book."""
    uids = run_uids_by_name(connection, sorted({row.stated_run for row in charges if row.stated_run is not None}))
    names = {uid: name for name, uid in uids.items()}
    rows_of_run: dict[str, list[SheetRow]] = {}
    for row in rows_about(connection, sorted(names), sorted(uids)):
        rows_of_run.setdefault(names.get(row.run_uid or "") or row.stated_run or "", []).append(row)
    found, known, copies, own = [], [], set(), set[str]()
    for read in charges:
        if read.stated_run not in uids:
            continue
        values = {name: getattr(read, name) for name in SheetRow.__slots__ if hasattr(read, name)}
        row = SheetRow(**values, order=0, uid=f"row {read.row_number}", state=ChargeState.COUNTED)
        own.add(row.uid)
        others = rows_of_run.setdefault(read.stated_run, [])
        same = next((other for other in others if same_charge(row, other)), None)
        standing = next((other for other in others if other.run_uid is not None and not other.added), None)
        if same is not None:
            known.append(row)
            copies |= {row.uid} if same.run_uid is None else set()
        elif standing is not None:
            item = f"FILE#{read.row_number}"
            found.append(_contradicts(row, read.stated_run, standing, item=item, of_same_sheet=standing.uid in own))
            others.append(row)
        else:
            others.append(replace(row, run_uid=uids[read.stated_run]))
    return [*found, *([_known_already(known, copies)] if known else [])]


def _orphaned_repeats(context: ApplyContext, uids: Sequence[str]) -> list[str]:
    """Return the known rows that repeat one of these, which does not count any more or has other values."""
    waiting = repeating(context.connection, uids, ChargeState.KNOWN)
    return [
        other.uid
        for row in rows_with_uids(context.connection, uids)
        for other in waiting[row.uid]
        if row.state not in STANDING or other.stated_run != row.stated_run or not _repeats(context, other, row)
    ]


def _repeats(context: ApplyContext, row: SheetRow, other: SheetRow) -> bool:
    return same_charge(row, other) or (
        row.repeats == other.uid and _repeats_uncorrected(row, other, manual_changes(context, [other.uid])[other.uid])
    )


def _repeats_uncorrected(row: SheetRow, other: SheetRow, manual: ManualChanges) -> bool:
    """Tell whether a row equals another one as it is, or as it was before a person corrected it."""
    names = ("charge_mah", "end_voltage_v", "mode", "stated_run")
    before = {name: manual.corrected[name][0] for name in names if name in manual.corrected}
    return same_charge(row, other) or (row.repeats == other.uid and same_charge(row, replace(other, **before)))


def same_charge(row: SheetRow, other: SheetRow) -> bool:
    """Tell whether two rows have the same charge, mode and end voltage, which may be missing in one of them."""
    voltages = (row.end_voltage_v, other.end_voltage_v)
    voltages_agree = None in voltages or same_value(*voltages)
    return same_value(row.charge_mah, other.charge_mah) and row.mode == other.mode and voltages_agree


def same_value(value: Any, other: Any) -> bool:
    """Tell whether two values are the same but for rounding: 0.0561 Ah is read as 56.099999999999994 mAh."""
    if isinstance(value, float) and isinstance(other, float):
        return math.isclose(value, other, rel_tol=_ROUNDING)
    return bool(value == other)


_ROUNDING = 1e-12
"""Far above the rounding of a conversion of units, and far below the last digit that any charger shows."""


def _second(row: SheetRow, other: SheetRow) -> bool:
    """Tell whether a person who gives one to the run of the other would be refused: a discharge is no second charge."""
    return row.mode == other.mode == ChargeMode.CHARGE


def note_on(rule: str, charge_mah: float, line: int | None, message: str) -> dict[str, Any]:
    """Return a finding on one row of a sheet."""
    return finding_values(Finding(Severity.NOTE, rule, message, line, None, f"{charge_mah:g} mAh", 1, ()))


STANDING = (ChargeState.COUNTED, ChargeState.DISMISSED)
"""States of a row that others may repeat."""


class RelatedRows:
    """What the rows to be placed may repeat or contradict.

    `manual` holds what people changed by hand in each row here, `runs` the uids of the runs that rows name. The rows to
    be placed count nowhere when this is made.
    """

    __slots__ = ("_context", "_named", "_of_run", "_rows", "manual", "runs")

    def __init__(
        self,
        context: ApplyContext,
        rows: Sequence[SheetRow],
        manual: Mapping[str, ManualChanges],
        run_uids: Sequence[str],
    ) -> None:
        self._context = context
        names = sorted({row.stated_run for row in rows if row.stated_run is not None})
        self.runs = run_uids_by_name(context.connection, names)
        rows_of_run = rows_about(context.connection, sorted({*run_uids, *self.runs.values()}), names)
        self._rows: dict[str, SheetRow] = {}
        self._of_run: dict[str, dict[str, None]] = {}
        self._named: dict[str, dict[str, None]] = {}
        for row in (*rows, *rows_of_run):
            self._rows[row.uid] = row
            self._of_run.setdefault(row.run_uid or "", {})[row.uid] = None
            self._named.setdefault(row.stated_run or "", {})[row.uid] = None
        others = [uid for uid in self._rows if uid not in manual]
        self.manual = {**manual, **manual_changes(context, others)}

    def rows_of_run(self, run_uid: str | None, run_name: str | None) -> list[SheetRow]:
        """Return the rows that count for a run, then those that name one and belong to none; dismissed ones too."""
        of_run = [self._rows[uid] for uid in self._of_run.get(run_uid or "", ())] if run_uid else []
        named = [self._rows[uid] for uid in self._named.get(run_name or "", ())] if run_name is not None else []
        found = [row for row in of_run if row.state is ChargeState.COUNTED]
        found += [row for row in named if row.run_uid is None and row.state in STANDING]
        return sorted(found, key=lambda row: (row.run_uid is None, row.order))

    def set(
        self,
        row: SheetRow,
        state: ChargeState,
        run_uid: str | None,
        repeats: str | None = None,
        *,
        added: bool = False,
    ) -> None:
        """Say where a row stands from now on."""
        values = {"state": str(state), "run": run_uid, "repeats": repeats, "added": int(added)}
        update_fact(self._context.connection, "charge", row.uid, values)
        self._of_run[self._rows[row.uid].run_uid or ""].pop(row.uid)
        self._rows[row.uid] = replace(self._rows[row.uid], state=state, run_uid=run_uid, repeats=repeats, added=added)
        self._of_run.setdefault(run_uid or "", {})[row.uid] = None


@dataclass(frozen=True, slots=True)
class ManualChanges:
    """What people changed of one charge by hand, from the journal: it outlives any reading of its sheet.

    `corrected` holds, by column, the value before the first correction and the one of the last. `assigned` tells
    whether a person assigned it to a run; `run_uid` is that run, None where it belongs to none; `added` whether it is
    one more part of that run's charge.
    """

    corrected: Mapping[str, tuple[Any, Any]]
    assigned: bool
    run_uid: str | None
    added: bool
    dismissed: bool

    @property
    def any(self) -> bool:
        """Whether it was corrected or assigned at all."""
        return self.assigned or bool(self.corrected)


def manual_changes(context: ApplyContext, uids: Sequence[str]) -> dict[str, ManualChanges]:
    """Return what people changed by hand in each of these charges."""
    return {uid: _changes_in(entries) for uid, entries in history_of_charges(context.connection, uids).items()}


def _changes_in(entries: Sequence[EntryRow]) -> ManualChanges:
    corrected: dict[str, tuple[Any, Any]] = {}
    assigned, run_uid, added, dismissed = False, None, False, False
    for entry in entries:
        if entry.action in (Action.DISMISS, Action.RESTORE):
            dismissed = entry.action is Action.DISMISS
        elif entry.action in (Action.ASSIGN, Action.CORRECT):
            old, new = entry.old, entry.new
            for name in new.keys() - {"run", "added"} if entry.action is Action.CORRECT else ():
                corrected[name] = (corrected[name][0] if name in corrected else old.get(name), new[name])
            if "run" in new:
                assigned, run_uid, added = True, new["run"], bool(new.get("added"))
                dismissed = dismissed and run_uid is None
    return ManualChanges(corrected, assigned, run_uid, added, dismissed)
