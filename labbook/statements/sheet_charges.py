"""The charges of a file: which are new, which are known, which contradict what stands, and which are there no longer.

A charge is known by its file and its line, so that a new reading changes it and keeps its uid, its run and what people
corrected. A hand-kept sheet grows and comes again: a row that a run's charge says already, or one that waits for the
run, does not count as a second charge, and one that contradicts the run's waits in the inbox.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from data_schema.queries import imports
from data_schema.queries.charges import ChargeOfRun, charges_of_run, charges_waiting_for
from data_schema.queries.facts import find_uid, insert_fact, update_fact
from data_schema.queries.readings import said_about
from data_schema.queries.sheet_rows import SheetRow, known_of_run, repeating, rows_of_file
from data_schema.vocabulary import Action, ChargeState, Severity
from ingest.findings import MORE_LINES
from ingest.model import ChargeRow, Finding, ReadFile
from labbook.statements.assigning import assign_charge
from labbook.statements.findings import finding_values
from labbook.statements.scene import Scene, derived_uid, run_named


@dataclass
class _Found:
    """What the rows of one file turn out to be."""

    touched: list[str] = field(default_factory=list)
    known: list[ChargeRow | SheetRow] = field(default_factory=list)
    findings: list[dict[str, Any]] = field(default_factory=list)


def update_charges(
    scene: Scene, ingest_key: int, file_uid: str, read: ReadFile, lines: list[int | None] | None
) -> list[str]:
    """Bring the charges of a file up to what was read from it; returns the runs that it concerns.

    `lines` are those of the file's charges when it was imported first, by row number, where the journal says them.
    """
    found = _Found()
    standing = rows_of_file(scene.connection, file_uid)
    by_line = {row.line if row.line is not None else -row.row_number: row for row in standing}
    numbers = {line: place for place, line in enumerate(lines or [], start=1)}
    free = max([len(numbers), *(row.row_number for row in standing)])
    for row in read.charges:
        old = by_line.pop(row.line or -row.row_number, None) or by_line.pop(-row.row_number, None)
        if old is not None:
            _update(scene, old, row, found)
            continue
        if lines is None and not standing:
            number = row.row_number
        elif row.line in numbers:
            number = numbers[row.line]
        else:
            number = free = free + 1
        uid = derived_uid("charge", file_uid, number)
        values = {"file": file_uid, "row_number": number, "run": None, "state": str(ChargeState.COUNTED)}
        insert_fact(scene.connection, "charge", uid, {**values, **_values(scene, row)})
        _place(scene, uid, row, found)
    found.touched += _lose(scene, list(by_line.values()))
    found.findings += _folded(found.known)
    imports.add_findings(scene.connection, ingest_key, found.findings)
    return found.touched


def lose_charges(scene: Scene, file_uid: str) -> list[str]:
    """Let no charge of a file count any more; rows of other sheets that say the same step in. Returns the runs."""
    return _lose(scene, rows_of_file(scene.connection, file_uid))


def regain_charges(scene: Scene, file_uid: str, ingest_key: int, lines: list[int | None] | None) -> list[str]:
    """Let the charges of a file in use again count by the rules of new ones; returns the runs that it concerns.

    Charges that stepped in for them give way, unless a person spoke of them since. `lines` are those that the reading
    in force holds, None where the journal does not say; what it does not hold stays gone.
    """
    found = _Found()
    rows = [row for row in rows_of_file(scene.connection, file_uid) if row.state is ChargeState.GONE]
    for row in rows:
        if lines is not None and row.line not in lines:
            continue
        for other in repeating(scene.connection, row.uid, ChargeState.COUNTED):
            if not _by_hand(scene, other.uid):
                values = {"state": str(ChargeState.KNOWN), "run": None}
                update_fact(scene.connection, "charge", other.uid, values)
        standing = charges_of_run(scene.connection, row.run_uid) if row.run_uid else []
        if row.run_uid and not standing and _by_hand(scene, row.uid):
            update_fact(scene.connection, "charge", row.uid, {"state": str(ChargeState.COUNTED)})
            found.touched.append(row.run_uid)
            continue
        stands_back = {"run": None, "state": str(ChargeState.COUNTED), "repeats": None}
        update_fact(scene.connection, "charge", row.uid, stands_back)
        _place(scene, row.uid, row, found)
    found.findings += _folded(found.known)
    imports.add_findings(scene.connection, ingest_key, found.findings)
    return found.touched


def _by_hand(scene: Scene, uid: str) -> bool:
    return bool(said_about(scene.connection, uid, [Action.ASSIGN, Action.CORRECT]))


def _update(scene: Scene, old: SheetRow, row: ChargeRow, found: _Found) -> None:
    """Change a charge to what its line says now, but for what a person corrected in it."""
    values = _values(scene, row)
    corrected = _corrected(scene, old.uid)
    for name in sorted(corrected.keys() & values.keys()):
        said = values.pop(name)
        before, now = corrected[name]
        if said not in (before, now):
            message = (
                f"{_row(old, row)} says {name}={said}, where {before} stood, and a person corrected that to {now}: the "
                f"correction stands; correct charge:{old.uid} again if the sheet is right."
            )
            found.findings.append(_finding("correction_stands", row, message))
    update_fact(scene.connection, "charge", old.uid, values)
    if old.state is ChargeState.DISMISSED:
        return
    by_hand = [
        new for _old, new in said_about(scene.connection, old.uid, [Action.ASSIGN, Action.CORRECT]) if "run" in new
    ]
    if by_hand and old.state is ChargeState.COUNTED:
        if row.stated_run != old.stated_run:
            message = (
                f"{_row(old, row)} names run {row.stated_run} now, and a person said where it belongs: that stands; "
                "`labbook assign` moves it."
            )
            found.findings.append(_finding("assignment_stands", row, message))
        found.touched += [old.run_uid] if old.run_uid else []
        return
    if old.run_uid is not None and old.state is ChargeState.COUNTED and row.stated_run == old.stated_run:
        found.touched.append(old.run_uid)
        return
    found.touched += [old.run_uid] if old.run_uid else []
    stands_back = {"run": None, "state": str(ChargeState.COUNTED), "repeats": None}
    update_fact(scene.connection, "charge", old.uid, stands_back)
    _place(scene, old.uid, row, found)


def _place(scene: Scene, uid: str, row: ChargeRow | SheetRow, found: _Found) -> None:
    """Give a charge that belongs to no run yet to the one it names, unless that is known or contradicted."""
    run_uid = run_named(scene, row.stated_run)
    standing = charges_of_run(scene.connection, run_uid) if run_uid else []
    waiting = charges_waiting_for(scene.connection, row.stated_run) if row.stated_run else []
    same = [charge for charge in (*standing, *waiting) if charge.uid != uid and _same_charge(row, charge)]
    if same:
        update_fact(scene.connection, "charge", uid, {"state": str(ChargeState.KNOWN), "repeats": same[0].uid})
        found.known.append(row)
    elif standing:
        message = (
            f"Run {row.stated_run} has a charge of {standing[0].charge_mah:g} mAh (charge:{standing[0].uid}); this "
            f"row waits in the inbox: correct that charge if it is wrong."
        )
        found.findings.append(_finding("charge_contradicts", row, message))
    elif run_uid:
        assign_charge(scene, uid, run_uid)
        found.touched.append(run_uid)


def _lose(scene: Scene, rows: list[SheetRow]) -> list[str]:
    touched = []
    for row in rows:
        if row.state not in (ChargeState.COUNTED, ChargeState.KNOWN):
            continue
        update_fact(scene.connection, "charge", row.uid, {"state": str(ChargeState.GONE)})
        touched += [row.run_uid] if row.run_uid else []
        if row.state is ChargeState.COUNTED:
            touched += _step_in(scene, row)
    return touched


def _step_in(scene: Scene, gone: SheetRow) -> list[str]:
    """Let the first row of another sheet that said the same count in the place of one that is gone."""
    known = known_of_run(scene.connection, gone.stated_run) if gone.stated_run else []
    first = next((row for row in known if _same_charge(row, gone)), None)
    if first is None:
        return []
    update_fact(scene.connection, "charge", first.uid, {"state": str(ChargeState.COUNTED), "repeats": gone.uid})
    run_uid = run_named(scene, first.stated_run)
    if run_uid is None or charges_of_run(scene.connection, run_uid):
        return []
    assign_charge(scene, first.uid, run_uid)
    return [run_uid]


def _corrected(scene: Scene, uid: str) -> dict[str, tuple[Any, Any]]:
    """Return, by column, what stood before the first correction by a person, and what the last one says."""
    found: dict[str, tuple[Any, Any]] = {}
    for old, new in said_about(scene.connection, uid, [Action.CORRECT]):
        for name, value in new.items():
            found[name] = (found[name][0] if name in found else old.get(name), value)
    return found


def _same_charge(row: ChargeRow | SheetRow, standing: ChargeOfRun | SheetRow) -> bool:
    voltages = {row.end_voltage_v, standing.end_voltage_v} - {None}
    return row.charge_mah == standing.charge_mah and str(row.mode) == standing.mode and len(voltages) < 2


def _folded(known: list[ChargeRow | SheetRow]) -> list[dict[str, Any]]:
    """Say in one finding which rows the book knows already."""
    if not known:
        return []
    lines = [row.line for row in known if row.line is not None]
    what = "1 row is" if len(known) == 1 else f"{len(known)} rows are"
    message = f"{what} known already: the book has these charges of these runs, so nothing is added."
    first, more = (lines[0], tuple(lines[1 : MORE_LINES + 1])) if lines else (None, ())
    return [finding_values(Finding(Severity.NOTE, "charge_known", message, first, None, None, len(known), more))]


def _row(old: SheetRow, row: ChargeRow) -> str:
    return f"Row {old.row_number}" if row.line is None else f"Line {row.line}"


def _finding(rule: str, row: ChargeRow | SheetRow, message: str) -> dict[str, Any]:
    value = f"{row.charge_mah:g} mAh"
    return finding_values(Finding(Severity.NOTE, rule, message, row.line, None, value, 1, ()))


def _values(scene: Scene, row: ChargeRow) -> dict[str, Any]:
    return {
        "line": row.line,
        "stated_run": row.stated_run,
        "battery": find_uid(scene.connection, "battery", name=row.stated_pack) if row.stated_pack else None,
        "stated_pack": row.stated_pack,
        "charge_mah": row.charge_mah,
        "resolution_mah": row.resolution_mah,
        "duration_s": row.duration_s,
        "end_voltage_v": row.end_voltage_v,
        "mode": str(row.mode),
        "ended_utc": row.ended_utc,
        "ended_original": row.ended_original,
    }
