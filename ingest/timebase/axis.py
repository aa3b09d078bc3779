"""Which rows of a table are usable in time, and the time axis of each of its recordings."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from zoneinfo import ZoneInfo

import numpy as np

from ingest.channels.columns import Plan, TimePlan
from ingest.channels.names import parse_header
from ingest.declared import argument
from ingest.findings import FILE, NOTE, FindingCollector
from ingest.model import BoolArray, Declarations, FloatArray, IntArray
from ingest.spool import by_blocks, take
from ingest.tables.table import Block, CellKind, Preamble
from ingest.timebase import clock
from ingest.timebase.clock import ClockColumn, read_clocks
from ingest.timebase.order import Order, put_in_order, unwrap
from ingest.timebase.stamps import (
    GAP_RULES,
    RATE_REFUSED,
    TICKS_PER_SECOND,
    Timebase,
    are_continuous,
    burst_starts,
    check_rate,
    from_bursts,
    from_rate,
    from_stamps,
    rate_within,
    rows_after_gaps,
)

MOTION = frozenset({"body_height", "foot_height", "leg_length", "leg_velocity", "body_velocity", "force_z"})
MOTION_RATES_HZ = (20.0, 50_000.0)
"""A log of jumps slower or faster than this has its time in another unit than declared."""
USUAL_RATE_HZ = 500.0

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
    """All that bears on the time of one table: its rows, plan and values, declarations, preamble, fixed rate.

    `clock_columns` names its columns of clock times, with or without a date, and those of dates alone.
    """

    block: Block
    plan: Plan
    stored: Mapping[int, FloatArray]
    declared: Declarations
    preamble: Preamble
    fixed_rate_hz: float | None
    clock_columns: tuple[Sequence[str], Sequence[str]] = ((), ())


def recordings(sources: TimeSources, usable: BoolArray, findings: FindingCollector) -> Recordings:
    """Build the time axis from the time column, or else from the rate; what is missing for it is asked for."""
    time = sources.plan.time
    if time is None:
        return _from_given_rate(sources, usable, findings)
    clocks = _clocks(time, sources, findings)
    ticks = _ticks(time, sources.block, findings) if clocks is None else clocks.seconds
    if time.kind is not CellKind.CLOCK and time.unit not in TICKS_PER_SECOND:
        if time.unit is not None:
            known = ", ".join(TICKS_PER_SECOND)
            flag = argument(f"{time.source_name}=ms")
            message = f"{time.unit!r} is no unit of time known here: say `--unit {flag}`, or one of {known}."
            findings.add(FILE, "time_unit_unknown", message, column=time.source_name, value=time.unit)
        order = put_in_order(ticks, usable, sources.block, findings, time.source_name)
        return Recordings(order.keep, ())
    per_second = TICKS_PER_SECOND[time.unit or "s"]
    seconds = ticks if time.kind is CellKind.CLOCK else by_blocks(ticks, lambda block: block / per_second)
    if sources.fixed_rate_hz is not None and _are_arrival_times(seconds):
        return _from_arrivals(sources, time, clocks, seconds, usable, findings)
    in_bursts = _from_bursts(sources, time, clocks, seconds, usable, findings)
    if in_bursts is not None:
        return in_bursts
    order = put_in_order(seconds, usable, sources.block, findings, time.source_name)
    found: list[Recording] = []
    ordinals = sources.block.ordinal()
    for rows in _segments(order):
        timebase = from_stamps(take(seconds, rows), take(ordinals, rows))
        _report_gaps(timebase, rows, sources.block, findings)
        utc, original = _start(sources, time, clocks, rows, first=not found, findings=findings)
        found.append(Recording(rows, timebase, utc, original))
    _check_rates(found, sources, findings)
    return Recordings(order.keep, tuple(found))


def _clocks(time: TimePlan, sources: TimeSources, findings: FindingCollector) -> ClockColumn | None:
    """Return the time column where it holds clock texts, with the dates beside it."""
    if time.kind is not CellKind.CLOCK:
        return None
    clocks = sources.block.clocks
    dates = None if time.date_position is None else clocks[time.date_position]
    return read_clocks(clocks[time.position], dates, time.source_name, sources.declared, findings)


def _ticks(time: TimePlan, block: Block, findings: FindingCollector) -> FloatArray:
    """Return the time column in its own unit, shape (n_rows,); long integers from the first one on, all digits kept."""
    column = block.numbers[time.position]
    if time.kind is CellKind.INTEGER:
        first, middle = column[0], column[len(column) // 2]
        return np.asarray(column - (first if abs(middle - first) < 2**53 else middle), dtype=np.float64)
    ticks = np.asarray(column, dtype=np.float64)
    if time.unit in _WRAPPING:
        ticks = unwrap(ticks, findings, block, time.source_name)
    return ticks


def _segments(order: Order) -> list[IntArray | slice]:
    if len(order.starts) == 1 and order.keep.all():
        return [slice(None)]
    rows = np.flatnonzero(order.keep)
    cuts = np.searchsorted(rows, np.array(order.starts[1:], dtype=np.int64))
    return [part for part in np.split(rows, cuts) if part.size]


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
        return None if iso is None else clock.to_utc(iso, zone, findings, clocks.fold(row)), clocks.texts[row]
    stamp = sources.block.numbers[time.position][row].item()
    original = f"{stamp if time.kind is CellKind.INTEGER else format(stamp, '.15g')} {time.unit}"
    if time.unit == "filetime":
        return clock.filetime_utc(int(stamp)), original
    utc = clock.epoch_utc(stamp, TICKS_PER_SECOND[time.unit or "s"])
    if utc is None and first and sources.preamble.start is not None:
        return clock.to_utc(sources.preamble.start, zone, findings), sources.preamble.start
    return utc, original


def first_day(sources: TimeSources) -> str | None:
    """Return the local date on which a table begins, None where neither its stamps nor its preamble have one."""
    findings = FindingCollector()
    time, start = sources.plan.time, sources.preamble.start
    utc = None if start is None else clock.to_utc(start, sources.declared.time_zone, findings)
    if time is not None and sources.block.n_rows and (time.kind is CellKind.CLOCK or time.unit in TICKS_PER_SECOND):
        utc, _ = _start(sources, time, _clocks(time, sources, findings), slice(None), True, findings)
    if utc is None:
        return None
    return str(datetime.fromisoformat(utc).astimezone(ZoneInfo(sources.declared.time_zone or "UTC")).date())


def _report_gaps(timebase: Timebase, rows: IntArray | slice, block: Block, findings: FindingCollector) -> None:
    for kind, rule, message in GAP_RULES:
        after = rows_after_gaps(timebase, kind)
        if after.size:
            places = after if isinstance(rows, slice) else rows[after]
            findings.add(NOTE, rule, message, lines=block.line_of(places), count=len(after))


def _check_rates(found: Sequence[Recording], sources: TimeSources, findings: FindingCollector) -> None:
    rates = [recording.timebase.rate_hz for recording in found]
    for rate in rates:
        if rate is None:
            continue
        declared, header = sources.declared.rate_hz, sources.preamble.rate_hz
        if declared is not None:
            remedy = _rate_advice(sources, rate, declared, "leave `--rate` out")
            check_rate(rate, declared, "the declaration", findings, remedy=remedy)
        if header is not None:
            confirmed = declared is not None and abs(rate / declared - 1) <= RATE_REFUSED
            cure = None if confirmed else _rate_advice(sources, rate, header, f"say `--rate {rate:.6g}`")
            check_rate(rate, header, "the file's header", findings, remedy=cure)
        moving = any(column.channel in MOTION for column in sources.plan.columns)
        if moving and not MOTION_RATES_HZ[0] <= rate <= MOTION_RATES_HZ[1]:
            message = f"The time stamps give {rate:.3g} Hz, at which no jump can be seen: is the unit of time right? "
            findings.add(FILE, "rate_implausible", message + _time_unit_advice(sources, rate))


def _rate_advice(sources: TimeSources, rate_hz: float, reference_hz: float, stamps_are_right: str) -> str:
    """Return the remedy for time stamps at another rate than given: the unit that explains it, where one does."""
    time = sources.plan.time
    if time is None:
        return stamps_are_right
    cell, cure = (
        parse_header(time.source_name),
        f"count by the rate, {_count_by_rate_flags(time, f'{reference_hz:.6g}')}",
    )
    if time.kind is not CellKind.CLOCK:
        second = rate_hz / TICKS_PER_SECOND[time.unit or "s"]
        override = " --override-units" if cell.unit is not None else ""
        for unit, ticks in TICKS_PER_SECOND.items():
            if abs(second * ticks / reference_hz - 1) <= RATE_REFUSED:
                cure = f"correct their unit, `--unit {argument(f'{cell.base}={unit}')}{override}`"
    return f"if the time stamps are right, {stamps_are_right}, else {cure}"


def _count_by_rate_flags(time: TimePlan, rate: str) -> str:
    """Return the flags that have samples counted at a rate, whatever is in the time column."""
    return f"`--rate {rate} --column {argument(f'{parse_header(time.source_name).base}=own.clock')}`"


def _time_unit_advice(sources: TimeSources, rate_hz: float) -> str:
    """Return which flag corrects the time column, or the rate where none is; first the unit with a usual rate."""
    time = sources.plan.time
    if time is None:
        return "Say the rate with `--rate`."
    if time.kind is CellKind.CLOCK:
        return f"Say the rate, and that this is not the time: {_count_by_rate_flags(time, '300')}, 300 being yours."
    cell = parse_header(time.source_name)
    override = " --override-units" if cell.unit is not None else ""
    second = rate_hz / TICKS_PER_SECOND[time.unit or "s"]
    others = [unit for unit in ("ms", "s", "us") if unit != time.unit]
    others.sort(key=lambda unit: abs(math.log(second * TICKS_PER_SECOND[unit] / USUAL_RATE_HZ)))
    return f"Say it with `--unit {argument(f'{cell.base}={others[0]}')}{override}` (or {others[1]})."


def _clock_advice(sources: TimeSources) -> str:
    """Return how to name the columns of dates and clock times that are there though no column is the time."""
    times, dates = sources.clock_columns
    if not times:
        return ""
    named = "".join(f' --column "{date}=date"' for date in dates[:1])
    return f'the clock times in column {times[0]!r} with `--column "{times[0]}=time"{named}`, or '


def _sheet_advice(sources: TimeSources) -> str:
    """Return how to read a table that may be one of recharges, one a row: it has a column of charges."""
    charges = [column for column in sources.plan.columns if column.source_unit in ("mAh", "Ah")]
    if not charges:
        return ""
    flag = argument(f"{charges[0].source_name}=charge")
    return (
        "The file looks like a sheet of recharges: if it is, say which column names the run (or the pack), `--column "
        f'"NAME=run" --column {flag}`, or, where none does, `--format charger_sheet --column {flag}`. '
    )


def _from_given_rate(sources: TimeSources, usable: BoolArray, findings: FindingCollector) -> Recordings:
    rate = _given_rate(sources, findings)
    if rate is None and findings.count("several_time_columns"):
        return Recordings(usable, ())
    if rate is None:
        sheet = _sheet_advice(sources)
        the = "Else the" if sheet else "The"
        findings.add(
            FILE,
            "rate_missing",
            f"{sheet}{the} file has neither a time column nor a sampling rate: say `--rate 300` (hertz), "
            f'or name {_clock_advice(sources)}its time column with `--column "NAME=time:ms"`, or do either in a '
            "[profiles.NAME] table of labbook.toml.",
        )
        return Recordings(usable, ())
    rows = np.flatnonzero(usable)
    if not rows.size:
        return Recordings(usable, ())
    ordinals = sources.block.ordinal()[rows]
    counts = _sequence(sources, rows)
    timebase = from_rate(ordinals if counts is None else counts, ordinals, rate)
    _report_gaps(timebase, rows, sources.block, findings)
    start = sources.preamble.start
    utc = None if start is None else clock.to_utc(start, sources.declared.time_zone, findings)
    recording = Recording(slice(None) if usable.all() else rows, timebase, utc, start)
    return Recordings(usable, (recording,))


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


def _sequence(sources: TimeSources, rows: IntArray | slice) -> IntArray | None:
    """Return the instrument's own sample numbers of the rows, where it has them and they count up."""
    for column in sources.plan.columns:
        if column.channel == "sequence":
            numbers = sources.stored[column.position][rows]
            if np.isfinite(numbers).all() and (np.diff(numbers) >= 1).all() and np.abs(numbers).max() < 2**53:
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
    rows = slice(None) if usable.all() else np.flatnonzero(usable)
    stamps = seconds[rows]
    starts = burst_starts(stamps)
    if starts is None:
        return None
    timebase = from_bursts(stamps, sources.block.ordinal()[rows], starts, _sequence(sources, rows))
    given_hz = sources.declared.rate_hz or sources.preamble.rate_hz
    if not _near(timebase.rate_hz, given_hz):
        channels = (values[rows] for values in sources.stored.values())
        if _near(rate_within(stamps, starts), given_hz) or not are_continuous(channels, starts):
            return None  # recorded now and then: the holes are real
    message = (
        f"The stamps are arrival stamps, {len(stamps) / len(starts):.3g} samples at once: the rate, "
        f"{timebase.rate_hz:.6g} Hz, is samples over time, and the axis is even."
    )
    findings.add(NOTE, "arrival_times", message, column=time.source_name)
    _report_gaps(timebase, rows, sources.block, findings)
    utc, original = _start(sources, time, clocks, rows, first=True, findings=findings)
    recording = Recording(rows, timebase, utc, original)
    _check_rates([recording], sources, findings)
    return Recordings(usable, (recording,))


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
    span = float(np.nanmax(seconds) - np.nanmin(seconds))
    if span > 0:
        check_rate((len(seconds) - 1) / span, rate, "the amplifier's manual", findings)
    utc, original = _start(sources, time, clocks, rows, first=True, findings=findings)
    ordinals = sources.block.ordinal()[rows]
    timebase = from_rate(ordinals, ordinals, rate)
    return Recordings(usable, (Recording(slice(None) if usable.all() else rows, timebase, utc, original),))
