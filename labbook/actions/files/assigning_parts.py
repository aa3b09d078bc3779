"""`labbook assign NAME#PART`: one part of a file that holds several runs belongs to its own."""

from __future__ import annotations

from data_schema.errors import UsageError
from data_schema.queries.imported_files import FileRow, links_of_file
from data_schema.queries.runs import RunRow
from data_schema.vocabulary import Action
from labbook.book.write_session import Statement, WriteSession


def assign_part(session: WriteSession, file: FileRow, part: str, run: RunRow | None, why: str | None) -> str:
    """Let a part belong to a run, or to none; returns the sentence that says what was done."""
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
