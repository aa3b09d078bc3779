"""What a rebuild made otherwise than it was made the first time: a newer labbook reads files anew.

The journal has how a file was read, so that this can be compared with what came of it now.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import sqlalchemy as sa

from data_schema.journal import Entry
from data_schema.queries.facts import fact_exists
from data_schema.queries.imports import readings
from data_schema.queries.readings import waiting_files
from data_schema.vocabulary import Action


@dataclass(frozen=True, slots=True)
class Differences:
    """Counts; all are 0 where this labbook reads what the earlier ones did.

    `files_read_anew` were read by another version of their reader,
    `files_changed` of them gave other rows or samples. `files_waiting` has for each file that this labbook refuses, and
    an earlier one read, what it waits for. `without_rows` names each statement about a charge or a part of a file that
    no reading gives now. `other_versions`: another version of a reader made some of it.
    """

    files_read_anew: int = 0
    files_changed: int = 0
    files_waiting: tuple[str, ...] = ()
    without_rows: tuple[str, ...] = ()
    other_versions: bool = False

    @property
    def sentences(self) -> list[str]:
        """Return a sentence for each difference; none where all agrees."""
        found = []
        if self.files_read_anew:
            result = (
                f"{self.files_changed} of them with another result" if self.files_changed else "with the same result"
            )
            found.append(
                f"{_counted(self.files_read_anew, 'file')} went through another version of their reader than at their "
                f"import, {result}."
            )
        return [*found, *self.files_waiting, *self.without_rows]


def differences(connection: sa.Connection, entries: Iterable[Entry], without_rows: Sequence[Entry] = ()) -> Differences:
    """Compare a rebuilt database with the entries of its journal on files.

    `without_rows` are the statements about rows that were not there when they were replayed; those about charges have
    taken effect where a later reading gave the charge.
    """
    now = readings(connection)
    anew = []
    for entry in entries:
        if entry.action in (Action.INGEST, Action.READ) and entry.entity_uid in now:
            content, reading = entry.new or {}, now[entry.entity_uid]
            if (content["reader"], content["reader_version"]) != (reading.reader, reading.reader_version):
                anew.append((content["rows"], content["signals"]) != (reading.rows, reading.signals))
    return Differences(
        files_read_anew=len(anew),
        files_changed=sum(anew),
        other_versions=bool(anew),
        files_waiting=tuple(f"{waiting.why.reason}." for waiting in waiting_files(connection)),
        without_rows=tuple(
            _without_row(entry)
            for entry in without_rows
            if entry.entity_kind != "charge" or not fact_exists(connection, "charge", entry.entity_uid)
        ),
    )


def _without_row(entry: Entry) -> str:
    why = f" ({entry.reason})" if entry.reason else ""
    return (
        f"Entry {entry.seq} of {entry.person}, {entry.action} {entry.entity_kind} {entry.entity_uid}{why}, speaks of "
        "what no reading of its file gives now: it has no effect until one does, see `labbook files show`."
    )


def _counted(count: int, what: str) -> str:
    return f"{count} {what}" if count == 1 else f"{count} {what}s"
