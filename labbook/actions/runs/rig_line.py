"""What the person at the rig must know of files just taken in, before the foot is changed.

One line a run: is it as it should be? And a log without body height is asked about loudly, for no jump is found in it.
"""

from __future__ import annotations

import difflib
import shlex
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import sqlalchemy as sa

from data_schema.queries.files import find_files
from data_schema.queries.runs import RunRow, list_runs, runs_named, runs_of_conditions
from data_schema.vocabulary import FileRole, GapKind, IngestStatus, RunKind, Undefined
from ingest.channels.names import channel_kind, squash
from ingest.declared import flag_of
from ingest.model import ChannelData, SignalPart
from labbook.actions.files.ingesting import FileOutcome
from labbook.actions.runs.attention import Lines, joules_of, known_joules
from labbook.actions.runs.remarks import remarks_on
from labbook.analysis.outcomes.charger_step import with_display_step
from labbook.analysis.outcomes.control_limits import LIMITS_FROM_RUNS, ControlLimits, joule_limits
from labbook.analysis.outcomes.detection import BODY_HEIGHT, Detections
from labbook.analysis.outcomes.run_apexes import jumps_found_in_run
from labbook.analysis.outcomes.run_energy import below_drain, drain_lines
from labbook.analysis.study_data import StudyData, gather_about
from labbook.book.opening import Book
from labbook.statements.importing import PreparedImport
from labbook.terminal import listed

OF_JOULES = frozenset({"charge_mah", "duration_s", "jumps_made", "condition", "mode", "run"})
"""Columns of a run and its charge whose correction changes its joules a jump, or with which others they compare."""
_RIG_GAPS = (GapKind.DROPPED, GapKind.HELD)
"""The gaps that radio or sensor caused: a pause was made on purpose, and rejected rows are findings."""


@dataclass(frozen=True, slots=True)
class RigLine:
    """A line about a run at the rig, and what is wrong with it, "" where nothing is.

    `concern` is a rule of `remarks`, or `logs_too_many`, `charge_below_drain`, `jumps_differ` by `jumps_off`, or
    `outside_limits`. The numbers in the text: `jumps_found` is None where no log was read, `misfires` counts those of
    the logs just read; a remark has none.
    """

    text: str
    concern: str = ""
    jumps_off: int = 0
    run: str = ""
    jumps_found: int | Undefined | None = None
    jumps_made: int | None = None
    misfires: int = 0
    joules_per_jump: float | Undefined | None = None


def rig_lines_of(book: Book, outcomes: Sequence[FileOutcome]) -> list[list[RigLine]]:
    """Return how the runs of each file do, when all files are stored.

    A run that several files belong to, a log and a charge, has one line, with the last of them.
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
        evidence = _evidence(book, connection, list(files))
        for name, line in _rig_lines(Detections(connection, book.store), files, evidence).items():
            found[last[name]].append(line)
        charged = [name for name, prepared in files.items() if any(each.read.charges for each in prepared)]
        remarks = remarks_on(connection, book.configuration, list(files), ["starts", "samples"])
        remarks += remarks_on(connection, book.configuration, charged, ["charge_mah"])
    for remark in remarks:
        found[last[remark.first]].append(RigLine(f"look again: {remark.message}", remark.rule, run=remark.first))
    return found


def rig_lines_of_runs(book: Book, names: Sequence[str], *, jumps: bool = False) -> list[RigLine]:
    """Return how corrected runs of jumps, given by name, do: their joules, and with `jumps` how many were found."""
    if not names:
        return []
    with book.reading() as connection:
        evidence, detections = _evidence(book, connection, names), Detections(connection, book.store)
        return list(_rig_lines(detections, dict.fromkeys(names, ()), evidence, jumps=jumps).values())


def _evidence(book: Book, connection: sa.Connection, names: Sequence[str]) -> StudyData:
    """Read the facts of runs, given by name, and of the others of their conditions, whose charges show the step."""
    about = runs_named(connection, names)
    conditions = sorted({run.condition_uid for run in about if run.condition_uid is not None})
    evidence = gather_about(connection, book.configuration, about, runs_of_conditions(connection, conditions))
    stated_mah = book.configuration.protocol.charger_resolution_mah
    return replace(evidence, charges=with_display_step(evidence.charges, stated_mah))


def _rig_lines(
    detections: Detections,
    files: Mapping[str, Sequence[PreparedImport]],
    evidence: StudyData,
    *,
    jumps: bool = False,
) -> dict[str, RigLine]:
    """Return a line for every run, by name: how many jumps and gaps it has and whether its joules are in control.

    `files` has what one command read for each run, logs and charges, in one line; the book may hold more of a run.
    Jumps are counted where a log was read, or of all runs with `jumps`.
    """
    drains = drain_lines(evidence)
    limits = joule_limits(evidence, known_joules(evidence, drains))
    return {
        run.name: _line(run, detections, files[run.name], evidence, drains, limits.get(run.uid, ControlLimits()), jumps)
        for run in evidence.runs
        if run.name in files
    }


def _line(
    run: RunRow,
    detections: Detections,
    files: Sequence[PreparedImport],
    evidence: StudyData,
    drains: Lines,
    limits: ControlLimits,
    jumps: bool,
) -> RigLine:
    parts = [f"run {run.name}:"]
    found: int | Undefined | None = None
    in_book = evidence.logs.get(run.uid, [])
    if (jumps and in_book) or any(stored.detection is not None for prepared in files for stored in prepared.parts):
        found = jumps_found_in_run(detections, run, in_book, evidence.configuration.protocol.detector)
        off = 0 if isinstance(found, Undefined) else run.jumps_made - found
        several = len({log.sha256 for log in in_book})
        parts.append(
            f"its jumps do not count ({found.reason}),"
            if isinstance(found, Undefined)
            else f"{found} of {run.jumps_made} jumps found{'' if several == 1 else f' in {several} logs'}"
            f"{f' ({off} missing)' if off > 0 else f' ({-off} too many)' if off else ''},"
        )
    logs = {
        stored.sha256: part
        for prepared in files
        for part, stored in zip(prepared.read.parts, prepared.parts, strict=True)
    }
    misfires = sum(stored.detection.misfires for prepared in files for stored in prepared.parts if stored.detection)
    if misfires:
        parts.append(f"{misfires} misfire{'' if misfires == 1 else 's'},")
    if logs:
        just_read = ""  # where the book has other logs of the run, whose jumps count too
        if not {log.file_sha256 for log in in_book} <= {prepared.sha256 for prepared in files}:
            several_read = sum(bool(prepared.parts) for prepared in files) > 1
            just_read = f" in the log{'s' if several_read else ''} just read"
        parts.append(f"{_gaps(logs.values())}{just_read},")
    joules_per_jump = joules_of(run, evidence, drains)
    joules, outside = _joules(joules_per_jump, limits)
    text = " ".join([*parts, joules])
    too_little = below_drain(run, evidence.charges.get(run.uid, []), drains[run.robot_uid])
    if too_little is not None and run.duration_s is not None:
        text += (
            f"; look again: its charge of {too_little[0]:g} mAh is below the {too_little[1]:.1f} mAh that the "
            f"electronics alone draw in its {run.duration_s / 60.0:.3g} min: check the charge and the duration "
            f"(`labbook show {run.name}`)"
        )
    off = abs(found - run.jumps_made) if isinstance(found, int) else 0
    concerns = {
        "logs_too_many": isinstance(found, Undefined),
        "charge_below_drain": too_little is not None,
        "jumps_differ": off > 0,
        "outside_limits": outside,
    }
    concern = next((concern for concern, is_so in concerns.items() if is_so), "")
    return RigLine(text, concern, off, run.name, found, run.jumps_made, misfires, joules_per_jump)


def _gaps(logs: Iterable[SignalPart]) -> str:
    gaps = [gap for log in logs for gap in log.gaps if gap.kind in _RIG_GAPS]
    if not gaps:
        return "no gaps"
    missing = sum(gap.samples_missing for gap in gaps)
    held = sum(gap.samples_missing for gap in gaps if gap.kind is GapKind.HELD)
    held_text = f", {held} of them held" if held else ""
    return f"{len(gaps)} gap{'' if len(gaps) == 1 else 's'} ({missing} samples{held_text})"


def _joules(joules: float | Undefined, limits: ControlLimits) -> tuple[str, bool]:
    """Say a run's joules a jump beside those of its condition, and whether they are out of the limits."""
    if isinstance(joules, Undefined):
        return f"joules unknown: {joules.reason}", False
    text = f"{joules:.1f} J a jump"
    if not limits.n:
        return f"{text}, the only one of its condition", False
    if limits.n < LIMITS_FROM_RUNS:
        runs = "run" if limits.n == 1 else "runs"
        return f"{text}, n = {limits.n} other {runs} of its condition; control limits take {LIMITS_FROM_RUNS}", False
    if limits.ends is None:
        return f"{text}, no control limits: those of the other runs are below 0 J (n = {limits.n})", False
    low, high = limits.ends
    outside = limits.outside(joules)
    lowest = f"{low:.1f}" if low else "0"
    verdict = "OUTSIDE" if outside else "within"
    return f"{text}, {verdict} the control limits {lowest} to {high:.1f} J (n = {limits.n})", outside


_LIKE_HEIGHT = ("bodyheight", "height", "hgt", "bodyz", "z", "h", "pot", "string", "position", "hoehe")
_LENGTHS = ("m", "cm", "mm", "um", "in", "ft")
_WITHOUT_UNIT = (None, "1")
_ALIKE = 0.5
"""A name less alike is none of a height."""
_QUOTED = set('"$`\\!')
"""What a shell reads within double quotes."""


@dataclass(frozen=True, slots=True)
class MissingHeight:
    """The columns of a log by their names in the file, and how to declare one of them.

    `command` declares the column; of a file that was only tried it is the options alone.
    """

    columns: tuple[str, ...]
    command: str


def missing_heights(book: Book, outcomes: Sequence[FileOutcome]) -> list[MissingHeight | None]:
    """Find the logs among files just read that lack a body height and belong to a run of jumps, or to none yet."""
    lacking = [_is_log_without_height(outcome) for outcome in outcomes]
    jumped: set[str] = set()
    again: dict[str, str] = {}
    if any(lacking):
        with book.reading() as connection:
            jumped = {run.name for run in list_runs(connection) if run.kind is RunKind.JUMPS}
            again = {
                one.sha256: _read_again(connection, one) for one, lacks in zip(outcomes, lacking, strict=True) if lacks
            }
    return [
        _missing(outcome, again[outcome.sha256]) if lacks and (not outcome.runs or jumped & set(outcome.runs)) else None
        for outcome, lacks in zip(outcomes, lacking, strict=True)
    ]


def missing_height_lines(name: str, missing: MissingHeight) -> list[str]:
    """Say it for people, before anything else of the file."""
    its_unit = ", UNIT being the file's, such as mm, or counts" if "UNIT" in missing.command else ""
    return [
        f"{name}: NO {BODY_HEIGHT}: no jump can be found in this log.",
        f"  its columns: {listed([*map(repr, missing.columns)])}.",
        f"  say which one it is{its_unit}: `{missing.command}` (`labbook channels` lists all channels).",
    ]


def _is_log_without_height(outcome: FileOutcome) -> bool:
    read = outcome.read
    return (
        read is not None
        and outcome.status is IngestStatus.IMPORTED
        and (read.role or FileRole.LOG) is FileRole.LOG
        and bool(read.parts)
        and not any(channel.name == BODY_HEIGHT for part in read.parts for channel in part.channels)
    )


def _read_again(connection: sa.Connection, outcome: FileOutcome) -> str:
    """Return the command that reads a file again, with a blank behind it; "" for one that was only tried."""
    if outcome.prepared is None:
        return ""
    name = Path(outcome.name).name
    alone = len(find_files(connection, name)) == 1
    return f"labbook files reread {shlex.quote(name) if alone else outcome.sha256[:12]} "


def _missing(outcome: FileOutcome, again: str) -> MissingHeight:
    assert outcome.read is not None  # noqa: S101 - it was looked at
    channels = {channel.source_name: channel for part in outcome.read.parts for channel in part.channels}
    name, unit = _likeliest(list(channels.values()))
    column = f"{flag_of(outcome.read.explanation.tables, name)}={BODY_HEIGHT}:{unit}"
    quoted = shlex.quote(column) if set(column) & _QUOTED else f'"{column}"'
    return MissingHeight(tuple(channels), f"{again}--column {quoted}")


def _likeliest(channels: Sequence[ChannelData]) -> tuple[str, str]:
    """Return the column that reads most like a height and its unit; `NAME` and `UNIT` where none does."""

    def likeness(channel: ChannelData) -> float:
        given = squash(channel.name)
        return max(difflib.SequenceMatcher(None, given, like).ratio() for like in _LIKE_HEIGHT)

    free = [
        channel
        for channel in channels
        if channel_kind(channel.name) is None and channel.source_unit in (*_WITHOUT_UNIT, *_LENGTHS)
    ]
    best = max(free, key=likeness, default=None)
    if best is None or likeness(best) < _ALIKE:
        return "NAME", "UNIT"
    return best.source_name, "UNIT" if best.source_unit in _WITHOUT_UNIT else str(best.source_unit)
