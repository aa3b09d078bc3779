"""What `labbook ingest` prints of each file."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import Any

from data_schema.queries.imports import FirstImport
from data_schema.queries.runs import RunRow
from data_schema.vocabulary import IngestStatus
from ingest.model import Finding
from labbook.actions.ingesting import FileOutcome
from labbook.actions.rig_line import rig_lines
from labbook.analysis.detections import Detections
from labbook.analysis.gathering import Evidence, gather
from labbook.analysis.run_apexes import usable_logs
from labbook.book.opening import Book
from labbook.statements.importing import PreparedImport


def outcome_lines(outcome: FileOutcome, run: str | None) -> list[str]:
    """Return the lines for people: what became of the file that was to belong to `run`, and its findings."""
    if outcome.first is not None:
        first = outcome.first
        runs = f" for run {', '.join(first.runs)}" if first.runs else ""
        line = f"{outcome.path}: imported before{runs}, as {first.original_name} by {first.person} on {first.at_utc}."
        restored = ["  raw copy restored: the book's own was missing or damaged."] if outcome.raw_restored else []
        return [line, *restored, *_run_not_heeded(first, run)]
    read = outcome.read
    assert read is not None  # noqa: S101 - only duplicates are not read
    if outcome.status is IngestStatus.REFUSED:
        head = f"{outcome.path}: refused ({read.format}), nothing stored:"
        return [head, *(f"  {_finding(finding)}" for finding in read.findings)]
    where = f"run {', '.join(outcome.runs)}" if outcome.runs else "no run yet (`labbook runs inbox`)"
    if outcome.runs and outcome.prepared is None:
        where = f"would belong to {where}"
    rejected = f", {read.rows_rejected} rejected" if read.rows_rejected else ""
    head = f"{outcome.path}: {read.format}, {read.rows_kept} rows kept{rejected}, {where}."
    return [head, *(f"  {_finding(finding)}" for finding in read.findings)]


def rig_lines_of(book: Book, outcomes: Sequence[FileOutcome]) -> list[list[str]]:
    """Return how the runs of each file do, when all files are stored: the book is gathered once for all of them.

    A run that several files belong to, a log and a charge, is told once, with the last of them.
    """
    files: dict[str, list[PreparedImport]] = {}
    last: dict[str, int] = {}
    for place, outcome in enumerate(outcomes):
        if outcome.prepared is not None:
            for name in outcome.runs:
                files.setdefault(name, []).append(outcome.prepared)
                last[name] = place
    found: list[list[str]] = [[] for _outcome in outcomes]
    if not files:
        return found
    with book.reading() as connection:
        evidence = gather(connection, book.configuration, None)
        for name, line in rig_lines(Detections(connection, book.store), files, evidence).items():
            found[last[name]].append(line)
    for run in evidence.runs:
        if run.name in last:
            found[last[run.name]] += _logs_too_many(run, evidence)
    return found


def _logs_too_many(run: RunRow, evidence: Evidence) -> list[str]:
    """Say that a run has logs that do not count, for there are more of them than it had starts."""
    logs = evidence.logs.get(run.uid, ())
    why = usable_logs(run, logs) if logs else ()
    if not isinstance(why, str):
        return []
    return [
        f"look again: run {run.name} has {why}, so none of them counts: take one off with "
        f"`labbook assign FILE none --why ...`, or say how often the run was started with "
        f"`labbook correct {run.name} starts=N --why ...`."
    ]


def _run_not_heeded(first: FirstImport, run: str | None) -> list[str]:
    """Say that `--run` does not move a file that is in the book, and what does."""
    if run is None or run in first.runs:
        return []
    if not first.runs:
        return [f"  it belongs to no run, and --run was not heeded: `labbook assign {first.original_name} {run}`."]
    move = f"`labbook assign {first.original_name} {run} --why ...` moves it"
    return [f"  --run {run} was not heeded, for the file belongs to run {', '.join(first.runs)}: {move}."]


def outcome_json(outcome: FileOutcome, rig: Sequence[str]) -> dict[str, Any]:
    """Return the record for programs; `rig` says how the file's runs do."""
    read = outcome.read
    return {
        "file": outcome.path,
        "status": str(outcome.status),
        "sha256": outcome.sha256,
        "runs": list(outcome.runs),
        "format": read.format if read else None,
        "rows_read": read.rows_read if read else 0,
        "rows_kept": read.rows_kept if read else 0,
        "rows_rejected": read.rows_rejected if read else 0,
        "channels": [
            {"name": channel.name, "unit": channel.unit, "rate_hz": part.rate_hz, "n": len(part.time_s)}
            for part in (read.parts if read else ())
            for channel in part.channels
        ],
        "findings": [_finding_json(finding) for finding in (read.findings if read else ())],
        "first_import": outcome.first,
        "raw_restored": outcome.raw_restored,
        "rig": list(rig),
    }


def summary_line(outcomes: Sequence[FileOutcome], dry_run: bool) -> str:
    """Return the one line that sums up a batch."""
    counts = Counter(outcome.status for outcome in outcomes)
    imported = "would be imported" if dry_run else "imported"
    return (
        f"{len(outcomes)} file{'' if len(outcomes) == 1 else 's'}: {counts[IngestStatus.IMPORTED]} {imported}, "
        f"{counts[IngestStatus.DUPLICATE]} there already, {counts[IngestStatus.REFUSED]} refused."
    )


def _finding(finding: Finding) -> str:
    line = "" if finding.line is None else f"line {finding.line}"
    if finding.count > 1 and line:
        line += f" and {finding.count - 1} more"
    column = "" if finding.column is None else f"column {finding.column!r}"
    place = f" ({', '.join(filter(None, (column, line)))})" if column or line else ""
    return f"{finding.severity}: {finding.rule}{place}: {finding.message}"


def _finding_json(finding: Finding) -> dict[str, Any]:
    return {
        "severity": str(finding.severity),
        "rule": finding.rule,
        "line": finding.line,
        "more_lines": list(finding.more_lines),
        "column": finding.column,
        "value": finding.value,
        "count": finding.count,
        "message": finding.message,
    }
