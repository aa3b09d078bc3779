"""The charges of a file: which are new, which changed, which are back, and which are there no longer.

A charge is known by its file and its line, so that a new reading changes it and keeps its uid, its run and what people
corrected. Which of the charges of a run counts is worked out by `counted_charges`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import sqlalchemy as sa

from data_schema.queries import imports
from data_schema.queries.facts import find_uid, insert_fact, update_fact
from data_schema.queries.readings import reading_entries
from data_schema.queries.sheet_rows import SheetRow, rows_of_file
from data_schema.vocabulary import ChargeState
from ingest.model import ChargeRow, ReadFile
from labbook.statements.counted_charges import Placed, lose, note_on, place
from labbook.statements.said_by_hand import SaidByHand, said_by_hand
from labbook.statements.scene import Scene, derived_uid


def charge_numbers(
    connection: sa.Connection, file_uid: str, new: Mapping[str, Any], lines: Sequence[int | None]
) -> dict[int, int]:
    """Return the row numbers of a file's charges by line (by minus their place where they have none).

    A line keeps the number that it had first: what an entry says comes before what the book holds, and that before what
    follows from the order of readings, for an earlier labbook did not write numbers down; those of a first reading are
    the places of its lines. `new` is the entry of the reading that gave `lines`.
    """
    numbers: dict[int, int] = {}
    unsaid: list[int] = []
    for earlier, said in enumerate([*reading_entries(connection, new["sha256"]), new]):
        keys = _keys(said.get("charge_lines") or [])
        given = said.get("charge_numbers") or (range(1, len(keys) + 1) if earlier == 0 else None)
        if given is None:
            unsaid += keys
            continue
        for key, number in zip(keys, given, strict=True):
            numbers.setdefault(key, number)
    for row in rows_of_file(connection, file_uid):
        numbers.setdefault(_key(row.line, row.row_number), row.row_number)
    for key in (*unsaid, *_keys(lines)):
        numbers.setdefault(key, 1 + max(numbers.values(), default=0))
    return numbers


def numbers_of(numbers: Mapping[int, int], lines: Sequence[int | None]) -> list[int]:
    """Return the row numbers of the charges in these lines, in their order."""
    return [numbers[key] for key in _keys(lines)]


def update_charges(
    scene: Scene, ingest_key: int, file_uid: str, read: ReadFile, numbers: Mapping[int, int], of_file: str | None = None
) -> list[str]:
    """Bring the charges of a file up to what was read from it; returns the runs that it concerns.

    `numbers` are the row numbers by line, and `of_file` the run that the only charge of a file belongs to.
    """
    placed = Placed()
    standing = {row.uid: row for row in rows_of_file(scene.connection, file_uid)}
    by_line = {_key(row.line, row.row_number): row.uid for row in standing.values()}
    uids = {}
    for row in read.charges:
        key = _key(row.line, row.row_number)
        uids[by_line.pop(key, "") or by_line.pop(-row.row_number, "") or _uid(file_uid, numbers[key])] = row
    said = said_by_hand(scene, list(uids))
    moving, back, changed = [], [], []
    for uid, row in uids.items():
        old = standing.get(uid)
        values = _overlaid(_values(scene, row), row, old, uid, said[uid], placed)
        if old is None:
            new = {"file": file_uid, "row_number": numbers[_key(row.line, row.row_number)], "run": None}
            insert_fact(scene.connection, "charge", uid, {**new, "state": str(ChargeState.GONE), **values})
            moving.append(uid)
            continue
        same = _says_same(old, values)
        if _stays(old, row, values, said[uid], placed):
            changed += [] if same else [uid]
        else:
            moving.append(uid)
            back += [uid] if old.state is ChargeState.GONE else []
            lose(scene, [] if old.state is ChargeState.GONE else [old], placed)
            values |= (
                {"run": None} if old.state is not ChargeState.GONE or old.stated_run != values["stated_run"] else {}
            )
            values |= {} if same else {"repeats": None}
        update_fact(scene.connection, "charge", uid, values)
    lost = [row for row in standing.values() if row.uid not in uids and row.state is not ChargeState.GONE]
    lose(scene, lost, placed)
    others = [*changed, *(row.uid for row in lost)]
    only = of_file if len(read.charges) == 1 else None
    place(scene, moving, placed, back=frozenset(back), others=others, of_file=only)
    imports.add_findings(scene.connection, ingest_key, placed.all_findings())
    return placed.runs


def lose_charges(scene: Scene, file_uid: str) -> list[str]:
    """Let no charge of a file count any more; rows of other sheets that say the same step in. Returns the runs."""
    placed = Placed()
    rows = [row for row in rows_of_file(scene.connection, file_uid) if row.state is not ChargeState.GONE]
    lose(scene, rows, placed)
    place(scene, [], placed, others=[row.uid for row in rows])
    return placed.runs


def regain_charges(scene: Scene, file_uid: str, ingest_key: int, lines: Sequence[int | None] | None) -> list[str]:
    """Let the charges of a file in use again count as they did; returns the runs that it concerns.

    `lines` are those that the reading in force holds, None where the journal does not say; what it does not hold stays
    gone.
    """
    placed = Placed()
    rows = [row for row in rows_of_file(scene.connection, file_uid) if row.state is ChargeState.GONE]
    uids = [row.uid for row in rows if lines is None or row.line in lines]
    place(scene, uids, placed, back=frozenset(uids))
    imports.add_findings(scene.connection, ingest_key, placed.all_findings())
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


def _keys(lines: Sequence[int | None]) -> list[int]:
    return [_key(line, place) for place, line in enumerate(lines, start=1)]


def _key(line: int | None, row_number: int) -> int:
    return -row_number if line is None else line


def _uid(file_uid: str, number: int) -> str:
    return derived_uid("charge", file_uid, number)


def _row(old: SheetRow | None, row: ChargeRow) -> str:
    return f"Line {row.line}" if row.line is not None else f"Row {(old or row).row_number}"


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
