"""Jumps that detectors found, verdicts of people on them, and those on samples that are not in force."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from operator import attrgetter
from typing import Any

import sqlalchemy as sa

from data_schema.tables.base import CHUNK, columns_of, in_chunks
from data_schema.tables.files import LAST_READING, file, ingest
from data_schema.tables.journal import person
from data_schema.tables.plain import fetch, insert_all
from data_schema.tables.runs import decision, run
from data_schema.tables.signals import detection, jump, signal
from data_schema.vocabulary import IngestStatus, ReasonCode, TargetKind, Verdict


@dataclass(frozen=True, slots=True)
class JumpRow:
    """One jump of a detection; times in s on the log's own clock, heights in m."""

    uid: str
    number: int
    touchdown_s: float | None
    liftoff_s: float | None
    apex_s: float | None
    apex_height_m: float | None
    apex_height_se_m: float | None
    undefined_reason: str | None
    flight_time_s: float | None
    samples_used: int
    gap_touched: bool
    flags: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class DetectionRow:
    """What one algorithm found in one signal."""

    uid: str
    key: str
    algorithm: str
    version: int
    signal_sha256: str
    parameters_json: str
    jumps: tuple[JumpRow, ...]


@dataclass(frozen=True, slots=True)
class DecisionRow:
    """A person's verdict on the jump nearest to `anchor_s` of a signal; later ones replace earlier ones.

    `blind`: it was given without sight of condition, run and the verdicts of others. `at_s` is where a person put the
    apex of a jump that was moved or added.
    """

    uid: str
    signal_sha256: str
    anchor_s: float
    verdict: Verdict
    reason_code: ReasonCode
    note: str | None
    old_value: float | None
    algorithm: str | None
    version: int | None
    person: str
    at_utc: str
    blind: bool = False
    at_s: float | None = None


def add_detection(connection: sa.Connection, found: DetectionRow, signal_key: int) -> None:
    """Store what was found in a signal, but where it is stored already; no jumps is a result too."""
    values = {**{name: getattr(found, name) for name in _OWN}, "signal": signal_key, "n_jumps": len(found.jumps)}
    for (key,) in fetch(connection, _ADD_NEW, values):
        rows = [
            (uid, key, *rest, int(gap_touched), _listed(flags))
            for uid, *rest, gap_touched, flags in map(_plain, found.jumps)
        ]
        insert_all(connection, jump, _COLUMNS, rows)


_OWN = ("uid", "key", "algorithm", "version", "parameters_json")
_ADD_NEW = (
    detection.insert()
    .from_select(
        [*_OWN, "signal", "n_jumps"],
        sa.select(*(sa.bindparam(name, type_=detection.c[name].type) for name in (*_OWN, "signal", "n_jumps"))).where(
            ~sa.exists().where(detection.c.key == sa.bindparam("key", type_=detection.c.key.type))
        ),
        include_defaults=False,
    )
    .returning(detection.c.id)
)
_COLUMNS = tuple(column.name for column in jump.c if column.name != "id")
_plain = attrgetter(*JumpRow.__slots__)
_listed = cache(json.dumps)


def jumps_found(connection: sa.Connection, ingest_uid: str, algorithm: str | None) -> dict[str, int]:
    """Return how many jumps an algorithm found in each part of a reading; the last one that looked, without a name.

    A stance without a flight that has an apex is no jump found, as where jumps found are set beside jumps made.
    """
    looked = signal.alias("looked")  # the same samples may have been looked at in an earlier reading, or another file
    found = sa.select(sa.func.count()).where(jump.c.detection == detection.c.id, jump.c.undefined_reason.is_(None))
    query = (
        sa.select(signal.c.part, found.scalar_subquery().label("n"))
        .select_from(detection)
        .join(looked, detection.c.signal == looked.c.id)
        .join(signal, signal.c.sha256 == looked.c.sha256)
        .join(ingest, signal.c.ingest == ingest.c.id)
        .where(ingest.c.uid == ingest_uid)
        .order_by(detection.c.id)
    )
    if algorithm is not None:
        query = query.where(detection.c.algorithm == algorithm)
    return {row.part: row.n for row in connection.execute(query)}


def detections_by_key(connection: sa.Connection, keys: Sequence[str]) -> dict[str, DetectionRow]:
    """Return the stored detections among `keys`, with their jumps in order."""
    found: dict[str, DetectionRow] = {}
    for some in in_chunks(keys):
        found |= _detections(connection, some)
    return found


def _detections(connection: sa.Connection, keys: Sequence[str]) -> dict[str, DetectionRow]:
    heads = connection.execute(
        sa.select(
            *columns_of(DetectionRow, detection, signal_sha256=signal.c.sha256, jumps=detection.c.id),
        )
        .join(signal, detection.c.signal == signal.c.id)
        .where(detection.c.key.in_(keys))
    ).all()
    jumps: dict[int, list[JumpRow]] = {row.jumps: [] for row in heads}
    columns = [column for column in jump.c if column.name != "id"]
    of_heads = sa.select(*columns).where(jump.c.detection.in_(jumps)).order_by(jump.c.detection, jump.c.number)
    for uid, owner, *rest, gap_touched, flags in connection.execute(of_heads).all():
        values: list[Any] = [uid, *rest, bool(gap_touched), _flags(flags)]
        jumps[owner].append(JumpRow(*values))
    return {row.key: DetectionRow(*[*row[:-1], tuple(jumps[row.jumps])]) for row in heads}


@cache
def _flags(text: str) -> tuple[str, ...]:
    return tuple(json.loads(text))


def jump_decisions(
    connection: sa.Connection, signals_sha256: Sequence[str] | None = None
) -> dict[str, list[DecisionRow]]:
    """Return the verdicts on jumps in the order they were made, by the SHA-256 of the signal: all, or of some.

    A verdict on an earlier reading of a file holds for the one in force where that has samples at the same times.
    """
    holds_for = _samples_in_force(connection, signals_sha256)
    query = (
        sa.select(*columns_of(DecisionRow, decision, person=person.c.name))
        .join(person, decision.c.person == person.c.id)
        .where(decision.c.target_kind == TargetKind.JUMP)
        .order_by(decision.c.id)
    )
    wanted = None if signals_sha256 is None else {*signals_sha256, *holds_for}
    if wanted is not None and len(wanted) <= CHUNK:
        query = query.where(decision.c.signal_sha256.in_(wanted))
    found: dict[str, list[DecisionRow]] = {}
    for uid, sha256, anchor_s, verdict, reason, *rest, blind, at_s in connection.execute(query):
        if wanted is not None and sha256 not in wanted:
            continue
        row = DecisionRow(*[uid, sha256, anchor_s, Verdict(verdict), ReasonCode(reason), *rest, bool(blind), at_s])
        for signal_sha256 in holds_for.get(sha256, {sha256}):
            found.setdefault(signal_sha256, []).append(row)
    return found


def _samples_in_force(
    connection: sa.Connection, signals_sha256: Sequence[str] | None = None, *, given_on: Sequence[str] | None = None
) -> dict[str, set[str]]:
    """Return, for the hash of any samples, those of the readings in force of the same file with the same times.

    All there are, those that lead to some signals, or those that lead from the samples `given_on`. The hash that the
    journal records for the samples counts as theirs.
    """
    now = signal.alias("now")
    query = (
        sa.select(signal.c.sha256, signal.c.recorded_sha256, now.c.sha256.label("now"))
        .join(now, sa.and_(now.c.file == signal.c.file, _same_times(now)))
        .join(ingest, sa.and_(ingest.c.id == now.c.ingest, ingest.c.status == IngestStatus.IMPORTED))
    )
    queries = [query]
    if signals_sha256 is not None:
        queries = [query.where(now.c.sha256.in_(some)) for some in in_chunks(signals_sha256)]
    if given_on is not None:
        either = (signal.c.sha256, signal.c.recorded_sha256)
        queries = [query.where(sa.or_(*(column.in_(some) for column in either))) for some in in_chunks(given_on)]
    found: dict[str, set[str]] = {}
    for row in (row for query in queries for row in connection.execute(query)):
        for sha256 in {row.sha256, row.recorded_sha256} - {None}:
            found.setdefault(sha256, set()).add(row.now)
    return found


def _same_times(now: sa.FromClause) -> sa.ColumnElement[bool]:
    return sa.or_(now.c.id == signal.c.id, now.c.time_sha256 == signal.c.time_sha256)


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
    at_s: float | None
    file_name: str | None

    @property
    def sentence(self) -> str:
        """Say what waits, and how it is settled."""
        again = f"labbook jumps {self.verdict} {self.run}{'' if self.verdict is Verdict.ADD else ' NUMBER'}"
        again += f" --at {self.at_s:.3f}" if self.at_s is not None else ""
        return (
            f"waiting for review: run {self.run}: {self.verdict} at {self.anchor_s:.3f} s ({self.reason_code}) by "
            f"{self.person} on {self.at_utc} was given on samples that are not in force: give it again with "
            f"`{again}`, then `labbook jumps clear {self.run} waiting`."
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
            decision.c.at_s,
        )
        .join(run, run.c.uid == decision.c.target_uid)
        .join(person, decision.c.person == person.c.id)
        .where(decision.c.target_kind == TargetKind.JUMP)
        .order_by(decision.c.id)
    )
    if run_uid is not None:
        query = query.where(run.c.uid == run_uid)
    rows = connection.execute(query).all()
    given_on = sorted({row.signal_sha256 for row in rows})
    holds = _samples_in_force(connection, given_on=given_on)
    names = _names(connection, [sha256 for sha256 in given_on if sha256 not in holds])
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
