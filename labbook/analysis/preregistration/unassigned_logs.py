"""Logs that were taken off a run that had them, and the run that has them now."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import sqlalchemy as sa

from data_schema.outcomes import Outcome
from data_schema.queries.changes import Change, file_links, roles_and_names_of_files
from data_schema.vocabulary import FileRole
from labbook.analysis.preregistration.study_history import StudyHistory


@dataclass(frozen=True, slots=True)
class UnassignedLog:
    """A log that a run had and has no more; `to` is the uid of the run that it was given to, None for none."""

    name: str
    file_uid: str
    run: str
    to: str | None
    change: Change


def unassigned_logs(connection: sa.Connection, study_history: StudyHistory) -> list[UnassignedLog]:
    """Return the logs that runs had and have no more.

    As with charges it is the difference in the end that counts: the run that a log was first given to had it. One that
    it was moved to, and left again, had it only where a report saw it there.
    """
    links = file_links(connection)
    linked, file_of = {(link.file_uid, link.run_uid) for link in links}, {link.uid: link.file_uid for link in links}
    file_of |= _files_of_gone_links(study_history.changes, file_of)
    known = roles_and_names_of_files(connection)
    first: dict[str, list[str]] = {}
    found: dict[tuple[str, str], UnassignedLog] = {}
    for change in study_history.changes:
        if change.kind not in ("file", "run_file"):
            continue
        file_uid = change.uid if change.kind == "file" else file_of.get(change.uid, "")
        # Of a link that is gone it may be unknown which file it was of; that a log was taken off is known.
        role, name = known.get(file_uid, (str(FileRole.LOG), "a file"))
        if role != FileRole.LOG:
            continue
        to = next((link.run_uid for link in links if link.file_uid == file_uid), None)
        had = _runs_before(change)
        first.setdefault(file_uid or change.uid, had or [change.new["run"]])
        for run_uid in had:
            its_own = run_uid in first[file_uid or change.uid] or _seen_there(study_history, file_uid, run_uid)
            if its_own and (file_uid, run_uid) not in linked:
                found[file_uid or change.uid, run_uid] = UnassignedLog(name, file_uid, run_uid, to, change)
    return list(found.values())


def _runs_before(change: Change) -> list[str]:
    """Return the runs that a file belonged to before a change."""
    return list(change.old.get("runs", [change.old["run"]] if change.old.get("run") else []))


def _seen_there(study_history: StudyHistory, file_uid: str, run_uid: str) -> bool:
    """Tell whether a report was made while a run had a log."""
    of_run = study_history.arrivals[Outcome.APEX].get(run_uid, ())
    return any(item.uid == file_uid and item.belonged(made) for item in of_run for made in study_history.reports)


def _files_of_gone_links(changes: Sequence[Change], there: Mapping[str, str]) -> dict[str, str]:
    """Find of which file a moved link was that is gone: of the only one later taken off the run that it moved to."""
    last = {item.uid: item for item in changes if item.kind == "run_file" and item.uid not in there}
    found = {}
    for uid, moved in last.items():
        taken = {item.uid for item in changes if item.seq > moved.seq and _takes_off(item, moved.new["run"])}
        if len(taken) == 1:
            found[uid] = taken.pop()
    return found


def _takes_off(change: Change, run_uid: str) -> bool:
    return change.kind == "file" and change.new.get("run") is None and run_uid in _runs_before(change)
