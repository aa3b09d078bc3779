"""What a rebuild made otherwise than it was made the first time: a newer labbook computes and reads anew.

The journal keeps what a report showed and how a file was read, so both can be compared with what came of them now.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import sqlalchemy as sa

from data_schema.journal import Entry
from data_schema.queries.facts import fact_exists
from data_schema.queries.imports import readings
from data_schema.queries.readings import waiting_files
from data_schema.queries.reports import shown_numbers
from data_schema.vocabulary import Action
from labbook.analysis.results.result_cache import equals_printed


@dataclass(frozen=True, slots=True)
class Differences:
    """Counts; all are 0 where this labbook computes and reads what the earlier ones did.

    `numbers_gone` shown numbers of `reports_concerned` reports could not be computed again under their ids,
    `numbers_changed` could, and have another value; `files_read_anew` were read by another version of their reader,
    `files_changed` of them gave other rows or samples. `files_waiting` has for each file that this labbook refuses, and
    an earlier one read, what it waits for. `without_rows` names each statement about a charge or a part of a file that
    no reading gives now. `other_versions`: another version of a reader or an algorithm made some of it.
    """

    numbers_gone: int = 0
    reports_concerned: int = 0
    numbers_changed: int = 0
    files_read_anew: int = 0
    files_changed: int = 0
    files_waiting: tuple[str, ...] = ()
    without_rows: tuple[str, ...] = ()
    other_versions: bool = False

    @property
    def sentences(self) -> list[str]:
        """Return a sentence for each difference; none where all agrees."""
        found = []
        if self.numbers_gone:
            explained = self.other_versions or self.files_waiting or self.without_rows
            why = (
                "an algorithm or a reader has another version now"
                if explained
                else "what they rest on had been altered in the database when they were computed"
            )
            found.append(
                f"{_counted(self.numbers_gone, 'shown number')} of {_counted(self.reports_concerned, 'report')} could "
                f"not be computed again under their ids ({why}); `labbook why` still tells what was printed."
            )
        if self.numbers_changed:
            found.append(
                f"{_counted(self.numbers_changed, 'shown number')} came out with another value than was printed; "
                "`labbook why` tells both."
            )
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
    """Compare a rebuilt database with the entries of its journal on reports and files.

    `without_rows` are the statements about rows that were not there when they were replayed; those about charges have
    taken effect where a later reading gave the charge.
    """
    from labbook.analysis.algorithms import versions_now  # what computes, and takes long to import

    shown = shown_numbers(connection)
    gone = [item for item in shown if item.result_uid is None]
    changed = [item for item in shown if item.result_uid and not equals_printed(item.value, item.value_now)]
    now = readings(connection)
    versions, other_algorithms, anew = versions_now(), False, []
    for entry in entries:
        content = entry.new or {}
        if entry.action is Action.REPORT:
            other_algorithms |= any(versions.get(name) != made for name, made in content.get("versions", {}).items())
        elif entry.action in (Action.INGEST, Action.READ) and entry.entity_uid in now:
            reading = now[entry.entity_uid]
            if (content["reader"], content["reader_version"]) != (reading.reader, reading.reader_version):
                anew.append((content["rows"], content["signals"]) != (reading.rows, reading.signals))
    return Differences(
        numbers_gone=len(gone),
        reports_concerned=len({item.report_uid for item in gone}),
        numbers_changed=len(changed),
        files_read_anew=len(anew),
        files_changed=sum(anew),
        other_versions=bool(anew) or other_algorithms,
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
