"""A table as CSV: full precision, stored units, safe to open in a spreadsheet."""

from __future__ import annotations

import csv
import io

from data_schema.vocabulary import Undefined
from reports.display import NO_BREAK
from reports.tables.table import Raw, Table

_FORMULA_STARTS = ("=", "+", "-", "@", "\t", "\n")


def csv_bytes(table: Table) -> bytes:
    """Write a table as CSV (UTF-8, comma, LF, one line of names): floats as their shortest exact text.

    A number that does not exist is an empty field, its reason stands in the last column `undefined`. Text that a
    spreadsheet would run as a formula gets an apostrophe in front; no-break spaces become spaces, line ends LF.
    """
    names = [name for column in table.columns for name in column.fields]
    with_block = any(row.block for row in table.rows)
    rows = [[value for cell in row.cells for value in cell.values] for row in table.rows]
    reasons = [_reasons(names, values) for values in rows]
    with_reasons = any(reasons)
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(["block"] * with_block + names + ["undefined"] * with_reasons)
    for row, values, reason in zip(table.rows, rows, reasons, strict=True):
        line = [row.block] * with_block + values + [reason] * with_reasons
        writer.writerow([_field(value) for value in line])
    return stream.getvalue().encode("utf-8")


def _reasons(names: list[str], values: list[Raw]) -> str:
    return "; ".join(f"{n}: {v.reason}" for n, v in zip(names, values, strict=True) if isinstance(v, Undefined))


def _field(value: Raw) -> str:
    if type(value) is float:
        return repr(value)
    if type(value) is str and value.isalnum():
        return value
    match value:
        case None | Undefined():
            return ""
        case str():
            text = value.replace(NO_BREAK, " ").replace("\r\n", "\n").replace("\r", "\n")
            return f"'{text}" if text.startswith(_FORMULA_STARTS) else text
        case int():
            return str(int(value))
        case _:
            return repr(float(value))  # a numpy float would give its type's name
