"""What a person types as the new value of a column, read as the column stores it.

Corrections also go in the words of the run sheet: `started=09:20`, `date=2021-06-05`, `jumps=24`, `mah=812`.
"""

from __future__ import annotations

import datetime
import json
import math
import re
import zoneinfo
from collections.abc import Mapping
from enum import StrEnum
from typing import Any
from zoneinfo import ZoneInfo

import sqlalchemy as sa

from data_schema.errors import UsageError, unknown_name
from data_schema.journal import canonical
from data_schema.queries.charges import charges_of_run
from data_schema.queries.runs import RunRow
from data_schema.tables.base import Real
from data_schema.vocabulary import ChargeMode, FactorKind, RunKind, StudyKind
from ingest.tables.sheet import lone_number
from labbook.plan.local_time import SheetQuestion, parse_clock, parse_date, to_utc

_WORDS: Mapping[tuple[str, str], type[StrEnum]] = {
    ("run", "kind"): RunKind,
    ("study", "kind"): StudyKind,
    ("factor", "kind"): FactorKind,
    ("charge", "mode"): ChargeMode,
}


_DIGITS = re.compile(r"[+-]?[0-9]+")
"""A whole number as it is written without a decimal point; read as such, no digit of it is lost."""


def text_value(kind: str, text: str, column: sa.Column[Any]) -> str | None:
    """Read what is stored as text: words of a closed list, time zones and instants are held to what they mean."""
    if not text:
        if column.nullable:
            return None
        raise UsageError(f"{column.name}= is empty: every {kind} needs its {column.name}.")
    words = _WORDS.get((kind, column.name))
    if words is not None and text not in tuple(words):
        raise unknown_name(f"{column.name} of a {kind}", text, words)
    if column.name == "time_zone" and text not in zoneinfo.available_timezones():
        raise unknown_name("time zone", text, zoneinfo.available_timezones())
    if column.name.endswith("_json"):
        return _json(column.name, text)
    return _instant(column.name, text) if column.name.endswith("_utc") else text


def _json(name: str, text: str) -> str:
    try:
        return canonical(json.loads(text))
    except ValueError:
        raise UsageError(f'{name}={text} is not JSON: write it as {name}={{"radius_m":0.038}}.') from None


def _instant(name: str, text: str) -> str:
    try:
        moment = datetime.datetime.fromisoformat(text)
    except ValueError:
        moment = None
    if moment is None or moment.tzinfo is None:
        raise UsageError(f"{name}={text} is no instant: write it with its zone, as 2021-06-01T14:30:00Z.")
    return moment.astimezone(datetime.UTC).isoformat().replace("+00:00", "Z")


def number_value(name: str, text: str, column: sa.Column[Any]) -> float | int:
    """Read a number as its column stores it: whole, or finite."""
    try:
        value = float(text)
    except ValueError:
        raise UsageError(f"{name}={text} is not a number: write it with a decimal point, for example 720.") from None
    if isinstance(column.type, Real):
        if math.isfinite(value):
            return value
    elif value.is_integer():
        whole = int(text) if _DIGITS.fullmatch(text) else int(value)
        if -(2**63) <= whole < 2**63:
            return whole
        raise UsageError(f"{name}={text} cannot be stored: a whole number goes from {-(2**63)} to {2**63 - 1}.")
    raise UsageError(
        f"{name}={text} cannot be stored: {name} is a {'finite' if isinstance(column.type, Real) else 'whole'} number."
    )


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


def text_by_column(kind: str) -> tuple[str, ...]:
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


def resolve_charge(connection: sa.Connection, run: RunRow) -> str:
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
    number = lone_number(text)
    if word == _MINUTES and text:
        if number is None:
            raise UsageError(f"minutes={text} is not a number of minutes: write for example 12 or 12.5.")
        return repr(60.0 * number)
    return text if number is None or "," not in text else repr(number)


def _started(text: str, date: datetime.date, zone: ZoneInfo, fold: str | None) -> str:
    """Return the instant of a time of day; an instant, or nothing, is left as it is."""
    return text if not text or "T" in text else to_utc(date, parse_clock(text), zone, fold)


def _date(text: str) -> datetime.date:
    try:
        return parse_date(text)
    except SheetQuestion as question:
        raise UsageError(f"{question.sentence}: write it as year-month-day, such as 2021-06-01.") from None
