"""The rows of one reading of a file: how it was read, what was found, its signals with channels, gaps and jumps."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from data_schema.errors import BookDamaged
from data_schema.journal import Entry, canonical
from data_schema.queries import imports
from data_schema.queries.detections import NewDetection, add_detections
from data_schema.vocabulary import FileRole, IngestStatus
from ingest.model import ReadFile, SignalPart
from labbook.analysis.outcomes.detecting import detection_rows
from labbook.statements.apply_context import ApplyContext, derived_uid
from labbook.statements.findings import finding_values
from labbook.statements.importing import PreparedImport, StoredPart, times_sha256


def add_reading(context: ApplyContext, entry: Entry, done: PreparedImport, file_key: int, role: FileRole) -> int:
    """Add how a file was read and what the checks found; returns the key of the reading.

    What is refused now and was not when it was said waits for a declaration.
    """
    read, new = done.read, entry.new or {}
    status = IngestStatus.WAITING if read.refused else IngestStatus.IMPORTED
    counts = {name: getattr(read, f"rows_{name}") for name in ("read", "kept", "rejected")}
    key = _add(context, entry, status, file_key, (read.format, read.reader_version), role, counts, new.get("settings"))
    imports.add_findings(context.connection, key, [finding_values(finding) for finding in read.findings])
    return key


def add_refusal(context: ApplyContext, entry: Entry) -> None:
    """Add why bytes were refused, as the entry says it."""
    new = entry.new or {}
    reader = (new["reader"], new["reader_version"])
    key = _add(context, entry, IngestStatus.REFUSED, None, reader, None, new["rows"], new.get("settings"))
    imports.add_findings(context.connection, key, new["findings"])


def _add(
    context: ApplyContext,
    entry: Entry,
    status: IngestStatus,
    file_key: int | None,
    reader: tuple[str, int],
    role: FileRole | None,
    counts: Mapping[str, int],
    settings: Mapping[str, Any] | None,
) -> int:
    new = entry.new or {}
    return imports.add_ingest(
        context.connection,
        person_name=entry.person,
        values={
            "uid": entry.entity_uid,
            "sha256": new["sha256"],
            "file": file_key,
            "original_name": new["original_name"],
            "modified_utc": new["modified_utc"],
            "status": str(status),
            "reader": reader[0],
            "reader_version": reader[1],
            "options_json": canonical(new["options"]),
            "role": None if role is None else str(role),
            "stated_run": new["stated_run"],
            "at_utc": entry.at_utc,
            "declared_json": None if settings is None else canonical(settings),
            **{f"rows_{name}": count for name, count in counts.items()},
        },
    )


def add_signals(
    context: ApplyContext,
    file_key: int,
    ingest_key: int,
    done: PreparedImport,
    new: Mapping[str, Any],
    reading_uid: str | None,
) -> None:
    """Add the parts of a reading; those of a first reading (`reading_uid` None) are named after their file alone."""
    recorded = _recorded(context, done, new)
    for part, stored in zip(done.read.parts, done.parts, strict=True):
        named = (done.sha256, part.part, done.read.reader_version)
        uid = derived_uid("signal", *(named if reading_uid is None else (reading_uid, part.part)))
        values = {
            "uid": uid,
            "file": file_key,
            "ingest": ingest_key,
            "part": part.part,
            "reader": done.read.format,
            "reader_version": done.read.reader_version,
            "start_utc": part.start_utc,
            "rate_hz": part.rate_hz,
            "n_samples": len(part.time_s),
            "sha256": stored.sha256,
            "store_path": stored.store_path,
            "time_sha256": stored.time_sha256,
            "recorded_sha256": recorded.get(part.part),
        }
        imports.add_signal(context.connection, values, _channels(part), _gaps(part))
        if stored.detection is not None:
            found, jumps = detection_rows(stored.detection, stored.sha256)
            add_detections(context.connection, [NewDetection(uid, found, jumps)])


def _recorded(context: ApplyContext, done: PreparedImport, new: Mapping[str, Any]) -> dict[str, str]:
    """Return, by part, the hash that the journal says its samples had, where they are sampled at the same times now.

    Verdicts of people name that hash. Whether the times are the same is asked of the entry. The first labbook did not
    write that down; then, and only then, a rebuild asks a derived file, the samples of that hash where they are still
    kept, for a reader that corrects times keeps the number of rows. Without the samples that number decides.
    """
    signals = new.get("signals", [])
    if len(signals) != len(done.parts):
        return {}
    pairs = zip(done.parts, signals, strict=True)
    times = new.get("times") or [_kept_times(context, done.read, stored, sha256, new) for stored, sha256 in pairs]
    return {
        part.part: sha256
        for part, stored, sha256, time_sha256 in zip(done.read.parts, done.parts, signals, times, strict=True)
        if time_sha256 == stored.time_sha256
    }


def _kept_times(
    context: ApplyContext, read: ReadFile, stored: StoredPart, sha256: str, new: Mapping[str, Any]
) -> str | None:
    if sha256 == stored.sha256:
        return stored.time_sha256
    try:
        kept = context.store.samples(f"signals/{sha256[:2]}/{sha256}.parquet", [])
    except BookDamaged:
        return stored.time_sha256 if new.get("rows", {}).get("kept") == read.rows_kept else None
    return times_sha256(kept["time"])


def _channels(part: SignalPart) -> list[dict[str, Any]]:
    return [
        {
            "position": position,
            "name": channel.name,
            "unit": channel.unit,
            "source_name": channel.source_name,
            "source_unit": channel.source_unit,
            "scale": channel.scale,
            "zero_offset": channel.offset,
            "sign": channel.sign,
            "assumed_json": canonical(list(channel.assumed)),
        }
        for position, channel in enumerate(part.channels)
    ]


def _gaps(part: SignalPart) -> list[dict[str, Any]]:
    return [
        {
            "start_s": gap.start_s,
            "length_s": gap.length_s,
            "samples_expected": gap.samples_expected,
            "samples_missing": gap.samples_missing,
            "kind": str(gap.kind),
        }
        for gap in part.gaps
    ]
