"""What reading one file gives: frozen results, independent of any database; its findings; and how it was understood.

A reader turns bytes and declarations into a `ReadFile`: signals, recharges and findings. Nothing in it
depends on the file's name, the clock or the book, so the same bytes and declarations always give the same result.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from data_schema.calibration import Calibration
from data_schema.vocabulary import ChargeMode, FileRole, GapKind, Severity


@dataclass(frozen=True, slots=True)
class Candidate:
    """A format that the file may be of, with its score and evidence."""

    format: str
    score: int
    evidence: str


@dataclass(frozen=True, slots=True)
class TextShape:
    """The layout of a table in text: lines are numbered from 1, None where there is no such line."""

    delimiter: str
    decimal: str
    header_line: int | None
    units_line: int | None
    first_line: int


@dataclass(frozen=True, slots=True)
class ColumnUse:
    """What one column became.

    `place` counts from 1. `holds` is a channel, a role in a charger sheet, or `time`, `date` or `trial`; None where the
    column is left out, for the reason `left_out`. `unit` is the file's, `stored_unit` labbook's, `unit_from` where the
    former was found.
    """

    place: int
    name: str
    holds: str | None
    unit: str | None = None
    stored_unit: str | None = None
    unit_from: str | None = None
    sign: int = 1
    assumed: tuple[str, ...] = ()
    left_out: str | None = None


@dataclass(frozen=True, slots=True)
class TableUse:
    """What one table of a file became; `text` is None where it is not text, `rate_from` where there is no time axis."""

    text: TextShape | None
    columns: tuple[ColumnUse, ...]
    rate_from: str | None = None


@dataclass(frozen=True, slots=True)
class Explanation:
    """How a file was understood. `candidates` has the most likely format first; `encoding` is None for binary
    files, and of an archive those of its members."""

    encoding: str | None = None
    candidates: tuple[Candidate, ...] = ()
    tables: tuple[TableUse, ...] = ()


FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]
IntArray = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class Finding:
    """What a check found in a file: one per rule and column, with how often and where.

    `line` is the first line it concerns (1-based, None when it concerns the file as a whole), `more_lines`
    at most 20 further ones, `value` the text found at the first line.
    """

    severity: Severity
    rule: str
    message: str
    line: int | None
    column: str | None
    value: str | None
    count: int
    more_lines: tuple[int, ...]


NOTE, ROW, FILE = Severity.NOTE, Severity.ROW, Severity.FILE

MORE_LINES = 20
"""Most lines listed beside the first one."""

_LONGEST_VALUE = 60
_GRAVEST_FIRST = {FILE: 0, ROW: 1, NOTE: 2}


@dataclass(slots=True)
class _Entry:
    message: str
    value: str | None
    count: int = 0
    lines: list[int] = field(default_factory=list)


class FindingCollector:
    """Accumulates findings; the message and value of the first report of a rule and column stand.

    `tables` takes what each table of the file became; of the files packed in it `encodings` takes the pages of text,
    and `named_runs` what the one file there calls its run.
    """

    __slots__ = ("_entries", "encodings", "named_runs", "tables")

    def __init__(self) -> None:
        self.tables: list[TableUse] = []
        self.encodings: list[str] = []
        self.named_runs: tuple[str, ...] = ()
        self._entries: dict[tuple[Severity, str, str | None], _Entry] = {}

    def add(
        self,
        severity: Severity,
        rule: str,
        message: str,
        *,
        column: str | None = None,
        lines: Sequence[int] | IntArray = (),
        count: int | None = None,
        value: str | None = None,
    ) -> None:
        """Report `rule` once, in each of `lines` (1-based, ascending), or `count` times where these are only some."""
        key = (severity, rule, column)
        entry = self._entries.get(key)
        if entry is None:
            shown = None if value is None else value[:_LONGEST_VALUE]
            entry = self._entries[key] = _Entry(message, shown)
        entry.count += count if count is not None else max(1, len(lines))
        room = MORE_LINES + 1 - len(entry.lines)
        if room > 0:
            entry.lines.extend(int(line) for line in lines[:room])

    def take_over(self, other: FindingCollector) -> None:
        """Add all that another collector holds."""
        self.tables += other.tables
        for finding in other.findings():
            self.repeat(finding)

    def repeat(self, found: Finding, where: str = "") -> None:
        """Report what was found in a part of the file, `where` before its message."""
        lines = () if found.line is None else (found.line, *found.more_lines)
        message = where + found.message
        self.add(
            found.severity, found.rule, message, column=found.column, lines=lines, count=found.count, value=found.value
        )

    def count(self, rule: str) -> int:
        """Return how often a rule was reported."""
        return sum(entry.count for (_, known, _), entry in self._entries.items() if known == rule)

    def refuse_for(self, rule: str, message: str) -> None:
        """Let all that was reported under a rule refuse the file, with another message."""
        for key in [key for key in self._entries if key[1] == rule]:
            entry = self._entries.pop(key)
            self._entries[FILE, rule, key[2]] = dataclasses.replace(entry, message=message)

    def __contains__(self, rule: str) -> bool:
        return any(known == rule for _, known, _ in self._entries)

    @property
    def refuse(self) -> bool:
        """Whether something refuses the file."""
        return any(severity is FILE for severity, _, _ in self._entries)

    def findings(self) -> tuple[Finding, ...]:
        """Return all findings, gravest first, otherwise in the order of their first report."""
        found = [
            Finding(
                severity,
                rule,
                entry.message,
                entry.lines[0] if entry.lines else None,
                column,
                entry.value,
                entry.count,
                tuple(entry.lines[1:]),
            )
            for (severity, rule, column), entry in self._entries.items()
        ]
        return tuple(sorted(found, key=lambda finding: _GRAVEST_FIRST[finding.severity]))


@dataclass(frozen=True, slots=True)
class Gap:
    """A stretch without trustworthy samples: from the last sample before it to the first one after it.

    `start_s` and `length_s` are on the signal's own time axis; `samples_expected` is how many samples lie strictly
    inside at the signal's rate, `samples_missing` how many of these are not there (or, held, not measured anew).
    """

    start_s: float
    length_s: float
    samples_expected: int
    samples_missing: int
    kind: GapKind


@dataclass(frozen=True, slots=True, eq=False)
class ChannelData:
    """One channel: `values = sign * (scale * source + offset)`, float64, shape (n_samples,).

    `name` is a key of `vocabulary.CHANNELS` (a second plate's with suffix `_2`) or the column's own cleaned name;
    `unit` is None when neither the file nor a declaration has it. `assumed` lists, as sentences, what was taken from a
    convention of the instrument's maker and not from the file. `calibration` is the one in `scale` and `offset`, whose
    own value is in `calibrated_unit`. A missing value is NaN.
    """

    name: str
    unit: str | None
    source_name: str
    source_unit: str | None
    scale: float
    offset: float
    sign: int
    assumed: tuple[str, ...]
    values: FloatArray
    calibration: Calibration | None = None
    calibrated_unit: str | None = None


@dataclass(frozen=True, slots=True, eq=False)
class SignalPart:
    """Channels sampled together: `time_s` is elapsed time from the first sample, strictly increasing.

    `rate_hz` is the measured mean rate, dropped samples counted in, pauses left out; None with a single sample.
    `start_utc` is ISO-8601 with `Z` when the file has an instant, `start_original` the first time stamp as written.
    """

    part: str
    time_s: FloatArray
    rate_hz: float | None
    start_utc: str | None
    start_original: str | None
    channels: tuple[ChannelData, ...]
    gaps: tuple[Gap, ...]


@dataclass(frozen=True, slots=True)
class ChargeRow:
    """One recharge (or discharge): `charge_mah` >= 0, its direction is `mode`.

    `row_number` counts the recharges of the file from 1; `stated_run` and `stated_pack` are the names as written;
    `line` is the one in which it stands, or begins, and `member` the name of the archive's file or the workbook's sheet
    that this is a line of, where there are several.
    """

    row_number: int
    stated_run: str | None
    stated_pack: str | None
    charge_mah: float
    resolution_mah: float
    duration_s: float | None
    end_voltage_v: float | None
    mode: ChargeMode
    ended_utc: str | None
    ended_original: str | None
    line: int | None = None
    member: str | None = None


@dataclass(frozen=True, slots=True)
class ColumnDeclaration:
    """A person's declaration of a source column; None leaves that to the file's header.

    `channel` is a key of `vocabulary.CHANNELS`, any other name to store it under, or `time` for the time column; `sign`
    is 1 or -1. With `calibrations`, of which one is in force on a day, `unit` is that of the calibrated value.
    """

    channel: str | None = None
    unit: str | None = None
    sign: int | None = None
    calibrations: tuple[Calibration, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class ReadingSettings:
    """How a file is to be read, by flags and profiles; None, or no column, leaves that to the file.

    `columns` goes from a column to what it holds: by its name, by `name#2` for the second of several equal names, or by
    its place, from 1. `time_column` and `date_column` are such columns too; a time of day in the one goes with the date
    in the other. `header_row` (0: there is none), `units_row` and `first_row` are line numbers from 1. Lines that begin
    with `comment` are skipped, the data end at a line that begins with `footer`. `date_format` is one of
    `clock_formats.DATE_FORMATS`, `clock_format` one of its `CLOCK_FORMATS`, `axes` a key of `channels.forces.AXES`:
    channels are then declared by the file's own axes. `trials` is the column whose value distinguishes the trials in
    one file. `encoding` is the page of text that is neither marked by a byte order mark nor valid UTF-8; `decimal_sign`
    settles `1,234`; `format` and `instrument` name what the file would otherwise be recognised as by its content.
    `override_units` lets declared units stand against those of the header, `complete` a last line without line end
    whose last number may be cut, `no_robot_check` forces and heights that no robot of the book can have.
    """

    rate_hz: float | None = None
    time_column: str | None = None
    time_unit: str | None = None
    date_column: str | None = None
    columns: Mapping[str, ColumnDeclaration] = field(default_factory=dict)
    encoding: str | None = None
    delimiter: str | None = None
    decimal_sign: str | None = None
    header_row: int | None = None
    units_row: int | None = None
    first_row: int | None = None
    comment: str | None = None
    footer: str | None = None
    date_format: str | None = None
    clock_format: str | None = None
    axes: str | None = None
    trials: str | None = None
    format: str | None = None
    instrument: str | None = None
    override_units: bool | None = None
    complete: bool | None = None
    no_robot_check: bool | None = None


@dataclass(frozen=True, slots=True)
class Profile(ReadingSettings):
    """A `[profiles.NAME]` table: it applies to files with a line that names every column of `recognise`, and whose own
    name fits the pattern `files` (`r*.csv`); one of the two may be missing.
    """

    name: str
    recognise: tuple[str, ...] = ()
    files: str | None = None


@dataclass(frozen=True, slots=True)
class RobotFacts:
    """What is known of a robot: its whole mass, and how far its leg reaches."""

    mass_kg: float
    reach_m: float


@dataclass(frozen=True, slots=True)
class PackFacts:
    """What is known of a pack: its name, and the charge that it holds."""

    name: str
    capacity_mah: float


@dataclass(frozen=True, slots=True)
class Limits:
    """What one file may ask for, by the names of `[files.limits]`; one that asks for more is refused with that name.

    `largest_expansion` is the ratio of expanded to packed bytes beyond the first MiB, `deepest_nesting` how often an
    archive may hold another, `most_cells` the rows times columns of one sheet.
    """

    largest_file_bytes: int = 8 << 30
    most_columns: int = 4096
    longest_line_bytes: int = 1 << 20
    largest_expanded_bytes: int = 2 << 30
    largest_expansion: int = 200
    most_members: int = 200
    deepest_nesting: int = 2
    most_cells: int = 20_000_000

    def most_expanded(self, packed_bytes: int) -> int:
        """Return how many bytes so many packed ones may expand to; a MiB is always allowed."""
        return min(self.largest_expanded_bytes, max(1 << 20, packed_bytes * self.largest_expansion))


DEFAULT_LIMITS = Limits()


@dataclass(frozen=True, slots=True)
class Declarations(ReadingSettings):
    """What was declared about a file: directly, and by the profiles, of which the most specific completes it.

    `profile` is the one chosen: a reading's declarations name it and hold its settings, those of columns as
    `profile_columns`. `file_name` is the file's own name, without folder. `day` is the local date of a log that does
    not say when it was recorded: calibrations are chosen by it. `time_zone` is the zone of clock times
    without one (None: such times stay without an instant). `robots` are those that may have been measured, with which
    forces and heights are compared unless `no_robot_check`, `packs` those that may have been charged; `limits` bound
    what a file may ask for.
    """

    profiles: tuple[Profile, ...] = ()
    profile: str | None = None
    profile_columns: Mapping[str, ColumnDeclaration] = field(default_factory=dict)
    file_name: str | None = None
    day: str | None = None
    time_zone: str | None = None
    robots: tuple[RobotFacts, ...] = ()
    packs: tuple[PackFacts, ...] = ()
    limits: Limits = DEFAULT_LIMITS

    @property
    def source(self) -> str:
        """Who declared what may be of the profile, for an explanation."""
        return "declared" if self.profile is None else f"declared, or profile {self.profile}"


@dataclass(frozen=True, slots=True, eq=False)
class Reading:
    """What one format's reader hands back; blank, comment and header lines are no rows.

    `declared` is what was in force: flags, and the profile's settings, also where only the table's own names showed
    which profile applies; `packed` is name and version of the format of a study's sheet, where that is the one sheet of
    a workbook.
    """

    parts: tuple[SignalPart, ...] = ()
    charges: tuple[ChargeRow, ...] = ()
    rows_read: int = 0
    rows_rejected: int = 0
    role: FileRole | None = None
    declared: Declarations | None = None
    packed: tuple[str, int] | None = None

    @property
    def rows_kept(self) -> int:
        """The rows that were not rejected."""
        return self.rows_read - self.rows_rejected


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class ReadFile(Reading):
    """The content of one file, with the findings and the verdict.

    `evidence` is by what the format was recognised, `plugin` whose format it is where it is not labbook's own;
    `explanation` how the file was understood; `named_runs` what the lines above its table call a run, word by word.
    """

    format: str
    reader_version: int
    findings: tuple[Finding, ...]
    evidence: str = ""
    plugin: str | None = None
    explanation: Explanation = field(default_factory=Explanation)
    named_runs: tuple[str, ...] = ()

    @property
    def profile(self) -> str | None:
        """The one of the declared profiles that was used."""
        return None if self.declared is None else self.declared.profile

    @property
    def refused(self) -> bool:
        """Whether the file cannot be imported: some finding is of severity file."""
        return any(finding.severity is Severity.FILE for finding in self.findings)
