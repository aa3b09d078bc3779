"""No mutant of a good log is imported with a wrong value, rate, unit or row count: a second parser decides."""

from __future__ import annotations

import math

import pytest

from ingest.model import Declarations, ReadFile, SignalPart
from ingest.read import read_file
from tests.ingest.mutants import Mutant, make_mutant
from tests.ingest.second_parser import FACTORS, SECONDS, Parsed, Row, parse, unit_of

RATE_HZ = 300.0
SKIPPED = {"header_repeated", "comment_line", "ctrl_z", "units_repeated", "nul_padding"}


def wrong(mutant: Mutant) -> str | None:
    """Return what is wrong with the reading of a mutant, None where nothing is."""
    read = read_file(mutant.data, Declarations())
    for finding in read.findings:
        if not finding.message.strip() or "\n" in finding.message or "Traceback" in finding.message:
            return f"the message {finding.message!r} is no sentence"
    if read.refused:
        return None
    return _wrong_reading(read, parse(mutant.data, mutant.dialect), mutant)


def _wrong_reading(read: ReadFile, parsed: Parsed, mutant: Mutant) -> str | None:
    at = 0
    for part in read.parts:
        found = _wrong_part(part, parsed.rows, at, mutant)
        if isinstance(found, str):
            return found
        at = found
    kept = sum(len(part.time_s) for part in read.parts)
    if kept != read.rows_kept:
        return f"{read.rows_kept} rows are said to be kept and {kept} are there"
    skipped = sum(finding.count for finding in read.findings if finding.rule in SKIPPED)
    lost = len(parsed.rows) + parsed.unreadable - read.rows_read - skipped
    if lost > 0:
        return f"{lost} lines are neither rows nor reported"
    return None


def _wrong_part(part: SignalPart, rows: list[Row], at: int, mutant: Mutant) -> str | int:
    if part.rate_hz is not None and len(part.time_s) > 30 and abs(part.rate_hz / RATE_HZ - 1) > 0.02:
        return f"the rate is {part.rate_hz:.4g} Hz"
    first_s = None
    for sample in range(len(part.time_s)):
        while at < len(rows):
            row = rows[at]
            at += 1
            stamp_s = _time(row, mutant)
            if stamp_s is None or not _same_values(part, sample, row):
                continue
            if first_s is None:
                first_s = stamp_s
            if abs(stamp_s - first_s - part.time_s[sample]) < 1e-6:
                break
        else:
            return f"sample {sample} of {part.part} stands in no line"
    return at


def _time(row: Row, mutant: Mutant) -> float | None:
    name = next((name for name in row.values if name.startswith("time")), None)
    if name is None or unit_of(name) not in SECONDS:
        return None
    return row.values[name] * SECONDS[unit_of(name) or ""]


def _same_values(part: SignalPart, sample: int, row: Row) -> bool:
    for channel in part.channels:
        if not channel.source_name:
            continue  # what stands behind the last delimiter of a line
        if channel.source_name not in row.values:
            return False
        factor = FACTORS.get(unit_of(channel.source_name) or "", 1.0)
        expected, value = row.values[channel.source_name] * factor, float(channel.values[sample])
        if not (math.isclose(expected, value, rel_tol=1e-12) or (math.isnan(expected) and math.isnan(value))):
            return False
    return True


def test_no_mutant_is_read_wrongly() -> None:
    check(range(100))


@pytest.mark.soak
@pytest.mark.parametrize("block", range(30))
def test_none_of_3000_mutants_is_read_wrongly(block: int) -> None:
    check(range(100 * block, 100 * block + 100))


def check(seeds: range) -> None:
    faults = {seed: (mutant.made_by, fault) for seed in seeds if (fault := wrong(mutant := make_mutant(seed)))}
    assert faults == {}
