"""No mutant of a good file is read with a wrong value, time, rate, unit or row count: a second reader decides."""

from __future__ import annotations

import math
import random
import re
from collections.abc import Sequence

import pytest

from ingest.model import Declarations, ReadFile, SignalPart
from ingest.read import read_file
from tests.ingest.maker_files import MAKERS, Maker
from tests.ingest.mutants import Mutant, make_mutant, mutated
from tests.ingest.second_parser import Dialect, Row, parse
from tests.ingest.synthetic import SHEET

OF_ANY_LINE = (
    *("digit", "any_byte", "delimiter", "decimal", "cut", "duplicate", "delete", "exchange"),
    *("nul", "line_ends", "quote", "word", "thousands", "trailing"),
)
SKIPPED = {"header_repeated", "comment_line", "ctrl_z", "units_repeated", "nul_padding"}
UNITS = {"force": "N", "moment": "N*m", "free_moment": "N*m", "cop": "m"}
Rows = Sequence[Row | None]


def wrong_parts(parts: Sequence[SignalPart], rows: Rows, rate_hz: float, *, of_maker: bool) -> str | None:
    """Say which sample stands in no line behind that of the sample before it, or which rate is wrong."""
    lines = iter(rows)
    for part in parts:
        if (
            part.rate_hz is not None
            and len(part.time_s) > 30
            and abs(part.rate_hz / rate_hz - 1) > 0.02 + of_maker / 100
        ):
            return f"the rate is {part.rate_hz:.4g} Hz"
        first: tuple[float, float] | None = None
        for sample, time_s in enumerate(part.time_s.tolist()):
            for row in lines:
                if row is None or math.isnan(row.time_s) or not same_values(part, sample, row, of_maker):
                    continue
                first = first or (row.time_s, time_s)
                if abs(row.time_s - first[0] - (time_s - first[1])) < 1e-6 + of_maker * 1e-4 * time_s:
                    break
            else:
                return f"sample {sample} of {part.part} stands in no line"
    return None


def same_values(part: SignalPart, sample: int, row: Row, of_maker: bool) -> bool:
    for channel in part.channels:
        name = channel.name if of_maker else channel.source_name
        if name not in row.values:
            if name in ("", "sequence"):
                continue  # what stands behind the last delimiter of a line, or is counted from frames
            return False
        expected, value = row.values[name], float(channel.values[sample])
        close = math.isclose(expected, value, rel_tol=1e-12, abs_tol=1e-12 * of_maker)
        without_load = math.isnan(value) and name.startswith("cop")
        if not (close or without_load or (math.isnan(expected) and math.isnan(value))):
            return False
    return True


def wrong_count(read: ReadFile, n_lines: int) -> str | None:
    kept = sum(len(part.time_s) for part in read.parts)
    if kept != read.rows_kept:
        return f"{read.rows_kept} rows are said to be kept and {kept} are there"
    skipped = sum(finding.count for finding in read.findings if finding.rule in SKIPPED)
    lost = n_lines - read.rows_read - skipped
    return f"{lost} lines are neither rows nor reported" if lost > 0 else None


def wrong_log(mutant: Mutant) -> str | None:
    """Return what is wrong with the reading of a mutant log, None where nothing is."""
    read = read_file(mutant.data, Declarations())
    for finding in read.findings:
        if not finding.message.strip() or "\n" in finding.message or "Traceback" in finding.message:
            return f"the message {finding.message!r} is no sentence"
    if read.refused:
        return None
    rows = parse(mutant.data, mutant.dialect)
    return wrong_parts(read.parts, rows, 300.0, of_maker=False) or wrong_count(read, len(rows))


SOAKED = [pytest.param(range(at, at + 100), marks=pytest.mark.soak) for at in range(0, 3000, 100)]


@pytest.mark.parametrize("seeds", [range(100), *SOAKED[1:]])
def test_no_mutant_of_a_log_is_read_wrongly(seeds: range) -> None:
    mutants = map(make_mutant, seeds)
    assert [(mutant.made_by, fault) for mutant in mutants if (fault := wrong_log(mutant))] == []


def mutant_of(data: bytes, delimiter: str, seed: int, names: Sequence[str]) -> Mutant:
    return mutated(Mutant(data, Dialect(delimiter)), random.Random(seed), names)


def lines_of(data: bytes) -> list[str]:
    return re.split("\r\n|\n|\r", data.decode("latin-1"))


def wrong(name: str, maker: Maker, seed: int) -> str | None:
    """Return what is wrong with the reading of a mutant of a maker's file, None where nothing is."""
    good = maker.write()
    # where lines are counted, a cell that goes on over the end of one may count as one or as two
    names = [each for each in OF_ANY_LINE if each != "quote" or maker.time is not None]
    mutant = mutant_of(good, maker.delimiter, seed, names)
    read = read_file(mutant.data, Declarations())
    if read.refused or read.format != name:
        return None  # of another format: what its columns are is what they are called, and nothing of the maker's
    lines = lines_of(mutant.data)
    if lines[: maker.head] != lines_of(good)[: maker.head]:
        return None  # what a header says that was changed, it says
    rows: list[Row | None] = []
    for line in lines[maker.head :]:
        if maker.followed_by and line.startswith(maker.followed_by) and line is not lines[-1]:
            break
        if line.strip(" \t\0\x1a" if maker.time is None else ' ",\t\0\x1a') and line not in lines[: maker.head]:
            rows.append(maker.row(line, len(rows)))
    parts = [part for part in read.parts if maker.part is None or part.part.startswith(maker.part)]
    for channel in (channel for part in parts for channel in part.channels):
        kind = re.sub(r"_[xyz](_\d)?$", "", channel.name)
        if kind in UNITS and channel.unit != UNITS[kind]:
            return f"{channel.name} is in {channel.unit}"
    first = next((place for place, row in enumerate(rows) if row), 0)  # lines without numbers above it are a header's
    n_lines = 0 if maker.part == "devices" else len(rows) - first
    fault = wrong_parts(parts, rows, maker.rate_hz, of_maker=True) or wrong_count(read, n_lines)
    return fault and f"{fault} ({mutant.made_by})"


@pytest.mark.parametrize("name", MAKERS)
def test_the_second_reader_agrees_with_the_good_file(name: str) -> None:
    maker = MAKERS[name]
    read = read_file(maker.write(), Declarations())
    assert (read.format, read.refused) == (name, False)
    lines = [line for line in lines_of(maker.write())[maker.head :] if line.strip()]
    rows = [row for place, line in enumerate(lines) if (row := maker.row(line, place)) is not None]
    part = next(part for part in read.parts if maker.part in (None, part.part))
    assert len(rows) >= len(part.time_s) == 120
    assert all(same_values(part, sample, rows[sample], True) for sample in range(120))


@pytest.mark.parametrize("seeds", [range(10), *SOAKED[:5]])
@pytest.mark.parametrize("name", MAKERS)
def test_no_mutant_of_a_makers_file_is_read_wrongly(name: str, seeds: range) -> None:
    assert {seed: fault for seed in seeds if (fault := wrong(name, MAKERS[name], seed))} == {}


REFUSED = "refused"
MINUTES = re.compile(r"\+?(\d+\.?\d*|\.\d+)|(\d+):([0-5]\d)")


def sheet_rows(data: bytes) -> list[tuple[str | None, float, float | None, float | None, str | None]]:
    """The recharges of the sheet as a second reader understands them."""
    found = []
    for line in lines_of(data)[1:]:
        cells = [cell.strip(' \t"') for cell in line.split(",")]
        while len(cells) > 5 and not cells[-1]:
            cells.pop()
        cells += [""] * (5 - len(cells))  # what stands behind the last separator that there is
        if len(cells) != 5 or not re.fullmatch(r"\+?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", cells[1]):
            continue
        minutes = MINUTES.fullmatch(cells[2])
        duration = None
        if minutes is not None:
            duration = 60 * float(minutes[1]) if minutes[1] else 60.0 * int(minutes[2]) + int(minutes[3])
        volts = float(cells[3]) if re.fullmatch(r"\+?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", cells[3]) else None
        found.append((cells[0] or None, float(cells[1]), duration, volts, cells[4] or None))
    return found


def wrong_sheet(seed: int) -> str | None:
    """Return what is wrong with the reading of a mutant sheet, `REFUSED` where none was read."""
    lines = [f"r{n:03},{440 + 7 * n % 50},{12 + n % 3}.5,16.{70 + n % 20},{'AB'[n % 2]}" for n in range(240)]
    good = "\n".join([SHEET.splitlines()[0], *lines, ""]).encode()
    mutant = mutant_of(good, ",", seed, OF_ANY_LINE)
    read = read_file(mutant.data, Declarations())
    if read.refused or read.format != "charger_sheet" or lines_of(mutant.data)[0] != lines_of(good)[0]:
        return REFUSED
    rows = sheet_rows(mutant.data)
    left = iter(rows)
    for charge in read.charges:
        run, pack = (None if text is None else text.strip('"') for text in (charge.stated_run, charge.stated_pack))
        told = (run, charge.charge_mah, charge.duration_s, charge.end_voltage_v, pack)
        if told not in left:
            return f"{told} stands in no line below those before it ({mutant.made_by})"
    if read.rows_read != len(read.charges) + read.rows_rejected:
        return f"{len(read.charges)} of {read.rows_read} rows are read and {read.rows_rejected} rejected"
    lost = len(rows) - len(read.charges) - read.rows_rejected
    return f"{lost} rows are neither read nor rejected ({mutant.made_by})" if lost > 0 else None


@pytest.mark.parametrize("seeds", [range(20), pytest.param(range(3000), marks=pytest.mark.soak)])
def test_no_mutant_of_a_charger_sheet_is_read_wrongly(seeds: range) -> None:
    found = {seed: wrong_sheet(seed) for seed in (*seeds, 2248)}
    assert {seed: fault for seed, fault in found.items() if fault not in (None, REFUSED)} == {}
    assert sum(fault is None for fault in found.values()) > 0.7 * len(seeds)
    assert found[2248] is None  # a Ctrl-Z in place of the first letter of a run's name
