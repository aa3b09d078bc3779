"""The charges of a file after a new reading: which are new, changed, back, or gone.

A charge is identified by its file and its place there, so that a new reading changes it and keeps its uid, its run and
people's corrections. It keeps its number in the file: its uid is derived from it, and people name it by it. Which of
the charges of a run counts is decided by `counted_charges`.
"""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import fields, replace
from itertools import repeat
from typing import Any

import sqlalchemy as sa

from data_schema.queries import imports
from data_schema.queries.charges import SheetRow, rows_of_file, rows_with_uids
from data_schema.queries.facts import find_uid, insert_fact, update_fact
from data_schema.queries.history import reading_entries
from data_schema.vocabulary import ChargeState
from ingest.model import ChargeRow, ReadFile
from labbook.statements.apply_context import ApplyContext, derived_uid
from labbook.statements.counted_charges import (
    ManualChanges,
    Placement,
    manual_changes,
    mark_gone,
    note_on,
    place_charges,
    same_value,
)


def update_charges(
    context: ApplyContext,
    ingest_key: int,
    file_uid: str,
    read: ReadFile,
    numbers: Mapping[Key, int],
    of_file: str | None = None,
) -> list[str]:
    """Update the charges of a file to what was read from it; returns the runs that it concerns.

    `numbers` are the row numbers by place of the charges, `of_file` the run that the only charge of a file belongs to.
    """
    placed = Placement()
    standing = {row.uid: row for row in rows_of_file(context.connection, file_uid)}
    known = {row.row_number: row for row in standing.values()}
    uids = {}
    for key, row in zip(keys_of(read.charges), read.charges, strict=True):
        number = numbers[key]
        uids[known.pop(number).uid if number in known else _uid(file_uid, number)] = (row, number)
    assert len(uids) == len(read.charges), "two charges of a file have one number"  # noqa: S101
    manual = manual_changes(context, list(uids))
    moving, changed = [], []
    for uid, (read_row, number) in uids.items():
        old = standing.get(uid)
        row, battery = _corrected(context, read_row, old, uid, manual[uid], placed)
        values = _columns(row, battery)
        if old is None:
            new = {"file": file_uid, "row_number": number, "run": None}
            insert_fact(context.connection, "charge", uid, {**new, "state": str(ChargeState.GONE), **values})
            moving.append(uid)
            continue
        same = _same_charge(old, row)
        if _stays(old, read_row, row, manual[uid], placed):
            changed += [] if same else [uid]
        else:
            moving.append(uid)
            mark_gone(context, [] if old.state is ChargeState.GONE else [old], placed)
            values |= {"run": None} if old.state is not ChargeState.GONE or old.stated_run != row.stated_run else {}
            values |= {} if same else {"repeats": None}
        update_fact(context.connection, "charge", uid, values)
    lost = [row for row in standing.values() if row.uid not in uids and row.state is not ChargeState.GONE]
    mark_gone(context, lost, placed)
    others = [*changed, *(row.uid for row in lost)]
    only = of_file if len(read.charges) == 1 else None
    staying = [row for row in placed.known if row.repeats is not None]
    place_charges(context, moving, placed, others=others, of_file=only)
    repeated = rows_with_uids(context.connection, sorted({row.repeats or "" for row in staying}))
    loose = {row.uid for row in repeated if row.run_uid is None}
    placed.copies |= {row.uid for row in staying if row.repeats in loose}
    imports.add_findings(context.connection, ingest_key, placed.all_findings())
    return placed.runs


def mark_charges_gone(context: ApplyContext, file_uid: str) -> list[str]:
    """Set all charges of a file to the state gone; equal rows of other sheets replace them. Returns the runs."""
    placed = Placement()
    rows = [row for row in rows_of_file(context.connection, file_uid) if row.state is not ChargeState.GONE]
    mark_gone(context, rows, placed)
    place_charges(context, [], placed, others=[row.uid for row in rows])
    return placed.runs


def restore_charges(context: ApplyContext, file_uid: str, ingest_key: int, reading: Mapping[str, Any]) -> list[str]:
    """Let the charges of a restored file count as before; returns the runs that it concerns.

    `reading` is the entry of the reading in force; charges that it lacks stay gone.
    """
    placed = Placement()
    gone = [row for row in rows_of_file(context.connection, file_uid) if row.state is ChargeState.GONE]
    uids = [row.uid for row in gone if row.row_number in reading["charge_numbers"]]
    place_charges(context, uids, placed)
    imports.add_findings(context.connection, ingest_key, placed.all_findings())
    return placed.runs


def _stays(old: SheetRow, read_row: ChargeRow, row: ChargeRow, manual: ManualChanges, placed: Placement) -> bool:
    """Tell whether a charge keeps its state: dismissed, with its run, or known; `row` has people's corrections."""
    same, same_run = _same_charge(old, row), row.stated_run == old.stated_run
    if old.state is ChargeState.KNOWN and same:
        placed.known.append(old)
    if old.state is ChargeState.COUNTED and manual.assigned and not same_run:
        message = (
            f"{_row(old, read_row)} names run {read_row.stated_run} now, and a person said where it belongs: that "
            "stands; `labbook assign` moves it."
        )
        placed.findings.append(note_on("assignment_stands", read_row.charge_mah, read_row.line, message))
    stays = {
        ChargeState.DISMISSED: True,
        ChargeState.KNOWN: same,
        ChargeState.COUNTED: manual.assigned or (same_run and old.run_uid is not None),
        ChargeState.GONE: False,
    }[old.state]
    placed.runs += [old.run_uid] if stays and old.run_uid else []
    return stays


_IN_TABLE = tuple(each.name for each in fields(ChargeRow) if each.name not in ("row_number", "member"))
"""The fields of a line that are stored as they are; its number is given once, and its pack has a row of its own too."""


def _corrected(
    context: ApplyContext, read_row: ChargeRow, old: SheetRow | None, uid: str, manual: ManualChanges, placed: Placement
) -> tuple[ChargeRow, str | None]:
    """Return a line with the values that a person corrected in it, and the uid of its pack, likewise."""
    pack = read_row.stated_pack
    read_values = {name: getattr(read_row, name) for name in _IN_TABLE}
    read_values["battery"] = find_uid(context.connection, "battery", name=pack) if pack else None
    corrected = {name: manual.corrected[name][1] for name in sorted(manual.corrected.keys() & read_values.keys())}
    for name, now in corrected.items():
        before = manual.corrected[name][0]
        if not same_value(read_values[name], before) and not same_value(read_values[name], now):
            message = (
                f"{_row(old, read_row)} says {name}={read_values[name]}, where {before} stood, and a person corrected "
                f"that to {now}: the correction stands; correct charge:{uid} again if the sheet is right."
            )
            placed.findings.append(note_on("correction_stands", read_row.charge_mah, read_row.line, message))
    battery = corrected.pop("battery", read_values["battery"])
    return replace(read_row, **corrected), battery


def _same_charge(old: SheetRow, row: ChargeRow) -> bool:
    names = ("charge_mah", "end_voltage_v", "mode", "stated_run")
    return all(same_value(getattr(old, name), getattr(row, name)) for name in names)


def _uid(file_uid: str, number: int) -> str:
    return derived_uid("charge", file_uid, number)


def _row(old: SheetRow | None, row: ChargeRow) -> str:
    if row.line is None:
        return f"Row {(old or row).row_number}"
    return f"Line {row.line}" if row.member is None else f"Line {row.line} of {row.member}"


def _columns(row: ChargeRow, battery: str | None) -> dict[str, Any]:
    """Return a charge as its table takes it."""
    return {**{name: getattr(row, name) for name in _IN_TABLE}, "mode": str(row.mode), "battery": battery}


Key = tuple[str, int, int]
"""The place of a charge: its member, its line (minus its place where it has none), and its place within that line."""


def keys_of(charges: Sequence[ChargeRow]) -> list[Key]:
    """Return the places of the charges of a reading, no two of them the same."""
    return _keys((row.line for row in charges), (row.member for row in charges))


def entry_keys(content: Mapping[str, Any]) -> list[Key]:
    """Return the places of the charges that the entry of a reading names."""
    return _keys(content["charge_lines"], content.get("charge_members") or repeat(None))


def charge_numbers(
    connection: sa.Connection, sha256: str, keys: Sequence[Key], new: Mapping[str, Any] | None = None
) -> dict[Key, int]:
    """Return the row numbers of a file's charges, no two of them the same.

    A charge keeps the number that it had first, by the entries of the file's readings; `new` is that of the reading
    which gave `keys`. Others follow the highest.
    """
    numbers: dict[Key, int] = {}
    for content in [*reading_entries(connection, sha256), *([] if new is None else [new])]:
        for key, number in zip(entry_keys(content), content["charge_numbers"], strict=True):
            if key not in numbers and number not in numbers.values():
                numbers[key] = number
    following = itertools.count(1 + max(numbers.values(), default=0))
    return numbers | {key: next(following) for key in keys if key not in numbers}


def _keys(lines: Iterable[int | None], members: Iterable[str | None]) -> list[Key]:
    return _numbered(
        (member or "", -place if line is None else line)
        for place, (line, member) in enumerate(zip(lines, members, strict=False), start=1)
    )


def _numbered(stands: Iterable[tuple[str, int]]) -> list[Key]:
    """Tell those apart that stand at one place, by their order."""
    seen: Counter[tuple[str, int]] = Counter()
    keys: list[Key] = []
    for stand in stands:
        seen[stand] += 1
        keys.append((*stand, seen[stand]))
    return keys
