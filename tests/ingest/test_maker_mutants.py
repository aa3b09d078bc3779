"""No mutant of a maker's export is read with a wrong value, time, rate, unit or row count: a second reader decides."""

from __future__ import annotations

import math
import random
import re

import pytest

from ingest.model import Declarations, ReadFile, SignalPart
from ingest.read import read_file
from tests.ingest.maker_files import MAKERS, Maker, MakerRow
from tests.ingest.mutants import MUTATIONS, Mutant
from tests.ingest.second_parser import Dialect
from tests.ingest.synthetic import SHEET

OF_ANY_LINE = (
    *("digit", "any byte", "delimiter", "decimal sign", "cut", "line twice", "lines deleted", "lines exchanged"),
    *("NUL", "line ends", "quote", "word", "thousands", "trailing delimiter"),
)
SKIPPED = {"header_repeated", "comment_line", "ctrl_z", "units_repeated", "nul_padding"}
UNITS = {"force": "N", "moment": "N*m", "free_moment": "N*m", "cop": "m"}


def mutant_of(data: bytes, delimiter: str, seed: int, *, quotes: bool = True) -> Mutant:
    """Return a file with one to three mutations, the same for the same number."""
    rng = random.Random(seed)
    mutant = Mutant(data, Dialect(delimiter))
    names = [name for name in OF_ANY_LINE if quotes or name != "quote"]
    for name in rng.choices(names, k=rng.choice((1, 1, 2, 3))):
        mutant = MUTATIONS[name](mutant, rng)
        mutant = Mutant(mutant.data, mutant.dialect, (*mutant.made_by, name))
    return mutant


def lines_of(data: bytes) -> list[str]:
    return re.split("\r\n|\n|\r", data.decode("latin-1"))


def wrong(name: str, maker: Maker, seed: int) -> str | None:
    """Return what is wrong with the reading of a mutant, None where nothing is."""
    good = maker.write()
    # where lines are counted, a cell that goes on over the end of one may count as one or as two
    mutant = mutant_of(good, maker.delimiter, seed, quotes=maker.time is not None)
    read = read_file(mutant.data, Declarations())
    if read.refused or read.format != name:
        return None  # of another format: what its columns are is what they are called, and nothing of the maker's
    lines = lines_of(mutant.data)
    if lines[: maker.head] != lines_of(good)[: maker.head]:
        return None  # what a header says that was changed, it says
    rows: list[tuple[int, MakerRow | None]] = []
    for line in lines[maker.head :]:
        if maker.ends_at(line) and line is not lines[-1]:
            break
        if line.strip(" \t\0\x1a" if maker.time is None else ' ",\t\0\x1a') and line not in lines[: maker.head]:
            rows.append((len(rows), maker.row(line)))
    parts = [part for part in read.parts if maker.part is None or part.part.startswith(maker.part)]
    at = 0
    for part in parts:
        found = wrong_part(part, rows, at, maker)
        if isinstance(found, str):
            return f"{found} ({mutant.made_by})"
        at = found
    return wrong_count(read, rows, maker)


def wrong_part(part: SignalPart, rows: list[tuple[int, MakerRow | None]], at: int, maker: Maker) -> str | int:
    if part.rate_hz is not None and len(part.time_s) > 30 and abs(part.rate_hz / maker.rate_hz - 1) > 0.03:
        return f"the rate is {part.rate_hz:.4g} Hz"
    for channel in part.channels:
        kind = re.sub(r"_[xyz](_\d)?$", "", channel.name)
        if kind in UNITS and channel.unit != UNITS[kind]:
            return f"{channel.name} is in {channel.unit}"
    first: tuple[float, float] | None = None
    for sample in range(len(part.time_s)):
        time_s = float(part.time_s[sample])
        while at < len(rows):
            place, row = rows[at]
            at += 1
            if row is None or not same_values(part, sample, row):
                continue
            stamp_s = place / maker.rate_hz if row.time_s is None else row.time_s
            first = first or (stamp_s, time_s)
            if abs(stamp_s - first[0] - (time_s - first[1])) < 1e-6 + 1e-4 * time_s:
                break
        else:
            return f"sample {sample} of {part.part} stands in no line"
    return at


def same_values(part: SignalPart, sample: int, row: MakerRow) -> bool:
    for channel in part.channels:
        if channel.name == "sequence" and channel.name not in row.values:
            continue  # counted from the frames, which are its time
        if channel.name not in row.values:
            return False
        expected, value = row.values[channel.name], float(channel.values[sample])
        close = math.isclose(expected, value, rel_tol=1e-9, abs_tol=1e-12)
        without_load = math.isnan(value) and channel.name.startswith("cop")
        if not (close or without_load or (math.isnan(expected) and math.isnan(value))):
            return False
    return True


def wrong_count(read: ReadFile, rows: list[tuple[int, MakerRow | None]], maker: Maker) -> str | None:
    kept = sum(len(part.time_s) for part in read.parts)
    if kept != read.rows_kept:
        return f"{read.rows_kept} rows are said to be kept and {kept} are there"
    if maker.part == "devices":
        return None
    skipped = sum(finding.count for finding in read.findings if finding.rule in SKIPPED)
    first = next((place for place, row in rows if row is not None), 0)  # lines without numbers above it are a header's
    lost = len(rows) - first - read.rows_read - skipped
    return f"{lost} lines are neither rows nor reported" if lost > 0 else None


def check(name: str, seeds: range) -> None:
    maker = MAKERS[name]
    assert {seed: fault for seed in seeds if (fault := wrong(name, maker, seed))} == {}


@pytest.mark.parametrize("name", MAKERS)
def test_the_second_reader_agrees_with_the_good_file(name: str) -> None:
    maker = MAKERS[name]
    read = read_file(maker.write(), Declarations())
    assert (read.format, read.refused) == (name, False)
    rows = [maker.row(line) for line in lines_of(maker.write())[maker.head :] if line.strip()]
    part = next(part for part in read.parts if maker.part in (None, part.part))
    there = [row for row in rows if row is not None]
    assert len(there) >= len(part.time_s) == 120
    assert all(same_values(part, sample, there[sample]) for sample in range(120))


@pytest.mark.parametrize("name", MAKERS)
def test_no_mutant_of_a_makers_file_is_read_wrongly(name: str) -> None:
    check(name, range(10))


@pytest.mark.soak
@pytest.mark.parametrize("block", range(5))
@pytest.mark.parametrize("name", MAKERS)
def test_none_of_500_mutants_of_each_makers_file_is_read_wrongly(name: str, block: int) -> None:
    check(name, range(100 * block, 100 * block + 100))


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
    mutant = mutant_of(good, ",", seed)
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


def check_sheets(seeds: range) -> None:
    found = {seed: wrong_sheet(seed) for seed in seeds}
    assert {seed: fault for seed, fault in found.items() if fault not in (None, REFUSED)} == {}
    assert sum(fault is None for fault in found.values()) > 0.7 * len(seeds)


def test_no_mutant_of_a_charger_sheet_is_read_wrongly() -> None:
    check_sheets(range(20))
    assert wrong_sheet(2248) is None  # a Ctrl-Z in place of the first letter of a run's name


@pytest.mark.soak
def test_none_of_3000_mutants_of_a_charger_sheet_is_read_wrongly() -> None:
    check_sheets(range(3000))
