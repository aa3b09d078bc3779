"""Which charge of a run counts: worked out anew for the rows of sheets that are new, changed, lost or back.

A row goes to the run that a person said, or that it belonged to before it was lost, or that it names. A run has one
charge: a row that says the same as what the run has, or as what waits for it, is known; one that says something else
waits in the inbox, until a person speaks or its sheet is read again. Known rows are placed anew when the row that they
repeat counts no more, and give way when it is back.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from data_schema.queries.facts import read_fact, update_fact
from data_schema.queries.sheet_rows import SheetRow, repeating, rows_with_uids
from data_schema.vocabulary import ChargeMode, ChargeState, Severity
from ingest.findings import MORE_LINES
from ingest.model import Finding
from labbook.statements.apply_context import ApplyContext
from labbook.statements.findings import finding_values
from labbook.statements.rows_around import STANDING, RowsAround
from labbook.statements.said_by_hand import SaidByHand, said_by_hand


@dataclass
class Placed:
    """What placing rows came to: the runs concerned, and which rows are known or contradict what a run has."""

    runs: list[str] = field(default_factory=list)
    known: list[SheetRow] = field(default_factory=list)
    findings: list[dict[str, Any]] = field(default_factory=list)

    def all_findings(self) -> list[dict[str, Any]]:
        """Return the findings, those on known rows folded into one."""
        if not self.known:
            return self.findings
        lines = [row.line for row in self.known if row.line is not None]
        what = "1 row is" if len(self.known) == 1 else f"{len(self.known)} rows are"
        message = f"{what} known already: the book has these charges of these runs, so nothing is added."
        first, more = (lines[0], tuple(lines[1 : MORE_LINES + 1])) if lines else (None, ())
        folded = Finding(Severity.NOTE, "charge_known", message, first, None, None, len(self.known), more)
        return [*self.findings, finding_values(folded)]


def lose(context: ApplyContext, rows: Sequence[SheetRow], placed: Placed) -> None:
    """Let rows count no more; they keep their run, to be known by when they are back. `place` lets others step in."""
    for row in rows:
        placed.runs += [row.run_uid] if row.run_uid and row.state is ChargeState.COUNTED else []
        update_fact(context.connection, "charge", row.uid, {"state": str(ChargeState.GONE)})


def place(
    context: ApplyContext,
    uids: Sequence[str],
    placed: Placed,
    *,
    back: frozenset[str] = frozenset(),
    others: Sequence[str] = (),
    of_file: str | None = None,
) -> None:
    """Give each of these charges its place, none of which counts meanwhile, and then those that repeat one of them.

    Those in `back` were lost: rows that came later, say the same, and that no person spoke of, give way to them.
    `others` were lost or say something else now, so that what repeats them is placed too; `of_file` is the run that a
    file of one charge belongs to.
    """
    queue = list(uids)
    while queue or others:
        rows = rows_with_uids(context.connection, queue)
        said = said_by_hand(context, queue)
        for row in rows:
            if row.state is not ChargeState.GONE:
                update_fact(context.connection, "charge", row.uid, {"state": str(ChargeState.GONE)})
        rows = [replace(row, state=ChargeState.GONE) for row in rows]
        rows.sort(key=lambda row: (not said[row.uid].assigned, row.order))
        stated = [row.run_uid for row in rows] + [said[row.uid].run_uid for row in rows] + [of_file]
        around = RowsAround(context, rows, said, [uid for uid in stated if uid], sorted(back))
        gave_way: list[str] = []
        for row in rows:
            run_uid = said[row.uid].run_uid if said[row.uid].assigned else row.run_uid
            if not said[row.uid].assigned and run_uid is None:
                run_uid = around.runs.get(row.stated_run or "") or of_file
            if row.uid in back:
                gave_way += _give_way(around, row, run_uid, placed)
            _place(context, around, row, run_uid, placed)
        queue = list(dict.fromkeys([*gave_way, *_left_alone(context, [*queue, *others])]))
        back, others = frozenset(), ()


def _place(context: ApplyContext, around: RowsAround, row: SheetRow, run_uid: str | None, placed: Placed) -> None:
    said = around.said[row.uid]
    if said.dismissed:
        around.set(row, ChargeState.DISMISSED, None)
        return
    about = [other for other in around.about(run_uid, row.stated_run) if other.uid != row.uid]
    same = next((other for other in about if _repeats_said(row, other, around.said[other.uid])), None)
    if same is not None and not said.assigned:
        around.set(row, ChargeState.KNOWN, None, same.uid)
        placed.known.append(row)
        return
    standing = [other for other in about if other.run_uid is not None and (not said.assigned or _second(row, other))]
    around.set(row, ChargeState.COUNTED, None if standing else run_uid, row.repeats)
    if standing:
        name = read_fact(context.connection, "run", standing[0].run_uid or "", ["name"])["name"]
        message = (
            f"Run {name} has a charge of {standing[0].charge_mah:g} mAh (charge:{standing[0].uid}); this "
            f"row waits in the inbox: correct that charge if it is wrong."
        )
        placed.findings.append(note_on("charge_contradicts", row.charge_mah, row.line, message))
    elif run_uid is not None:
        placed.runs.append(run_uid)


def _give_way(around: RowsAround, row: SheetRow, run_uid: str | None, placed: Placed) -> list[str]:
    """Let later rows that say the same make room for one that is back; returns them, to be placed after it."""
    own = replace(row, run_uid=None)
    about = [
        *around.about(run_uid or around.runs.get(row.stated_run or ""), row.stated_run),
        *around.repeating(row.uid),
    ]
    later = {other.uid: other for other in about if other.order > row.order and not other.typed}
    spoken = around.said
    giving = [
        other
        for other in later.values()
        if not spoken[other.uid].spoken
        and not spoken[other.uid].dismissed
        and _repeats_said(other, own, spoken[row.uid])
    ]
    for other in giving:
        placed.runs += [other.run_uid] if other.run_uid else []
        around.set(other, ChargeState.GONE, None, row.uid)
    return [other.uid for other in giving]


def _left_alone(context: ApplyContext, uids: Sequence[str]) -> list[str]:
    """Return the known rows that repeat one of these, which does not stand any more or says something else."""
    waiting = repeating(context.connection, uids, ChargeState.KNOWN)
    return [
        other.uid
        for row in rows_with_uids(context.connection, uids)
        for other in waiting[row.uid]
        if row.state not in STANDING or other.stated_run != row.stated_run or not _repeats(context, other, row)
    ]


def _repeats(context: ApplyContext, row: SheetRow, other: SheetRow) -> bool:
    return _same(row, other) or (
        row.repeats == other.uid and _repeats_said(row, other, said_by_hand(context, [other.uid])[other.uid])
    )


def _repeats_said(row: SheetRow, other: SheetRow, said: SaidByHand) -> bool:
    """Tell whether a row says what another one says, or said before a person corrected it."""
    names = ("charge_mah", "end_voltage_v", "mode", "stated_run")
    before = {name: said.corrected[name][0] for name in names if name in said.corrected}
    return _same(row, other) or (row.repeats == other.uid and _same(row, replace(other, **before)))


def _same(row: SheetRow, other: SheetRow) -> bool:
    voltages = {row.end_voltage_v, other.end_voltage_v} - {None}
    return row.charge_mah == other.charge_mah and row.mode == other.mode and len(voltages) < 2


def _second(row: SheetRow, other: SheetRow) -> bool:
    """Tell whether a person who gives one to the run of the other would be refused: a discharge is no second charge."""
    return row.mode == other.mode == ChargeMode.CHARGE


def note_on(rule: str, charge_mah: float, line: int | None, message: str) -> dict[str, Any]:
    """Return a finding on one row of a sheet."""
    return finding_values(Finding(Severity.NOTE, rule, message, line, None, f"{charge_mah:g} mAh", 1, ()))
