"""What a person types as the new value of a column, read as the column stores it."""

from __future__ import annotations

import datetime
import json
import math
import re
import zoneinfo
from collections.abc import Mapping
from enum import StrEnum
from typing import Any

import sqlalchemy as sa

from data_schema.errors import UsageError, unknown_name
from data_schema.journal import canonical
from data_schema.tables.base import Real
from data_schema.vocabulary import ChargeMode, FactorKind, RunKind, StudyKind

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


def date_value(text: str) -> str:
    """Read the date of a day."""
    try:
        return datetime.date.fromisoformat(text).isoformat()
    except ValueError:
        raise UsageError(f"day={text} is not a date: write it as 2021-06-01.") from None
