"""A file was ingested, or refused: the rows that it leaves."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from data_schema.errors import BookDamaged
from data_schema.journal import Entry, canonical
from data_schema.queries import imports
from data_schema.queries.detections import NewDetection, add_detections
from data_schema.queries.facts import read_fact
from data_schema.queries.people import config_in_force
from data_schema.queries.results import mark_stale
from data_schema.vocabulary import FileRole, IngestStatus, RunKind, Severity
from ingest.model import Finding, ReadFile, SignalPart
from labbook.analysis.detecting import detection_rows, jumps_found
from labbook.config.parsing import Configuration, parse_configuration
from labbook.statements.assigning import assign_file
from labbook.statements.findings import finding_values
from labbook.statements.importing import PreparedImport, StoredPart, read_and_store
from labbook.statements.scene import Scene, around_run, derived_uid, run_named
from labbook.statements.sheet_charges import add_charges


def apply_ingest(scene: Scene, entry: Entry, prepared: object) -> list[tuple[str, str]]:
    """Add the file, what was read from it, and its run where that is known."""
    new = entry.new or {}
    done = prepared if isinstance(prepared, PreparedImport) else _read_again(scene, new)
    read = done.read
    file_uid = derived_uid("file", done.sha256)
    file_key = imports.add_file(
        scene.connection, uid=file_uid, sha256=done.sha256, n_bytes=done.n_bytes, store_path=done.raw_path
    )
    ingest_key = _add_ingest(scene, entry, read.format, read.reader_version, IngestStatus.IMPORTED, file_key, read)
    imports.add_findings(scene.connection, ingest_key, [finding_values(finding) for finding in read.findings])
    for part, stored in zip(read.parts, done.parts, strict=True):
        _add_signal(scene, file_key, done.sha256, read, part, stored)
    touched = add_charges(scene, ingest_key, file_uid, read)
    run_uid = new.get("run") or run_named(scene, new.get("stated_run"))
    if run_uid:
        assign_file(scene, file_uid, run_uid, read.role or FileRole.LOG)
        touched.append(run_uid)
        imports.add_findings(scene.connection, ingest_key, _jumps_mismatch(scene, run_uid, done))
    return mark_stale(scene.connection, [changed for uid in touched for changed in around_run(scene, uid)])


def apply_refuse(scene: Scene, entry: Entry, _prepared: object) -> list[tuple[str, str]]:
    """Add the row that says why a file was refused; its findings stand in the entry, for no copy is kept."""
    new = entry.new or {}
    ingest_key = _add_ingest(
        scene, entry, new["reader"], new["reader_version"], IngestStatus.REFUSED, None, counts=new["rows"]
    )
    imports.add_findings(scene.connection, ingest_key, new["findings"])
    return []


def as_read(done: PreparedImport) -> dict[str, Any]:
    """Return what the journal keeps of how a file was read, so that another reading can be compared with it."""
    read = done.read
    return {
        "reader": read.format,
        "reader_version": read.reader_version,
        "rows": {"read": read.rows_read, "kept": read.rows_kept, "rejected": read.rows_rejected},
        "signals": [part.sha256 for part in done.parts],
    }


def configuration_in_force(scene: Scene) -> Configuration:
    """Return the configuration under which the book stands at this point of its journal."""
    row = config_in_force(scene.connection)
    assert row is not None, "a configuration is declared before any file is read"  # noqa: S101
    return parse_configuration(row.text, "the book's configuration")


def _read_again(scene: Scene, new: Mapping[str, Any]) -> PreparedImport:
    sha256 = new["sha256"]
    data = scene.store.raw(f"raw/{sha256[:2]}/{sha256}.zst", sha256)
    done = read_and_store(
        scene.store,
        data,
        sha256,
        configuration_in_force(scene),
        new["options"],
        file_name=new["original_name"],
        anew=True,
    )
    if done.read.refused:
        raise BookDamaged(
            f"{new['original_name']} was imported once and is refused by this labbook's {done.read.format} reader, "
            f"version {done.read.reader_version} ({done.read.findings[0].message}): rebuild with the labbook that "
            "imported it."
        )
    return done


def _add_ingest(
    scene: Scene,
    entry: Entry,
    reader: str,
    reader_version: int,
    status: IngestStatus,
    file_key: int | None,
    read: ReadFile | None = None,
    counts: Mapping[str, int] | None = None,
) -> int:
    new = entry.new or {}
    rows = counts or {name: getattr(read, f"rows_{name}") for name in ("read", "kept", "rejected")}
    return imports.add_ingest(
        scene.connection,
        person_name=entry.person,
        values={
            "uid": entry.entity_uid,
            "sha256": new["sha256"],
            "file": file_key,
            "original_name": new["original_name"],
            "modified_utc": new["modified_utc"],
            "status": str(status),
            "reader": reader,
            "reader_version": reader_version,
            "options_json": canonical(new["options"]),
            "role": None if read is None else str(read.role or FileRole.LOG),
            "stated_run": new["stated_run"],
            "at_utc": entry.at_utc,
            **{f"rows_{name}": count for name, count in rows.items()},
        },
    )


def _add_signal(
    scene: Scene, file_key: int, file_sha256: str, read: ReadFile, part: SignalPart, stored: StoredPart
) -> None:
    uid = derived_uid("signal", file_sha256, part.part, read.reader_version)
    imports.add_signal(
        scene.connection,
        {
            "uid": uid,
            "file": file_key,
            "part": part.part,
            "reader": read.format,
            "reader_version": read.reader_version,
            "start_utc": part.start_utc,
            "rate_hz": part.rate_hz,
            "n_samples": len(part.time_s),
            "sha256": stored.sha256,
            "store_path": stored.store_path,
        },
        [
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
        ],
        [
            {
                "start_s": gap.start_s,
                "length_s": gap.length_s,
                "samples_expected": gap.samples_expected,
                "samples_missing": gap.samples_missing,
                "kind": str(gap.kind),
            }
            for gap in part.gaps
        ],
    )
    if stored.detection is not None:
        values, jumps = detection_rows(stored.detection, stored.sha256)
        add_detections(scene.connection, [NewDetection(uid, values, jumps)])


def _jumps_mismatch(scene: Scene, run_uid: str, done: PreparedImport) -> list[dict[str, Any]]:
    """Jumps made are what a person counted; a log that shows another number is worth a look.

    A run that was started again may have more logs to come: fewer jumps in one of them mean nothing yet.
    """
    run = read_fact(scene.connection, "run", run_uid, ["name", "kind", "jumps_made", "starts"])
    found = [jumps_found(part.detection.found.jumps) for part in done.parts if part.detection is not None]
    more_to_come = run["starts"] > 1 and sum(found) < run["jumps_made"]
    if run["kind"] != RunKind.JUMPS or not found or sum(found) == run["jumps_made"] or more_to_come:
        return []
    message = f"{sum(found)} jumps were found and run {run['name']} says {run['jumps_made']} were made."
    return [finding_values(Finding(Severity.NOTE, "jumps_found_not_made", message, None, None, str(sum(found)), 1, ()))]
