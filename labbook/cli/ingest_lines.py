"""What `labbook ingest` prints of each file."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import Any

from data_schema.queries.runs import RunRow, runs_named, runs_of_conditions
from data_schema.vocabulary import IngestStatus, Severity
from ingest.model import Finding
from labbook.actions.files.ingesting import FileOutcome
from labbook.actions.files.missing_height import MissingHeight, missing_height_lines
from labbook.actions.runs.remarks import remarks_on
from labbook.actions.runs.rig_line import RigLine, rig_lines
from labbook.analysis.outcomes.detections import Detections
from labbook.analysis.outcomes.run_apexes import usable_logs
from labbook.analysis.study_data import StudyData, gather_about
from labbook.book.opening import Book
from labbook.statements.importing import PreparedImport

_MOST_COLUMNS = 8
_CONTRADICTIONS = ("charge_contradicts", "log_day_differs", "height_doubtful")
"""Rules of notes that wait for a person's word."""


def outcome_lines(outcome: FileOutcome, missing: MissingHeight | None = None, *, remarks: bool = True) -> list[str]:
    """Return the lines for people: what became of the file, and its findings.

    `missing` is said before all else: the log has no body height. Without `remarks` only findings that a person must
    act on are told.
    """
    if outcome.first is not None:
        restored = ["  raw copy restored: the book's own was missing or damaged."] if outcome.raw_restored else []
        return [file_head(outcome), *restored, *(f"  {text}" for text in outcome.said)]
    loud = [] if missing is None else missing_height_lines(outcome.path, missing)
    found = () if outcome.read is None else outcome.read.findings
    findings = [finding for finding in found if remarks or not _is_remark(finding)]
    return [*loud, file_head(outcome), *(f"  {line}" for line in finding_lines(findings))]


def file_line(outcome: FileOutcome) -> str:
    """Return the one line that is enough where nothing needs attention: what was read, and the rules of its remarks."""
    if outcome.first is not None:
        return (
            file_head(outcome)
            + ("".join(f" {text}" for text in outcome.said))
            + (" Raw copy restored." if outcome.raw_restored else "")
        )
    noted = noted_in(outcome)
    return file_head(outcome) + (f" Noted: {noted}." if noted else "")


def noted_in(outcome: FileOutcome) -> str:
    """Return the rules of a file's remarks, each with how often it was found; empty where there are none."""
    found = () if outcome.read is None else outcome.read.findings
    rules = Counter(finding.rule for finding in found if _is_remark(finding))
    return ", ".join(rule if count == 1 else f"{count} {rule}" for rule, count in rules.items())


def needs_a_person(finding: Finding) -> bool:
    """Whether a finding calls for somebody though the file was imported: rows left out, charges that contradict."""
    return finding.severity is Severity.ROW or finding.rule in _CONTRADICTIONS


def _is_remark(finding: Finding) -> bool:
    return finding.severity is Severity.NOTE and finding.rule not in _CONTRADICTIONS


def file_head(outcome: FileOutcome) -> str:
    """Return what became of a file, in one line."""
    if outcome.first is not None:
        first = outcome.first
        runs = f" for run {', '.join(first.runs)}" if first.runs else ""
        return f"{outcome.path}: imported before{runs}, as {first.original_name} by {first.person} on {first.at_utc}."
    read = outcome.read
    assert read is not None  # noqa: S101 - only duplicates are not read
    if outcome.status is IngestStatus.REFUSED:
        return f"{outcome.path}: refused ({read.format}), nothing stored:"
    where = f"run {', '.join(outcome.runs)}" if outcome.runs else "no run yet (`labbook runs inbox`)"
    if outcome.runs and outcome.prepared is None:
        where = f"would belong to {where}"
    rejected = f", {read.rows_rejected} rejected" if read.rows_rejected else ""
    return f"{outcome.path}: {read.format}, {read.rows_kept} rows kept{rejected}, {where}."


def rig_lines_of(book: Book, outcomes: Sequence[FileOutcome]) -> list[list[RigLine]]:
    """Return how the runs of each file do, when all files are stored.

    A run that several files belong to, a log and a charge, is told once, with the last of them.
    """
    files: dict[str, list[PreparedImport]] = {}
    last: dict[str, int] = {}
    for place, outcome in enumerate(outcomes):
        if outcome.prepared is not None:
            for name in outcome.runs:
                files.setdefault(name, []).append(outcome.prepared)
                last[name] = place
    found: list[list[RigLine]] = [[] for _outcome in outcomes]
    if not files:
        return found
    with book.reading() as connection:
        about = runs_named(connection, list(files))
        conditions = sorted({run.condition_uid for run in about if run.condition_uid is not None})
        earlier = runs_of_conditions(connection, conditions)
        evidence = gather_about(connection, book.configuration, about, earlier)
        for name, line in rig_lines(Detections(connection, book.store), files, evidence).items():
            found[last[name]].append(line)
        charged = [name for name, prepared in files.items() if any(each.read.charges for each in prepared)]
        remarks = remarks_on(connection, book.configuration, charged, ["charge_mah"])
    for remark in remarks:
        found[last[remark.first]].append(RigLine(f"look again: {remark.message}", charge_odd=True))
    for run in evidence.runs:
        if run.name in last:
            found[last[run.name]] += _logs_too_many(run, evidence)
    return found


def _logs_too_many(run: RunRow, evidence: StudyData) -> list[RigLine]:
    """Say that a run has logs that do not count, for there are more of them than it had starts."""
    logs = evidence.logs.get(run.uid, ())
    why = usable_logs(run, logs) if logs else ()
    if not isinstance(why, str):
        return []
    text = (
        f"look again: run {run.name} has {why}, so none of them counts: take one off with "
        f"`labbook assign FILE none --why ...`, or say how often the run was started with "
        f"`labbook correct {run.name} starts=N --why ...`."
    )
    return [RigLine(text, logs_do_not_count=True)]


def outcome_json(outcome: FileOutcome, rig: Sequence[RigLine], missing: MissingHeight | None) -> dict[str, Any]:
    """Return the record for programs; `rig` says how the file's runs do, `missing` what a log lacks for jumps."""
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
        "changes": outcome.changes,
        "said": list(outcome.said),
        "raw_restored": outcome.raw_restored,
        "rig": [line.text for line in rig],
        "missing_body_height": missing,
    }


def finding_lines(findings: Sequence[Finding]) -> list[str]:
    """Return a line for each rule: what several columns or rows have in common is said once, with the first message.

    Of what refuses a file every message stands, for each names what to do.
    """
    by_rule: dict[object, list[Finding]] = {}
    for finding in findings:
        alike = finding if finding.severity is Severity.FILE else (finding.severity, finding.rule)
        by_rule.setdefault(alike, []).append(finding)
    return [_finding_line(same) for same in by_rule.values()]


def _finding_line(same: Sequence[Finding]) -> str:
    first = same[0]
    columns = list(dict.fromkeys(repr(finding.column) for finding in same if finding.column is not None))
    more = f" and {len(columns) - _MOST_COLUMNS} more" if len(columns) > _MOST_COLUMNS else ""
    column = f"column{'' if len(columns) == 1 else 's'} {', '.join(columns[:_MOST_COLUMNS])}{more}" if columns else ""
    line = "" if first.line is None else f"line {first.line}"
    count = sum(finding.count for finding in same)
    if count > 1 and line:
        line += f" and {count - 1} more"
    times = f"{len(same)} times" if len(same) > max(1, len(columns)) else ""
    place = ", ".join(filter(None, (column, line, times)))
    return f"{first.severity}: {first.rule}{f' ({place})' if place else ''}: {first.message}"


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
