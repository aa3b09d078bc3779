"""What `labbook ingest` prints for people: the sum first, then what needs attention, worst first, then the rest."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field

from data_schema.vocabulary import IngestStatus
from labbook.actions.files.ingesting import FileOutcome
from labbook.actions.files.missing_height import MissingHeight
from labbook.actions.runs.rig_line import RigLine
from labbook.cli.ingest_lines import file_head, file_line, needs_a_person, noted_in, outcome_lines

MOST_LISTED = 12
"""More files or runs than this with nothing to say about them are counted, not listed: a day at the rig has fewer."""
_REFUSED, _NO_HEIGHT, _JUMPS, _LOGS, _CHARGE, _ROWS, _NO_RUN, _LIMITS = range(8)
"""What needs attention, gravest first."""


@dataclass(frozen=True, slots=True)
class Batch:
    """What one command did: for each outcome the lines of its runs, and what it lacks for jumps to be found."""

    outcomes: Sequence[FileOutcome]
    rig: Sequence[Sequence[RigLine]]
    heights: Sequence[MissingHeight | None]
    run: str | None
    dry_run: bool


@dataclass(frozen=True, slots=True)
class _Concern:
    """What needs attention: how grave it is, its lines, and of a file what is the same of others that ail alike."""

    rank: tuple[int, int]
    lines: list[str]
    path: str = ""
    alike: tuple[str, ...] = ()


@dataclass(slots=True)
class _Sorted:
    attention: list[_Concern] = field(default_factory=list)
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
            for line in outcome_lines(outcome, missing)
        ]
        rig = sorted((line for of_file in batch.rig for line in of_file), key=_of_run)
        return [summary, *full, *(f"  {line.text}" for line in rig)]
    found = _sorted(batch)
    attention = _worst_first(found.attention)
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
        concern = _concern(outcome, missing, batch.run)
        if concern is not None:
            lines = outcome_lines(outcome, missing, remarks=False)
            alike = tuple(line.replace(outcome.path, "") for line in lines if line != file_head(outcome))
            noted = "" if outcome.status is IngestStatus.REFUSED else noted_in(outcome)
            lines += [f"  noted: {noted}."] if noted else []
            found.attention.append(_Concern(concern, lines, outcome.path, alike))
        elif (outcome.read is not None and outcome.read.findings) or outcome.raw_restored or outcome.said:
            found.noted.append(file_line(outcome))
        else:
            found.fine.append(file_line(outcome))
        for line in of_file:
            rank = _of_run(line)
            if rank[0] > _LIMITS:
                found.fine_runs.append(f"  {line.text}")
            else:
                found.attention.append(_Concern(rank, [f"  {line.text}"]))
    return found


def _worst_first(concerns: Sequence[_Concern]) -> list[str]:
    """Return the lines of all, the gravest first; of files that ail alike the first is told, and the others named."""
    groups: dict[object, list[_Concern]] = {}
    for place, concern in sorted(enumerate(concerns), key=lambda item: item[1].rank):
        groups.setdefault((concern.rank, concern.alike) if concern.alike else place, []).append(concern)
    lines = []
    for first, *others in groups.values():
        lines += first.lines
        if others:
            more = f" and {len(others) - MOST_LISTED} more" if len(others) > MOST_LISTED else ""
            lines.append(f"  the same of: {', '.join(other.path for other in others[:MOST_LISTED])}{more}.")
    return lines


def _concern(outcome: FileOutcome, missing: MissingHeight | None, run: str | None) -> tuple[int, int] | None:
    """Return what of a file needs attention, and minus how much of it; None where nothing does."""
    read = outcome.read
    if outcome.status is IngestStatus.REFUSED:
        return _REFUSED, 0
    if missing is not None:
        return _NO_HEIGHT, 0
    if read is not None and (read.rows_rejected or any(map(needs_a_person, read.findings))):
        return _ROWS, -read.rows_rejected
    not_heeded = outcome.first is not None and run is not None and run not in outcome.runs
    return (_NO_RUN, 0) if not_heeded or (read is not None and not outcome.runs) else None


def _of_run(line: RigLine) -> tuple[int, int]:
    """Rank what is said of a run: jumps not as made, logs too many, an odd charge, joules out of limits, nothing."""
    if line.jumps_off:
        return _JUMPS, -line.jumps_off
    if line.logs_do_not_count:
        return _LOGS, 0
    if line.charge_odd:
        return _CHARGE, 0
    return (_LIMITS, 0) if line.outside else (_LIMITS + 1, 0)


def _folded(lines: Sequence[str], what: str) -> list[str]:
    if len(lines) <= MOST_LISTED:
        return list(lines)
    return [f"{len(lines)} {what} (`--verbose` lists them)."]
