"""A file was ingested, read again, or refused: the rows that it leaves, of the file and of each of its readings."""

from __future__ import annotations

import shlex
from collections.abc import Collection, Mapping, Sequence
from dataclasses import asdict
from typing import Any

import sqlalchemy as sa

from data_schema.errors import BookBusy, BookError, InputRefused, UsageError
from data_schema.journal import Entry, canonical
from data_schema.queries import files
from data_schema.queries.detections import add_detection
from data_schema.queries.facts import insert_fact, key_of
from data_schema.queries.files import ReadingRow, last_reading, links_of_file, parts_of_file, set_status
from data_schema.queries.runs import stated_of_run
from data_schema.vocabulary import FileRole, IngestStatus, RunKind, Severity
from ingest.declared import flag_of
from ingest.formats.format import UNKNOWN
from ingest.formats.registry import PLUGIN_FAILED
from ingest.model import ChannelData, Finding, ReadFile, SignalPart
from ingest.read import read_file
from ingest.store import raw_path
from labbook.analysis.outcomes.detection import BODY_HEIGHT, jumps_found
from labbook.analysis.outcomes.log_dates import day_notes
from labbook.statements.apply_context import ApplyContext, derived_uid, run_named
from labbook.statements.assigning import link_part, link_parts_again
from labbook.statements.importing import (
    PreparedImport,
    ReadSettings,
    finding_values,
    store_reading,
)
from labbook.statements.reading_cache import remember
from labbook.statements.sheet_charges import charge_numbers, keys_of, mark_charges_gone, update_charges

RUN_CONTRADICTS = "run_contradicts"
"""The rule of a file whose name and content say that it is of other runs."""

_ZERO_SE_M = 0.005
"""Standard error of a zero that a standing body shows: its leg gives way by some millimetres, more in some logs."""


def apply_ingest(context: ApplyContext, entry: Entry, prepared: object) -> None:
    """Add the file, what was read from it, and its run where that is known; of a refused one the findings.

    A file that this labbook's reader refuses, on rebuilding, waits for a declaration; it belongs to its run all the
    same. Another reading of a file is in force from now on, and what belongs to the file is brought up to it: parts
    that there are no longer belong to no run, and parts that are new belong to the one run that the file belongs to.
    Statements about a file that were made while it waited take effect then.
    """
    connection, new = context.connection, entry.new or {}
    if not entry.reads:  # no copy is stored
        reader = (new["reader"], new["reader_version"])
        ingest_key = _add(context, entry, IngestStatus.REFUSED, None, reader, None, new["rows"])
        files.add_findings(connection, ingest_key, new["findings"])
        return
    done = _reading_of(context, new, prepared)
    file_uid, role, parts = derived_uid("file", done.sha256), _role(new, done), _parts(new, done)
    before, of_runs = None if entry.makes else _read_before(connection, new), dict[str, list[str]]()
    if before is None:
        values = {"sha256": done.sha256, "n_bytes": done.n_bytes, "store_path": raw_path(done.sha256)}
        file_key = insert_fact(connection, "file", file_uid, values)
        ingest_key = add_reading(context, entry, done, file_key, role)
        run_uid = new.get("run") or run_named(context, new.get("stated_run"))
        if run_uid:
            of_runs[run_uid] = parts
            for part in parts:
                link_part(context, file_uid, run_uid, role, part)
    else:
        before_parts = parts_of_file(connection, file_uid)
        set_status(connection, before.uid, IngestStatus.SUPERSEDED)
        file_key = key_of(connection, "file", file_uid)
        ingest_key = add_reading(context, entry, done, file_key, role)
        link_parts_again(context, file_uid, role, new.get("stated_run"), before_parts, parts)
        for link in links_of_file(connection, file_uid):
            of_runs.setdefault(link.run_uid, []).append(link.part)
    if done.read.refused:
        mark_charges_gone(context, file_uid)
    else:
        add_signals(context, file_key, ingest_key, done, new, None if before is None else entry.entity_uid)
        if done.read.charges or before is not None:
            of_file = next(iter(of_runs)) if role is FileRole.CHARGE and len(of_runs) == 1 else None
            numbers = charge_numbers(connection, done.sha256, keys_of(done.read.charges), new)
            update_charges(context, ingest_key, file_uid, done.read, numbers, of_file)
    contradicting = runs_contradict(new.get("stated_runs", ()), new["original_name"])
    files.add_findings(connection, ingest_key, [finding_values(finding) for finding in contradicting])
    for run_uid, of_run in of_runs.items():
        files.add_findings(connection, ingest_key, _against_run(context, run_uid, of_run, done))


def _read_before(connection: sa.Connection, new: Mapping[str, Any]) -> ReadingRow:
    before = last_reading(connection, new["sha256"])
    if before is None:
        raise InputRefused(f"{new['original_name']} is not in the book: what was never read cannot be read again.")
    return before


def runs_contradict(stated: Sequence[str], name: str) -> list[Finding]:
    """Return the finding on a file of this name that says it is of several runs; empty where it says one, or none."""
    if len(stated) < 2:
        return []
    message = (
        f"The file's name says run {stated[0]} and the lines above its table run {stated[1]}, so that it belongs to "
        f"none: `labbook assign {shlex.quote(name)} {stated[0]}`, or {stated[1]}, says which."
    )
    return [Finding(Severity.NOTE, RUN_CONTRADICTS, message, None, None, " ".join(stated), 1, ())]


def _parts(new: Mapping[str, Any], done: PreparedImport) -> list[str]:
    """Return the parts of a reading; of one that is refused now, those that it gave when it was made."""
    return (new["parts"] if done.read.refused else [part.part for part in done.read.parts]) or [""]


def _reading_of(context: ApplyContext, new: Mapping[str, Any], prepared: object) -> PreparedImport:
    """Return what was read before, or read it again; a live one's files must be there now that nobody else writes."""
    if not isinstance(prepared, PreparedImport):
        return _read_again(context, new)
    if context.without_rows is not None:  # it was looked at when it was taken
        return prepared
    for path in (raw_path(prepared.sha256), *(part.store_path for part in prepared.parts)):
        if not (context.store.root / path).exists():
            raise BookBusy(f"{path} was removed from the store before the book had it: give the command again.")
    return prepared


def _read_again(context: ApplyContext, new: Mapping[str, Any]) -> PreparedImport:
    """Read the stored copy with the entry's settings."""
    sha256, settings = new["sha256"], ReadSettings.from_json(new["settings"])
    if sha256 in context.lost:
        read = (new["reader"], new["reader_version"])
        message = (
            f"its raw copy {raw_path(sha256)} is missing or damaged; give the original file again with `labbook "
            "ingest`, or put the copy back from a backup and run `labbook rebuild`."
        )
        return _unread(new, new.get("n_bytes", 0), settings, files.LOST, message, read)
    data = context.store.raw(raw_path(sha256), sha256)
    try:
        done = store_reading(context.store, data, sha256, read_file(data, settings.declared), settings, anew=True)
    except (UsageError, InputRefused) as error:
        # what was declared then has no meaning any more: a format's plug-in is not there
        return _unread(new, len(data), settings, "declaration_unknown", _named_plugin(new, str(error)))
    except (BookError, OSError, MemoryError):
        raise
    except Exception as error:  # whatever somebody else's code does
        failure = f"Reading it failed ({type(error).__name__}: {error})."
        return _unread(new, len(data), settings, PLUGIN_FAILED, _named_plugin(new, failure))
    remember(done, new["settings"])
    return done


def _named_plugin(new: Mapping[str, Any], failure: str) -> str:
    return f"It was read by plug-in {new['plugin']}: {failure}" if new.get("plugin") else failure


def _unread(
    new: Mapping[str, Any],
    n_bytes: int,
    settings: ReadSettings,
    rule: str,
    message: str,
    reader: tuple[str, int] = (UNKNOWN, 0),
) -> PreparedImport:
    finding = Finding(Severity.FILE, rule, message, None, None, None, 1, ())
    read = ReadFile(format=reader[0], reader_version=reader[1], findings=(finding,))
    return PreparedImport(new["sha256"], n_bytes, read, settings, ())


def _role(new: Mapping[str, Any], done: PreparedImport) -> FileRole:
    if not done.read.refused:
        return done.read.role or FileRole.LOG
    return FileRole(new["role"])


def _against_run(
    context: ApplyContext, run_uid: str, of_run: Collection[str], done: PreparedImport
) -> list[dict[str, Any]]:
    """Return what is found of the parts of a file that belong to a run by that run: other jumps, another day."""
    run = stated_of_run(context.connection, run_uid)
    found = _jumps_mismatch(run, of_run, done) + _height_zeros(run, of_run, done)
    if done.read.role is not FileRole.CHARGE and not done.read.refused:
        parts = [part for part in done.read.parts if part.part in of_run]
        found += day_notes(parts, run["name"], run["date_local"], done.settings.declared.time_zone)
    return [finding_values(finding) for finding in found]


def _jumps_mismatch(run: Mapping[str, Any], of_run: Collection[str], done: PreparedImport) -> list[Finding]:
    """Return a note where a log shows another number of jumps than the person counted.

    A run that was started again may have more logs to come: fewer jumps in one of them mean nothing yet.
    """
    found = [
        jumps_found(stored.detection.row.jumps)
        for part, stored in zip(done.read.parts, done.parts, strict=True)
        if stored.detection is not None and part.part in of_run
    ]
    more_to_come = run["starts"] > 1 and sum(found) < run["jumps_made"]
    if run["kind"] != RunKind.JUMPS or not found or sum(found) == run["jumps_made"] or more_to_come:
        return []
    message = f"{sum(found)} jumps were found and run {run['name']} says {run['jumps_made']} were made."
    return [Finding(Severity.NOTE, "jumps_found_not_made", message, None, None, str(sum(found)), 1, ())]


def _height_zeros(run: Mapping[str, Any], of_run: Collection[str], done: PreparedImport) -> list[Finding]:
    """Return what the standing body says of a height's zero, and where no stance is found though jumps were made."""
    found = []
    zero_rule, no_stance_rule = files.LEG
    for part, stored in zip(done.read.parts, done.parts, strict=True):
        if stored.detection is None or part.part not in of_run or run["kind"] != RunKind.JUMPS:
            continue
        height = next(channel for channel in part.channels if channel.name == BODY_HEIGHT)
        rest_m, zero_m = stored.detection.rest_length_m, stored.detection.zero_m
        if zero_m:
            remedy = _zero_remedy(height, flag_of(done.read.explanation.tables, height.source_name), zero_m, done)
            message = (
                f"The body stands higher than its leg is long (rest length {rest_m:.3f} m), and leaves the ground at "
                f"{rest_m + zero_m:.3f} m: a zero of about {1e3 * zero_m:.0f} mm? {remedy}, or correct rest_length_m "
                "in [robots]."
            )
            found.append(Finding(Severity.NOTE, zero_rule, message, None, height.source_name, f"{zero_m:g}", 1, ()))
        elif run["jumps_made"] and stored.detection.height_range_m is not None:
            low_m, high_m = stored.detection.height_range_m
            flag = flag_of(done.read.explanation.tables, height.source_name)
            message = (
                f"No jump can be found: the body is between {low_m:.3f} and {high_m:.3f} m, and jumps go below and "
                f"above the leg's rest length, {rest_m:.3f} m: did the sensor come loose, are the height's unit and "
                f'zero right (`--column "{flag}={BODY_HEIGHT}:{height.source_unit or "m"},offset=OFFSET"`), and '
                "rest_length_m in [robots]?"
            )
            found.append(Finding(Severity.NOTE, no_stance_rule, message, None, height.source_name, None, 1, ()))
    return found


def _zero_remedy(height: ChannelData, flag: str, zero_m: float, done: PreparedImport) -> str:
    """Return how the zero of a height is stated, in the unit of its column."""
    if height.calibration is not None:
        return f"Correct the calibration of column {height.source_name!r}"
    named = shlex.quote(done.settings.declared.file_name or "NAME")
    column = zero_declared(flag, height.source_unit, height.sign, height.scale, zero_m)
    return f'Say `labbook files reread {named} --column "{column}"`, with one offset for all logs of a sensor'


def zero_declared(flag: str, source_unit: str | None, sign: int, scale: float, zero_m: float) -> str:
    """Return what `--column` is given so that a height's zero, in m, is taken off; `sign` and `scale` are its own."""
    offset, se = -sign * zero_m / scale, _ZERO_SE_M / scale
    return f"{flag}={BODY_HEIGHT}:{source_unit or 'm'},offset={offset:.4g},offset_se={se:.2g}"


def add_reading(context: ApplyContext, entry: Entry, done: PreparedImport, file_key: int, role: FileRole) -> int:
    """Add how a file was read and what the checks found; returns the key of the reading.

    A file that is refused now and was read when the statement was made waits for a declaration.
    """
    read = done.read
    status = IngestStatus.WAITING if read.refused else IngestStatus.IMPORTED
    counts = {name: getattr(read, f"rows_{name}") for name in ("read", "kept", "rejected")}
    key = _add(context, entry, status, file_key, (read.format, read.reader_version), role, counts)
    files.add_findings(context.connection, key, [finding_values(finding) for finding in read.findings])
    return key


def _add(
    context: ApplyContext,
    entry: Entry,
    status: IngestStatus,
    file_key: int | None,
    reader: tuple[str, int],
    role: FileRole | None,
    counts: Mapping[str, int],
) -> int:
    new = entry.new or {}
    return files.add_ingest(
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
            "declared_json": canonical(new["settings"]),
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
    recorded = _recorded(done, new)
    for part, stored in zip(done.read.parts, done.parts, strict=True):
        named = (done.sha256, part.part, done.read.reader_version)
        values = {
            "uid": derived_uid("signal", *(named if reading_uid is None else (reading_uid, part.part))),
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
        key = files.add_signal(context.connection, values, _channels(part, stored.ranges), _gaps(part))
        if stored.detection is not None:
            add_detection(context.connection, stored.detection.row, key)


def _recorded(done: PreparedImport, new: Mapping[str, Any]) -> dict[str, str]:
    """Return, by part, the hash of its samples in the journal, where they are sampled at the same times now.

    Verdicts of people name that hash.
    """
    recorded = zip(new["signals"], new["times"], strict=True)
    if len(new["signals"]) != len(done.parts):
        return {}
    return {
        part.part: sha256
        for part, stored, (sha256, time_sha256) in zip(done.read.parts, done.parts, recorded, strict=True)
        if time_sha256 == stored.time_sha256
    }


def _channels(part: SignalPart, ranges: Sequence[tuple[float, float] | None]) -> list[dict[str, Any]]:
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
            "lowest": None if found is None else found[0],
            "highest": None if found is None else found[1],
            "assumed_json": canonical(list(channel.assumed)),
            "calibration_json": None if channel.calibration is None else canonical(asdict(channel.calibration)),
            "calibrated_unit": channel.calibrated_unit,
        }
        for position, (channel, found) in enumerate(zip(part.channels, ranges, strict=True))
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
