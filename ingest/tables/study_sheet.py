"""Sheets of studies: columns of quantities with units in their names, and columns of words."""

from __future__ import annotations

import contextlib
import re
from collections.abc import Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass

from data_schema.errors import InputRefused, UsageError
from data_schema.units import conversion
from ingest.tables.long_table import LineRefused, LongTable, decimal_sign, maybe_thousands, numbers_of, read_table

_SPELLINGS = {"m3": "m^3", "cm3": "cm^3", "mm3": "mm^3", "wh": "Wh", "kwh": "kWh", "mah": "mAh", "ah": "Ah"}
"""Units as people write them in a header, in any case."""


@dataclass(frozen=True, slots=True)
class Quantity:
    """A quantity of a sheet: the unit that it is turned into, and what it is, for who has not named a column so.

    One of unit "1" has no unit in its name. `any_sign`: it may be 0 or negative. Below `least` it is of another unit.
    """

    unit: str
    meaning: str
    needed: bool = True
    any_sign: bool = False
    least: float = 0.0


@dataclass(frozen=True, slots=True)
class StudySheet:
    """What a sheet holds: by quantity its values in SI units, by word its cells; all as long as the sheet has rows.

    `lines` are the rows' lines in the file, from 1. A word in other letters (upper case) is the one that came first.
    `repeats` are the lines of rows whose cells are all those of a row before, each after that row's line.
    """

    values: Mapping[str, Sequence[float]]
    words: Mapping[str, Sequence[str]]
    lines: Sequence[int]
    repeats: Sequence[tuple[int, int]]


def read_study_sheet(
    text: str,
    file: str,
    quantities: Mapping[str, Quantity],
    words: Sequence[str],
    example: str,
    decimal: str | None,
    *,
    optional_words: Sequence[str] = (),
) -> StudySheet:
    """Read a sheet whose columns are named as `radius_mm` or `water (ml)`, and `state`; upper case is the same.

    Of the `optional_words`, those are read that the sheet has a column of.

    Raises `InputRefused` for columns that are missing, units of something else, and cells that hold no positive number
    or no word, with the line.
    """
    table = read_table(text, file, f"a header such as {example} and a row for each")
    named = re.compile(
        rf"({'|'.join(quantities)})(?:[ _]volume)?(?:[_ ]([a-z0-9^*/]+)|\s*[(\[]([^)\]]+)[)\]])", re.IGNORECASE
    )
    values: dict[str, list[float]] = {}
    columns: dict[str, str] = {}
    for column in table.columns:
        if (plain := column.lower().replace(" ", "_")) in quantities and quantities[plain].unit == "1":
            columns[plain] = column
            values[plain] = _values(table, column, 1.0, quantities[plain], decimal)
        elif matched := named.fullmatch(column):
            name = matched[1].lower()
            if name in columns:
                raise InputRefused(f"columns {columns[name]!r} and {column!r} of {file} both are {name}: keep one.")
            columns[name] = column
            factor = _factor(matched[2] or matched[3], quantities[name].unit)
            if factor is None:
                raise InputRefused(
                    f"column {column!r} of {file} is in no unit of the {quantities[name].meaning}: name the columns as "
                    f"in {example}."
                )
            values[name] = _values(table, column, factor, quantities[name], decimal)
    for name, quantity in quantities.items():
        if quantity.needed and name not in values:
            with_unit = "" if quantity.unit == "1" else " with its unit"
            raise InputRefused(
                f"{file} has no column of the {quantity.meaning}{with_unit}: name the columns as in {example}."
            )
    _check_decimals(table, list(columns.values()), decimal)
    there = {column.lower() for column in table.columns}
    read = (*words, *(word for word in optional_words if word in there))
    repeats = repeated(zip(*table.columns.values(), strict=True), table.lines)
    return StudySheet(values, {word: _cells(table, word, example) for word in read}, table.lines, repeats)


def repeated(keys: Iterable[Hashable], lines: Sequence[int]) -> list[tuple[int, int]]:
    """Return the lines of keys that came before: the first line of each such key, and that of its repeat."""
    first: dict[Hashable, int] = {}
    found = [(first.setdefault(key, line), line) for key, line in zip(keys, lines, strict=True)]
    return [pair for pair in found if pair[0] != pair[1]]


def _check_decimals(table: LongTable, columns: Sequence[str], declared: str | None) -> None:
    """Refuse points that could be thousands: a sheet read a thousand times off looks like any other."""
    signs = {column: decimal_sign(table.columns[column], column, declared) for column in columns}
    for column in columns:
        cells = table.columns[column]
        unclear = maybe_thousands(cells, table.delimiter, declared)
        if declared is None and "," in signs.values() and signs[column] == ".":
            unclear = unclear or next((cell for cell in cells if "." in cell), None)
        if unclear is not None:
            raise UsageError(
                f"{unclear!r} in column {column!r} of {table.file} could be a decimal or thousands: add --decimal , or "
                "--decimal ."
            )


def _factor(unit: str, target: str) -> float | None:
    """Return what a value in `unit` is multiplied with, None where the unit is of something else."""
    spelt = _SPELLINGS.get(unit.lower(), unit)
    for spelling in (spelt, spelt.lower()):  # MM, Kg
        with contextlib.suppress(InputRefused):
            return conversion(spelling, target)[0]
    return None


def _values(table: LongTable, column: str, factor: float, quantity: Quantity, decimal: str | None) -> list[float]:
    found = []
    for number, line in zip(numbers_of(table, column, "the study", decimal), table.lines, strict=True):
        if number is None or (number <= 0 and not quantity.any_sign):
            kind = "" if quantity.any_sign else "positive "
            raise LineRefused(line, f"line {line} of {table.file} has no {kind}{column}: measure it, or drop the row.")
        if (value := float(number) * factor) < quantity.least and not quantity.any_sign:
            raise LineRefused(
                line,
                f"line {line} of {table.file} has {number} as {column}, less than {quantity.least:g} {quantity.unit}: "
                f"check the unit of the {quantity.meaning}.",
            )
        found.append(value)
    return found


def _cells(table: LongTable, name: str, example: str) -> tuple[str, ...]:
    column = next((column for column in table.columns if column.lower() == name), None)
    if column is None:
        raise InputRefused(f"{table.file} has no column {name!r}: name the columns as in {example}.")
    cells = table.columns[column]
    for cell, line in zip(cells, table.lines, strict=True):
        if not cell:
            raise LineRefused(line, f"line {line} of {table.file} has no {name}: write it, or drop the row.")
    first = {cell.casefold(): cell for cell in reversed(cells)}
    return tuple(first[cell.casefold()] for cell in cells)
