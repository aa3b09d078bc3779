"""Which rows of a table are usable in time, and the time axis of each of its recordings."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from zoneinfo import ZoneInfo

import numpy as np

from data_schema.vocabulary import GapKind
from ingest.channels.columns import Plan, TimePlan, count_by_rate_flags
from ingest.channels.names import channel_kind, is_unit
from ingest.declared import argument
from ingest.findings import FILE, NOTE, FindingCollector
from ingest.model import BoolArray, Declarations, FloatArray, IntArray
from ingest.spool import by_blocks, take
from ingest.tables.table import Block, CellKind, Preamble
from ingest.timebase import clock
from ingest.timebase.clock import ClockColumn, read_clocks
from ingest.timebase.order import Order, put_in_order, unwrap, unwrap_counter
from ingest.timebase.stamps import (
    GAP_RULES,
    RATE_REFUSED,
    TICKS_PER_SECOND,
    Timebase,
    are_continuous,
    are_rounded,
    burst_starts,
    check_rate,
    from_bursts,
    from_rate,
    from_stamps,
    missing_samples,
    rate_within,
    rows_after_gaps,
    ticks_per_second,
    usual_step,
)

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


@dataclass(frozen=True, slots=True, eq=False)
class TimeSources:
    """All that bears on the time of one table: its rows, plan and values, declarations, preamble, fixed rate."""

    block: Block
    plan: Plan
    stored: Mapping[int, FloatArray]
    declared: Declarations
    preamble: Preamble
    fixed_rate_hz: float | None


def recordings(sources: TimeSources, usable: BoolArray, findings: FindingCollector) -> Recordings:
    """Build the time axis from the time column, or else from the rate; what is missing for it is asked for."""
    time = sources.plan.time
    if time is None:
        return _from_given_rate(sources, usable, findings)
    clocks = _clocks(time, sources, findings)
    ticks = _ticks(time, sources.block, findings) if clocks is None else clocks.seconds
    per_second = 1.0 if time.kind is CellKind.CLOCK else ticks_per_second(time.unit)
    if per_second is None:
        _ask_for_unit(sources, time, ticks[usable & np.isfinite(ticks)], findings)
        return Recordings(usable, ())
    seconds = ticks if per_second == 1.0 else by_blocks(ticks, lambda block: block / per_second)
    if sources.fixed_rate_hz is not None and _are_arrival_times(seconds):
        return _from_arrivals(sources, time, clocks, seconds, usable, findings)
    in_bursts = _from_bursts(sources, time, clocks, seconds, usable, findings)
    if in_bursts is not None:
        return in_bursts
    order = put_in_order(seconds, usable, sources.block, findings, time.source_name)
    found: list[Recording] = []
    ordinals = sources.block.ordinals
    for rows in _segments(order):
        timebase = from_stamps(take(seconds, rows), take(ordinals, rows))
        _report_gaps(timebase, rows, sources.block, findings)
        utc, original = _start(sources, time, clocks, rows, first=not found, findings=findings)
        found.append(Recording(rows, timebase, utc, original))
    _check_rates(found, sources, time, findings)
    return Recordings(order.keep, tuple(found))


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


def _ask_for_unit(sources: TimeSources, time: TimePlan, ticks: FloatArray, findings: FindingCollector) -> None:
    """Refuse a time column without a unit that is known; the flag names one only where all else rules out the others.

    `ticks` has shape (n_usable_rows,).
    """
    flag = _unit_flag(time, _units_by_rate(sources, ticks))
    rate = sources.declared.rate_hz
    flag += "" if rate is None else f", or count samples by the rate, {count_by_rate_flags(time.flag, f'{rate:g}')}"
    if time.unit is not None:
        message = f"{time.unit!r} is no unit of time known here: say which it is, {flag}."
        findings.add(FILE, "time_unit_unknown", message, column=time.source_name, value=time.unit)
        return
    message = (
        f"The unit of column {time.source_name!r} is stated nowhere: say it, {flag}, or as `time` in a "
        "[profiles.NAME] table of labbook.toml."
    )
    findings.add(FILE, "time_unit_missing", message, column=time.source_name)


def _samples_per_tick(ticks: FloatArray) -> float | None:
    """Return the rate of stamps, shape (n,), in samples per tick; None where no stamp follows another."""
    steps = np.diff(ticks)
    steps = steps[steps > 0]
    return 1 / usual_step(steps) if steps.size else None


def _units_by_rate(sources: TimeSources, ticks: FloatArray) -> list[str]:
    """Return the units in which stamps have the rate declared or in the header; none where neither is."""
    rate, per_tick = sources.declared.rate_hz or sources.preamble.rate_hz, _samples_per_tick(ticks)
    return _units_near(rate / per_tick) if rate and per_tick else []


def _units_near(per_second: float) -> list[str]:
    return [unit for unit, known in TICKS_PER_SECOND.items() if abs(per_second / known - 1) <= RATE_REFUSED]


def _unit_flag(time: TimePlan, units: Sequence[str]) -> str:
    """Return the flag for the unit of a time column; it is left open, with the choices, where not one alone is left."""
    unit = units[0] if len(units) == 1 else "UNIT"
    override = " --override-units" if time.file_unit is not None and is_unit(time.file_unit) else ""
    others = units or [unit for unit in TICKS_PER_SECOND if unit != time.unit]
    choices = "" if len(units) == 1 else f" (UNIT: one of {', '.join(others)})"
    return f"`--unit {argument(f'{time.flag}={unit}')}{override}`{choices}"


def _clocks(time: TimePlan, sources: TimeSources, findings: FindingCollector) -> ClockColumn | None:
    """Return the time column where it holds clock texts, with the dates beside it."""
    if time.kind is not CellKind.CLOCK:
        return None
    clocks = sources.block.clocks
    dates = None if time.date_position is None else clocks[time.date_position]
    return read_clocks(clocks[time.position], dates, time.source_name, sources.declared, findings)


def _ticks(time: TimePlan, block: Block, findings: FindingCollector) -> FloatArray:
    """Return the time column in its own unit, shape (n_rows,); long counts from one of them on, all digits kept."""
    column = block.numbers[time.position]
    if time.fraction_position is not None:
        whole = np.asarray(column - np.nanmedian(column).round(), dtype=np.float64)
        return np.asarray(TICKS_PER_SECOND[time.unit or "ns"] * whole + block.numbers[time.fraction_position])
    if time.kind is CellKind.INTEGER:
        first, middle = column[0], column[len(column) // 2]
        return np.asarray(column - (first if abs(middle - first) < 2**53 else middle), dtype=np.float64)
    ticks = np.asarray(column, dtype=np.float64)
    if time.unit in _WRAPPING:
        ticks = unwrap(ticks, findings, block, time.source_name)
    return ticks


def _segments(order: Order) -> list[IntArray | slice]:
    rows = _rows_of(order.keep)
    if isinstance(rows, slice) and len(order.starts) == 1:
        return [rows]
    rows = np.flatnonzero(order.keep)
    cuts = np.searchsorted(rows, np.array(order.starts[1:], dtype=np.int64))
    return [part for part in np.split(rows, cuts) if part.size]


def _rows_of(marked: BoolArray) -> IntArray | slice:
    return slice(None) if marked.all() else np.flatnonzero(marked)


def _first_row(rows: IntArray | slice) -> int:
    return 0 if isinstance(rows, slice) else int(rows[0])


def _start(
    sources: TimeSources,
    time: TimePlan,
    clocks: ClockColumn | None,
    rows: IntArray | slice,
    first: bool,
    findings: FindingCollector,
) -> tuple[str | None, str | None]:
    """Return instant and original text of the beginning of a recording."""
    row = _first_row(rows)
    zone = sources.declared.time_zone
    if clocks is not None:
        iso = clocks.iso[row]
        return None if iso is None else clock.to_utc(iso, zone, findings), clocks.texts[row]
    stamp = sources.block.numbers[time.position][row].item()
    if time.fraction_position is not None:
        per_second = round(TICKS_PER_SECOND[time.unit or "ns"])
        stamp = per_second * int(stamp) + int(sources.block.numbers[time.fraction_position][row])
    original = f"{_written(stamp)} {time.unit}"
    utc = clock.epoch_time(stamp, time.unit or "s", ticks_per_second(time.unit) or 1.0)
    if utc is not None and not utc.endswith("Z"):
        return clock.to_utc(utc, zone, findings), original
    if utc is None and first and sources.preamble.start is not None:
        original = sources.preamble.start_text or sources.preamble.start
        return clock.to_utc(sources.preamble.start, zone, findings), original
    return utc, original


def first_day(sources: TimeSources) -> str | None:
    """Return the local date of the first row with a time, None where neither its stamps nor its preamble have one."""
    findings = FindingCollector()
    time, start = sources.plan.time, sources.preamble.start
    utc = None if start is None else clock.to_utc(start, sources.declared.time_zone, findings)
    if time is not None and (time.kind is CellKind.CLOCK or ticks_per_second(time.unit)):
        clocks = _clocks(time, sources, findings)
        stamps = _ticks(time, sources.block, findings) if clocks is None else clocks.seconds
        filled = np.flatnonzero(np.isfinite(stamps))
        if filled.size:
            utc, _ = _start(sources, time, clocks, filled[:1], True, findings)
    if utc is None:
        return None
    return str(datetime.fromisoformat(utc).astimezone(ZoneInfo(sources.declared.time_zone or "UTC")).date())


def _report_gaps(timebase: Timebase, rows: IntArray | slice, block: Block, findings: FindingCollector) -> None:
    for kind, rule, message in GAP_RULES:
        after = rows_after_gaps(timebase, kind)
        if after.size:
            places = after if isinstance(rows, slice) else rows[after]
            findings.add(NOTE, rule, message, lines=block.lines[places])


def _check_rates(found: Sequence[Recording], sources: TimeSources, time: TimePlan, findings: FindingCollector) -> None:
    declared, header = sources.declared.rate_hz, sources.preamble.rate_hz
    for recording in found:
        rate = recording.timebase.rate_hz
        if rate is None:
            continue
        if declared is None and header is None:
            _ask_about_rate(recording.timebase, rate, time, sources, findings)
        if declared is not None:
            remedy = _rate_advice(time, rate, declared)
            check_rate(rate, declared, "the declaration", findings, remedy=remedy)
        if header is not None:
            confirmed = declared is not None and abs(rate / declared - 1) <= RATE_REFUSED
            cure = None if confirmed else _rate_advice(time, rate, header)
            check_rate(rate, header, "the file's header", findings, remedy=cure)


def _ask_about_rate(
    timebase: Timebase, rate_hz: float, time: TimePlan, sources: TimeSources, findings: FindingCollector
) -> None:
    """Refuse a rate, until it is said, at which no jump can be seen in a log of jumps, or at which more samples are
    missing than there are.
    """
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
    disordered = sum(map(findings.count, ("time_backwards", "time_spike", "time_duplicate")))
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


def _from_given_rate(sources: TimeSources, usable: BoolArray, findings: FindingCollector) -> Recordings:
    if findings.count("several_time_columns") or findings.count("time_unreadable"):
        return Recordings(usable, ())  # asked about already
    rate = _given_rate(sources, findings)
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
    counts = _sequence(sources, rows, findings)
    if counts is None and all(column.channel != SEQUENCE for column in sources.plan.columns):
        counts = _counted_by(sources, rows, findings)
    timebase = from_rate(ordinals if counts is None else counts, ordinals, rate)
    _report_gaps(timebase, rows, sources.block, findings)
    if missing_samples(timebase) > len(rows) and any(column.channel == SEQUENCE for column in sources.plan.columns):
        _ask_about_counter(timebase, sources, findings)
    start = sources.preamble.start
    utc = None if start is None else clock.to_utc(start, sources.declared.time_zone, findings)
    recording = Recording(_rows_of(usable), timebase, utc, sources.preamble.start_text or start)
    return Recordings(usable, (recording,))


def _ask_about_counter(timebase: Timebase, sources: TimeSources, findings: FindingCollector) -> None:
    """Refuse a counter of samples by which most are missing, until a person says that it is one."""
    declared = (*sources.declared.columns.values(), *sources.declared.profile_columns.values())
    if any(declaration.channel == SEQUENCE for declaration in declared):
        return
    column = next(column for column in sources.plan.columns if column.channel == SEQUENCE)
    n, missing = len(timebase.time_s), missing_samples(timebase)
    findings.add(
        FILE,
        "mostly_missing",
        f"By column {column.source_name!r} {missing} samples are missing beside {n}: if it numbers the samples, say "
        f"`--column {argument(f'{column.flag}={SEQUENCE}')}`, else "
        f"`--column {argument(f'{column.flag}=own.counter')}`.",
        column=column.source_name,
    )


def _given_rate(sources: TimeSources, findings: FindingCollector) -> float | None:
    """Return the declared rate, or else the one above the table, with a note which; two that differ are refused."""
    declared, preamble = sources.declared.rate_hz, sources.preamble
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


def _sequence(sources: TimeSources, rows: IntArray | slice, findings: FindingCollector) -> IntArray | None:
    """Return the instrument's own sample numbers of the rows, where it has them and they count up."""
    for column in sources.plan.columns:
        if column.channel == SEQUENCE:
            numbers = unwrap_counter(sources.stored[column.position][rows])
            if numbers is not None:
                return numbers.astype(np.int64)
            message = "The sample numbers do not count up: samples that are missing by them are not looked for."
            findings.add(NOTE, "sequence_unused", message, column=column.source_name)
    return None


def _counted_by(sources: TimeSources, rows: IntArray | slice, findings: FindingCollector) -> IntArray | None:
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
        findings.add(NOTE, "sequence_found", message, column=column.source_name)
        return numbers.astype(np.int64)
    return None


def _are_arrival_times(seconds: FloatArray) -> bool:
    """Whether stamps are times at which packets came in, not at which samples were taken: many are equal."""
    return int(np.count_nonzero(np.diff(seconds) <= 0)) > 0.01 * len(seconds)


def _from_bursts(
    sources: TimeSources,
    time: TimePlan,
    clocks: ClockColumn | None,
    seconds: FloatArray,
    usable: BoolArray,
    findings: FindingCollector,
) -> Recordings | None:
    """Return the one recording of stamps that come in bursts, None where they do not."""
    rows = _rows_of(usable)
    stamps = seconds[rows]
    starts = burst_starts(stamps)
    one_by_one = starts is None
    if starts is None and are_rounded(stamps):
        starts = np.arange(len(stamps), dtype=np.int64)
    if starts is None:
        return None
    timebase = from_bursts(stamps, sources.block.ordinals[rows], starts, _sequence(sources, rows, findings))
    given_hz = sources.declared.rate_hz or sources.preamble.rate_hz
    if one_by_one and not _is_rounded_at(given_hz, timebase, stamps, time, findings):
        return None
    may_be_written_twice = len(stamps) < 1.1 * len(starts)
    if not one_by_one and (may_be_written_twice or not _near(timebase.rate_hz, given_hz)):
        channels = (values[rows] for values in sources.stored.values())
        if _near(rate_within(stamps, starts), given_hz) or not are_continuous(channels, starts):
            return None  # recorded now and then: the holes are real
    message = (
        f"The stamps are arrival stamps, or those of a coarse clock, {len(stamps) / len(starts):.3g} samples at once: "
        f"the rate, {timebase.rate_hz:.6g} Hz, is samples over time, and the axis is even."
    )
    findings.add(NOTE, "arrival_times", message, column=time.source_name)
    _report_gaps(timebase, rows, sources.block, findings)
    utc, original = _start(sources, time, clocks, rows, first=True, findings=findings)
    recording = Recording(rows, timebase, utc, original)
    _check_rates([recording], sources, time, findings)
    return Recordings(usable, (recording,))


def _is_rounded_at(
    given_hz: float | None, timebase: Timebase, stamps: FloatArray, time: TimePlan, findings: FindingCollector
) -> bool:
    """Whether stamps that are rounded to a tick, or lack samples as evenly, are rounded: the rate given decides, and is
    asked for.
    """
    tick = float(np.median(np.diff(stamps)))
    even_hz, full_hz = timebase.rate_hz or 1 / tick, 1 / tick
    if given_hz is None:
        findings.add(
            FILE,
            "rate_unclear",
            f"The time stamps are {even_hz:.6g} Hz in ticks of {tick:.3g} s, or {full_hz:.6g} Hz with samples missing "
            f"evenly: say which, `--rate {even_hz:.6g}` or `--rate {full_hz:.6g}`.",
            column=time.source_name,
        )
        return False
    return abs(given_hz - even_hz) < abs(given_hz - full_hz)


def _near(rate_hz: float | None, reference_hz: float | None) -> bool:
    return rate_hz is not None and reference_hz is not None and abs(rate_hz / reference_hz - 1) <= RATE_REFUSED


def _from_arrivals(
    sources: TimeSources,
    time: TimePlan,
    clocks: ClockColumn | None,
    seconds: FloatArray,
    usable: BoolArray,
    findings: FindingCollector,
) -> Recordings:
    rate = sources.fixed_rate_hz or 1.0
    rows = np.flatnonzero(usable)
    message = (
        f"The stamps tell when packets arrived: the axis counts samples at the amplifier's fixed {rate:g} Hz instead."
    )
    findings.add(NOTE, "arrival_times", message, column=time.source_name)
    span = float(np.fmax.reduce(seconds) - np.fmin.reduce(seconds))
    if span > 0:
        check_rate((len(seconds) - 1) / span, rate, "the amplifier's manual", findings)
    utc, original = _start(sources, time, clocks, rows, first=True, findings=findings)
    ordinals = sources.block.ordinals[rows]
    timebase = from_rate(ordinals, ordinals, rate)
    return Recordings(usable, (Recording(_rows_of(usable), timebase, utc, original),))
