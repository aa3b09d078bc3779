"""The time axis of each recording in a table: from its time column, or from a rate; usable rows, mean rate, gaps.

Rows with an impossible stamp are found, and where recording began anew. Stamps are never changed to fit, except that a
counter which passed its end is counted on.

Whole milliseconds make the median step useless: 300 Hz shows steps of 3, 3, 4 ms and 333 Hz of 3, 3, 3, with one
median. The rate is therefore counted from end to end, samples that were dropped counted in and pauses left out.

Stamps may also come in bursts: then they are times at which packets arrived, ten samples at once, and not when samples
were taken. Between one burst and the next passes the time of the samples in it, so the rate is samples over time and
the axis even. Samples that were lost are seen from bursts that bring too few for the time that passed, and that no
later ones make up for: a burst that comes late, and the few after it that come the sooner, have lost nothing.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from functools import cached_property
from zoneinfo import ZoneInfo

import numpy as np

from data_schema.vocabulary import GapKind
from ingest.channels.columns import ColumnPlan, Plan, TimePlan, count_by_rate_flags
from ingest.channels.names import TICKS_PER_SECOND, channel_kind, is_unit, ticks_per_second
from ingest.declared import argument
from ingest.model import FILE, NOTE, ROW, BoolArray, Declarations, FindingCollector, FloatArray, Gap, IntArray
from ingest.spool import by_blocks, take
from ingest.tables.table import Block, CellKind, Preamble
from ingest.timebase import clock
from ingest.timebase.clock import ClockColumn, read_clocks

MOTION = frozenset({"body_height", "foot_height", "leg_length", "leg_velocity", "body_velocity", "force_z"})
MOTION_RATES_HZ = (20.0, 50_000.0)
"""Of a log of jumps slower or faster than this it is asked whether its time is in the unit named."""

SEQUENCE = "sequence"
_FEWEST_COUNTED, _MOSTLY = 20, 0.9
"""Of at least so many steps of a column nine in ten are 1 where it counts the samples."""

_WRAPPING = ("ms", "us")


@dataclass(frozen=True, slots=True, eq=False)
class Recording:
    """One uninterrupted clock: its rows (a slice when it is all of them), axis and beginning."""

    rows: IntArray | slice
    timebase: Timebase
    start_utc: str | None
    start_original: str | None


@dataclass(frozen=True, slots=True, eq=False)
class Recordings:
    """The usable rows, shape (n_rows,), and the recordings they make; none when there is no time axis."""

    keep: BoolArray
    recordings: tuple[Recording, ...]


@dataclass(frozen=True, eq=False)
class TimeSources:
    """All that bears on the time of one table: its rows, plan and values, declarations, preamble, fixed rate."""

    block: Block
    plan: Plan
    stored: Mapping[int, FloatArray]
    declared: Declarations
    preamble: Preamble
    fixed_rate_hz: float | None
    findings: FindingCollector

    @property
    def given_hz(self) -> float | None:
        """The rate that is declared, or else the one above the table."""
        return self.declared.rate_hz or self.preamble.rate_hz

    @cached_property
    def clocks(self) -> ClockColumn | None:
        """The time column where it holds clock texts, with the dates beside it."""
        time, clocks = self.plan.time, self.block.clocks
        if time is None or time.kind is not CellKind.CLOCK:
            return None
        dates = None if time.date_position is None else clocks[time.date_position]
        return read_clocks(clocks[time.position], dates, time.source_name, self.declared, self.findings)


def recordings(sources: TimeSources, usable: BoolArray) -> Recordings:
    """Build the time axis from the time column, or else from the rate; what is missing for it is asked for."""
    time = sources.plan.time
    if time is None:
        return _from_given_rate(sources, usable)
    ticks = _ticks(time, sources)
    per_second = 1.0 if time.kind is CellKind.CLOCK else ticks_per_second(time.unit)
    if per_second is None:
        _ask_for_unit(sources, time, ticks[usable & np.isfinite(ticks)])
        return Recordings(usable, ())
    seconds = ticks if per_second == 1.0 else by_blocks(ticks, lambda block: block / per_second)
    if sources.fixed_rate_hz is not None and _are_arrival_times(seconds):
        return _from_arrivals(sources, time, seconds, usable, sources.fixed_rate_hz)
    in_bursts = _from_bursts(sources, time, seconds, usable)
    if in_bursts is not None:
        return in_bursts
    order = put_in_order(seconds, usable, sources.block, sources.findings, time.source_name)
    found: list[Recording] = []
    ordinals = sources.block.ordinals
    for rows in _segments(order):
        timebase = from_stamps(take(seconds, rows), take(ordinals, rows))
        found.append(_recording(sources, rows, timebase, first=not found))
    _check_rates(found, sources, time)
    return Recordings(order.keep, tuple(found))


def _recording(sources: TimeSources, rows: IntArray | slice, timebase: Timebase, first: bool = True) -> Recording:
    """Return a recording with its beginning, its gaps reported."""
    for kind, rule, message in GAP_RULES:
        starts = np.array([gap.start_s for gap in timebase.gaps if gap.kind is kind], dtype=np.float64)
        after = np.searchsorted(timebase.time_s, starts) + 1
        if after.size:
            places = after if isinstance(rows, slice) else rows[after]
            sources.findings.add(NOTE, rule, message, lines=sources.block.lines[places])
    return Recording(rows, timebase, *_start(sources, 0 if isinstance(rows, slice) else int(rows[0]), first))


_DATED = ("s", "ms", "us", "ns", "filetime")
_SLOWEST_STEP_S = 60.0
"""Counts since switching on pass for dates too, us after a quarter of an hour for seconds, but with longer steps."""


def with_epoch_unit(time: TimePlan | None, block: Block, findings: FindingCollector) -> TimePlan | None:
    """Return the time column, where its unit is stated nowhere, in the one unit in which its stamps are dates."""
    if time is None or time.unit is not None or time.kind not in (CellKind.NUMBER, CellKind.INTEGER):
        return time
    stamps = block.numbers[time.position]
    stamps = stamps[np.isfinite(stamps)]
    if not stamps.size:
        return time
    stamp = np.sort(stamps)[len(stamps) // 2].item()
    per_tick = _samples_per_tick(np.asarray(stamps - stamp, dtype=np.float64))
    for unit in _DATED:
        per_second = TICKS_PER_SECOND[unit]
        date = clock.epoch_time(stamp, unit, per_second)
        if date is not None and (per_tick is None or 1 / per_tick <= _SLOWEST_STEP_S * per_second):
            message = (
                f"Stamps such as {_written(stamp)} are dates in {unit} alone, about {date}: they are read as such."
            )
            findings.add(NOTE, "time_unit_found", message, column=time.source_name)
            return dataclasses.replace(time, unit=unit)
    return time


def _written(stamp: float) -> str:
    return str(stamp) if isinstance(stamp, int) else f"{stamp:.15g}"


def _ask_for_unit(sources: TimeSources, time: TimePlan, ticks: FloatArray) -> None:
    """Refuse a time column without a unit that is known; the flag names one only where all else rules out the others.

    `ticks` has shape (n_usable_rows,).
    """
    given, per_tick = sources.given_hz, _samples_per_tick(ticks)
    flag = _unit_flag(time, _units_near(given / per_tick) if given and per_tick else [])
    rate = sources.declared.rate_hz
    flag += "" if rate is None else f", or count samples by the rate, {count_by_rate_flags(time.flag, f'{rate:g}')}"
    if time.unit is not None:
        message = f"{time.unit!r} is no unit of time known here: say which it is, {flag}."
        sources.findings.add(FILE, "time_unit_unknown", message, column=time.source_name, value=time.unit)
        return
    message = (
        f"The unit of column {time.source_name!r} is stated nowhere: say it, {flag}, or as `time` in a "
        "[profiles.NAME] table of labbook.toml."
    )
    sources.findings.add(FILE, "time_unit_missing", message, column=time.source_name)


def _samples_per_tick(ticks: FloatArray) -> float | None:
    """Return the rate of stamps, shape (n,), in samples per tick; None where no stamp follows another."""
    steps = np.diff(ticks)
    steps = steps[steps > 0]
    return 1 / usual_step(steps) if steps.size else None


def _units_near(per_second: float) -> list[str]:
    return [unit for unit, known in TICKS_PER_SECOND.items() if abs(per_second / known - 1) <= RATE_REFUSED]


def _unit_flag(time: TimePlan, units: Sequence[str]) -> str:
    """Return the flag for the unit of a time column; it is left open, with the choices, where not one alone is left."""
    unit = units[0] if len(units) == 1 else "UNIT"
    override = " --override-units" if time.file_unit is not None and is_unit(time.file_unit) else ""
    others = units or [unit for unit in TICKS_PER_SECOND if unit != time.unit]
    choices = "" if len(units) == 1 else f" (UNIT: one of {', '.join(others)})"
    return f"`--unit {argument(f'{time.flag}={unit}')}{override}`{choices}"


def _ticks(time: TimePlan, sources: TimeSources) -> FloatArray:
    """Return the time column in its own unit, shape (n_rows,); long counts from one of them on, all digits kept."""
    if sources.clocks is not None:
        return sources.clocks.seconds
    block = sources.block
    column = block.numbers[time.position]
    if time.fraction_position is not None:
        whole = np.asarray(column - np.nanmedian(column).round(), dtype=np.float64)
        return np.asarray(TICKS_PER_SECOND[time.unit or "ns"] * whole + block.numbers[time.fraction_position])
    if time.kind is CellKind.INTEGER:
        first, middle = column[0], column[len(column) // 2]
        return np.asarray(column - (first if abs(middle - first) < 2**53 else middle), dtype=np.float64)
    ticks = np.asarray(column, dtype=np.float64)
    return unwrap(ticks, sources.findings, block, time.source_name) if time.unit in _WRAPPING else ticks


def _segments(order: Order) -> list[IntArray | slice]:
    if order.keep.all() and len(order.starts) == 1:
        return [slice(None)]
    rows = np.flatnonzero(order.keep)
    cuts = np.searchsorted(rows, np.array(order.starts[1:], dtype=np.int64))
    return [part for part in np.split(rows, cuts) if part.size]


def _rows_of(marked: BoolArray) -> IntArray | slice:
    return slice(None) if marked.all() else np.flatnonzero(marked)


def _start(sources: TimeSources, row: int, first: bool = True) -> tuple[str | None, str | None]:
    """Return instant and original text of the beginning of a recording; without a date of its own the `first` one has
    that above the table.
    """
    zone, findings, preamble, time = sources.declared.time_zone, sources.findings, sources.preamble, sources.plan.time
    if sources.clocks is not None:
        iso = sources.clocks.iso[row]
        return None if iso is None else clock.to_utc(iso, zone, findings), sources.clocks.texts[row]
    utc = original = None
    if time is not None:
        stamp = sources.block.numbers[time.position][row].item()
        if time.fraction_position is not None:
            per_second = round(TICKS_PER_SECOND[time.unit or "ns"])
            stamp = per_second * int(stamp) + int(sources.block.numbers[time.fraction_position][row])
        original = f"{_written(stamp)} {time.unit}"
        utc = clock.epoch_time(stamp, time.unit or "s", ticks_per_second(time.unit) or 1.0)
        if utc is not None and not utc.endswith("Z"):
            return clock.to_utc(utc, zone, findings), original
    if utc is None and first and preamble.start is not None:
        return clock.to_utc(preamble.start, zone, findings), preamble.start_text or preamble.start
    return utc, original


def first_day(sources: TimeSources) -> str | None:
    """Return the local date of the first row with a time, None where neither its stamps nor its preamble have one."""
    time, start, zone = sources.plan.time, sources.preamble.start, sources.declared.time_zone
    utc = None if start is None else clock.to_utc(start, zone, sources.findings)
    if time is not None and (time.kind is CellKind.CLOCK or ticks_per_second(time.unit)):
        filled = np.flatnonzero(np.isfinite(_ticks(time, sources)))
        if filled.size:
            utc, _ = _start(sources, int(filled[0]))
    return None if utc is None else str(datetime.fromisoformat(utc).astimezone(ZoneInfo(zone or "UTC")).date())


def _check_rates(found: Sequence[Recording], sources: TimeSources, time: TimePlan) -> None:
    declared, header = sources.declared.rate_hz, sources.preamble.rate_hz
    for recording in found:
        rate = recording.timebase.rate_hz
        if rate is None:
            continue
        if declared is None and header is None:
            _ask_about_rate(recording.timebase, rate, time, sources)
        if declared is not None:
            remedy = _rate_advice(time, rate, declared)
            check_rate(rate, declared, "the declaration", sources.findings, remedy=remedy)
        if header is not None:
            cure = None if _near(rate, declared) else _rate_advice(time, rate, header)
            check_rate(rate, header, "the file's header", sources.findings, remedy=cure)


def _ask_about_rate(timebase: Timebase, rate_hz: float, time: TimePlan, sources: TimeSources) -> None:
    """Refuse a rate, until it is said, at which no jump can be seen in a log of jumps, or at which more samples are
    missing than there are.
    """
    findings = sources.findings
    moving = any(column.channel in MOTION for column in sources.plan.columns)
    if moving and not MOTION_RATES_HZ[0] <= rate_hz <= MOTION_RATES_HZ[1]:
        unit = "" if time.kind is CellKind.CLOCK else f"correct their unit, {_unit_flag(time, [])}, or "
        findings.add(
            FILE,
            "rate_implausible",
            f"The time stamps give {rate_hz:.6g} Hz, at which no jump can be seen: if they are right, say "
            f"`--rate {rate_hz:.6g}`, else {unit}count samples by their rate, {count_by_rate_flags(time.flag)}.",
        )
    n, missing = len(timebase.time_s), missing_samples(timebase)
    if missing <= n:
        return
    disordered = sum(map(findings.count, FAULTS_OF_TIME))
    if disordered > RATE_REFUSED * n:
        return  # what is left tells no rate, and the rows that are rejected refuse the file
    paused_s = sum(gap.length_s for gap in timebase.gaps if gap.kind is GapKind.PAUSE)
    even_hz = (n - 1) / (float(timebase.time_s[-1]) - paused_s)
    findings.add(
        FILE,
        "mostly_missing",
        f"The time stamps give {rate_hz:.6g} Hz, at which {missing} samples are missing beside {n}: if that is so, say "
        f"`--rate {rate_hz:.6g}`; if samples were taken evenly and the stamps are those of their arrival, count by the "
        f"rate, {count_by_rate_flags(time.flag, f'{even_hz:.6g}')}.",
        column=time.source_name,
    )


def _rate_advice(time: TimePlan, rate_hz: float, reference_hz: float) -> str:
    """Return the remedy for time stamps at another rate than given: the unit that explains it, where one does."""
    cure = f"count by the rate, {count_by_rate_flags(time.flag, f'{reference_hz:.6g}')}"
    if time.kind is not CellKind.CLOCK:
        units = _units_near((ticks_per_second(time.unit) or 1.0) * reference_hz / rate_hz)
        cure = f"correct their unit, {_unit_flag(time, units)}" if units else cure
    return f"if the time stamps are right, say `--rate {rate_hz:.6g}`, else {cure}"


def _from_given_rate(sources: TimeSources, usable: BoolArray) -> Recordings:
    findings = sources.findings
    if "several_time_columns" in findings or "time_unreadable" in findings:
        return Recordings(usable, ())  # asked about already
    rate = _given_rate(sources)
    if rate is None:
        findings.add(
            FILE,
            "rate_missing",
            "The file has neither a time column nor a sampling rate: say `--rate HZ` (samples a second), or name its "
            'time column with `--column "NAME=time"`, or do either in a [profiles.NAME] table of labbook.toml.',
        )
        return Recordings(usable, ())
    rows = np.flatnonzero(usable)
    if not rows.size:
        return Recordings(usable, ())
    ordinals = sources.block.ordinals[rows]
    counts = _sequence(sources, rows)
    counter = next((column for column in sources.plan.columns if column.channel == SEQUENCE), None)
    if counts is None and counter is None:
        counts = _counted_by(sources, rows)
    timebase = from_rate(ordinals if counts is None else counts, ordinals, rate)
    if counter is not None and missing_samples(timebase) > len(rows):
        _ask_about_counter(timebase, counter, sources)
    return Recordings(usable, (_recording(sources, _rows_of(usable), timebase),))


def _ask_about_counter(timebase: Timebase, counter: ColumnPlan, sources: TimeSources) -> None:
    """Refuse a counter of samples by which most are missing, until a person says that it is one."""
    declared = (*sources.declared.columns.values(), *sources.declared.profile_columns.values())
    if any(declaration.channel == SEQUENCE for declaration in declared):
        return
    n, missing = len(timebase.time_s), missing_samples(timebase)
    sources.findings.add(
        FILE,
        "mostly_missing",
        f"By column {counter.source_name!r} {missing} samples are missing beside {n}: if it numbers the samples, say "
        f"`--column {argument(f'{counter.flag}={SEQUENCE}')}`, else "
        f"`--column {argument(f'{counter.flag}=own.counter')}`.",
        column=counter.source_name,
    )


def _given_rate(sources: TimeSources) -> float | None:
    """Return the declared rate, or else the one above the table, with a note which; two that differ are refused."""
    declared, preamble, findings = sources.declared.rate_hz, sources.preamble, sources.findings
    line = None if preamble.rate_line is None else repr(preamble.rate_line)
    if declared is not None:
        if preamble.rate_hz is not None:
            where = "the file" if line is None else f"the file's line {line}"
            remedy = "leave `--rate` out, or correct the file"
            check_rate(declared, preamble.rate_hz, where, findings, subject="Declared are", remedy=remedy)
        findings.add(NOTE, "rate_declared", f"The axis is counted at the declared {declared:g} Hz.")
        return declared
    if preamble.other_rate_line is not None:
        other = repr(preamble.other_rate_line)
        message = f"The file states two rates, {line} and {other}: say which holds with `--rate`."
        findings.add(FILE, "rates_contradict", message)
    elif preamble.rate_hz is not None:
        message = f"The axis is counted at {preamble.rate_hz:g} Hz, as the file states"
        findings.add(NOTE, "rate_from_header", f"{message}{'.' if line is None else f' in {line}.'}", value=line)
    return preamble.rate_hz


def _sequence(sources: TimeSources, rows: IntArray | slice) -> IntArray | None:
    """Return the instrument's own sample numbers of the rows, where it has them and they count up."""
    for column in sources.plan.columns:
        if column.channel == SEQUENCE:
            numbers = unwrap_counter(sources.stored[column.position][rows])
            if numbers is not None:
                return numbers.astype(np.int64)
            message = "The sample numbers do not count up: samples that are missing by them are not looked for."
            sources.findings.add(NOTE, "sequence_unused", message, column=column.source_name)
    return None


def _counted_by(sources: TimeSources, rows: IntArray | slice) -> IntArray | None:
    """Return the numbers in a column of no known quantity that rise by one from row to row, but where samples lack."""
    said = {*sources.declared.columns, *sources.declared.profile_columns}
    for column in sources.plan.columns:
        if channel_kind(column.channel) is not None or said.intersection((column.flag, column.source_name)):
            continue
        numbers = unwrap_counter(sources.stored[column.position][rows])
        steps = np.empty(0) if numbers is None else np.diff(numbers)
        if numbers is None or len(steps) < _FEWEST_COUNTED or not _MOSTLY <= np.mean(steps == 1.0) < 1.0:
            continue
        message = (
            "The numbers rise by one from row to row, but for jumps: samples are missing there. If they count "
            f"something else, say `--column {argument(f'{column.flag}=own.counter')}`."
        )
        sources.findings.add(NOTE, "sequence_found", message, column=column.source_name)
        return numbers.astype(np.int64)
    return None


def _are_arrival_times(seconds: FloatArray) -> bool:
    """Whether stamps are times at which packets came in, not at which samples were taken: many are equal."""
    return int(np.count_nonzero(np.diff(seconds) <= 0)) > 0.01 * len(seconds)


def _from_bursts(sources: TimeSources, time: TimePlan, seconds: FloatArray, usable: BoolArray) -> Recordings | None:
    """Return the one recording of stamps that come in bursts, None where they do not."""
    rows = _rows_of(usable)
    stamps = seconds[rows]
    starts = burst_starts(stamps)
    one_by_one = starts is None
    if starts is None and are_rounded(stamps):
        starts = np.arange(len(stamps), dtype=np.int64)
    if starts is None:
        return None
    timebase = from_bursts(stamps, sources.block.ordinals[rows], starts, _sequence(sources, rows))
    if one_by_one and not _is_rounded_at(sources, timebase, stamps, time):
        return None
    may_be_written_twice = len(stamps) < 1.1 * len(starts)
    if not one_by_one and (may_be_written_twice or not _near(timebase.rate_hz, sources.given_hz)):
        channels = (values[rows] for values in sources.stored.values())
        if _near(rate_within(stamps, starts), sources.given_hz) or not are_continuous(channels, starts):
            return None  # recorded now and then: the holes are real
    message = (
        f"The stamps are arrival stamps, or those of a coarse clock, {len(stamps) / len(starts):.3g} samples at once: "
        f"the rate, {timebase.rate_hz:.6g} Hz, is samples over time, and the axis is even."
    )
    sources.findings.add(NOTE, "arrival_times", message, column=time.source_name)
    recording = _recording(sources, rows, timebase)
    _check_rates([recording], sources, time)
    return Recordings(usable, (recording,))


def _is_rounded_at(sources: TimeSources, timebase: Timebase, stamps: FloatArray, time: TimePlan) -> bool:
    """Whether stamps that are rounded to a tick, or lack samples as evenly, are rounded: the rate given decides, and is
    asked for.
    """
    tick = float(np.median(np.diff(stamps)))
    even_hz, full_hz = timebase.rate_hz or 1 / tick, 1 / tick
    if sources.given_hz is None:
        sources.findings.add(
            FILE,
            "rate_unclear",
            f"The time stamps are {even_hz:.6g} Hz in ticks of {tick:.3g} s, or {full_hz:.6g} Hz with samples missing "
            f"evenly: say which, `--rate {even_hz:.6g}` or `--rate {full_hz:.6g}`.",
            column=time.source_name,
        )
        return False
    return abs(sources.given_hz - even_hz) < abs(sources.given_hz - full_hz)


def _near(rate_hz: float | None, reference_hz: float | None) -> bool:
    return rate_hz is not None and reference_hz is not None and abs(rate_hz / reference_hz - 1) <= RATE_REFUSED


def _from_arrivals(
    sources: TimeSources, time: TimePlan, seconds: FloatArray, usable: BoolArray, rate_hz: float
) -> Recordings:
    message = (
        "The stamps tell when packets arrived: the axis counts samples at the amplifier's fixed "
        f"{rate_hz:g} Hz instead."
    )
    sources.findings.add(NOTE, "arrival_times", message, column=time.source_name)
    span = float(np.fmax.reduce(seconds) - np.fmin.reduce(seconds))
    if span > 0:
        check_rate((len(seconds) - 1) / span, rate_hz, "the amplifier's manual", sources.findings)
    rows = _rows_of(usable)
    ordinals = sources.block.ordinals[rows]
    return Recordings(usable, (_recording(sources, rows, from_rate(ordinals, ordinals, rate_hz)),))


PAUSE_S = 1.0
PAUSE_PERIODS = 10.0
"""A hole longer than both is a pause of the recording, a shorter one dropped packets."""

GAP_RULES = (
    (GapKind.DROPPED, "packets_dropped", "Samples are missing: recorded as gaps, nothing is interpolated."),
    (GapKind.PAUSE, "recording_paused", "The recording pauses: recorded as gaps."),
)
"""How gaps are reported; those of rejected rows are reported by what rejected them."""

RATE_NOTED = 0.005
RATE_REFUSED = 0.05


@dataclass(frozen=True, slots=True, eq=False)
class Timebase:
    """Elapsed time of the samples, shape (n,), seconds from the first one; mean rate; gaps in order of time."""

    time_s: FloatArray
    rate_hz: float | None
    gaps: tuple[Gap, ...]


def from_stamps(seconds: FloatArray, ordinals: IntArray) -> Timebase:
    """Build the axis from strictly increasing stamps of one segment, shape (n,).

    `ordinals` number the rows as they stand in the file: rows rejected in between leave a hole of that kind.
    """
    first_s = seconds[0]
    time_s = by_blocks(seconds, lambda block: block - first_s)
    if len(time_s) < 2:
        return Timebase(time_s, None, ())
    steps = np.diff(time_s)
    period = usual_step(steps)
    holes = _holes(steps, period)
    inside = np.rint(steps[holes] / period).astype(np.int64) - 1
    paused = steps[holes] > max(PAUSE_S, PAUSE_PERIODS * period)
    recorded = float(time_s[-1]) - float(steps[holes][paused].sum())
    intervals = len(steps) - int(paused.sum()) + int(inside[~paused].sum())
    rate = intervals / recorded if recorded > 0 else 1 / period
    gaps = []
    for hole, pause in zip(holes.tolist(), paused.tolist(), strict=True):
        missing = max(1, round(float(steps[hole]) * rate) - 1)
        gap = _gap(float(time_s[hole]), float(steps[hole]), missing, ordinals, hole)
        gaps.append(dataclasses.replace(gap, kind=GapKind.PAUSE) if pause else gap)
    return Timebase(time_s, rate, tuple(gaps))


def from_rate(counts: IntArray, ordinals: IntArray, rate_hz: float) -> Timebase:
    """Build the axis of a file without time from its rate.

    `counts`, shape (n,), strictly increasing, number the samples as they were taken; `ordinals` the rows of the file.
    """
    time_s = (counts - counts[0]).astype(np.float64) / rate_hz
    steps = np.diff(counts)
    gaps = []
    for hole in np.flatnonzero(steps > 1).tolist():
        length_s = float(steps[hole]) / rate_hz
        gaps.append(_gap(float(time_s[hole]), length_s, int(steps[hole]) - 1, ordinals, hole))
    return Timebase(time_s, rate_hz, tuple(gaps))


def _gap(start_s: float, length_s: float, missing: int, ordinals: IntArray, row: int) -> Gap:
    """Return the gap behind a row: of rows that were rejected, where so many stand there, else of dropped samples."""
    rejected = int(ordinals[row + 1] - ordinals[row]) - 1
    return Gap(start_s, length_s, missing, missing, GapKind.REJECTED if rejected >= missing else GapKind.DROPPED)


def missing_samples(timebase: Timebase) -> int:
    """Return how many samples are missing without a pause and without rejected rows."""
    return sum(gap.samples_missing for gap in timebase.gaps if gap.kind is GapKind.DROPPED)


def usual_step(steps: FloatArray) -> float:
    """Return the mean of the steps without holes: those up to 1.6 median steps (3, 3, 4 ms belong together)."""
    median = float(np.median(steps))
    return float(steps[steps <= 1.6 * median].mean())


def _holes(steps: FloatArray, period: float) -> IntArray:
    """Return the positions of steps in which samples are missing.

    A late sample that the next one makes up for is jitter: with its neighbour such a step still spans two periods.
    """
    long = np.flatnonzero(steps > 1.5 * period)
    if not long.size:
        return long
    padded = np.concatenate([[np.inf], steps, [np.inf]])
    with_neighbour = padded[long + 1] + np.minimum(padded[long], padded[long + 2])
    return np.asarray(long[with_neighbour > 2.5 * period], dtype=np.int64)


def check_rate(
    measured_hz: float,
    reference_hz: float,
    where: str,
    findings: FindingCollector,
    subject: str = "The time stamps give",
    remedy: str | None = "correct what is wrong, the time's unit with `--unit` or the rate with `--rate`",
) -> None:
    """Compare a rate with a reference: over 0.5 % apart is noted, over 5 % refuses the file.

    `subject` begins the sentence about `measured_hz`, the rate that is used; `where` is the source of `reference_hz`.
    Without a `remedy`, since a person has decided, any difference is only noted.
    """
    apart = abs(measured_hz / reference_hz - 1)
    if apart <= RATE_NOTED:
        return
    found = f"{subject} {measured_hz:.6g} Hz and {where} says {reference_hz:.6g} Hz"
    if apart <= RATE_REFUSED or remedy is None:
        findings.add(NOTE, "rate_differs", f"{found}: {measured_hz:.6g} Hz is used.")
    else:
        findings.add(
            FILE,
            "rate_contradicts",
            f"{found}: {remedy}.",
        )


_WITHIN = 0.5
"""A step below this share of the mean step lies within a burst."""
_SHORT, _FEWEST_SHORT = 0.25, 0.1
"""No jitter: so many steps are as short as this share of the mean step."""
_FEWEST_EQUAL = 0.01
"""A clock coarser than the samples, 1100 Hz in whole milliseconds: so many stamps, and ten, equal the one before."""
_FEWEST_BURSTS = 10
_REGULAR, _REGULAR_SHARE = 0.35, 0.7
_CONTINUOUS = 5.0
_LONGEST_STEP_S = 3600.0
_FEWEST_LONG, _LONG_TOGETHER = 20, 5
"""Steps of two ticks from which rounding is told from losses, and how many of them in a row vary by less than one."""
_TOGETHER = 20
"""Bursts over which their period is taken."""
_MOST_ROUNDED = 1.1
"""Samples by which a coarse clock makes a burst early or late."""
_MAKES_UP = 50
"""Bursts within which a delay is made up for; later ones would take the drift of a clock for it."""
_ENDS = 50
"""Bursts at either end, a third of all at most, whose usual lateness gives the duration of a recording."""
_MOST_ROWS = 1 << 20
"""A long recording that does not begin in bursts has none."""


def burst_starts(seconds: FloatArray) -> IntArray | None:
    """Return the rows at which bursts start, or None where stamps, shape (n,), come one by one.

    Rows of a burst repeat their stamp or follow in a small part of the mean step, and every burst brings about as many
    samples as fit into the time until the next, give or take the one by which a coarse clock rounds.
    """
    if len(seconds) > _MOST_ROWS and burst_starts(seconds[:_MOST_ROWS]) is None:
        return None
    if len(seconds) < 2 * _FEWEST_BURSTS or not np.isfinite(seconds).all():
        return None
    steps = np.diff(seconds)
    if steps.min() < 0 or not 0 < steps.max() <= _LONGEST_STEP_S:
        return None
    usual = steps[steps <= PAUSE_S] if (steps <= PAUSE_S).any() else steps
    mean = float(usual.mean())
    short, equal = np.count_nonzero(steps < _SHORT * mean), np.count_nonzero(steps == 0)
    if short < _FEWEST_SHORT * len(steps) and equal < max(_FEWEST_BURSTS, _FEWEST_EQUAL * len(steps)):
        return None
    starts = np.concatenate([[0], np.flatnonzero(steps >= _shortest_between(usual, mean)) + 1])
    if len(starts) < _FEWEST_BURSTS or np.diff(starts).max() < 2:
        return None
    passed, brought = np.diff(seconds[starts]), np.diff(starts)
    period = _usual_period(passed, brought)
    near = (np.abs(passed / (brought * period) - 1) < _REGULAR) | (np.abs(passed / period - brought) < 1)
    return np.asarray(starts, dtype=np.int64) if np.count_nonzero(near) >= _REGULAR_SHARE * len(near) else None


def are_rounded(seconds: FloatArray) -> bool:
    """Whether steps of one and of two ticks alternate as evenly as rounding to a decimal place spreads them: 700 Hz in
    whole milliseconds, or 1000 Hz of which samples are missing very evenly. Stamps have shape (n,).
    """
    steps = np.diff(seconds)
    tick = float(np.median(steps)) if len(steps) else 0.0
    n_long = np.count_nonzero((steps > 1.6 * tick) & (steps < 2.4 * tick))
    if tick <= 0 or n_long < _FEWEST_LONG or abs(np.log10(tick) - np.rint(np.log10(tick))) > 0.01:
        return False
    some = len(steps) * _LONG_TOGETHER // n_long
    sums = seconds[some:] - seconds[:-some]
    return bool(np.count_nonzero(np.abs(sums - np.median(sums)) < 1.1 * tick) >= 0.9 * len(sums))


def _shortest_between(steps: FloatArray, mean: float) -> float:
    """Return the shortest step from burst to burst: above the widest gap, by ratio, in the lengths of steps.

    Looked for from `_WITHIN` mean steps up to the usual long one, so that neither pauses nor jitter are taken for it.
    """
    longest = float(np.median(steps[steps > mean]))
    lengths = np.sort(steps[(steps > _WITHIN * mean) & (steps <= longest)])
    ratios = lengths / np.concatenate([[_WITHIN * mean], lengths[:-1]])
    return float(lengths[np.argmax(ratios)])


def rate_within(seconds: FloatArray, starts: IntArray) -> float | None:
    """Return the rate, in hertz, at which rows follow each other within bursts; None where they share their stamps."""
    within = np.ones(len(seconds) - 1, dtype=np.bool_)
    within[starts[1:] - 1] = False
    step = float(np.median(np.diff(seconds)[within]))
    return 1 / step if step > 0 else None


def are_continuous(channels: Iterable[FloatArray], starts: IntArray) -> bool:
    """Whether values, shape (n,) each, change within bursts, and most not much more from burst to burst than within.

    A logger that records only now and then leaves the stamps of bursts, but its channels jump from one to the next;
    rows that are written twice repeat all their values.
    """
    moving = moving_within = jumping = 0
    for values in channels:
        within = np.ones(len(values) - 1, dtype=np.bool_)
        within[starts[1:] - 1] = False
        change = np.abs(np.diff(values))
        inside, between = _mean(change[within]), _mean(change[~within])
        moving += inside + between > 0
        moving_within += inside > 0
        jumping += 0 < _CONTINUOUS * inside < between
    return 2 * jumping <= moving_within and (moving_within > 0 or not moving)


def _mean(values: FloatArray) -> float:
    finite = values[np.isfinite(values)]
    return float(finite.mean()) if finite.size else 0.0


def from_bursts(seconds: FloatArray, ordinals: IntArray, starts: IntArray, numbers: IntArray | None = None) -> Timebase:
    """Build the even axis of samples that came in bursts.

    `seconds`, shape (n,), are the stamps, `ordinals` number the rows as they stand in the file, `starts` are the rows
    at which bursts start, `numbers` the instrument's own numbers of the samples, where it has them.
    """
    counts = (ordinals if numbers is None else numbers).copy()
    last_of_burst = np.append(starts[1:], len(counts)) - 1
    # All samples of a burst have come by its last stamp, however a burst was parted or two of them joined.
    # How much of the last burst the file holds shows nothing; when it came, only what it made up for.
    brought = np.diff(counts[last_of_burst])[:-1]
    between = np.diff(seconds[last_of_burst])
    passed = between[:-1]
    steps = np.diff(seconds)
    period, tolerated = _burst_period(passed, brought, float(steps[steps > 0].min()))
    lateness = np.concatenate([[0.0], np.cumsum(passed - brought * period)])
    of_last = lateness[-1] + between[-1] - float(np.median(brought)) * period
    lowest = _lowest_from_each_on(np.append(lateness, of_last))[:-1]
    for_good = np.diff(lowest)
    # What the last bursts are late may yet be made up for, as it usually was before.
    is_last = np.arange(len(for_good)) >= len(for_good) - _MAKES_UP
    allowed = np.where(is_last, tolerated + float(np.percentile(lateness - lowest, 90)), tolerated)
    missing = np.where(for_good > allowed, np.rint(for_good / period), 0).astype(np.int64)
    paused = for_good > max(PAUSE_S, PAUSE_PERIODS * period)
    took = np.concatenate([[0.0], np.cumsum(np.where(paused, brought * period, passed))])
    rate = _rate(took, np.concatenate([[0], np.cumsum(brought + np.where(paused, 0, missing))]))
    for start, number in zip(starts[1:-1][missing > 0].tolist(), missing[missing > 0].tolist(), strict=True):
        counts[start:] += number
    even = from_rate(counts, ordinals, rate)
    longest = max(PAUSE_S, PAUSE_PERIODS / rate)
    gaps = tuple(
        dataclasses.replace(gap, kind=GapKind.PAUSE) if gap.kind is GapKind.DROPPED and gap.length_s > longest else gap
        for gap in even.gaps
    )
    return dataclasses.replace(even, gaps=gaps)


def _usual_period(passed: FloatArray, brought: IntArray) -> float:
    """Return the time of one sample: the median over bursts, of some together, for a coarse clock brings 1, 2, 2, 1."""
    some = min(_TOGETHER, len(passed) // 3 + 1)
    took, samples = (np.concatenate([[0], np.cumsum(each)]) for each in (passed, brought))
    return float(np.median((took[some:] - took[:-some]) / (samples[some:] - samples[:-some])))


def _burst_period(passed: FloatArray, brought: IntArray, tick: float) -> tuple[float, float]:
    """Return the time of one sample, the mean over bursts that came in time, and how late these are at most, in s.

    `tick` is the shortest time between two different stamps: a clock coarser than the samples makes a burst early or
    late by one of them, which does not add up.
    """
    usual = _usual_period(passed, brought)
    late = passed - brought * usual
    jitter = 5 * 1.4826 * float(np.median(np.abs(late - np.median(late))))
    in_time = np.abs(late) <= max(_MOST_ROUNDED * usual, jitter)
    period = float(passed[in_time].sum() / brought[in_time].sum()) if in_time.any() else usual
    is_coarse = tick > 0.5 * usual and float(np.percentile(np.abs(late), 95)) <= _MOST_ROUNDED * usual
    return period, 0.75 * usual if is_coarse else max(0.75 * usual, jitter)


def _rate(took: FloatArray, samples: IntArray) -> float:
    """Return the samples over the time that they took, each counted until a burst, by the medians at either end."""
    few = max(1, min(_ENDS, len(took) // 3))
    period = (took[-1] - took[0]) / (samples[-1] - samples[0])
    late = took - samples * period
    drift = (np.median(late[-few:]) - np.median(late[:few])) / (np.median(samples[-few:]) - np.median(samples[:few]))
    return float(1 / (period + drift))


def _lowest_from_each_on(lateness: FloatArray) -> FloatArray:
    """Return the least lateness of each burst and those after it, shape (n,): what was not made up for."""
    following = np.concatenate([lateness, np.full(_MAKES_UP - 1, np.inf)])
    return np.asarray(np.lib.stride_tricks.sliding_window_view(following, _MAKES_UP).min(axis=1), dtype=np.float64)


RESTART_S = 1.0
"""A step back by more than this, and by three usual steps, is a new recording, by less a row out of order."""

JUMP_S = 3600.0
"""A step forward by more than this is a new recording."""

MOST_SEGMENTS = 10
_NEAR_END = 1 / 16
"""A counter that begins again has come so near to its end, and begun so near to 0, in shares of all its numbers."""


@dataclass(frozen=True, slots=True)
class Order:
    """`keep`, shape (n_rows,), marks rows with a usable stamp; `starts` are the rows at which segments begin."""

    keep: BoolArray
    starts: tuple[int, ...]


def unwrap(ticks: FloatArray, findings: FindingCollector, block: Block, column: str) -> FloatArray:
    """Return the ticks of a 32-bit clock counted on beyond 2^32; other ticks unchanged. Shape (n,)."""
    steps = np.diff(ticks)
    usual = float(np.median(steps[steps > 0])) if (steps > 0).any() else 0.0
    wrapped = _wraps(ticks, 2.0**32, 1000 * usual)
    if not wrapped.size:
        return ticks
    message = "The 32-bit clock passes its end: counted on from there."
    findings.add(NOTE, "time_wrapped", message, column=column, lines=block.lines[wrapped])
    return _counted_on(ticks, wrapped, 2.0**32)


def unwrap_counter(numbers: FloatArray) -> FloatArray | None:
    """Return the numbers of samples, shape (n,), counted on where the counter begins again; None where they do not
    count up.

    It begins again near 0 after 2^8, 2^16 or 2^32, or at the least number seen after the largest.
    """
    if not (np.isfinite(numbers).all() and numbers.size):
        return None
    if _counts_up(numbers):
        return numbers
    from_least = numbers - numbers.min()
    for counter, modulus in (
        *((numbers, 2.0**bits) for bits in (8, 16, 32)),
        (from_least, float(from_least.max()) + 1),
    ):
        counted = _counted_on(counter, _wraps(counter, modulus, max(1.0, _NEAR_END * modulus)), modulus)
        if _counts_up(counted):
            return counted
    return None


def _counts_up(numbers: FloatArray) -> bool:
    return bool((np.diff(numbers) >= 1).all() and np.abs(numbers).max() < 2**53)


def _wraps(numbers: FloatArray, modulus: float, longest_step: float) -> IntArray:
    """Return the rows at which a counter has passed its end, by a step of `longest_step` at most."""
    if numbers.min() < 0 or numbers.max() >= modulus:
        return np.zeros(0, dtype=np.int64)
    steps = np.diff(numbers)
    return np.flatnonzero((steps < 0) & (steps + modulus > 0) & (steps + modulus <= longest_step)) + 1


def _counted_on(numbers: FloatArray, wraps: IntArray, modulus: float) -> FloatArray:
    turns = np.zeros(len(numbers))
    turns[wraps] = modulus
    return np.asarray(numbers + np.cumsum(turns), dtype=np.float64)


def put_in_order(
    seconds: FloatArray, usable: BoolArray, block: Block, findings: FindingCollector, column: str
) -> Order:
    """Mark the rows whose stamp does not increase, and the beginnings of new recordings.

    `seconds`, shape (n_rows,), are the stamps; `usable` excludes rows already rejected.
    """
    keep = usable & np.isfinite(seconds)
    missing = np.flatnonzero(usable & ~keep)
    if missing.size:
        message = "The time stamp is missing or unreadable; the row is left out."
        findings.add(ROW, "time_missing", message, column=column, lines=block.lines[missing])
    rows = np.flatnonzero(keep)
    stamps = seconds[rows]
    steps = np.diff(stamps)
    if not ((steps <= 0).any() or (steps > JUMP_S).any()):
        return Order(keep, (int(rows[0]),) if rows.size else ())
    faults, starts = _walk(stamps.data, 3 * float(np.median(steps)))
    starts = _without_lone_rows(starts, len(stamps), faults)
    for rule, found in faults.items():
        bad = rows[np.array(sorted(found), dtype=np.int64)]
        keep[bad] = False
        findings.add(ROW, rule, FAULTS_OF_TIME[rule], column=column, lines=block.lines[bad])
    return Order(keep, _report_starts([int(rows[start]) for start in starts], block, findings, column))


def _without_lone_rows(starts: list[int], n_stamps: int, faults: dict[str, list[int]]) -> list[int]:
    """Return the starts of segments of two rows and more; a row alone has a false stamp and joins the faults."""
    rejected = {position for found in faults.values() for position in found}
    true_starts = []
    for start, stop in zip(starts, [*starts[1:], n_stamps], strict=True):
        members = [position for position in range(start, min(stop, start + 50)) if position not in rejected]
        if len(members) > 1 or stop > start + 50:
            true_starts.append(start)
        else:
            faults.setdefault("time_spike", []).extend(members)
    return true_starts


def _report_starts(starts: list[int], block: Block, findings: FindingCollector, column: str) -> tuple[int, ...]:
    if len(starts) > 1:
        lines = block.lines[starts[1:]]
        message = "The clock starts again or jumps by hours: what follows is kept as a segment of its own."
        findings.add(NOTE, "time_restarted", message, column=column, lines=lines)
    if len(starts) > MOST_SEGMENTS:
        message = (
            f"The clock starts again more than {MOST_SEGMENTS} times: is this the time column? "
            'Name the right one with `--column "NAME=time"`, or have samples counted by their rate, '
            f"{count_by_rate_flags(column)}."
        )
        findings.add(FILE, "time_unusable", message, column=column, lines=lines)
    return tuple(starts)


FAULTS_OF_TIME = {
    "time_duplicate": "The time stamp repeats the one before it; the row is left out.",
    "time_backwards": "The time stamp lies before the one above it; the row is left out.",
    "time_spike": "The time stamp lies far from those before and after it; the row is left out.",
}


def _walk(stamps: memoryview, normal_step: float) -> tuple[dict[str, list[int]], list[int]]:
    """Go through stamps one by one; returns the faulty positions by rule and the positions where segments start."""
    faults: dict[str, list[int]] = {}
    starts = [0]
    restart = max(RESTART_S, normal_step)
    last = stamps[0]
    end = len(stamps) - 1

    def fault(rule: str, position: int) -> None:
        faults.setdefault(rule, []).append(position)

    for position in range(1, end + 1):
        stamp = stamps[position]
        step = stamp - last
        following = stamps[position + 1] if position < end else None
        if step == 0:
            fault("time_duplicate", position)
        elif step > 0:
            if step > normal_step and following is not None and last < following < stamp:
                fault("time_spike", position)  # the next row goes on from before it
                continue
            if step > JUMP_S:
                if following is None:
                    fault("time_spike", position)
                    continue
                starts.append(position)
            last = stamp
        elif step < -restart and following is not None and 0 < following - stamp < restart:
            starts.append(position)
            last = stamp
        else:
            fault("time_spike" if step < -restart else "time_backwards", position)
    return faults, starts
