"""Corrections in the words of the run sheet: `started=09:20`, `date=2021-06-05`, `jumps=24`, `mah=812`."""

from __future__ import annotations

import datetime
from collections.abc import Mapping
from zoneinfo import ZoneInfo

import sqlalchemy as sa

from data_schema.errors import UsageError
from data_schema.queries.charges import charges_of_run
from data_schema.queries.runs import RunRow
from labbook.plan.sheet_cells import as_float
from labbook.plan.sheet_times import SheetQuestion, date_reader, read_clock, to_utc

MAH = "mah"
"""Of a run it is the charge of its only recharge."""
_DATE, _STARTED, _MINUTES = "date", "started", "minutes"
_COLUMNS: Mapping[str, Mapping[str, str]] = {
    "run": {
        "run": "name",
        _DATE: "day",
        "position": "position_in_day",
        _STARTED: "started_utc",
        _MINUTES: "duration_s",
        "jumps": "jumps_made",
    },
    "charge": {MAH: "charge_mah", _MINUTES: "duration_s"},
}
"""The column that a word of the sheets stands for."""


def words_of(kind: str) -> tuple[str, ...]:
    """Return the words that a correction of this kind of row takes beside its columns' own names."""
    return (*_COLUMNS.get(kind, {}), *((MAH,) if kind == "run" else ()))


def in_columns(
    kind: str, given: Mapping[str, str], run: RunRow | None, zone: ZoneInfo, fold: str | None
) -> dict[str, str]:
    """Return what was given by column; a new date takes the time of day of the start along.

    Raises `UsageError` where a word and its column are both given, `SheetQuestion` for a time with two readings.
    """
    columns = _COLUMNS.get(kind, {})
    texts: dict[str, str] = {}
    for word, text in given.items():
        column = columns.get(word, word)
        if column in texts:
            raise UsageError(f"{column} is given twice, also as {word}: leave one of the two out.")
        texts[column] = _text(word, text) if word in columns else text
    if run is None:
        return texts
    date = _date(texts["day"]) if _DATE in given else None
    if _STARTED in given:
        texts["started_utc"] = _started(given[_STARTED], _date(texts.get("day", run.day)), zone, fold)
    elif date is not None and run.started_utc is not None and "started_utc" not in texts:
        clock = datetime.datetime.fromisoformat(run.started_utc).astimezone(zone).time()
        texts["started_utc"] = to_utc(date, clock, zone, fold)
    return texts


def charge_meant(connection: sa.Connection, run: RunRow) -> str:
    """Return the uid of the only charge of a run; raises `UsageError` where it has none, or several."""
    uids = [charge.uid for charge in charges_of_run(connection, run.uid)]
    if not uids:
        raise UsageError(f"run {run.name} has no charge to correct: state it with `labbook charge {run.name} MAH`.")
    if len(uids) > 1:
        listed = ", ".join(f"charge:{uid}" for uid in uids)
        raise UsageError(f"run {run.name} has {len(uids)} charges: correct one of {listed}.")
    return uids[0]


def _text(word: str, text: str) -> str:
    """Return a value as its column takes it: a date as ISO, a number with a decimal point, minutes in seconds."""
    if word == _DATE:
        return _date(text).isoformat()
    number = as_float(text)
    if word == _MINUTES and text:
        if number is None:
            raise UsageError(f"minutes={text} is not a number of minutes: write for example 12 or 12.5.")
        return repr(60.0 * number)
    return text if number is None or "," not in text else repr(number)


def _started(text: str, date: datetime.date, zone: ZoneInfo, fold: str | None) -> str:
    """Return the instant of a time of day; an instant, or nothing, is left as it is."""
    return text if not text or "T" in text else to_utc(date, read_clock(text), zone, fold)


def _date(text: str) -> datetime.date:
    try:
        return date_reader()(text)
    except SheetQuestion as question:
        raise UsageError(f"{question.sentence}: write it as year-month-day, such as 2021-06-01.") from None
