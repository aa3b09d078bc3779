"""`labbook assign`: which file or charge is meant, and whether it moves from another run, or to none."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import sqlalchemy as sa

from data_schema.errors import UsageError, unknown_name
from data_schema.queries.charges import SheetRow
from data_schema.queries.imported_files import (
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
from labbook.actions.runs.charges import (
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
        return _take_file_off(session, file, what, why) if run is None else _assign_file(session, file, what, run, why)
    file = file_named(session.connection, name)
    parts = parts_of_file(session.connection, file.uid)
    if place in parts:
        return assign_part(session, file, place, run, why)
    if not place.isdigit():
        raise unknown_name(f"part of {file.name}", place, parts, f"`labbook files show {file.name}` lists them.")
    charge = charge_of(session.connection, file, int(place))
    if run is None:
        return _take_charge_off(session, file, charge, why)
    return _add_charge(session, file, charge, run, why) if add else _assign_charge(session, file, charge, run, why)


def _assign_file(session: WriteSession, file: FileRow, what: str, run: RunRow, why: str | None) -> str:
    links = links_of_file(session.connection, file.uid)
    if any(link.run_uid == run.uid for link in links):
        return f"{what} belongs to run {run.name} already."
    if not links:
        refuse_second_of_file(session.connection, file.uid, file.role, run)
        session.state(Statement(Action.ASSIGN, "file", file.uid, new={"run": run.uid, "role": file.role}, reason=why))
        return f"{what} belongs to run {run.name} now."
    if why is None:
        raise UsageError(f"{what} belongs to run {_names(links)}: add --why to move it to {run.name}.")
    charges = _charges_with(session, file, links)
    for charge in charges:
        if not charge.added:
            refuse_second_charge(session.connection, run.uid, run.name, charge_uid=charge.uid, mode=charge.mode)
    moved: list[tuple[str, str, dict[str, Any]]] = [("run_file", link.uid, {"run": link.run_uid}) for link in links]
    moved += [("charge", item.uid, {"run": item.run_uid} | ({"added": 1} if item.added else {})) for item in charges]
    for kind, uid, old in moved:
        session.state(Statement(Action.CORRECT, kind, uid, new={**old, "run": run.uid}, old=old, reason=why))
    return f"{what} moved to run {run.name}."


def _take_file_off(session: WriteSession, file: FileRow, what: str, why: str | None) -> str:
    links = links_of_file(session.connection, file.uid)
    charges = _charges_with(session, file, links)
    if not links and not charges:
        assigned = [charge for charge in charges_of_file(session.connection, file.uid) if charge.run_uid is not None]
        if assigned:
            first = assigned[0]
            raise UsageError(
                f"the charges of {what} belong to {len(assigned)} runs: take them off one by one, for example "
                f"{what}#{first.row_number}, the charge of run {first.run_name}."
            )
        return f"{what} belongs to no run: `labbook runs inbox` lists it."
    names = _names([*links, *charges])
    if why is None:
        raise UsageError(f"{what} belongs to run {names}: add --why to take it off.")
    if links:
        old = {"runs": sorted({link.run_uid for link in links})}
        session.state(Statement(Action.ASSIGN, "file", file.uid, new={"run": None}, old=old, reason=why))
    for charge in charges:
        _state_no_run(session, charge, why)
    return f"{what} belongs to run {names} no longer: it is in the inbox."


def _charges_with(session: WriteSession, file: FileRow, links: list[Link]) -> list[SheetRow]:
    """Return the charges that follow their file: those of the run it is linked to; without a link, its only one."""
    if file.role != FileRole.CHARGE:
        return []
    charges = charges_of_file(session.connection, file.uid)
    if links:
        runs = {link.run_uid for link in links}
        return [charge for charge in charges if charge.run_uid in runs]
    return [charge for charge in charges if len(charges) == 1 and charge.run_uid is not None]


def _assign_charge(session: WriteSession, file: FileRow, charge: SheetRow, run: RunRow, why: str | None) -> str:
    what = f"charge {charge.row_number} of {file.name}"
    if charge.run_uid != run.uid:
        refuse_second_charge(session.connection, run.uid, run.name, charge_uid=charge.uid, mode=charge.mode)
    if charge.run_uid is None:
        session.state(Statement(Action.ASSIGN, "charge", charge.uid, new={"run": run.uid}, reason=why))
        return f"{what} belongs to run {run.name} now."
    if charge.run_uid == run.uid:
        return f"{what} belongs to run {run.name} already."
    if why is None:
        raise UsageError(f"{what} belongs to another run, {charge.run_name}: add --why to move it to {run.name}.")
    old, new = _with_added(charge, {"run": charge.run_uid}, {"run": run.uid})
    session.state(Statement(Action.CORRECT, "charge", charge.uid, new=new, old=old, reason=why))
    return f"{what} moved to run {run.name}."


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
    new, old = {"run": run.uid, "added": 1}, {"run": None, "added": 0}
    session.state(Statement(Action.ASSIGN, "charge", charge.uid, new=new, old=old, reason=why))
    return f"{what} is added to that of run {run.name}: the sum counts."


def _take_charge_off(session: WriteSession, file: FileRow, charge: SheetRow, why: str | None) -> str:
    what = f"charge {charge.row_number} of {file.name}"
    if charge.run_uid is None:
        return f"{what} belongs to no run: `labbook runs inbox` lists it."
    if why is None:
        raise UsageError(f"{what} belongs to run {charge.run_name}: add --why to take it off.")
    _state_no_run(session, charge, why)
    return f"{what} belongs to run {charge.run_name} no longer: it is in the inbox."


def _state_no_run(session: WriteSession, charge: SheetRow, why: str) -> None:
    old, new = _with_added(charge, {"run": charge.run_uid}, {"run": None})
    session.state(Statement(Action.ASSIGN, "charge", charge.uid, new=new, old=old, reason=why))


def _with_added(charge: SheetRow, old: dict[str, Any], new: dict[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return old and new values of a charge that leaves a run; one that was added there is so no longer."""
    return ({**old, "added": 1}, {**new, "added": 0}) if charge.added else (old, new)


def _names(rows: Sequence[Link | SheetRow]) -> str:
    return ", ".join(sorted({row.run_name for row in rows if row.run_name is not None}))


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


def charge_of(connection: sa.Connection, file: FileRow, row_number: int) -> SheetRow:
    """Return the charge in a row of a file; raises `UsageError` where there is none."""
    for charge in charges_of_file(connection, file.uid):
        if charge.row_number == row_number:
            return charge
    raise UsageError(f"{file.name} has no charge {row_number}: `labbook runs inbox` lists the rows without a run.")


def assign_part(session: WriteSession, file: FileRow, part: str, run: RunRow | None, why: str | None) -> str:
    """Assign a part to a run, or to none; returns a sentence about what was done."""
    what = f"part {part} of {file.name}"
    link = next((link for link in links_of_file(session.connection, file.uid) if link.part == part), None)
    if link is None and run is None:
        return f"{what} belongs to no run: `labbook runs inbox` lists it."
    if link is not None and run is not None and link.run_uid == run.uid:
        return f"{what} belongs to run {run.name} already."
    if link is not None:
        if why is None:
            doing = "take it off" if run is None else f"move it to {run.name}"
            raise UsageError(f"{what} belongs to run {link.run_name}: add --why to {doing}.")
        old = {"runs": [link.run_uid]}
        session.state(Statement(Action.ASSIGN, "file", file.uid, new={"run": None, "part": part}, old=old, reason=why))
        if run is None:
            return f"{what} belongs to run {link.run_name} no longer: it is in the inbox."
    assert run is not None  # noqa: S101 - a part without a run was refused
    new = {"run": run.uid, "role": file.role, "part": part}
    session.state(Statement(Action.ASSIGN, "file", file.uid, new=new, reason=why))
    return f"{what} {'belongs' if link is None else 'moved'} to run {run.name}{' now' if link is None else ''}."
