"""Signals that belong to runs, their channels and gaps."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import sqlalchemy as sa

from data_schema.calibration import Calibration
from data_schema.tables.base import columns_of, in_chunks
from data_schema.tables.design import day
from data_schema.tables.files import LAST_READING, file, ingest, run_file
from data_schema.tables.journal import person
from data_schema.tables.runs import run
from data_schema.tables.signals import channel, gap, signal
from data_schema.vocabulary import FileRole, GapKind, IngestStatus


@dataclass(frozen=True, slots=True)
class CalibratedChannel:
    """A channel that was calibrated: `stored = sign * (scale * raw + zero_offset)`, `calibration` in `calibrated_unit`.

    `person` is who had the file read with it.
    """

    name: str
    source_name: str
    scale: float
    zero_offset: float
    sign: int
    calibration: Calibration
    calibrated_unit: str
    person: str

    def sentence(self) -> str:
        """Return the line of the calibration in words."""
        return self.calibration.sentence(self.source_name, self.name, self.calibrated_unit)

    def error_terms(self, stored: float) -> tuple[float, ...]:
        """Return the signed standard errors of a stored value, one for each independent error of the calibration."""
        raw = (self.sign * stored - self.zero_offset) / self.scale
        per_value = self.sign * self.scale / self.calibration.scale
        return tuple(per_value * (slope * raw + intercept) for slope, intercept in self.calibration.errors)


@dataclass(frozen=True, slots=True)
class SignalRow:
    """A signal that belongs to a run."""

    uid: str
    run_uid: str
    run_name: str
    role: str
    sha256: str
    store_path: str
    rate_hz: float | None
    n_samples: int
    channels: tuple[str, ...]
    file_sha256: str
    start_utc: str | None
    file_name: str


@dataclass(frozen=True, slots=True)
class GapRow:
    """Samples that are missing."""

    start_s: float
    length_s: float
    samples_expected: int
    samples_missing: int
    kind: GapKind


def signals_of_runs(
    connection: sa.Connection, role: FileRole | None = None, run_uids: Sequence[str] | None = None
) -> list[SignalRow]:
    """List the signals that belong to a run, by run and part: of all runs, or of some."""
    every = (
        sa.select(
            *columns_of(SignalRow, signal, run_uid=run.c.uid, run_name=run.c.name, role=run_file.c.role, **_OF_OTHERS)
        )
        .select_from(_OF_RUNS)
        .order_by(run.c.id, signal.c.id)
    )
    if role is not None:
        every = every.where(run_file.c.role == str(role))
    queries = [every] if run_uids is None else [every.where(run.c.uid.in_(some)) for some in in_chunks(run_uids)]
    found = []
    for query in queries:
        rows = connection.execute(query).all()
        names = _channel_names(connection, None if run_uids is None else [row.channels for row in rows])
        found += [_signal_row(row, names) for row in rows]
    return found


_OF_RUNS = (
    signal.join(file, signal.c.file == file.c.id)
    .join(run_file, sa.and_(run_file.c.file == signal.c.file, run_file.c.part == signal.c.part))
    .join(run, run_file.c.run == run.c.id)
    .join(ingest, sa.and_(ingest.c.id == signal.c.ingest, ingest.c.status == IngestStatus.IMPORTED))
)
"""The signals in use that belong to a run."""

_OF_OTHERS = {"channels": signal.c.id, "file_sha256": file.c.sha256, "file_name": ingest.c.original_name}


def _signal_row(row: Sequence[Any], names: Mapping[int, tuple[str, ...]]) -> SignalRow:
    """Make a row of the columns that were asked for, where the signal's key stands for its channels."""
    return SignalRow(*[*row[:8], names.get(row[8], ()), *row[9:]])


def signals_of_files(connection: sa.Connection, role: FileRole) -> dict[tuple[str, str], SignalRow]:
    """Return the signals of the last reading of every file of a role, by the file's uid and the part.

    Those of withdrawn files and of parts that belong to no run are there too: no row names a run.
    """
    nobody = sa.literal("")
    query = (
        sa.select(
            file.c.uid,
            signal.c.part,
            *columns_of(SignalRow, signal, run_uid=nobody, run_name=nobody, role=ingest.c.role, **_OF_OTHERS),
        )
        .select_from(
            signal.join(file, signal.c.file == file.c.id).join(
                ingest, sa.and_(ingest.c.id == signal.c.ingest, LAST_READING)
            )
        )
        .where(ingest.c.role == str(role))
        .order_by(signal.c.id)
    )
    names = _channel_names(connection, None)
    return {(uid, part): _signal_row(row, names) for uid, part, *row in connection.execute(query)}


def samples_of_files(connection: sa.Connection) -> list[tuple[str, str]]:
    """Return the uid of a file and the hash of its samples, for every reading there was."""
    query = sa.select(file.c.uid, signal.c.sha256).join(file, signal.c.file == file.c.id)
    return [(uid, sha256) for uid, sha256 in connection.execute(query)]


@dataclass(frozen=True, slots=True)
class SameSamples:
    """A file of a run that has the samples of another file, of the same run or of another."""

    file_name: str
    file_sha256: str
    other_file: str
    other_run: str


def same_samples(connection: sa.Connection, run_uids: Sequence[str]) -> dict[str, SameSamples]:
    """Return, by the uid of the run, the first file of each of these runs that has the samples of another file.

    Of two files of one run it is the one that came later.
    """
    mine, theirs = (_linked_signals() for _ in range(2))
    later = sa.and_(theirs.c.file != mine.c.file, theirs.c.key < mine.c.key)
    found: dict[str, SameSamples] = {}
    for some in in_chunks(run_uids):
        query = (
            sa.select(mine.c.run_uid, mine.c.file_name, mine.c.file_sha256, theirs.c.file_name, theirs.c.run_name)
            .join(theirs, sa.and_(theirs.c.sha256 == mine.c.sha256, sa.or_(theirs.c.run_uid != mine.c.run_uid, later)))
            .where(mine.c.run_uid.in_(some))
            .order_by(mine.c.key, theirs.c.key)
        )
        for uid, *names in connection.execute(query):
            found.setdefault(uid, SameSamples(*names))
    return found


def _linked_signals() -> sa.Subquery:
    """Select the signals in use that belong to a run."""
    names = {
        "run_uid": run.c.uid,
        "run_name": run.c.name,
        "file_sha256": file.c.sha256,
        "file_name": ingest.c.original_name,
    }
    columns = (column.label(name) for name, column in names.items())
    return (
        sa.select(signal.c.id.label("key"), signal.c.sha256, signal.c.file, *columns).select_from(_OF_RUNS).subquery()
    )


def every_start(connection: sa.Connection) -> list[str]:
    """Return the instants at which logs start, each once, as far as they are known."""
    query = sa.select(signal.c.start_utc).where(signal.c.start_utc.is_not(None)).distinct()
    return list(connection.execute(query).scalars())


def _channel_names(connection: sa.Connection, signals: Sequence[int] | None) -> dict[int, tuple[str, ...]]:
    query = sa.select(channel.c.signal, channel.c.name).order_by(channel.c.signal, channel.c.position)
    if signals is not None:
        query = query.where(channel.c.signal.in_(signals))
    found: dict[int, list[str]] = {}
    for key, name in connection.execute(query):
        found.setdefault(key, []).append(name)
    return {key: tuple(names) for key, names in found.items()}


def calibrated_channels(
    connection: sa.Connection, run_uid: str | None = None
) -> dict[str, tuple[CalibratedChannel, ...]]:
    """Return the calibrated channels of the signals that belong to one run or to any, by the signal's uid."""
    query = (
        sa.select(
            signal.c.uid,
            *columns_of(CalibratedChannel, channel, calibration=channel.c.calibration_json, person=person.c.name),
        )
        .select_from(
            _OF_RUNS.join(channel, channel.c.signal == signal.c.id).join(person, ingest.c.person == person.c.id)
        )
        .where(channel.c.calibration_json.is_not(None))
        .order_by(channel.c.signal, channel.c.position)
    )
    if run_uid is not None:
        query = query.where(run.c.uid == run_uid)
    found: dict[str, list[CalibratedChannel]] = {}
    for uid, *row in connection.execute(query):
        values = dict(zip(CalibratedChannel.__annotations__, row, strict=True))
        record = json.loads(values.pop("calibration"))
        record["errors"] = tuple(map(tuple, record["errors"]))
        found.setdefault(uid, []).append(CalibratedChannel(**values, calibration=Calibration(**record)))
    return {uid: tuple(channels) for uid, channels in found.items()}


@dataclass(frozen=True, slots=True)
class RecordedRange:
    """The lowest and highest value of a channel of a log; `stated_run` is the run that its file names."""

    signal_uid: str
    run_uid: str
    stated_run: str | None
    channel: str
    lowest: float
    highest: float


def recorded_ranges(
    connection: sa.Connection, channels: Sequence[str], days: Sequence[str] | None = None
) -> list[RecordedRange]:
    """Return what these channels recorded in the logs that belong to runs, of some days or of all."""
    columns = columns_of(
        RecordedRange,
        channel,
        signal_uid=signal.c.uid,
        run_uid=run.c.uid,
        stated_run=ingest.c.stated_run,
        channel=channel.c.name,
    )
    query = (
        sa.select(*columns)
        .select_from(_OF_RUNS.join(channel, channel.c.signal == signal.c.id))
        .where(channel.c.name.in_(channels), channel.c.lowest.is_not(None), run_file.c.role == str(FileRole.LOG))
        .order_by(run.c.id, signal.c.id)
    )
    if days is not None:
        query = query.where(run.c.day.in_(sa.select(day.c.id).where(day.c.date_local.in_(days))))
    return [RecordedRange(*row) for row in connection.execute(query)] if channels else []


@dataclass(frozen=True, slots=True)
class SourceColumn:
    """The column of a file that a channel was read from, and by what: `stored = sign * (scale * raw + ...)`."""

    name: str
    unit: str | None
    scale: float
    sign: int
    calibrated: bool


def source_columns(connection: sa.Connection, signal_uids: Sequence[str], channel_name: str) -> dict[str, SourceColumn]:
    """Return the column that each of some signals has a channel from, by the signal's uid."""
    about = (channel.c.source_name, channel.c.source_unit, channel.c.scale, channel.c.sign)
    query = (
        sa.select(signal.c.uid, *about, channel.c.calibration_json.is_not(None))
        .join(channel, channel.c.signal == signal.c.id)
        .where(channel.c.name == channel_name)
    )
    return {
        uid: SourceColumn(name, unit, scale, sign, bool(calibrated))
        for some in in_chunks(signal_uids)
        for uid, name, unit, scale, sign, calibrated in connection.execute(query.where(signal.c.uid.in_(some)))
    }


@dataclass(frozen=True, slots=True)
class ChannelRow:
    """A channel of a signal: its name, its unit (None where nothing says it), and the file's column and its unit."""

    name: str
    unit: str | None
    source_name: str
    source_unit: str | None


def channels_of(connection: sa.Connection, signal_uid: str) -> list[ChannelRow]:
    """Return the channels of a signal in their order."""
    query = (
        sa.select(*columns_of(ChannelRow, channel))
        .join(signal, channel.c.signal == signal.c.id)
        .where(signal.c.uid == signal_uid)
        .order_by(channel.c.position)
    )
    return [ChannelRow(*row) for row in connection.execute(query)]


def gaps_of(connection: sa.Connection, signal_uid: str) -> tuple[GapRow, ...]:
    """Return the gaps of one signal by their start."""
    return gaps_by_signal(connection, [signal_uid])[signal_uid]


def gaps_by_signal(connection: sa.Connection, signal_uids: Sequence[str]) -> dict[str, tuple[GapRow, ...]]:
    """Return the gaps of each signal by their start."""
    found: dict[str, list[GapRow]] = {uid: [] for uid in signal_uids}
    for some in in_chunks(signal_uids):
        query = (
            sa.select(signal.c.uid, *columns_of(GapRow, gap))
            .join(signal, gap.c.signal == signal.c.id)
            .where(signal.c.uid.in_(some))
            .order_by(gap.c.signal, gap.c.start_s)
        )
        for row in connection.execute(query):
            found[row[0]].append(GapRow(*[*row[1:5], GapKind(row[5])]))
    return {uid: tuple(gaps) for uid, gaps in found.items()}
