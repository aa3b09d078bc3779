"""How files were read: the history of readings, the one that is in force, and what a person decided about them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import sqlalchemy as sa

from data_schema.queries.signals import GapRow, gaps_by_signal
from data_schema.reasons import Reason
from data_schema.tables.base import columns_of
from data_schema.tables.files import LAST_READING, file, finding, ingest, run_file
from data_schema.tables.journal import config, journal, person
from data_schema.tables.runs import run
from data_schema.tables.signals import channel, signal
from data_schema.vocabulary import IngestStatus, Severity, Undefined


@dataclass(frozen=True, slots=True)
class ReadingRow:
    """One reading of a file.

    `settings_json` is all that it depended on, `config_text` the labbook.toml that was in force. `why` is the reason of
    the person who had the file read again.
    """

    uid: str
    file_uid: str | None
    sha256: str
    name: str
    at_utc: str
    person: str
    status: IngestStatus
    reader: str
    reader_version: int
    options_json: str
    settings_json: str
    config_text: str
    role: str | None
    stated_run: str | None
    modified_utc: str | None
    rows_read: int
    rows_kept: int
    rows_rejected: int
    why: str | None


@dataclass(frozen=True, slots=True)
class PartRow:
    """What was sampled together in one reading; channels as (name, unit), `columns` the file's names of them."""

    part: str
    sha256: str
    time_sha256: str | None
    rate_hz: float | None
    n_samples: int
    channels: tuple[tuple[str, str | None], ...]
    columns: tuple[str, ...]
    start_utc: str | None
    gaps: tuple[GapRow, ...]


@dataclass(frozen=True, slots=True)
class WaitingFile:
    """A file that was imported and that this labbook refuses; `message` is the sentence of the refusal."""

    file_uid: str
    name: str
    role: str | None
    message: str
    runs: tuple[str, ...]

    @property
    def why(self) -> Undefined:
        """Why numbers that would come from it are undefined, and what to do."""
        return Undefined(Reason.FILE_WAITS, role=self.role or "file", name=self.name, said=self.message)


def readings_of(connection: sa.Connection, sha256: str) -> list[ReadingRow]:
    """Return all readings of the bytes with this hash, also refused ones, the oldest first."""
    return _readings(connection, ingest.c.sha256 == sha256)


def last_readings(connection: sa.Connection) -> list[ReadingRow]:
    """Return the last reading of every file that was imported, in the order of the files' import."""
    return _readings(connection, LAST_READING, file.c.id)


def readings_in_force(connection: sa.Connection, readers: Sequence[str]) -> list[ReadingRow]:
    """Return the readings in force that some readers made, the oldest first."""
    return _readings(connection, sa.and_(ingest.c.status == IngestStatus.IMPORTED, ingest.c.reader.in_(readers)))


def configurations_of_readings(connection: sa.Connection) -> dict[int, str]:
    """Return the texts of labbook.toml under which readings in force were made, by their keys."""
    used = sa.select(ingest.c.config).where(ingest.c.status == IngestStatus.IMPORTED)
    return {row.id: row.text for row in connection.execute(sa.select(config).where(config.c.id.in_(used)))}


def settings_under(connection: sa.Connection, config_key: int) -> list[tuple[str, str]]:
    """Return the name and the settings, as JSON, of each reading in force that was made under a configuration."""
    query = (
        sa.select(ingest.c.original_name, ingest.c.declared_json)
        .where(ingest.c.status == IngestStatus.IMPORTED, ingest.c.config == config_key)
        .order_by(ingest.c.id)
    )
    return [(name, settings) for name, settings in connection.execute(query)]


def shown_readings(connection: sa.Connection) -> Sequence[Sequence[Any]]:
    """List the columns of `labbook files list` for the last reading of each file, in the order of their import.

    Returns:
        name, reader, rows kept, key and uid of the file, status, uid of the reading.
    """
    read = (ingest.c.original_name, ingest.c.reader, ingest.c.rows_kept, ingest.c.file)
    query = sa.select(*read, file.c.uid, ingest.c.status, ingest.c.uid).join(file, ingest.c.file == file.c.id)
    return connection.execute(query.where(LAST_READING).order_by(ingest.c.file)).all()


def last_reading(connection: sa.Connection, sha256: str) -> ReadingRow | None:
    """Return the last reading of the bytes with this hash, if they were imported."""
    return next(iter(_readings(connection, sa.and_(LAST_READING, ingest.c.sha256 == sha256))), None)


def _readings(
    connection: sa.Connection, wanted: sa.ColumnElement[bool], order: sa.Column[int] = ingest.c.id
) -> list[ReadingRow]:
    why = sa.select(journal.c.reason).where(journal.c.entity_uid == ingest.c.uid).limit(1).scalar_subquery()
    query = (
        sa.select(
            *columns_of(
                ReadingRow,
                ingest,
                file_uid=file.c.uid,
                name=ingest.c.original_name,
                person=person.c.name,
                settings_json=ingest.c.declared_json,
                config_text=ingest.c.config,
                why=why,
            )
        )
        .join(person, ingest.c.person == person.c.id)
        .outerjoin(file, ingest.c.file == file.c.id)
        .where(wanted)
        .order_by(order)
    )
    texts = {row.id: row.text for row in connection.execute(sa.select(config.c.id, config.c.text))}  # a few for all
    rows: Iterator[Any] = (
        (*row[:6], _STATUS[row[6]], *row[7:11], texts[row[11]], *row[12:]) for row in connection.execute(query).all()
    )
    return [ReadingRow(*row) for row in rows]


_STATUS = {str(status): status for status in IngestStatus}
"""Looking a word up costs a tenth of asking the enumeration for it."""


def parts_of_reading(connection: sa.Connection, ingest_uid: str) -> list[PartRow]:
    """Return the parts of a reading, in the order of the file."""
    query = (
        sa.select(
            signal.c.id,
            signal.c.uid,
            signal.c.part,
            signal.c.sha256,
            signal.c.time_sha256,
            signal.c.rate_hz,
            signal.c.n_samples,
            signal.c.start_utc,
        )
        .join(ingest, signal.c.ingest == ingest.c.id)
        .where(ingest.c.uid == ingest_uid)
        .order_by(signal.c.id)
    )
    rows = connection.execute(query).all()
    channels: dict[int, list[tuple[str, str | None]]] = {row.id: [] for row in rows}
    columns: dict[int, list[str]] = {row.id: [] for row in rows}
    of_rows = (
        sa.select(channel.c.signal, channel.c.name, channel.c.unit, channel.c.source_name)
        .where(channel.c.signal.in_(channels))
        .order_by(channel.c.signal, channel.c.position)
    )
    for owner, name, unit, column in connection.execute(of_rows):
        channels[owner].append((name, unit))
        columns[owner].append(column)
    gaps = gaps_by_signal(connection, [row.uid for row in rows])
    return [
        PartRow(*row[2:7], tuple(channels[row.id]), tuple(columns[row.id]), row.start_utc, gaps[row.uid])
        for row in rows
    ]


def set_status(connection: sa.Connection, ingest_uid: str, status: IngestStatus) -> None:
    """Set the status of a reading."""
    connection.execute(ingest.update().where(ingest.c.uid == ingest_uid).values(status=str(status)))


def waiting_files(connection: sa.Connection) -> list[WaitingFile]:
    """Return the files that wait for a declaration, with the runs that they belong to."""
    rows = connection.execute(
        sa.select(ingest.c.id, file.c.uid, ingest.c.original_name, ingest.c.role)
        .join(file, ingest.c.file == file.c.id)
        .where(ingest.c.status == IngestStatus.WAITING)
        .order_by(ingest.c.id)
    ).all()
    found = []
    for row in rows:
        message = connection.execute(
            sa.select(finding.c.message)
            .where(finding.c.ingest == row.id, finding.c.severity == Severity.FILE)
            .order_by(finding.c.id)
        ).scalar()
        runs = (
            sa.select(run.c.uid)
            .join(run_file, run_file.c.run == run.c.id)
            .join(file, run_file.c.file == file.c.id)
            .where(file.c.uid == row.uid)
            .distinct()
        )
        of_file = tuple(sorted(connection.execute(runs).scalars()))
        found.append(WaitingFile(row.uid, row.original_name, row.role, message or "it is refused.", of_file))
    return found
