"""Which rows belong to one recording: trials distinguished by a column, and time stamps put in order.

Which rows have an impossible stamp, where a counter wrapped, where recording began anew. Stamps are never changed to
fit, except that a counter which passed its end is counted on.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ingest.channels.columns import count_by_rate_flags
from ingest.channels.names import clean_name
from ingest.declared import positions_of
from ingest.findings import FILE, NOTE, ROW, FindingCollector
from ingest.model import BoolArray, FloatArray, IntArray
from ingest.tables.table import Block, Table

MOST_TRIALS = 500


def trial_position(column: str | None, table: Table, findings: FindingCollector) -> int | None:
    """Return the position of the column that distinguishes trials; a column that is not there refuses the file."""
    if column is None:
        return None
    positions = positions_of(column, table.names)
    if positions:
        return positions[0]
    listed = ", ".join(map(repr, table.names[:12]))
    message = f"The trials are told apart by column {column!r}, which the file does not have: it has {listed}."
    findings.add(FILE, "trial_column_absent", message, column=column)
    return None


def trials(block: Block, position: int | None, findings: FindingCollector) -> list[tuple[str | None, BoolArray]]:
    """Return the name of each trial and its rows, shape (n_rows,), in order of their first row; one trial without such
    a column.
    """
    if position is None:
        return [(None, np.ones(block.n_rows, dtype=np.bool_))]
    if position in block.clocks:
        values = np.array([cell.decode("utf-8", errors="replace").strip() for cell in block.clocks[position]])
    else:
        values = np.array([f"{value:.15g}" for value in np.asarray(block.numbers[position]).tolist()])
    found, first, which = np.unique(values, return_index=True, return_inverse=True)
    if len(found) > MOST_TRIALS:
        message = f"The column has {len(found)} values, more than the {MOST_TRIALS} trials allowed: name another one."
        findings.add(FILE, "too_many_trials", message)
        return []
    names: list[str] = []
    for value in found.tolist():
        name = clean_name(value) or "without_name"
        names.append(name if name not in names else f"{name}_{len(names)}")
    return [(names[trial], which == trial) for trial in np.argsort(first).tolist()]


def refuse_series(
    block: Block, time_position: int, texts: Mapping[str, Sequence[bytes]], findings: FindingCollector
) -> None:
    """Refuse a long table: its stamps repeat and are each once under each word of a column, by name in `texts`, or
    those of each word follow each other more steadily than all together.
    """
    stamps = block.clocks[time_position] if time_position in block.clocks else block.numbers[time_position]
    if not texts:
        return
    repeats = block.n_rows - len(np.unique(np.asarray(stamps)))
    repeated = repeats >= max(2, block.n_rows / 100)
    stamp = np.unique(np.asarray(stamps), return_inverse=True)[1].astype(np.int64)
    for name, cells in texts.items():
        words, word = np.unique(np.asarray(cells), return_inverse=True)
        if len(words) > MOST_TRIALS:
            continue
        listed = ", ".join(repr(each.decode("utf-8", errors="replace").strip()) for each in words[:6].tolist())
        if repeated and len(np.unique(stamp * len(words) + word)) == block.n_rows:
            message = f"Each stamp stands beside several words of column {name!r} ({listed})"
        elif time_position in block.numbers and _steadier(np.asarray(stamps, dtype=np.float64), word, len(words)):
            message = f"The stamps beside each word of column {name!r} ({listed}) are steadier than all together"
        else:
            continue
        message += (
            f", as in a long table: say `trials = {json.dumps(name, ensure_ascii=False)}` in a [profiles.NAME] table "
            "of labbook.toml, and each becomes a part of its own."
        )
        findings.add(FILE, "series_interleaved", message, column=name)


_STEADIER = 0.5
"""Steps of this share of the spread of all are those of another clock; of a word by chance the spread is as large."""
_FEWEST_STEPS = 3


def _steadier(stamps: FloatArray, word: IntArray, n_words: int) -> bool:
    """Whether the steps between the stamps, shape (n_rows,), of each of several words spread less than all steps."""
    if n_words < 2 or np.bincount(word).min() <= _FEWEST_STEPS:
        return False
    most = _STEADIER * float(np.std(np.diff(stamps)))
    return all(float(np.std(np.diff(stamps[word == each]))) < most for each in range(n_words))


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
