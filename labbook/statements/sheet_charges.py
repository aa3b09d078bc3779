"""The charges of a file: which are new, which changed, which are back, and which are there no longer.

A charge is known by its file and where it stands there, so that a new reading changes it and keeps its uid, its run and
what people corrected. Which of the charges of a run counts is worked out by `counted_charges`.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from data_schema.queries import imports
from data_schema.queries.facts import find_uid, insert_fact, update_fact
from data_schema.queries.sheet_rows import SheetRow, rows_of_file
from data_schema.vocabulary import ChargeState
from ingest.model import ChargeRow, ReadFile
from labbook.statements.apply_context import ApplyContext, derived_uid
from labbook.statements.charge_numbers import Key, keys_of, numbers_held
from labbook.statements.counted_charges import Placed, lose, note_on, place
from labbook.statements.said_by_hand import SaidByHand, said_by_hand


def update_charges(
    context: ApplyContext,
    ingest_key: int,
    file_uid: str,
    read: ReadFile,
    numbers: Mapping[Key, int],
    of_file: str | None = None,
) -> list[str]:
    """Bring the charges of a file up to what was read from it; returns the runs that it concerns.

    `numbers` are the row numbers by where charges stand, `of_file` the run that the only charge of a file belongs to.
    """
    placed = Placed()
    standing = {row.uid: row for row in rows_of_file(context.connection, file_uid)}
    known = {row.row_number: row for row in standing.values()}
    uids = {}
    for key, row in zip(keys_of(read.charges), read.charges, strict=True):
        before = known.get(row.row_number)
        unnamed = numbers[key] not in known and before is not None and before.line is None
        number = row.row_number if unnamed else numbers[key]
        uids[known.pop(number).uid if number in known else _uid(file_uid, number)] = (row, number)
    assert len(uids) == len(read.charges), "two charges of a file have one number"  # noqa: S101
    said = said_by_hand(context, list(uids))
    moving, back, changed = [], [], []
    for uid, (row, number) in uids.items():
        old = standing.get(uid)
        values = _overlaid(_values(context, row), row, old, uid, said[uid], placed)
        if old is None:
            new = {"file": file_uid, "row_number": number, "run": None}
            insert_fact(context.connection, "charge", uid, {**new, "state": str(ChargeState.GONE), **values})
            moving.append(uid)
            continue
        same = _says_same(old, values)
        if _stays(old, row, values, said[uid], placed):
            changed += [] if same else [uid]
        else:
            moving.append(uid)
            back += [uid] if old.state is ChargeState.GONE else []
            lose(context, [] if old.state is ChargeState.GONE else [old], placed)
            values |= (
                {"run": None} if old.state is not ChargeState.GONE or old.stated_run != values["stated_run"] else {}
            )
            values |= {} if same else {"repeats": None}
        update_fact(context.connection, "charge", uid, values)
    lost = [row for row in standing.values() if row.uid not in uids and row.state is not ChargeState.GONE]
    lose(context, lost, placed)
    others = [*changed, *(row.uid for row in lost)]
    only = of_file if len(read.charges) == 1 else None
    place(context, moving, placed, back=frozenset(back), others=others, of_file=only)
    imports.add_findings(context.connection, ingest_key, placed.all_findings())
    return placed.runs


def lose_charges(context: ApplyContext, file_uid: str) -> list[str]:
    """Let no charge of a file count any more; rows of other sheets that say the same step in. Returns the runs."""
    placed = Placed()
    rows = [row for row in rows_of_file(context.connection, file_uid) if row.state is not ChargeState.GONE]
    lose(context, rows, placed)
    place(context, [], placed, others=[row.uid for row in rows])
    return placed.runs


def regain_charges(
    context: ApplyContext, file_uid: str, ingest_key: int, reading: Mapping[str, Any], *, first: bool
) -> list[str]:
    """Let the charges of a file in use again count as they did; returns the runs that it concerns.

    `reading` is the entry of the reading in force, the `first` of the file or not; what it does not hold stays gone.
    """
    placed = Placed()
    rows = [row for row in rows_of_file(context.connection, file_uid) if row.state is ChargeState.GONE]
    lines, numbers = reading.get("charge_lines"), numbers_held(reading, first=first)
    if numbers is not None:
        rows = [row for row in rows if row.row_number in numbers]
    elif lines is not None:
        rows = [row for row in rows if row.line in lines]
    uids = [row.uid for row in rows]
    place(context, uids, placed, back=frozenset(uids))
    imports.add_findings(context.connection, ingest_key, placed.all_findings())
    return placed.runs


def _stays(old: SheetRow, row: ChargeRow, values: Mapping[str, Any], said: SaidByHand, placed: Placed) -> bool:
    """Tell whether a charge stays where it is: dismissed, with the run it has, or known."""
    same, same_run = _says_same(old, values), values["stated_run"] == old.stated_run
    if old.state is ChargeState.KNOWN and same:
        placed.known.append(old)
    if old.state is ChargeState.COUNTED and said.assigned and not same_run:
        message = (
            f"{_row(old, row)} names run {row.stated_run} now, and a person said where it belongs: that stands; "
            "`labbook assign` moves it."
        )
        placed.findings.append(note_on("assignment_stands", row.charge_mah, row.line, message))
    stays = {
        ChargeState.DISMISSED: True,
        ChargeState.KNOWN: same,
        ChargeState.COUNTED: said.assigned or (same_run and old.run_uid is not None),
        ChargeState.GONE: False,
    }[old.state]
    placed.runs += [old.run_uid] if stays and old.run_uid else []
    return stays


def _overlaid(
    values: dict[str, Any], row: ChargeRow, old: SheetRow | None, uid: str, said: SaidByHand, placed: Placed
) -> dict[str, Any]:
    """Return what a line says now, but for what a person corrected in it."""
    for name in sorted(said.corrected.keys() & values.keys()):
        says = values[name]
        before, now = said.corrected[name]
        values[name] = now
        if says not in (before, now):
            message = (
                f"{_row(old, row)} says {name}={says}, where {before} stood, and a person corrected that to {now}: the "
                f"correction stands; correct charge:{uid} again if the sheet is right."
            )
            placed.findings.append(note_on("correction_stands", row.charge_mah, row.line, message))
    return values


def _says_same(old: SheetRow, values: Mapping[str, Any]) -> bool:
    names = ("charge_mah", "end_voltage_v", "mode", "stated_run")
    return all(getattr(old, name) == values[name] for name in names)


def _uid(file_uid: str, number: int) -> str:
    return derived_uid("charge", file_uid, number)


def _row(old: SheetRow | None, row: ChargeRow) -> str:
    if row.line is None:
        return f"Row {(old or row).row_number}"
    return f"Line {row.line}" if row.member is None else f"Line {row.line} of {row.member}"


def _values(context: ApplyContext, row: ChargeRow) -> dict[str, Any]:
    return {
        "line": row.line,
        "stated_run": row.stated_run,
        "battery": find_uid(context.connection, "battery", name=row.stated_pack) if row.stated_pack else None,
        "stated_pack": row.stated_pack,
        "charge_mah": row.charge_mah,
        "resolution_mah": row.resolution_mah,
        "duration_s": row.duration_s,
        "end_voltage_v": row.end_voltage_v,
        "mode": str(row.mode),
        "ended_utc": row.ended_utc,
        "ended_original": row.ended_original,
    }
