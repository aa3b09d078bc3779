"""Verdicts on jumps that no reading in force has the samples of: they wait for a person."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import sqlalchemy as sa

from data_schema.chunks import in_chunks
from data_schema.queries.detections import same_times
from data_schema.tables.files import LAST_READING, file, ingest
from data_schema.tables.people import person
from data_schema.tables.runs import decision, run
from data_schema.tables.signals import signal
from data_schema.vocabulary import IngestStatus, TargetKind, Verdict


@dataclass(frozen=True, slots=True)
class WaitingVerdict:
    """A verdict that was given on samples of a reading that is not in force any more.

    `file_name` is None where no reading of this book has such samples: another version of a reader made them.
    """

    run: str
    run_uid: str
    signal_sha256: str
    anchor_s: float
    verdict: Verdict
    reason_code: str
    person: str
    at_utc: str
    file_name: str | None

    @property
    def sentence(self) -> str:
        """Say what waits, and how it is settled."""
        return (
            f"waiting for review: run {self.run}: {self.verdict} at {self.anchor_s:.3f} s ({self.reason_code}) by "
            f"{self.person} on {self.at_utc} was given on samples that are not in force: give it again with `labbook "
            f"jumps {self.verdict} {self.run} NUMBER`, then `labbook jumps clear {self.run} waiting`."
        )


def verdicts_waiting(connection: sa.Connection, run_uid: str | None = None) -> list[WaitingVerdict]:
    """Return the verdicts whose samples are in no reading in force, of all runs or of one; not of withdrawn files."""
    query = (
        sa.select(
            run.c.name,
            run.c.uid,
            decision.c.signal_sha256,
            decision.c.anchor_s,
            decision.c.verdict,
            decision.c.reason_code,
            person.c.name,
            decision.c.at_utc,
        )
        .join(run, run.c.uid == decision.c.target_uid)
        .join(person, decision.c.person == person.c.id)
        .where(decision.c.target_kind == str(TargetKind.JUMP))
        .order_by(decision.c.id)
    )
    if run_uid is not None:
        query = query.where(run.c.uid == run_uid)
    rows = connection.execute(query).all()
    given_on = sorted({row.signal_sha256 for row in rows})
    holds, names = same_times(connection, given_on=given_on), _names(connection, given_on)
    last: dict[tuple[str, str, float], WaitingVerdict] = {}
    for row in rows:
        sha256 = row.signal_sha256
        name, withdrawn = names.get(sha256, (None, False))
        if sha256 in holds or withdrawn:
            continue
        last[row[1], sha256, row.anchor_s] = WaitingVerdict(*row[:4], Verdict(row.verdict), *row[5:], name)
    return [item for item in last.values() if item.verdict is not Verdict.CLEAR]


def _names(connection: sa.Connection, hashes: Sequence[str]) -> dict[str, tuple[str, bool]]:
    """Return, by the hashes of samples, the name of their file and whether that is withdrawn."""
    found = {}
    for some in in_chunks(hashes):
        query = (
            sa.select(signal.c.sha256, signal.c.recorded_sha256, ingest.c.original_name, ingest.c.status)
            .join(file, signal.c.file == file.c.id)
            .join(ingest, sa.and_(ingest.c.file == file.c.id, LAST_READING))
            .where(sa.or_(signal.c.sha256.in_(some), signal.c.recorded_sha256.in_(some)))
            .order_by(signal.c.id)
        )
        for row in connection.execute(query):
            for sha256 in {row.sha256, row.recorded_sha256} - {None}:
                found[sha256] = (row.original_name, row.status == IngestStatus.WITHDRAWN)
    return found
