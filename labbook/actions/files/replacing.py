"""A file taken in while it was still being written is withdrawn for what it became, which begins with its bytes.

The book keeps the names of files, not the folders that they lay in, and a stick is mounted elsewhere tomorrow. So the
earlier file is one of the same name in use whose every byte the later one begins with, which no two logs share.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import sqlalchemy as sa

from data_schema.queries.charges import SheetRow
from data_schema.queries.detections import jump_decisions
from data_schema.queries.files import (
    FileRow,
    Link,
    charges_of_file,
    find_files,
    last_reading,
    links_of_file,
    signals_of_file,
)
from data_schema.queries.history import statements_about
from data_schema.vocabulary import Action, FileRole, IngestStatus, Verdict
from ingest.model import ChargeRow
from ingest.store import Store, raw_path
from labbook.actions.files.stored_files import withdraw
from labbook.book.write_session import Statement, WriteSession
from labbook.statements.apply_context import derived_uid
from labbook.statements.counted_charges import same_value


@dataclass(frozen=True, slots=True)
class Beginnings:
    """Files in use that a later one begins with, the longest last, and what of that one holds for the later.

    `options` were declared about it; `links` are its runs. `unlinked`: a person took it off its run.
    """

    files: tuple[FileRow, ...]
    options: Mapping[str, Any]
    links: tuple[Link, ...]
    unlinked: bool

    @property
    def run(self) -> Link | None:
        """The link to the one run that all of the file belongs to; None where it has none, or several."""
        return self.links[0] if len({link.run_uid for link in self.links}) == 1 else None


def beginnings(connection: sa.Connection, store: Store, name: str, data: bytes, sha256: str) -> Beginnings | None:
    """Find the other files of a name in use that these bytes begin with; None where there are none."""
    found = [row for row in _others(connection, name, sha256) if store.is_beginning(raw_path(row.sha256), data)]
    if not found:
        return None
    last = found[-1]
    reading = last_reading(connection, last.sha256)
    assert reading is not None  # noqa: S101 - it is in use
    links = tuple(links_of_file(connection, last.uid))
    unlinked = not links and bool(statements_about(connection, last.uid, Action.SET))
    return Beginnings(tuple(found), json.loads(reading.options_json), links, unlinked)


def whole_of(connection: sa.Connection, store: Store, name: str, data: bytes, sha256: str) -> FileRow | None:
    """Find a file of a name in use that begins with these bytes and has more; None where there is none."""
    whole = (
        row for row in _others(connection, name, sha256) if store.is_beginning(raw_path(row.sha256), data) is False
    )
    return next(whole, None)


def _others(connection: sa.Connection, name: str, sha256: str) -> list[FileRow]:
    """Return the files in use that have a name and not these bytes."""
    return [
        row
        for row in find_files(connection, name)
        if row.name == name and row.sha256 != sha256 and row.status in (IngestStatus.IMPORTED, IngestStatus.WAITING)
    ]


def withdraw_beginnings(
    session: WriteSession, found: Beginnings, sha256: str, charges: Sequence[ChargeRow]
) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Withdraw the files that one with this hash, about to be stated, begins with.

    One whose charges all stand in `charges`, those of the later file, stays: a sheet of recharges that grew says again
    what people may have corrected.

    Returns:
        uids of the files withdrawn; sentences on what a person has to do again.
    """
    replaced, again = [], []
    for row in found.files:
        if row.role == FileRole.CHARGE and _stand_in(charges_of_file(session.connection, row.uid), charges):
            continue
        decided = jump_decisions(session.connection, signals_of_file(session.connection, row.uid))
        verdicts = {(one.signal_sha256, one.anchor_s): one.verdict for several in decided.values() for one in several}
        standing = sum(verdict is not Verdict.CLEAR for verdict in verdicts.values())
        withdraw(session, row.uid, f"it was still being written: {row.name} ({sha256[:12]}) begins with its bytes")
        replaced.append(row.uid)
        if standing:
            runs = sorted({link.run_name for link in found.links})
            shown = runs[0] if runs else "RUN"
            again.append(
                f"{standing} verdict{'' if standing == 1 else 's'} on jumps of {row.name} as it was before "
                f"{'is' if standing == 1 else 'are'} to be given again: `labbook show {shown}` has them."
            )
    return tuple(replaced), tuple(again)


def state_links(session: WriteSession, found: Beginnings, sha256: str, parts: Sequence[str]) -> None:
    """State that the parts of the later file belong to runs as those of the earlier did, where these were several."""
    if found.run is not None:
        return
    for link in found.links:
        if link.part in parts:
            new = {"run": link.run_uid, "role": link.role, "part": link.part}
            session.state(Statement(Action.SET, "file", derived_uid("file", sha256), new=new, old={"runs": []}))


def _stand_in(before: Sequence[SheetRow], charges: Sequence[ChargeRow]) -> bool:
    """Tell whether all charges of a file, as they were read, are among those of another."""
    left = [(row.stated_run, row.charge_mah) for row in charges]
    for row in before:
        read = (
            row.corrected.get("stated_run", (row.stated_run,))[0],
            row.corrected.get("charge_mah", (row.charge_mah,))[0],
        )
        same = next((one for one in left if one[0] == read[0] and same_value(one[1], read[1])), None)
        if same is None:
            return False
        left.remove(same)
    return bool(before)
