"""What `labbook ingest` prints for people: the sum first, then what needs attention, worst first, then the rest."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field

from data_schema.vocabulary import IngestStatus, Severity
from labbook.actions.ingesting import FileOutcome
from labbook.actions.missing_height import MissingHeight
from labbook.actions.rig_line import RigLine
from labbook.cli.ingest_lines import file_line, outcome_lines

MOST_LISTED = 12
"""More files or runs than this with nothing to say about them are counted, not listed: a day at the rig has fewer."""
_OF_RUNS = ("charge_contradicts",)
_REFUSED, _NO_HEIGHT, _JUMPS, _LOGS, _ROWS, _NO_RUN, _LIMITS = range(7)
"""What needs attention, gravest first."""


@dataclass(frozen=True, slots=True)
class Batch:
    """What one command did: for each outcome the lines of its runs, and what it lacks for jumps to be found."""

    outcomes: Sequence[FileOutcome]
    rig: Sequence[Sequence[RigLine]]
    heights: Sequence[MissingHeight | None]
    run: str | None
    dry_run: bool


@dataclass(slots=True)
class _Sorted:
    attention: list[tuple[tuple[int, int], list[str]]] = field(default_factory=list)
    noted: list[str] = field(default_factory=list)
    fine: list[str] = field(default_factory=list)
    fine_runs: list[str] = field(default_factory=list)


def batch_lines(batch: Batch, *, verbose: bool) -> list[str]:
    """Return all lines; of one file, or where `verbose`, everything that is known, else short lines and counts."""
    summary = summary_line(batch.outcomes, batch.dry_run)
    if len(batch.outcomes) == 1 or verbose:
        full = [
            line
            for outcome, missing in zip(batch.outcomes, batch.heights, strict=True)
            for line in outcome_lines(outcome, batch.run, missing)
        ]
        rig = sorted((line for of_file in batch.rig for line in of_file), key=_of_run)
        return [summary, *full, *(f"  {line.text}" for line in rig)]
    found = _sorted(batch)
    attention = [line for _rank, lines in sorted(found.attention, key=lambda item: item[0]) for line in lines]
    if attention:
        attention.insert(0, f"look at these first ({len(found.attention)}):")
        if found.noted or found.fine or found.fine_runs:
            attention.append("the others:")
    return [
        summary,
        *attention,
        *found.noted,
        *_folded(found.fine, "files with nothing to remark"),
        *_folded(found.fine_runs, "runs as they should be"),
    ]


def summary_line(outcomes: Sequence[FileOutcome], dry_run: bool) -> str:
    """Return the one line that sums up a batch."""
    counts = Counter(outcome.status for outcome in outcomes)
    imported = "would be imported" if dry_run else "imported"
    return (
        f"{len(outcomes)} file{'' if len(outcomes) == 1 else 's'}: {counts[IngestStatus.IMPORTED]} {imported}, "
        f"{counts[IngestStatus.DUPLICATE]} there already, {counts[IngestStatus.REFUSED]} refused."
    )


def _sorted(batch: Batch) -> _Sorted:
    found = _Sorted()
    for outcome, of_file, missing in zip(batch.outcomes, batch.rig, batch.heights, strict=True):
        full = outcome_lines(outcome, batch.run, missing, remarks=outcome.status is not IngestStatus.REFUSED)
        concern = _concern(outcome, missing, batch.run)
        if concern is not None:
            found.attention.append((concern, full))
        elif (outcome.read is not None and outcome.read.findings) or outcome.raw_restored:
            found.noted.append(file_line(outcome))
        else:
            found.fine.append(file_line(outcome))
        for line in of_file:
            rank = _of_run(line)
            if rank[0] > _LIMITS:
                found.fine_runs.append(f"  {line.text}")
            else:
                found.attention.append((rank, [f"  {line.text}"]))
    return found


def _concern(outcome: FileOutcome, missing: MissingHeight | None, run: str | None) -> tuple[int, int] | None:
    """Return what of a file needs attention, and minus how much of it; None where nothing does."""
    read = outcome.read
    if outcome.status is IngestStatus.REFUSED:
        return _REFUSED, 0
    if missing is not None:
        return _NO_HEIGHT, 0
    if read is not None and (read.rows_rejected or any(finding.severity is Severity.ROW for finding in read.findings)):
        return _ROWS, -read.rows_rejected
    if read is not None and any(finding.rule in _OF_RUNS for finding in read.findings):
        return _ROWS, 0
    not_heeded = outcome.first is not None and run is not None and run not in outcome.first.runs
    return (_NO_RUN, 0) if not_heeded or (read is not None and not outcome.runs) else None


def _of_run(line: RigLine) -> tuple[int, int]:
    """Rank what is said of a run: how many jumps are not as made, logs too many, joules out of limits, nothing."""
    if line.jumps_off:
        return _JUMPS, -line.jumps_off
    if line.logs_do_not_count:
        return _LOGS, 0
    return (_LIMITS, 0) if line.outside else (_LIMITS + 1, 0)


def _folded(lines: Sequence[str], what: str) -> list[str]:
    if len(lines) <= MOST_LISTED:
        return list(lines)
    return [f"{len(lines)} {what} (`--verbose` lists them)."]
