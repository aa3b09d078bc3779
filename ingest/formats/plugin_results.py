"""Checks of what a plug-in returns, before anything uses it: the type of every field, then the values.

A value that would fail in the database or a later step is reported here, where it is known whose format it comes from.
"""

from __future__ import annotations

import dataclasses
import re
import types
import typing
from collections.abc import Mapping, Sequence
from datetime import datetime

import numpy as np

from ingest.findings import FindingCollector
from ingest.formats.chargers.sheet_columns import LIMITS, STORED_UNIT
from ingest.formats.format import SIGNATURE, Clue, Format, Recognition
from ingest.model import ChargeRow, Finding, Reading, SignalPart

_NAME = re.compile(r"[A-Za-z0-9][\w.-]{0,63}")
_LARGEST_VERSION = 10**6


def check_format(found: Format) -> None:
    """Raise `TypeError` or `ValueError` unless a format can be registered."""
    _check_type(found.name, str, "its name")
    if not _NAME.fullmatch(found.name):
        raise ValueError(f"its name {found.name!r} is not made of letters, digits and _")
    _check_type(found.version, int, "its version")
    if not 1 <= found.version <= _LARGEST_VERSION:
        raise ValueError(f"its version {found.version} is not from 1 to {_LARGEST_VERSION}")
    _check_type(found.what, str | None, "its what")
    _check_type(found.clue, Clue | None, "its clue")
    if found.clue is not None:
        _check_clue(found.clue)
    for name in ("recognise", "read"):
        if not callable(getattr(found, name)):
            raise TypeError(f"its {name} is no function")


def _check_clue(clue: Clue) -> None:
    if any(not words or words != words.lower() or b"\0" in words for words in clue.says):
        raise ValueError("the words of its clue are not in lower case, or empty, or hold a zero byte")
    if clue == Clue() or not all(clue.begins):
        raise ValueError("its clue says nothing that a file can be known by")


def check_recognition(found: Recognition | None) -> None:
    """Raise `TypeError` or `ValueError` unless a recognition can be weighed against those of other formats."""
    _check_type(found, Recognition | None, "what recognise gave")
    if found is not None and not 1 <= found.score <= SIGNATURE:
        raise ValueError(f"its score {found.score} is not from 1 to {SIGNATURE}, of a signature")


def check_reading(found: Reading, findings: FindingCollector) -> None:
    """Raise `TypeError` or `ValueError` unless a reading can be stored, or its findings refuse the file."""
    _check_type(found, Reading, "what read gave")
    for finding in findings.findings():
        _check_type(finding, Finding, "a finding")
    if not 0 <= found.rows_rejected <= found.rows_read:
        raise ValueError(f"{found.rows_rejected} of {found.rows_read} rows are rejected")
    if findings.refuse:
        return
    if not found.parts and not found.charges:
        raise ValueError("it gave neither samples nor recharges, and no finding that refuses the file")
    if found.role is None:
        raise ValueError("the reading has no role")
    _check_different([part.part for part in found.parts], "parts")
    for part in found.parts:
        _check_part(part)
    for place, charge in enumerate(found.charges, start=1):
        if charge.row_number != place:
            raise ValueError(f"recharge {place} has row_number {charge.row_number}: they count from 1, in order")
        _check_charge(charge)


def _check_charge(charge: ChargeRow) -> None:
    where = f"recharge {charge.row_number}"
    if charge.resolution_mah <= 0:
        raise ValueError(f"resolution_mah of {where} is {charge.resolution_mah:g}, not above 0")
    if charge.duration_s == 0:
        raise ValueError(f"duration_s of {where} is 0: say None where it is not known")
    amounts = {"charge": charge.charge_mah, "duration": charge.duration_s, "end_voltage": charge.end_voltage_v}
    for role, value in amounts.items():
        low, high = LIMITS[role]
        if value is not None and not low <= value <= high:
            raise ValueError(f"{role} of {where} is {value:g} {STORED_UNIT[role]}, not from {low:g} to {high:g}")
    _check_instant(charge.ended_utc)


def _check_part(part: SignalPart) -> None:
    where = f"part {part.part!r}"
    if not part.time_s.size:
        raise ValueError(f"{where} has no sample")
    if not np.isfinite(part.time_s).all() or (np.diff(part.time_s) <= 0).any():
        raise ValueError(f"the times of {where} do not increase")
    if part.rate_hz is not None and part.rate_hz <= 0:
        raise ValueError(f"the rate of {where} is {part.rate_hz}")
    _check_instant(part.start_utc)
    _check_different([channel.name for channel in part.channels], f"channels of {where}")
    for channel in part.channels:
        if channel.values.shape != part.time_s.shape or np.isinf(channel.values).any():
            raise ValueError(f"channel {channel.name!r} of {where} is not one finite number or NaN for each time")
        if channel.sign not in (-1, 1):
            raise ValueError(f"the sign of channel {channel.name!r} is {channel.sign}")
    if any(gap.length_s <= 0 for gap in part.gaps):
        raise ValueError(f"a gap of {where} has no length")


def _check_instant(instant: str | None) -> None:
    if instant is not None and (datetime.fromisoformat(instant).tzinfo is None or not instant.endswith("Z")):
        raise ValueError(f"{instant!r} is no instant of ISO-8601 with Z")


def _check_different(names: Sequence[object], what: str) -> None:
    if len(set(names)) < len(names) or "" in names:
        raise ValueError(f"the names of the {what} are not all different, or one is empty")


def _check_type(value: object, hint: object, where: str) -> None:
    """Raise `TypeError` unless a value has the type, and each field of a dataclass the type that it is declared with.

    A number of type float has to be finite; an array has to hold float64 in one dimension, as all of the model do.
    """
    origin, inner = typing.get_origin(hint), typing.get_args(hint)
    if origin in (typing.Union, types.UnionType):
        if value is not None or type(None) not in inner:
            _check_type(value, next(part for part in inner if part is not type(None)), where)
        return
    expected = typing.cast(type, origin or hint)
    kinds = (int, float) if hint is float else expected
    right = isinstance(value, kinds) and (hint is bool or not isinstance(value, bool))
    if isinstance(value, np.ndarray):
        right = right and value.dtype == np.float64 and value.ndim == 1
    elif hint is float:
        right = right and bool(np.isfinite(typing.cast(float, value)))
    if not right:
        given = f"{str(value)[:40]!r} of type {type(value).__name__}"
        raise TypeError(f"{where} is {given}, not what {expected.__name__} stands for there")
    if dataclasses.is_dataclass(value):
        for name, field in typing.get_type_hints(type(value)).items():
            _check_type(getattr(value, name), field, f"{type(value).__name__}.{name}")
    elif origin is tuple:
        for item in typing.cast(tuple[object, ...], value):
            _check_type(item, inner[0], where)
    elif isinstance(value, Mapping):
        for item in value.values():
            _check_type(item, inner[1], where)
