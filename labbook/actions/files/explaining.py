"""How a file would be read and what would be stored of it, without storing anything."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from data_schema.queries.facts import find_uid
from ingest.model import ChargeRow, Explanation, Finding, Limits, ReadFile
from ingest.read import read_file
from labbook.actions.files.absent_columns import refused_without_columns
from labbook.actions.files.day_of_run import with_day_of_run
from labbook.actions.files.ingesting import readable, stated_run
from labbook.book.opening import Book
from labbook.statements.importing import declarations


@dataclass(frozen=True, slots=True)
class PartStored:
    """One signal that would be stored: its channels with their units, samples, rate and gaps."""

    part: str
    channels: tuple[tuple[str, str | None], ...]
    samples: int
    duration_s: float
    rate_hz: float | None
    start_utc: str | None
    gaps: int
    samples_missing: int


@dataclass(frozen=True, slots=True)
class Explained:
    """How one file would be read. `run` is the run it would belong to, `run_known` whether the book has it."""

    file: str
    refused: bool
    format: str
    reader_version: int
    plugin: str | None
    evidence: str
    profile: str | None
    explanation: Explanation
    rows_read: int
    rows_kept: int
    parts: tuple[PartStored, ...]
    charges: tuple[ChargeRow, ...]
    run: str | None
    run_known: bool
    findings: tuple[Finding, ...]


def explain_file(book: Book, path: Path, options: Mapping[str, Any], run: str | None, *, alone: bool) -> Explained:
    """Read a file as `ingest` would, and say how; `run` is the one named for it, `alone`: no other file is read."""
    run = run or stated_run(book, path)
    with book.reading() as connection:
        read = read_as_ingest(book, path, options)
        read = refused_without_columns(read, options) if alone else read
        read = with_day_of_run(connection, read, run, notes=True)
        known = run is not None and find_uid(connection, "run", name=run) is not None
    return Explained(
        readable(path),
        read.refused,
        read.format,
        read.reader_version,
        read.plugin,
        read.evidence,
        read.profile,
        read.explanation,
        read.rows_read,
        read.rows_kept,
        () if read.refused else _parts(read),
        () if read.refused else read.charges,
        run,
        known,
        read.findings,
    )


def read_as_ingest(book: Book, path: Path, options: Mapping[str, Any]) -> ReadFile:
    """Read a file with what the command line and the book's profiles say of it; nothing is stored."""
    return read_file(bytes_of(book, path), declarations(book.configuration, options, readable(Path(path.name))))


def bytes_of(book: Book, path: Path) -> bytes:
    """Return the bytes of a file, mapped where they are many; raises `InputRefused` beyond the book's limit."""
    data, _ = book.store.read_and_hash(path, Limits(**book.configuration.files.limits).largest_file_bytes)
    return data


def _parts(read: ReadFile) -> tuple[PartStored, ...]:
    return tuple(
        PartStored(
            part.part,
            tuple((channel.name, channel.unit) for channel in part.channels),
            len(part.time_s),
            float(part.time_s[-1] - part.time_s[0]) if len(part.time_s) else 0.0,
            part.rate_hz,
            part.start_utc,
            len(part.gaps),
            sum(gap.samples_missing for gap in part.gaps),
        )
        for part in read.parts
    )
