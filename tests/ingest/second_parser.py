"""A second reading of delimited logs, in plain Python, that shares no code with `ingest`: it decides about mutants.

It is told how a file is written (delimiter, decimal sign) and reads every line strictly; a line that it cannot read is
one that no reader may take for a row of numbers.
"""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Mapping
from dataclasses import dataclass

FACTORS = {"m": 1.0, "cm": 0.01, "mm": 0.001, "m/s": 1.0, "V": 1.0, "mV": 0.001, "N": 1.0, "kN": 1000.0}
"""From a header's unit to the stored one."""
SECONDS = {"s": 1.0, "ms": 1e-3, "us": 1e-6}
NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)
MISSING = {"", "nan", "n/a", "na", "-", "--", "null", "none", "#n/a"}


@dataclass(frozen=True)
class Dialect:
    """How the cells of a file are written."""

    delimiter: str = ","
    decimal: str = "."


@dataclass(frozen=True)
class Row:
    """A line that could be read: its time, NaN where it has none, and the values of its channels, in stored units."""

    time_s: float
    values: Mapping[str, float]


def parse(data: bytes, dialect: Dialect, time_word: str = "time") -> list[Row | None]:
    """Read the lines below the first with `time_word` in it that are neither blank nor a header; None is no row.

    Channels are called as the header that holds for their row calls them.
    """
    text = data.removeprefix(b"\xef\xbb\xbf").decode("latin-1")
    names: list[str] = []
    unnamed = False
    rows: list[Row | None] = []
    for line in re.split("\r\n|\n|\r", text):
        bare = line.strip(" \t\0\x1a")
        if not bare or (bare.startswith(("#", "%", "//")) and time_word not in bare):
            continue
        cells = _cells(line, dialect)
        if cells is not None and any(time_word in cell for cell in cells):
            names = [cell.lstrip("#% ").replace("\0", "") for cell in cells]
            unnamed = not names[-1]
            names = names[:-1] if unnamed else names
        elif names:
            values = None if cells is None or "\0" in line else _values(cells, len(names), dialect, unnamed)
            rows.append(None if values is None else _row(names, values, time_word))
    return rows


def _row(names: list[str], values: list[float], time_word: str) -> Row:
    written = dict(zip(names, values, strict=True))
    time = next((name for name in written if name.startswith(time_word)), "")
    stored = {name: value * FACTORS.get(unit_of(name) or "", 1.0) for name, value in written.items()}
    return Row(written.get(time, math.nan) * SECONDS.get(unit_of(time) or "", math.nan), stored)


def unit_of(name: str) -> str | None:
    """Return the unit in the brackets of a column's name."""
    found = re.search(r"\[(.*)\]", name)
    return found[1] if found else None


def _cells(line: str, dialect: Dialect) -> list[str] | None:
    if line.count('"') % 2:
        return None
    try:
        (cells,) = csv.reader([line], delimiter=dialect.delimiter, skipinitialspace=True, strict=True)
    except (csv.Error, ValueError):
        return None
    return [cell.strip(" \t") for cell in cells]


def _values(cells: list[str], width: int, dialect: Dialect, unnamed: bool) -> list[float] | None:
    if len(cells) == width + 1 and (unnamed or not cells[-1]):
        cells = cells[:-1]
    if len(cells) != width:
        return None
    values = [_number(cell, dialect.decimal) for cell in cells]
    return [value for value in values if value is not None] if None not in values else None


def _number(cell: str, decimal: str) -> float | None:
    if cell.lower() in MISSING:
        return math.nan
    if decimal == ",":
        if "." in cell:
            return None
        cell = cell.replace(",", ".")
    if not NUMBER.fullmatch(cell):
        return None
    value = float(cell)
    return None if math.isinf(value) else value
