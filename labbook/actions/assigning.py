"""`labbook assign`: which file or charge is meant, and whether it moves from another run."""

from __future__ import annotations

from data_schema.errors import UsageError, unknown_name
from data_schema.queries.imports import FileRow, charge_of_row, find_files, imported_names, links_of_file
from data_schema.vocabulary import Action
from labbook.book.desk import Desk, Statement
from labbook.book.naming import refuse_empty, run_named


def assign(desk: Desk, what: str, run_name: str, why: str | None) -> str:
    """State the assignment; returns the sentence that says what was done."""
    if why is not None:
        refuse_empty("--why", why)
    run = run_named(desk.connection, run_name)
    name, mark, row_text = what.rpartition("#")
    if mark and row_text.isdigit():
        return _assign_charge(desk, _the_file(desk, name), int(row_text), run.uid, run_name, why)
    file = _the_file(desk, what)
    links = links_of_file(desk.connection, file.uid)
    if any(link.run_uid == run.uid for link in links):
        raise UsageError(f"{what} belongs to run {run_name} already.")
    if not links:
        desk.state(Statement(Action.ASSIGN, "file", file.uid, new={"run": run.uid, "role": file.role}, reason=why))
        return f"{what} belongs to run {run_name} now."
    if why is None:
        names = ", ".join(sorted({link.run_name for link in links}))
        raise UsageError(f"{what} belongs to run {names}: add --why to move it to {run_name}.")
    for link in links:
        old, new = {"run": link.run_uid}, {"run": run.uid}
        desk.state(Statement(Action.CORRECT, "run_file", link.uid, new=new, old=old, reason=why))
    return f"{what} moved to run {run_name}."


def _assign_charge(desk: Desk, file: FileRow, row: int, run_uid: str, run_name: str, why: str | None) -> str:
    charge = charge_of_row(desk.connection, file.uid, row)
    if charge is None:
        raise UsageError(f"{file.name} has no charge {row}: `labbook runs inbox` lists the rows without a run.")
    if charge.run_uid is None:
        desk.state(Statement(Action.ASSIGN, "charge", charge.uid, new={"run": run_uid}, reason=why))
        return f"charge {row} of {file.name} belongs to run {run_name} now."
    if charge.run_uid == run_uid:
        raise UsageError(f"charge {row} of {file.name} belongs to run {run_name} already.")
    if why is None:
        raise UsageError(f"charge {row} of {file.name} belongs to another run: add --why to move it to {run_name}.")
    old, new = {"run": charge.run_uid}, {"run": run_uid}
    desk.state(Statement(Action.CORRECT, "charge", charge.uid, new=new, old=old, reason=why))
    return f"charge {row} of {file.name} moved to run {run_name}."


def _the_file(desk: Desk, name: str) -> FileRow:
    found = find_files(desk.connection, name)
    if not found:
        raise unknown_name("imported file", name, imported_names(desk.connection), "Ingest it first.")
    if len(found) > 1:
        listed = ", ".join(f"{row.uid} ({row.at_utc})" for row in found)
        raise UsageError(f"{len(found)} imported files are called {name!r}: name one by its uid: {listed}.")
    return found[0]
