"""The charges of a file: what a reading says of each, those that are gone or back, and what is found in them.

A charge is identified by its file and its place there, so that a new reading changes it and keeps its uid, its run and
people's corrections. It keeps its number in the file: its uid is derived from it, and people name it by it. Which of
the charges of a run counts follows from all of them (`counted_charges`).
"""

from __future__ import annotations

import itertools
import sys
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import fields as fields_of
from itertools import repeat
from typing import Any

import sqlalchemy as sa

from data_schema.journal import canonical
from data_schema.queries import files
from data_schema.queries.charges import SheetRow, rows_of_file
from data_schema.queries.facts import find_uid, insert_fact, read_fact, update_fact
from data_schema.queries.history import history_of_charges, reading_entries
from data_schema.queries.runs import run_uids_by_name
from data_schema.vocabulary import ChargeState, Severity
from ingest.model import MORE_LINES, ChargeRow, Finding, ReadFile
from labbook.statements.apply_context import ApplyContext, derived_uid
from labbook.statements.counted_charges import (
    COMPARED,
    Place,
    placed_about,
    same_charge,
    same_value,
    settle,
    write_statement,
)
from labbook.statements.importing import finding_values


def update_charges(
    context: ApplyContext,
    ingest_key: int,
    file_uid: str,
    read: ReadFile,
    numbers: Mapping[Key, int],
    of_file: str | None = None,
) -> None:
    """Update the charges of a file to what was read from it.

    `numbers` are the row numbers by place of the charges, `of_file` the run that the only charge of a file belongs to.
    """
    connection = context.connection
    before = rows_of_file(connection, file_uid)
    standing = {row.row_number: row for row in before}
    named = _named_runs(connection, read.charges, of_file)
    found: list[Finding] = []
    held, new = [], []
    packs = {
        name: find_uid(connection, "battery", name=name) for name in {row.stated_pack for row in read.charges} if name
    }
    for key, row, run in zip(keys_of(read.charges), read.charges, named, strict=True):
        values = {name: getattr(row, name) for name in _IN_TABLE}
        values |= {"mode": str(row.mode), "battery": packs[row.stated_pack] if row.stated_pack else None}
        old = standing.pop(numbers[key], None)
        if old is None:
            held.append(derived_uid("charge", file_uid, numbers[key]))
            new.append(held[-1])
            place = {"file": file_uid, "row_number": numbers[key], "named_run": run}
            insert_fact(connection, "charge", held[-1], {**values, **place})
        else:
            held.append(old.uid)
            found += _keep_corrections(old, row, values)
            if values["stated_run"] != row.stated_run:
                values["named_run"] = find_uid(connection, "run", name=values["stated_run"])  # as a person corrected it
            elif old.named_run is None or row.stated_run != old.stated_run:
                values["named_run"] = run
            update_fact(connection, "charge", old.uid, {**values, "state": str(ChargeState.COUNTED)})
    for uid, entries in history_of_charges(connection, new).items():  # said while no reading gave this charge
        for entry in entries:
            write_statement(connection, uid, entry.new, entry.action)
    _set_gone(connection, standing.values())
    placed = settle(connection, held, before)
    found += findings_on(connection, placed, held)
    files.add_findings(connection, ingest_key, [finding_values(finding) for finding in found])


def mark_charges_gone(context: ApplyContext, file_uid: str) -> None:
    """Set all charges of a file to the state gone; equal rows of other sheets replace them."""
    rows = rows_of_file(context.connection, file_uid)
    _set_gone(context.connection, rows)
    settle(context.connection, [row.uid for row in rows])


def restore_charges(context: ApplyContext, file_uid: str, ingest_key: int, reading: Mapping[str, Any]) -> None:
    """Let the charges of a restored file count as before.

    `reading` is the entry of the reading in force; charges that it lacks stay gone.
    """
    rows = rows_of_file(context.connection, file_uid)
    uids = [row.uid for row in rows if row.row_number in reading["charge_numbers"]]
    for uid in uids:
        update_fact(context.connection, "charge", uid, {"state": str(ChargeState.COUNTED)})
    found = findings_on(context.connection, settle(context.connection, uids), uids)
    files.add_findings(context.connection, ingest_key, [finding_values(finding) for finding in found])


def _set_gone(connection: sa.Connection, rows: Iterable[SheetRow]) -> None:
    for row in rows:
        if row.state is not ChargeState.GONE:
            update_fact(connection, "charge", row.uid, {"state": str(ChargeState.GONE), "run": None, "repeats": None})


def _named_runs(connection: sa.Connection, charges: Sequence[ChargeRow], of_file: str | None) -> list[str | None]:
    """Return the uid of the run that each charge of a file names; the only one may be of the file's run."""
    names = sorted({row.stated_run for row in charges if row.stated_run is not None})
    runs = run_uids_by_name(connection, names)
    return [runs.get(row.stated_run or "") or (of_file if len(charges) == 1 else None) for row in charges]


def _keep_corrections(old: SheetRow, read: ChargeRow, values: dict[str, Any]) -> list[Finding]:
    """Put the values that people corrected in place of those read now; returns where a person's word stands."""
    place = f"Row {old.row_number}" if read.line is None else f"Line {read.line}"
    place += "" if read.member is None or read.line is None else f" of {read.member}"
    found = []
    for name, (before, right) in old.corrected.items():
        if not same_value(values[name], before) and not same_value(values[name], right):
            message = (
                f"{place} says {name}={values[name]}, where {before} stood, and a person corrected that to {right}: "
                f"the correction stands; correct charge:{old.uid} again if the sheet is right."
            )
            found.append(_note("correction_stands", read, message))
    if old.corrected:
        corrected = {name: (values[name], right) for name, (_before, right) in old.corrected.items()}
        values |= {name: right for name, (_before, right) in old.corrected.items()}
        values["corrected"] = canonical(corrected)
    if old.assigned and old.state is not ChargeState.GONE and values["stated_run"] != old.stated_run:
        message = (
            f"{place} names run {read.stated_run} now, and a person said where it belongs: that stands; `labbook "
            "assign` moves it."
        )
        found.append(_note("assignment_stands", read, message))
    return found


_IN_TABLE = tuple(each.name for each in fields_of(ChargeRow) if each.name not in ("row_number", "member"))
"""The fields of a line that are stored as they are; its number is given once, and its pack has a row of its own too."""


_NEW_FILE = "FILE"
"""Stands for a file that is not in the book yet."""


def predicted_findings(connection: sa.Connection, charges: Sequence[ChargeRow], of_run: str | None) -> list[Finding]:
    """Return what would be found of the charges of a file that is not in the book; `of_run` is the file's run."""
    of_file = None if of_run is None else find_uid(connection, "run", name=of_run)
    rows = []
    for read, run in zip(charges, _named_runs(connection, charges, of_file), strict=True):
        values = {name: getattr(read, name) for name in SheetRow.__slots__ if hasattr(read, name)}
        uid = f"{_NEW_FILE}#{read.row_number}"
        rows.append(SheetRow(**values, order=sys.maxsize, uid=uid, file_uid=_NEW_FILE, named_run=run))
    return findings_on(connection, placed_about(connection, rows, in_book=False), [row.uid for row in rows])


def findings_on(connection: sa.Connection, placed: Mapping[str, Place], uids: Iterable[str]) -> list[Finding]:
    """Return which of these charges contradict what their run has, and one finding on all that are known."""
    known, found = [], []
    for row, place in ((placed[uid].row, placed[uid]) for uid in uids):
        if place.other is None:
            continue
        if place.state is not ChargeState.KNOWN:
            name = read_fact(connection, "run", row.assigned_run or row.named_run or "", ["name"])["name"]
            found.append(_contradicts(row, name, place.other))
            continue
        known.append(place)
        if not same_charge(row, place.other):
            message = (
                f"{row.charge_mah:g} mAh is what charge:{place.other.uid} said before a person corrected it to "
                f"{place.other.charge_mah:g} mAh: the correction stands; correct it again if the sheet is right."
            )
            found.append(_note("correction_stands", row, message))
    return [*found, *([_known_already(known, placed)] if known else [])]


def _known_already(known: Sequence[Place], placed: Mapping[str, Place]) -> Finding:
    """Say that rows are known, and whether what they repeat is a charge of their run."""
    lines = [place.row.line for place in known if place.row.line is not None]
    what = "1 row is" if len(known) == 1 else f"{len(known)} rows are"
    others = [place.other for place in known if place.other is not None]
    of_no_run = sum((placed[other.uid].run if other.uid in placed else other.run_uid) is None for other in others)
    if not of_no_run:
        why = "the book has these charges of these runs"
    elif of_no_run < len(known):
        why = f"the book has these charges, {of_no_run} of them of no run (`labbook runs inbox`)"
    else:
        why = f"the book has {'it' if of_no_run == 1 else 'them'} as of no run (`labbook runs inbox`)"
    message = f"{what} known already: {why}, so nothing is added."
    first, more = (lines[0], tuple(lines[1 : MORE_LINES + 1])) if lines else (None, ())
    return Finding(Severity.NOTE, "charge_known", message, first, None, None, len(known), more)


def _contradicts(row: SheetRow, run: str, other: SheetRow) -> Finding:
    """Say that a run has another charge than a row differing."""
    item, where = (each.uid if each.file_uid == _NEW_FILE else f"charge:{each.uid}" for each in (row, other))
    compared = [(name, getattr(row, name), getattr(other, name)) for name in COMPARED]
    differing = {name: value for name, value, before in compared if value is not None and not same_value(value, before)}
    fields = " ".join(
        f"{name}={value:.12g}" if isinstance(value, float) else f"{name}={value}" for name, value in differing.items()
    )
    cure = f"`labbook correct {where} {fields} --why ...`, which settles the row"
    message = (
        f"Run {run} has a charge of {other.charge_mah:g} mAh ({where}); this row waits in the inbox: if that charge is "
        f"wrong, {'correct the sheet' if other.file_uid == _NEW_FILE else cure}; if the pack was charged in two parts, "
        f"add this one, `labbook assign {item} {run} --add`; else `labbook runs dismiss` it."
    )
    return _note("charge_contradicts", row, message)


def _note(rule: str, row: SheetRow | ChargeRow, message: str) -> Finding:
    return Finding(Severity.NOTE, rule, message, row.line, None, f"{row.charge_mah:g} mAh", 1, ())


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
    taken: set[int] = set()
    for content in [*reading_entries(connection, sha256), *([] if new is None else [new])]:
        for key, number in zip(entry_keys(content), content["charge_numbers"], strict=True):
            if key not in numbers and number not in taken:
                numbers[key] = number
                taken.add(number)
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
