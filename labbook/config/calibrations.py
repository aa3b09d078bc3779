"""How a log's column is calibrated: by `scale` and `offset`, or by `raw` numbers at known values; and on which days."""

from __future__ import annotations

import math
from dataclasses import replace
from datetime import date
from typing import Any

from data_schema.calibration import Calibration, line_through
from data_schema.errors import InputRefused, UsageError
from labbook.config.tables import TableReader, as_number

_KEYS = ("scale", "offset", "scale_se", "offset_se", "raw", "value", "height", "se", "source", "from", "until")


def read_calibrations(table: TableReader) -> tuple[Calibration, ...]:
    """Read the calibration in a column's own keys, or those listed under `calibrations`, each for its days."""
    listed = []
    for below in table.list_of_tables("calibrations"):
        found = _read(below)
        if found is None:
            table.fault("calibrations", "holds an empty table: give `scale`, `offset` or `raw` in each.")
        else:
            listed.append(found)
        below.finish()
    own = _read(table)
    if own is not None and listed:
        table.fault("calibrations", "stands beside keys of a calibration: list all of them there.")
    return tuple(listed) if own is None else (own,)


def calibration_in(text: str, option: str) -> Calibration | None:
    """Read `scale=0.29,offset=-4.7,source=ruler` or `raw=812 3071,value=0.2 0.85,se=0.001`; None for no text.

    Raises `UsageError` for what is none of that.
    """
    record: dict[str, Any] = {}
    for part in filter(None, map(str.strip, text.split(","))):
        key, _equals, value = map(str.strip, part.partition("="))
        if key in record:
            raise UsageError(f"{option} gives {key} twice: leave one of the two out.")
        record[key] = [_number(each) for each in value.split()] if key in ("raw", "value", "height") else _number(value)
    faults: list[str] = []
    table = TableReader(record, "", faults)
    found = _read(table)
    table.finish()
    if faults:
        raise UsageError(f"{option}: {' '.join(faults)}")
    return found


def _number(text: str) -> float | str:
    try:
        return float(text)
    except ValueError:
        return text


def _read(table: TableReader) -> Calibration | None:
    if all(table.value(key) is None for key in _KEYS):
        return None
    if table.value("raw") is not None:
        found = _from_points(table)
    else:
        scale, offset = table.number("scale", 1.0), table.number("offset", 0.0)
        if scale == 0:
            table.fault("scale", "0 makes every value the same: give what one raw unit is.")
        for key in ("value", "height", "se"):
            if table.value(key) is not None:
                table.fault(key, "belongs to `raw` numbers, which are not there: give them, or `scale` and `offset`.")
        scale_se, offset_se = (table.optional_number(key, above=0.0) for key in ("scale_se", "offset_se"))
        errors = [*([(scale_se, 0.0)] if scale_se else []), *([(0.0, offset_se)] if offset_se else [])]
        found = Calibration(scale, offset, tuple(errors))
    first_day, last_day = _day(table, "from"), _day(table, "until")
    if first_day is not None and last_day is not None and first_day > last_day:
        table.fault("until", f"{last_day} is before `from`, {first_day}: exchange them.")
    return replace(found, source=table.optional_text("source"), first_day=first_day, last_day=last_day)


def _from_points(table: TableReader) -> Calibration:
    for key in ("scale", "offset", "scale_se", "offset_se"):
        if table.value(key) is not None:
            table.fault(key, "stands beside `raw`, from which it follows: leave one of the two out.")
    value = "height" if table.value("height") is not None else "value"
    raw, known = (_numbers(table, key) for key in ("raw", value))
    try:
        return line_through(raw, known, table.optional_number("se", above=0.0))
    except InputRefused as error:
        table.fault("raw", str(error))
        return Calibration()


def _numbers(table: TableReader, key: str) -> list[float]:
    numbers = [as_number(item) for item in table.items(key, "numbers")]
    if None in numbers:
        table.fault(key, "holds what is no number: write numbers such as [812, 3071].")
    return [math.nan if number is None else number for number in numbers]


def _day(table: TableReader, key: str) -> str | None:
    given = table.value(key)
    if given is None:
        return None
    try:
        return str(given if isinstance(given, date) else date.fromisoformat(str(given)))
    except ValueError:
        table.fault(key, f"{given!r} is no date: write one such as 2024-03-04.")
        return None
