"""`labbook assign`: which file or charge is meant, and whether it moves from another run, or to none."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import sqlalchemy as sa

from data_schema.errors import UsageError, unknown_name
from data_schema.queries.charges import SheetRow, charges_of_run
from data_schema.queries.files import (
    FileRow,
    Link,
    charges_of_file,
    find_files,
    links_of_file,
    parts_of_file,
    place_of_charge,
)
from data_schema.queries.runs import RunRow
from data_schema.vocabulary import Action, ChargeMode, FileRole
from labbook.actions.files.named_files import file_named
from labbook.actions.runs.correcting import (
    refuse_added_to_nothing,
    refuse_second_charge,
    refuse_second_of_file,
)
from labbook.book.naming import refuse_empty, run_named
from labbook.book.write_session import Statement, WriteSession

NO_RUN = "none"
"""Stands where a run's name would: the file or charge belongs to no run."""


def assign(session: WriteSession, what: str, run_name: str, why: str | None, *, add: bool = False) -> str:
    """State the assignment, of a charge with `add` beside that of the run; returns a sentence about what was done."""
    if why is not None:
        refuse_empty("--why", why)
    run = None if run_name == NO_RUN else run_named(session.connection, run_name)
    what = resolve_item(session.connection, what)
    name, mark, place = what.rpartition("#")
    if add and (run is None or not place.isdigit()):
        raise UsageError(f"--add gives a run one more charge: name its row, as NAME#2, and its run, not {what}.")
    if not mark or not (place.isdigit() or find_files(session.connection, name)):
        file = file_named(session.connection, what)
        if file.role == FileRole.SHEET:
            raise UsageError(f"{what} is for a study and belongs to no run: `labbook study --help` lists them.")
        return _assign_file(session, file, what, run, why)
    file = file_named(session.connection, name)
    parts = parts_of_file(session.connection, file.uid)
    if place in parts:
        return _assign_part(session, file, place, run, why)
    if not place.isdigit():
        raise unknown_name(f"part of {file.name}", place, parts, f"`labbook files show {file.name}` lists them.")
    charge = charge_of(session.connection, file, int(place))
    if add and run is not None:
        return _add_charge(session, file, charge, run, why)
    return _assign_charge(session, file, charge, run, why)


def _moved(
    what: str, before: Sequence[Link | SheetRow], run: RunRow | None, why: str | None, state: Callable[[], None]
) -> str:
    """Let something that belonged to the runs of `before` belong to another run, or to none; returns what was done."""
    names = {row.run_name: "" for row in before if row.run_name is not None}
    held = ", ".join(sorted(names))
    if run is not None and run.name in names:
        return f"{what} belongs to run {run.name} already."
    if run is None and not held:
        return f"{what} belongs to no run: `labbook runs inbox` lists it."
    if held and why is None:
        doing = "take it off" if run is None else f"move it to {run.name}"
        raise UsageError(f"{what} belongs to run {held}: add --why to {doing}.")
    state()
    if run is None:
        return f"{what} belongs to run {held} no longer: it is in the inbox."
    return f"{what} moved to run {run.name}." if held else f"{what} belongs to run {run.name} now."


def _assign_file(session: WriteSession, file: FileRow, what: str, run: RunRow | None, why: str | None) -> str:
    links = links_of_file(session.connection, file.uid)
    every = charges_of_file(session.connection, file.uid) if file.role == FileRole.CHARGE else []
    runs = {link.run_uid for link in links}
    alone = len(every) == 1 and not links and run is None
    # a file's charges follow it: those of its run, or without one its only one
    charges = [charge for charge in every if charge.run_uid in runs or (alone and charge.run_uid is not None)]
    assigned = [charge for charge in every if charge.run_uid is not None]
    if run is None and assigned and not links and not charges:
        first = assigned[0]
        raise UsageError(
            f"the charges of {what} belong to {len(assigned)} runs: take them off one by one, for example "
            f"{what}#{first.row_number}, the charge of run {first.run_name}."
        )

    def state() -> None:
        if run is None:
            if links:
                _state(session, "file", file.uid, {"runs": sorted(runs)}, {"run": None}, why)
            for charge in charges:
                _state_charge(session, charge, None, why)
        elif not links:
            refuse_second_of_file(session.connection, file.uid, file.role, run)
            _state(session, "file", file.uid, {"runs": []}, {"run": run.uid, "role": file.role}, why)
        else:
            for charge in charges:
                if not charge.added:
                    refuse_second_charge(session.connection, run.uid, run.name, charge_uid=charge.uid, mode=charge.mode)
            for link in links:
                _state(session, "run_file", link.uid, {"run": link.run_uid}, {"run": run.uid}, why)
            for charge in charges:
                added = {"added": 1} if charge.added else {}
                old, new = {"run": charge.run_uid, **added}, {"run": run.uid, **added}
                _state(session, "charge", charge.uid, old, new, why)

    return _moved(what, [*links, *charges] if run is None else links, run, why, state)


def _assign_part(session: WriteSession, file: FileRow, part: str, run: RunRow | None, why: str | None) -> str:
    links = [link for link in links_of_file(session.connection, file.uid) if link.part == part]

    def state() -> None:
        for link in links:
            _state(session, "file", file.uid, {"runs": [link.run_uid]}, {"run": None, "part": part}, why)
        if run is not None:
            new = {"run": run.uid, "role": file.role, "part": part}
            _state(session, "file", file.uid, {"runs": []}, new, why)

    return _moved(f"part {part} of {file.name}", links, run, why, state)


def _assign_charge(session: WriteSession, file: FileRow, charge: SheetRow, run: RunRow | None, why: str | None) -> str:
    def state() -> None:
        if run is not None:
            refuse_second_charge(session.connection, run.uid, run.name, charge_uid=charge.uid, mode=charge.mode)
        _state_charge(session, charge, run, why)

    return _moved(f"charge {charge.row_number} of {file.name}", [charge], run, why, state) + _instead(session, charge)


def _instead(session: WriteSession, charge: SheetRow) -> str:
    """Say which row that waited is the charge of the run that a charge has left."""
    of_run = [] if charge.run_uid is None or charge.added else charges_of_run(session.connection, charge.run_uid)
    others = [row for row in of_run if row.uid != charge.uid and row.mode == charge.mode and not row.added]
    places = [place_of_charge(session.connection, row.uid) for row in others]
    return f" {places[0]} waited, and is the charge of run {charge.run_name} now." if places else ""


def _add_charge(session: WriteSession, file: FileRow, charge: SheetRow, run: RunRow, why: str | None) -> str:
    what = f"charge {charge.row_number} of {file.name}"
    if charge.run_uid == run.uid and charge.added:
        return f"{what} is added to that of run {run.name} already."
    if charge.run_uid is not None:
        raise UsageError(
            f"{what} belongs to run {charge.run_name}: take it off first, `labbook assign {file.name}#"
            f"{charge.row_number} none --why ...`."
        )
    if charge.mode != ChargeMode.CHARGE:
        raise UsageError(f"{what} is a discharge, which adds nothing to the charge of a run: leave --add out.")
    refuse_added_to_nothing(session.connection, run)
    old, new = {"run": None, "added": 0}, {"run": run.uid, "added": 1}
    _state(session, "charge", charge.uid, old, new, why)
    return f"{what} is added to that of run {run.name}: the sum counts."


def _state_charge(session: WriteSession, charge: SheetRow, run: RunRow | None, why: str | None) -> None:
    """State which run a charge belongs to; one that was added to that of the run which it leaves is so no longer."""
    old: dict[str, Any] = {"run": charge.run_uid}
    new: dict[str, Any] = {"run": None if run is None else run.uid}
    if charge.added:
        old, new = {**old, "added": 1}, {**new, "added": 0}
    _state(session, "charge", charge.uid, old, new, why)


def _state(
    session: WriteSession,
    kind: str,
    uid: str,
    old: Mapping[str, Any],
    new: Mapping[str, Any],
    why: str | None,
) -> None:
    session.state(Statement(Action.SET, kind, uid, new=new, old=old, reason=why))


def resolve_item(connection: sa.Connection, what: str) -> str:
    """Return an item of the inbox as it is called there, FILE#ROW, where the uid of a charge was given, as is shown."""
    uid = what.removeprefix("charge:")
    place = place_of_charge(connection, uid)
    if place is None:
        return what
    name, _mark, row = place.rpartition("#")
    files = find_files(connection, name)
    of_charge = [file for file in files if any(each.uid == uid for each in charges_of_file(connection, file.uid))]
    return place if len(files) == 1 else f"{of_charge[0].uid}#{row}"


def item_named(connection: sa.Connection, what: str) -> tuple[str, SheetRow | None]:
    """Return an item of the inbox as it is called there, and the charge where it is a row of a sheet, not a file."""
    what = resolve_item(connection, what)
    name, mark, row = what.rpartition("#")
    return what, charge_of(connection, file_named(connection, name), int(row)) if mark and row.isdigit() else None


def charge_of(connection: sa.Connection, file: FileRow, row_number: int) -> SheetRow:
    """Return the charge in a row of a file; raises `UsageError` where there is none."""
    for charge in charges_of_file(connection, file.uid):
        if charge.row_number == row_number:
            return charge
    raise UsageError(f"{file.name} has no charge {row_number}: `labbook runs inbox` lists the rows without a run.")
