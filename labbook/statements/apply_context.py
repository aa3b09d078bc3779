"""What a statement acts on: the open transaction, the store, and on replaying which reports need no computing."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import sqlalchemy as sa

from data_schema.errors import UnknownName
from data_schema.journal import Entry
from data_schema.queries.facts import find_uid, read_fact
from data_schema.queries.study import person_uid
from data_schema.vocabulary import Action, RunKind
from ingest.store import Store

if TYPE_CHECKING:
    from labbook.presenting.report.content import MadeReport


@dataclass(frozen=True, slots=True)
class ApplyContext:
    """The open transaction and the store of files.

    `without_rows` is None while a person makes statements; on replaying the journal it collects the statements about
    charges and links that no reading of their file gives now.
    """

    connection: sa.Connection
    store: Store
    without_rows: list[Entry] | None = None


def inputs_around_run(context: ApplyContext, run_uid: str) -> list[tuple[str, str]]:
    """Return (kind, uid) of the inputs of results that change when something is added to a run.

    These are the run itself, its condition, and for an idle run the idle runs of its robot.
    """
    return inputs_around(run_uid, read_fact(context.connection, "run", run_uid, ["kind", "condition", "robot"]))


def inputs_around(run_uid: str, run: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Return the same for a run whose columns are known."""
    found = [("run", run_uid)]
    if run["condition"] is not None:
        found.append(("condition", run["condition"]))
    if run["kind"] == RunKind.IDLE:
        found.append(("idle_runs", run["robot"]))
    return found


def with_author(context: ApplyContext, entry: Entry, values: Mapping[str, Any]) -> dict[str, Any]:
    """Add person and time of the statement to the columns of a row that has these two."""
    return {**values, "person": person_uid(context.connection, entry.person), "at_utc": entry.at_utc}


def run_named(context: ApplyContext, name: str | None) -> str | None:
    """Return the uid of the run of this name, if there is one."""
    return find_uid(context.connection, "run", name=name) if name else None


def missing_row(context: ApplyContext, entry: Entry) -> None:
    """Collect a statement about a missing row where the journal is replayed, which nothing may stop.

    A newer reader may give fewer rows than an earlier one, and a file may wait for a declaration. A statement about a
    charge takes effect when a reading gives it. Raises `UnknownName` for a statement that is being made now.
    """
    if context.without_rows is None:
        raise UnknownName(
            f"there is no {entry.entity_kind} with uid {entry.entity_uid!r}: list what there is and use a name from "
            "there."
        )
    context.without_rows.append(entry)


def derived_uid(*parts: object) -> str:
    """Name a row after what it was derived from, so that deriving it again gives the same name."""
    return hashlib.sha256("\n".join(str(part) for part in parts).encode()).hexdigest()[:16]


@dataclass
class ReplayedReports:
    """During a replay of the journal: which reports would compute nothing if they were made once more.

    `settled` are the selections of those that computed nothing and renewed nothing when they were made, and after which
    nothing was stated but reports that did not either. Most reports of a book see the same rows as the one before.
    """

    settled: set[str | None] = field(default_factory=set)

    def note_entry(self, entry: Entry) -> None:
        """Take note that an entry is about to take effect."""
        if entry.action is not Action.REPORT:
            self.settled.clear()

    def note_report(self, where: str | None, made: MadeReport) -> None:
        """Take note of a report that was computed."""
        if made.cache.computed or made.detections.computed or any(row.stale for row in made.cache.reused.values()):
            self.settled.clear()
        else:
            self.settled.add(where)
