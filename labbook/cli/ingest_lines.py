"""What `labbook ingest` prints: the sum first, then what needs attention, worst first, then the rest.

And what `--explain` prints of a file.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeAlias

from data_schema.grouping import grouped
from data_schema.queries.files import LEG
from data_schema.vocabulary import FileRole, IngestStatus, Severity
from ingest.model import Finding, ReadFile, TableUse
from labbook.actions.files.ingesting import FileOutcome
from labbook.actions.files.rereading import OUTDATED
from labbook.actions.runs.rig_line import MissingHeight, RigLine, missing_height_lines
from labbook.terminal import columns, listed

if TYPE_CHECKING:
    from labbook.actions.files.explaining import Explained


_MOST_COLUMNS = 8
_OF_OTHER_RUN = ("run_contradicts", "log_day_differs")
"""Rules of notes on a file that may be of another run than it belongs to."""
_CONTRADICTIONS = (*_OF_OTHER_RUN, "charge_contradicts", "date_in_future", *LEG)
"""Rules of notes that wait for a person's word."""


@dataclass(frozen=True, slots=True)
class Taken:
    """A file that was taken in: what became of it, the lines of its runs, and what it lacks for jumps to be found."""

    outcome: FileOutcome
    rig: Sequence[RigLine] = ()
    missing: MissingHeight | None = None


def outcome_lines(outcome: FileOutcome, missing: MissingHeight | None = None, *, remarks: bool = True) -> list[str]:
    """Return the lines for people: what became of the file, and its findings.

    `missing` comes first: the log has no body height. Without `remarks` only findings that a person must act on are
    listed.
    """
    if outcome.first is not None:
        restored = ["  raw copy restored: the book's own was missing or damaged."] if outcome.raw_restored else []
        return [file_head(outcome), *restored, *(f"  {text}" for text in outcome.messages)]
    loud = [] if missing is None else missing_height_lines(outcome.name, missing)
    found = () if outcome.read is None else outcome.read.findings
    findings = [finding for finding in found if remarks or not _is_remark(finding)]
    return [*loud, file_head(outcome), *(f"  {line}" for line in (*finding_lines(findings), *outcome.messages))]


def file_line(outcome: FileOutcome) -> str:
    """Return the one line that is enough where nothing needs attention: what was read, and the rules of its remarks."""
    if outcome.first is not None:
        return " ".join(line.strip() for line in outcome_lines(outcome))
    noted = remark_counts(outcome)
    return file_head(outcome) + (f" Noted: {noted}." if noted else "")


def remark_counts(outcome: FileOutcome) -> str:
    """Return the rules of a file's remarks, each with how often it was found; empty where there are none."""
    found = () if outcome.read is None else outcome.read.findings
    rules = Counter(finding.rule for finding in found if _is_remark(finding))
    return ", ".join(rule if count == 1 else f"{count} {rule}" for rule, count in rules.items())


def _is_remark(finding: Finding) -> bool:
    return finding.severity is Severity.NOTE and finding.rule not in _CONTRADICTIONS


def file_head(outcome: FileOutcome) -> str:
    """Return what became of a file, in one line."""
    if outcome.first is not None:
        first = outcome.first
        runs = f" for run {', '.join(first.runs)}" if first.runs else ""
        return f"{outcome.name}: imported before{runs}, as {first.original_name} by {first.person} on {first.at_utc}."
    read = outcome.read
    assert read is not None  # noqa: S101 - only duplicates are not read
    if outcome.status is IngestStatus.REFUSED:
        return f"{outcome.name}: refused ({read.format}), nothing stored:"
    where = f"run {', '.join(outcome.runs)}" if outcome.runs else "no run yet (`labbook runs inbox`)"
    where = "no row is new" if _knows_all(read) else where
    where = "for `labbook study`" if read.role is FileRole.SHEET else where
    if outcome.runs and outcome.prepared is None:
        where = f"would belong to {where}"
    rejected = f", {read.rows_rejected} rejected" if read.rows_rejected else ""
    instead = f" In place of {listed(outcome.replaced)}, its beginning, now withdrawn." if outcome.replaced else ""
    return f"{outcome.name}: {read.format}, {read.rows_kept} rows kept{rejected}, {where}.{instead}"


def _knows_all(read: ReadFile) -> bool:
    """Whether the book has all charges of a file already."""
    known = sum(finding.count for finding in read.findings if finding.rule == "charge_known")
    return bool(read.charges) and known == len(read.charges)


def taken_json(taken: Taken) -> dict[str, Any]:
    """Return the record for programs."""
    outcome, read = taken.outcome, taken.outcome.read
    return {
        "file": outcome.name,
        "status": str(outcome.status),
        "sha256": outcome.sha256,
        "runs": list(outcome.runs),
        "format": read.format if read else None,
        **{name: getattr(read, name, 0) for name in ("rows_read", "rows_kept", "rows_rejected")},
        "channels": [
            {"name": channel.name, "unit": channel.unit, "rate_hz": part.rate_hz, "n": len(part.time_s)}
            for part in (read.parts if read else ())
            for channel in part.channels
        ],
        "findings": read.findings if read else [],
        "first_import": outcome.first,
        "changes": outcome.changes,
        "said": list(outcome.messages),
        "raw_restored": outcome.raw_restored,
        "replaced": list(outcome.replaced),
        "rig": [line.text for line in taken.rig],
        "missing_body_height": taken.missing,
    }


def finding_lines(findings: Sequence[Finding]) -> list[str]:
    """Return a line for each rule: what several columns or rows have in common is written once, with the first message.

    Of what refuses a file every message stands, for each names what to do.
    """
    rules = [one if one.severity is Severity.FILE else (one.severity, one.rule) for one in findings]
    by_rule = grouped(findings, rules)
    return [_finding_line(same) for same in by_rule.values()]


def _finding_line(same: Sequence[Finding]) -> str:
    first = same[0]
    columns = list(dict.fromkeys(repr(finding.column) for finding in same if finding.column is not None))
    column = f"column{'' if len(columns) == 1 else 's'} {listed(columns, _MOST_COLUMNS)}" if columns else ""
    line = "" if first.line is None else f"line {first.line}"
    count = sum(finding.count for finding in same)
    if count > 1 and line:
        line += f" and {count - 1} more"
    times = f"{len(same)} times" if len(same) > max(1, len(columns)) else ""
    place = ", ".join(filter(None, (column, line, times)))
    return f"{first.severity}: {first.rule}{f' ({place})' if place else ''}: {first.message}"


MOST_LISTED = 12
"""More files or runs than this with nothing to say about them are counted, not listed: a day at the rig has fewer."""
_REFUSED, _OTHER_RUN, _NO_HEIGHT, _LOGS, _DOUBTFUL, _NO_RUN, _JUMPS, _SAMPLES, _LIMITS = range(9)
"""What needs attention, gravest first: what gives wrong numbers or none, before what a run has less of."""


_NOTED = "  noted: "
_Concern: TypeAlias = tuple[tuple[int, int], list[str], FileOutcome | None]
"""What needs attention: how grave it is, its lines, and the file where it is about one."""


def batch_lines(files: Sequence[Taken], run: str | None, skipped: str, *, dry_run: bool, verbose: bool) -> list[str]:
    """Return all lines; of one file, or where `verbose`, everything that is known, else short lines and counts.

    `run` is the one named for all, `skipped` says what was left out of the folders named; "" where nothing was.
    """
    counts = Counter(each.outcome.status for each in files)
    imported = "would be imported" if dry_run else "imported"
    summary = [
        f"{len(files)} file{'' if len(files) == 1 else 's'}: {counts[IngestStatus.IMPORTED]} {imported}, "
        f"{counts[IngestStatus.DUPLICATE]} there already, {counts[IngestStatus.REFUSED]} refused.",
        *([skipped] if skipped else []),
    ]
    rig = [line for each in files for line in each.rig]
    if len(files) == 1 or verbose:
        full = [line for each in files for line in outcome_lines(each.outcome, each.missing)]
        return [*summary, *full, *(f"  {line.text}" for line in sorted(rig, key=_of_run))]
    attention: list[_Concern] = []
    noted: list[str] = []
    fine: list[str] = []
    outdated: list[str] = []
    for each in files:
        outcome, missing = each.outcome, each.missing
        concern = _concern(outcome, missing, run)
        if concern is not None:
            rules = "" if outcome.status is IngestStatus.REFUSED else remark_counts(outcome)
            more = [f"{_NOTED}{rules}."] if rules else []
            attention.append((concern, [*outcome_lines(outcome, missing, remarks=False), *more], outcome))
        elif outcome.messages == (OUTDATED,) and not outcome.raw_restored:
            outdated.append(outcome.name)
        else:
            calm = outcome.read is not None and outcome.read.findings
            (noted if calm or outcome.raw_restored or outcome.messages else fine).append(file_line(outcome))
    attention += [(_of_run(line), [f"  {line.text}"], None) for line in rig if line.concern]
    others = [
        *noted,
        *([f"{listed(outdated)}: imported before; {OUTDATED}"] if outdated else []),
        *_folded(fine, "files with nothing to remark"),
        *_folded([f"  {line.text}" for line in rig if not line.concern], "runs as they should be"),
    ]
    if not attention:
        return [*summary, *others]
    head = f"look at these first ({len(attention)}):"
    return [*summary, head, *_worst_first(attention), *(["the others:", *others] if others else [])]


def _worst_first(concerns: Sequence[_Concern]) -> list[str]:
    """Return the lines of all, the gravest first; of files with the same fault the first is described, others named."""
    groups: dict[object, list[tuple[list[str], str]]] = {}
    for place, (rank, lines, outcome) in enumerate(sorted(concerns, key=lambda concern: concern[0])):
        name, head = ("", "") if outcome is None else (outcome.name, file_head(outcome))
        alike = (
            (rank, *(line.replace(name, "") for line in lines if line != head and not line.startswith(_NOTED)))
            if name
            else place
        )
        groups.setdefault(alike, []).append((lines, name))
    found = []
    for (lines, _name), *others in groups.values():
        found += lines
        if others:
            found.append(f"  the same of: {listed([name for _lines, name in others])}.")
    return found


def _concern(outcome: FileOutcome, missing: MissingHeight | None, run: str | None) -> tuple[int, int] | None:
    """Return what of a file needs attention, and minus how much of it; None where nothing does."""
    read = outcome.read
    if outcome.status is IngestStatus.REFUSED:
        return _REFUSED, 0
    rules = {finding.rule for finding in read.findings} if read is not None else set()
    if outcome.of_other_run or rules.intersection(_OF_OTHER_RUN):
        return _OTHER_RUN, 0
    if missing is not None:
        return _NO_HEIGHT, 0
    if read is not None and (rules.intersection(_CONTRADICTIONS) or (read.rows_rejected and read.charges)):
        return _DOUBTFUL, -read.rows_rejected
    not_heeded = outcome.first is not None and run is not None and run not in outcome.runs
    no_run = read is not None and read.role is not FileRole.SHEET and not outcome.runs and not _knows_all(read)
    if not_heeded or no_run:
        return _NO_RUN, 0
    if read is not None and (read.rows_rejected or any(one.severity is Severity.ROW for one in read.findings)):
        return _SAMPLES, -read.rows_rejected
    return None


_OF_RUN = {
    "level_differs": _OTHER_RUN,
    "samples_twice": _OTHER_RUN,
    "logs_too_many": _LOGS,
    "jumps_differ": _JUMPS,
    "outside_limits": _LIMITS,
}


def _of_run(line: RigLine) -> tuple[int, int]:
    """Rank the concern about a run, minus how much of it; an odd charge is doubtful."""
    return _OF_RUN.get(line.concern, _DOUBTFUL) if line.concern else _LIMITS + 1, -line.jumps_off


def _folded(lines: Sequence[str], what: str) -> list[str]:
    if len(lines) <= MOST_LISTED:
        return list(lines)
    return [f"{len(lines)} {what} (`--verbose` lists them)."]


_SIGNS = {"\t": "tab", " ": "blanks", "": "none (one column)"}


def explained_lines(explained: Explained) -> list[str]:
    """Return the lines for people: format, layout, columns, what would be stored, findings."""
    plugin = f" of plug-in {explained.plugin}" if explained.plugin else ""
    by = f", recognised by: {explained.evidence}" if explained.evidence else ""
    lines = [f"{explained.file}: {explained.format}, version {explained.reader_version}{plugin}{by}"]
    others = [each for each in explained.explanation.candidates if each.format != explained.format][:2]
    if others:
        likely = "; ".join(f"{each.format} ({each.evidence})" for each in others)
        lines.append(f"  next likely: {likely}; `--format NAME` decides")
    lines.append(f"  profile: {explained.profile or 'none'}")
    if explained.explanation.encoding:
        lines.append(f"  text: {explained.explanation.encoding}")
    for table in explained.explanation.tables:
        lines += [f"  {line}" for line in _table_lines(table)]
    lines += [f"  {line}" for line in _stored_lines(explained)]
    return [*lines, *(f"  {line}" for line in finding_lines(explained.findings))]


def _table_lines(table: TableUse) -> list[str]:
    lines = []
    if table.text is not None:
        shape = table.text
        sign = _SIGNS.get(shape.delimiter, repr(shape.delimiter))
        header = "no header" if shape.header_line is None else f"header in line {shape.header_line}"
        units = "" if shape.units_line is None else f", units in line {shape.units_line}"
        lines.append(
            f"layout: delimiter {sign}, decimal sign {shape.decimal!r}, {header}{units}, data from line "
            f"{shape.first_line}"
        )
    if table.columns:
        rows = [
            (
                column.place,
                column.name,
                f"left out: {column.left_out}" if column.holds is None else column.holds,
                column.unit or "-",
                column.unit_from or "-",
                f"{column.stored_unit or '-'}{'' if column.sign == 1 else ', sign turned round'}",
            )
            for column in table.columns
        ]
        lines += columns(("column", "name", "becomes", "unit", "from", "stored in"), rows)
    if table.rate_from is not None:
        lines.append(f"rate from: {table.rate_from}")
    assumed = list(dict.fromkeys(reason for column in table.columns for reason in column.assumed))
    return [*lines, *([f"assumed: {'; '.join(assumed)}"] if assumed else [])]


def _stored_lines(explained: Explained) -> list[str]:
    if explained.refused:
        return ["would be refused; nothing would be stored"]
    lines = []
    for part in explained.parts:
        rate = "" if part.rate_hz is None else f" at {part.rate_hz:.6g} Hz"
        gaps = f", {part.gaps} gaps with {part.samples_missing} samples missing" if part.gaps else ", no gaps"
        start = f", from {part.start_utc}" if part.start_utc else ""
        held = f"{part.samples} samples, {part.duration_s:.6g} s{rate}{gaps}{start}"
        lines.append(f"would be stored: part {part.part}, {held}")
    if explained.charges:
        total = sum(charge.charge_mah for charge in explained.charges)
        lines.append(f"would be stored: {len(explained.charges)} recharges, {total:g} mAh")
    run = "no run (its name states none)" if explained.run is None else f"run {explained.run}"
    known = "" if explained.run is None or explained.run_known else ", which the book does not have"
    if explained.parts:
        lines.append(f"would belong to: {run}{known}")
    return [*lines, f"rows: {explained.rows_kept} of {explained.rows_read} kept"]
