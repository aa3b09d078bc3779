"""Imported files: their names, what they leave in the tables, and how they were read.

What belongs to each (runs, charges, signals, parts), and what has no run yet; the rows that a file leaves (how it was
read, what the checks found, signals and gaps) and the files of the store that they refer to; the history of readings,
the one that is in force, and what a person decided about them.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import sqlalchemy as sa

from data_schema.queries.charges import SheetRow, rows_of_file
from data_schema.queries.history import reading_entries
from data_schema.queries.signals import GapRow, gaps_by_signal
from data_schema.reasons import Reason
from data_schema.tables.base import columns_of
from data_schema.tables.files import IN_USE, LAST_READING, file, finding, ingest, run_file
from data_schema.tables.journal import config, journal, person
from data_schema.tables.plain import change, fetch, insert
from data_schema.tables.runs import charge, run
from data_schema.tables.signals import channel, gap, signal
from data_schema.vocabulary import ChargeState, FileRole, IngestStatus, Severity, Undefined


def runs_of_file(connection: sa.Connection, sha256: str) -> tuple[str, ...]:
    """Return the names of all runs of a file, by assignment or by charge rows."""
    counted = charge.c.state == ChargeState.COUNTED
    assigned = sa.select(run.c.name).join(run_file, run_file.c.run == run.c.id).join(file, run_file.c.file == file.c.id)
    charged = sa.select(run.c.name).join(charge, charge.c.run == run.c.id).join(file, charge.c.file == file.c.id)
    both = sa.union(assigned.where(file.c.sha256 == sha256), charged.where(file.c.sha256 == sha256, counted))
    return tuple(sorted(connection.execute(both).scalars()))


def file_keys(connection: sa.Connection) -> dict[str, int]:
    """Return the key of every file by its SHA-256."""
    return {sha256: key for key, sha256 in connection.execute(sa.select(file.c.id, file.c.sha256))}


def runs_by_file(connection: sa.Connection) -> dict[int, tuple[str, ...]]:
    """Return the same for every file of which there are runs, by the file's key."""
    counted = sa.and_(charge.c.run == run.c.id, charge.c.state == ChargeState.COUNTED)
    found: dict[int, list[str]] = {}
    for query in (
        sa.select(run_file.c.file, run.c.name).join(run, run_file.c.run == run.c.id),
        sa.select(charge.c.file, run.c.name).join(run, counted),
    ):
        for key, name in connection.execute(query).all():
            if key in found:
                found[key].append(name)
            else:
                found[key] = [name]
    return {key: tuple(names if len(names) == 1 else sorted({*names})) for key, names in found.items()}


@dataclass(frozen=True, slots=True)
class FileRow:
    """An imported file as people name it; `status` is that of its last reading."""

    uid: str
    name: str
    role: str
    at_utc: str
    sha256: str
    status: IngestStatus


@dataclass(frozen=True, slots=True)
class Link:
    """A part of a file that belongs to a run."""

    uid: str
    file_uid: str
    run_uid: str
    run_name: str
    part: str
    role: str


def _imported() -> sa.Select[Any]:
    return (
        sa.select(file.c.uid, ingest.c.original_name, ingest.c.role, ingest.c.at_utc, file.c.sha256, ingest.c.status)
        .join(file, ingest.c.file == file.c.id)
        .where(LAST_READING)
        .order_by(ingest.c.id)
    )


def find_files(connection: sa.Connection, name: str) -> list[FileRow]:
    """Return the imported files of this name, uid or SHA-256, of which 8 digits will do; withdrawn ones too."""
    matches = [ingest.c.original_name == name, ingest.c.file.in_(sa.select(file.c.id).where(file.c.uid == name))]
    if _BEGINNING.fullmatch(name):
        matches.append(sa.and_(ingest.c.sha256 >= name, ingest.c.sha256 < f"{name}g"))
    rows = [list(row) for row in connection.execute(_imported().where(sa.or_(*matches)))]
    return [FileRow(*[*row[:-1], IngestStatus(row[-1])]) for row in rows]


_BEGINNING = re.compile("[0-9a-f]{8,64}")
"""Enough of a SHA-256 to name a file."""


def imported_names(connection: sa.Connection) -> list[str]:
    """Return the names of all imported files."""
    return [row.original_name for row in connection.execute(_imported())]


def newest_files(connection: sa.Connection, most: int) -> list[FileRow]:
    """Return the files that were read last, the newest first."""
    newest = _imported().order_by(None).order_by(ingest.c.id.desc()).limit(most)
    return [FileRow(*[*row[:-1], IngestStatus(row[-1])]) for row in connection.execute(newest)]


@dataclass(frozen=True, slots=True)
class RefusedFile:
    """A file that could not be read, the run that it states, and the first thing that was wrong with it."""

    name: str
    stated_run: str | None
    at_utc: str
    person: str
    why: str


def refused_files(connection: sa.Connection, most: int | None = None) -> list[RefusedFile]:
    """Return the files that were refused last, the newest first; not those whose bytes, or name, came in since."""
    other = ingest.alias()
    imported = other.c.status == IngestStatus.IMPORTED
    later = sa.and_(other.c.id > ingest.c.id, other.c.original_name == ingest.c.original_name, imported)
    same = other.c.sha256 == ingest.c.sha256
    again = sa.and_(same, other.c.id > ingest.c.id)
    wrong = finding.alias()
    first = sa.select(sa.func.min(wrong.c.id)).where(wrong.c.ingest == ingest.c.id, wrong.c.severity == Severity.FILE)
    query = (
        sa.select(ingest.c.original_name, ingest.c.stated_run, ingest.c.at_utc, person.c.name, finding.c.message)
        .join(person, ingest.c.person == person.c.id)
        .join(finding, finding.c.id == first.scalar_subquery())
        .where(
            ingest.c.status == IngestStatus.REFUSED,
            ~sa.exists().where(sa.or_(later, again, sa.and_(same, imported))),
        )
        .order_by(ingest.c.id.desc())
        .limit(most)
    )
    return [RefusedFile(*row) for row in connection.execute(query)]


def last_imports(connection: sa.Connection) -> dict[str, str]:
    """Return when the newest file in use of each run came in, by the run's uid."""
    query = (
        sa.select(run.c.uid, sa.func.max(ingest.c.at_utc))
        .select_from(run_file.join(run, run_file.c.run == run.c.id).join(ingest, ingest.c.file == run_file.c.file))
        .where(IN_USE)
        .group_by(run.c.uid)
    )
    return {row[0]: row[1] for row in connection.execute(query)}


def links_of_file(connection: sa.Connection, file_uid: str) -> list[Link]:
    """Return which runs the parts of a file belong to."""
    return _links(connection, _LINKS_OF_FILE, file_uid)


def links_of_run(connection: sa.Connection, run_uid: str) -> list[Link]:
    """Return the parts of files that belong to a run."""
    return _links(connection, _LINKS_OF_RUN, run_uid)


def logs_by_run(connection: sa.Connection) -> dict[str, list[Link]]:
    """Return the logs in use that belong to runs, by the run's uid."""
    found: dict[str, list[Link]] = {}
    for row in connection.execute(_LINKS.join(ingest, sa.and_(ingest.c.file == file.c.id, IN_USE)).where(_IS_LOG)):
        found.setdefault(row[2], []).append(Link(*row))
    return found


def _links(connection: sa.Connection, query: sa.Select[Any], uid: str) -> list[Link]:
    return [Link(*row) for row in fetch(connection, query, {"of": uid})]


# Built once: an ingest of many files asks them for each, and building one takes longer than asking it.
_LINKS = (
    sa.select(run_file.c.uid, file.c.uid, run.c.uid, run.c.name, run_file.c.part, run_file.c.role)
    .join(run, run_file.c.run == run.c.id)
    .join(file, run_file.c.file == file.c.id)
    .order_by(run_file.c.id)
)
_LINKS_OF_FILE = _LINKS.where(file.c.uid == sa.bindparam("of"))
_LINKS_OF_RUN = _LINKS.where(run.c.uid == sa.bindparam("of"))
_IS_LOG = run_file.c.role == FileRole.LOG


def charges_of_file(connection: sa.Connection, file_uid: str) -> list[SheetRow]:
    """Return the charges that a file holds, by row, but for those that are gone."""
    return [row for row in rows_of_file(connection, file_uid) if row.state is not ChargeState.GONE]


def place_of_charge(connection: sa.Connection, uid: str) -> str | None:
    """Return the file's name and the row of a charge as NAME#ROW; None where it was typed in."""
    query = (
        sa.select(ingest.c.original_name, charge.c.row_number)
        .join(file, charge.c.file == file.c.id)
        .join(ingest, sa.and_(ingest.c.file == file.c.id, LAST_READING))
        .where(charge.c.uid == uid)
    )
    row = connection.execute(query).first()
    return None if row is None else f"{row.original_name}#{row.row_number}"


def signals_of_file(connection: sa.Connection, file_uid: str) -> list[str]:
    """Return the SHA-256 of the samples that a file holds, by part."""
    query = (
        sa.select(signal.c.sha256)
        .join(file, signal.c.file == file.c.id)
        .join(ingest, sa.and_(ingest.c.id == signal.c.ingest, IN_USE))
        .where(file.c.uid == file_uid)
        .order_by(signal.c.part)
    )
    return list(connection.execute(query).scalars())


def unlink_file(connection: sa.Connection, file_uid: str, part: str | None = None) -> None:
    """Let a file, or a part of it, belong to no run; which one it belonged to stands in the journal."""
    change(connection, _UNLINK_PART if part is not None else _UNLINK, {"file_uid": file_uid, "of": part})


_OF_FILE = run_file.c.file == sa.select(file.c.id).where(file.c.uid == sa.bindparam("file_uid")).scalar_subquery()
_UNLINK = run_file.delete().where(_OF_FILE)
_UNLINK_PART = _UNLINK.where(run_file.c.part == sa.bindparam("of"))


def parts_of_file(connection: sa.Connection, file_uid: str) -> list[str]:
    """Return the parts of a file's reading that were sampled apart; one without signals has one part, ''.

    Those of a file that waits for a declaration are the ones that the entry of its reading names.
    """
    waiting = sa.and_(ingest.c.file == file.c.id, ingest.c.status == IngestStatus.WAITING)
    sha256 = connection.execute(sa.select(file.c.sha256).join(ingest, waiting).where(file.c.uid == file_uid)).scalar()
    if sha256 is not None:
        return reading_entries(connection, sha256)[-1]["parts"] or [""]
    query = (
        sa.select(signal.c.part)
        .join(file, signal.c.file == file.c.id)
        .join(ingest, sa.and_(ingest.c.id == signal.c.ingest, IN_USE))
        .where(file.c.uid == file_uid)
        .distinct()
        .order_by(signal.c.part)
    )
    return list(connection.execute(query).scalars()) or [""]


def recorded_parts(connection: sa.Connection, file_uid: str) -> list[str]:
    """Return the parts of all readings of a file, as the journal recorded them."""
    sha256 = connection.execute(sa.select(file.c.sha256).where(file.c.uid == file_uid)).scalar_one()
    return list(dict.fromkeys(part for new in reading_entries(connection, sha256) for part in new["parts"] or [""]))


def unassigned_charges_of_file(connection: sa.Connection, file_uid: str) -> list[str]:
    """Return the uids of a file's charges that belong to no run yet."""
    query = (
        sa.select(charge.c.uid)
        .join(file, charge.c.file == file.c.id)
        .where(file.c.uid == file_uid, charge.c.run.is_(None), charge.c.state == ChargeState.COUNTED)
        .order_by(charge.c.row_number)
    )
    return list(connection.execute(query).scalars())


@dataclass(frozen=True, slots=True)
class InboxItem:
    """A file, or a row of a charger sheet, that belongs to no run yet; `uid` is that of the file or of the charge."""

    what: str
    name: str
    stated_run: str | None
    detail: str
    uid: str


_NEVER_WAITING = (FileRole.CHARGE, FileRole.SHEET)


def inbox(connection: sa.Connection) -> list[InboxItem]:
    """List the imported files and charge rows whose run is unknown, oldest first; a charger's file is its charges.

    Sheets of studies belong to no run.
    """
    linked = sa.select(run_file.c.id).where(run_file.c.file == file.c.id)  # asked by its index, file by file
    files = connection.execute(
        sa.select(ingest.c.original_name, ingest.c.stated_run, file.c.uid, ingest.c.reader, ingest.c.rows_kept)
        .join(file, ingest.c.file == file.c.id)
        .where(IN_USE)
        .where(~linked.exists(), ingest.c.role.not_in(_NEVER_WAITING))
        .order_by(ingest.c.id)
    )
    items = [
        InboxItem("file", row.original_name, row.stated_run, f"{row.reader}, {row.rows_kept} rows, {row.uid}", row.uid)
        for row in files
    ]
    items += _loose_parts(connection)
    charges = connection.execute(
        sa.select(charge.c.uid, charge.c.row_number, charge.c.stated_run, charge.c.charge_mah, ingest.c.original_name)
        .join(file, charge.c.file == file.c.id)
        .join(ingest, sa.and_(ingest.c.file == file.c.id, IN_USE))
        .where(charge.c.run.is_(None), charge.c.state == ChargeState.COUNTED)
        .order_by(charge.c.id)
    )
    items += [
        InboxItem(
            "charge",
            f"{row.original_name}#{row.row_number}",
            row.stated_run,
            f"{row.charge_mah:g} mAh, {row.uid}",
            row.uid,
        )
        for row in charges
    ]
    return items


def _loose_parts(connection: sa.Connection) -> list[InboxItem]:
    """List the parts without a run of files whose other parts have one."""
    linked = sa.select(run_file.c.id).where(run_file.c.file == file.c.id, run_file.c.part == signal.c.part)
    rows = connection.execute(
        sa.select(ingest.c.original_name, signal.c.part, signal.c.n_samples, file.c.uid, ingest.c.reader)
        .join(file, signal.c.file == file.c.id)
        .join(ingest, sa.and_(ingest.c.id == signal.c.ingest, IN_USE))
        .where(file.c.id.in_(sa.select(run_file.c.file)), ~linked.exists())
        .where(ingest.c.role != FileRole.CHARGE)
        .order_by(signal.c.id)
    )
    return [
        InboxItem(
            "part", f"{row.original_name}#{row.part}", None, f"{row.reader}, {row.n_samples} rows, {row.uid}", row.uid
        )
        for row in rows
    ]


def files_naming(connection: sa.Connection, run_name: str) -> list[tuple[str, str]]:
    """Return the unassigned files that name a run of this name, each with its role."""
    return [(uid, role) for uid, role in fetch(connection, _WAITING_FILES, {"named": run_name})]


# Built once: a sheet states thousands of runs, and each is asked for what waits for it.
_WAITING_FILES = (
    sa.select(file.c.uid, ingest.c.role)
    .join(ingest, ingest.c.file == file.c.id)
    .where(ingest.c.stated_run == sa.bindparam("named"), IN_USE)
    .where(~sa.exists().where(run_file.c.file == file.c.id))
    .order_by(file.c.id)
)


LEG = ("height_zero_doubtful", "no_stance_found")
"""Rules of a log whose heights do not fit the leg of its run's robot."""

ABOUT_RUNS = (
    "charge_known",
    "charge_contradicts",
    "correction_stands",
    "assignment_stands",
    "jumps_found_not_made",
    "run_contradicts",
    "log_day_differs",
    *LEG,
)
"""Rules of findings that only a book can make, because they compare a file with a run."""


@dataclass(frozen=True, slots=True)
class FirstImport:
    """When and as what the same bytes were imported before."""

    ingest_uid: str
    file_uid: str
    original_name: str
    person: str
    at_utc: str
    runs: tuple[str, ...]


def first_import(connection: sa.Connection, sha256: str) -> FirstImport | None:
    """Return the first import of these bytes, if they were imported."""
    row = connection.execute(
        sa.select(ingest.c.uid, file.c.uid.label("file_uid"), ingest.c.original_name, person.c.name, ingest.c.at_utc)
        .join(person, ingest.c.person == person.c.id)
        .join(file, ingest.c.file == file.c.id)
        .where(ingest.c.sha256 == sha256)
        .order_by(ingest.c.id)
    ).first()
    if row is None:
        return None
    return FirstImport(row.uid, row.file_uid, row.original_name, row.name, row.at_utc, runs_of_file(connection, sha256))


def refused_with(connection: sa.Connection, sha256: str, reader: str, options_json: str) -> list[Any]:
    """Return the settings of each refusal of these bytes by a reader under these options."""
    query = sa.select(ingest.c.declared_json).where(
        ingest.c.sha256 == sha256,
        ingest.c.status == IngestStatus.REFUSED,
        ingest.c.reader == reader,
        ingest.c.options_json == options_json,
    )
    return [json.loads(text) for text in connection.execute(query).scalars()]


def add_ingest(connection: sa.Connection, *, person_name: str, values: Mapping[str, Any]) -> int:
    """Add the row of a file's reading, under the configuration in force; returns its key."""
    return insert(connection, _ADD_INGEST, {"person_name": person_name, **values})


_ADD_INGEST = ingest.insert().values(
    person=sa.select(person.c.id).where(person.c.name == sa.bindparam("person_name")).scalar_subquery(),
    config=sa.select(sa.func.max(config.c.id)).scalar_subquery(),
)
"""Built once: an ingest of many files asks for it for each."""


def add_findings(connection: sa.Connection, ingest_key: int, rows: Sequence[Mapping[str, Any]]) -> None:
    """Add what the checks found."""
    for row in rows:
        insert(connection, finding, {"ingest": ingest_key, **row})


@dataclass(frozen=True, slots=True)
class FindingRow:
    """A finding as it is stored."""

    severity: str
    rule: str
    message: str
    line: int | None
    column_name: str | None
    value: str | None
    n: int
    more_lines: tuple[int, ...]


def findings_of(connection: sa.Connection, ingest_uid: str, rules: Sequence[str] | None = None) -> list[FindingRow]:
    """Return what a reading of a file found, all of it or by some rules."""
    query = (
        sa.select(*columns_of(FindingRow, finding, more_lines=finding.c.more_lines_json))
        .join(ingest, finding.c.ingest == ingest.c.id)
        .where(ingest.c.uid == ingest_uid)
        .order_by(finding.c.id)
    )
    if rules is not None:
        query = query.where(finding.c.rule.in_(rules))
    return [FindingRow(*[*row[:-1], tuple(json.loads(row[-1]))]) for row in connection.execute(query)]


def values_found(connection: sa.Connection, rule: str) -> dict[str, str]:
    """Return the first value that a rule found in each reading in force, by the SHA-256 of the file."""
    query = (
        sa.select(ingest.c.sha256, finding.c.value)
        .join(finding, finding.c.ingest == ingest.c.id)
        .where(ingest.c.status == IngestStatus.IMPORTED, finding.c.rule == rule, finding.c.value.is_not(None))
        .order_by(finding.c.id.desc())
    )
    return {row.sha256: row.value for row in connection.execute(query)}


def add_signal(
    connection: sa.Connection,
    values: Mapping[str, Any],
    channels: Sequence[Mapping[str, Any]],
    gaps: Sequence[Mapping[str, Any]],
) -> int:
    """Add a signal of the reading that the transaction adds, with its channels and gaps; returns its key."""
    key = insert(connection, signal, values)
    for table, rows in ((channel, channels), (gap, gaps)):
        for row in rows:
            insert(connection, table, {"signal": key, **row})
    return key


@dataclass(frozen=True, slots=True)
class StoredFile:
    """A file of the store that a row refers to: its path there, and the SHA-256 of its content."""

    store_path: str
    sha256: str
    name: str


@dataclass(frozen=True, slots=True)
class Reading:
    """What one reading of a file gave: by which reader, how many rows, and the hashes of its signals."""

    reader: str
    reader_version: int
    rows: dict[str, int]
    signals: list[str]


def raw_copies(connection: sa.Connection) -> list[StoredFile]:
    """List the raw copies of all imported files, under the names that they came with."""
    query = (
        sa.select(file.c.store_path, file.c.sha256, ingest.c.original_name)
        .join(ingest, sa.and_(ingest.c.file == file.c.id, LAST_READING))
        .order_by(file.c.id)
    )
    return [StoredFile(*row) for row in connection.execute(query)]


def signal_files(connection: sa.Connection) -> list[StoredFile]:
    """List the files of samples, under the names of the files that they were read from; each path once."""
    query = (
        sa.select(signal.c.store_path, signal.c.sha256, ingest.c.original_name)
        .join(ingest, ingest.c.id == signal.c.ingest)
        .order_by(signal.c.id.desc())
    )
    rows = [StoredFile(*row) for row in connection.execute(query)]
    return list({row.store_path: row for row in rows}.values())[::-1]


_COUNTED = ("rows_read", "rows_kept", "rows_rejected")


def readings(connection: sa.Connection) -> dict[str, Reading]:
    """Return what each reading of a file gave, also an earlier one, by the uid of its ingest; refused ones left out."""
    gave = ingest.c.status.not_in((IngestStatus.REFUSED, IngestStatus.WAITING))
    columns = [ingest.c[name] for name in ("id", "uid", "reader", "reader_version", *_COUNTED)]
    heads = connection.execute(sa.select(*columns).where(gave).order_by(ingest.c.id)).all()
    signals: dict[int, list[str]] = {row.id: [] for row in heads}
    for owner, sha256 in connection.execute(sa.select(signal.c.ingest, signal.c.sha256).order_by(signal.c.id)):
        signals[owner].append(sha256)
    return {
        row.uid: Reading(
            row.reader,
            row.reader_version,
            {"read": row.rows_read, "kept": row.rows_kept, "rejected": row.rows_rejected},
            signals[row.id],
        )
        for row in heads
    }


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
    """A file that was imported and that this labbook refuses; `message` is the sentence of the refusal.

    `lost`: there is nothing to refuse, its raw copy could not be read.
    """

    file_uid: str
    name: str
    role: str | None
    message: str
    runs: tuple[str, ...]
    lost: bool

    @property
    def why(self) -> Undefined:
        """Why numbers that would come from it are undefined, and what to do."""
        reason, said = (Reason.FILE_LOST, self.message.rstrip(".")) if self.lost else (Reason.FILE_WAITS, self.message)
        return Undefined(reason, role=self.role or "file", name=self.name, said=said)


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
    """Return the files that wait for a declaration or for their raw copy, with the runs that they belong to."""
    rows = connection.execute(
        sa.select(ingest.c.id, file.c.uid, ingest.c.original_name, ingest.c.role)
        .join(file, ingest.c.file == file.c.id)
        .where(ingest.c.status == IngestStatus.WAITING)
        .order_by(ingest.c.id)
    ).all()
    found = []
    for row in rows:
        refusal = connection.execute(
            sa.select(finding.c.message, finding.c.rule)
            .where(finding.c.ingest == row.id, finding.c.severity == Severity.FILE)
            .order_by(finding.c.id)
        ).first()
        message, rule = refusal or ("it is refused.", "")
        runs = (
            sa.select(run.c.uid)
            .join(run_file, run_file.c.run == run.c.id)
            .join(file, run_file.c.file == file.c.id)
            .where(file.c.uid == row.uid)
            .distinct()
        )
        of_file = tuple(sorted(connection.execute(runs).scalars()))
        found.append(WaitingFile(row.uid, row.original_name, row.role, message, of_file, rule == LOST))
    return found


LOST = "raw_copy_lost"
"""The rule of a file whose raw copy could not be read when the database was made."""


def lost_copies(connection: sa.Connection, sha256: str | None = None) -> frozenset[str]:
    """Return the SHA-256 of the files without whose raw copies the database was made, all or whether one is so."""
    query = sa.select(ingest.c.sha256).join(finding, finding.c.ingest == ingest.c.id).where(finding.c.rule == LOST)
    if sha256 is not None:
        query = query.where(ingest.c.sha256 == sha256)
    return frozenset(connection.execute(query).scalars())
