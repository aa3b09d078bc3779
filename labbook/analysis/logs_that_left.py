"""Logs that were taken off a run that had them, and the run that has them now."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import sqlalchemy as sa

from data_schema.queries.changes import Change, file_links, roles_and_names_of_files
from data_schema.vocabulary import FileRole


@dataclass(frozen=True, slots=True)
class LogThatLeft:
    """A log that a run had and has no more; `to` is the uid of the run that it was given to, None for none."""

    name: str
    file_uid: str
    run: str
    to: str | None
    change: Change


def logs_that_left(connection: sa.Connection, changes: Sequence[Change]) -> list[LogThatLeft]:
    """Return the logs that runs had and have no more."""
    links = file_links(connection)
    linked, file_of = {(link.file_uid, link.run_uid) for link in links}, {link.uid: link.file_uid for link in links}
    known = roles_and_names_of_files(connection)
    found: dict[tuple[str, str], LogThatLeft] = {}
    for change in changes:
        if change.kind not in ("file", "run_file"):
            continue
        file_uid = change.uid if change.kind == "file" else file_of.get(change.uid, "")
        # A link that is gone names no file any more: what it was is not known, that it was taken off is.
        role, name = known.get(file_uid, (str(FileRole.LOG), "a file"))
        if role != FileRole.LOG:
            continue
        to = next((link.run_uid for link in links if link.file_uid == file_uid), None)
        for run_uid in change.old.get("runs", [change.old["run"]] if change.old.get("run") else []):
            if (file_uid, run_uid) not in linked:
                found[file_uid or change.uid, run_uid] = LogThatLeft(name, file_uid, run_uid, to, change)
    return list(found.values())
