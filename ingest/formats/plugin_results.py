"""Checks of what a plug-in returns, before anything uses it.

A value that would fail in the database or a later step is reported here, where it is known whose format it comes from.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from datetime import datetime

import numpy as np

from data_schema.vocabulary import FileRole
from ingest.findings import FindingCollector
from ingest.formats.chargers.sheet_columns import LIMITS, STORED_UNIT
from ingest.formats.format import SIGNATURE, Format, Recognition
from ingest.model import ChargeRow, Reading, SignalPart

_NAME = re.compile(r"[A-Za-z0-9][\w.-]{0,63}")
_LARGEST_VERSION = 10**6


def check_format(found: Format) -> None:
    """Raise `TypeError` or `ValueError` unless a format can be registered."""
    if not isinstance(found.name, str) or not _NAME.fullmatch(found.name):
        raise ValueError(f"its name {found.name!r} is not made of letters, digits and _")
    if not isinstance(found.version, int) or not 1 <= found.version <= _LARGEST_VERSION:
        raise ValueError(f"its version {found.version} is not from 1 to {_LARGEST_VERSION}")
    if any(not clue or clue != clue.lower() or b"\0" in clue for clue in found.clues):
        raise ValueError("its clues are not in lower case, or empty, or hold a zero byte")
    for name in ("recognise", "read"):
        if not callable(getattr(found, name)):
            raise TypeError(f"its {name} is no function")


def check_recognition(found: Recognition | None) -> None:
    """Raise `TypeError` or `ValueError` unless a recognition can be weighed against those of other formats."""
    if found is not None and not isinstance(found, Recognition):
        raise TypeError(f"what recognise gave is {type(found).__name__}, not a Recognition or None")
    if found is not None and not 1 <= found.score <= SIGNATURE:
        raise ValueError(f"its score {found.score} is not from 1 to {SIGNATURE}, of a signature")


def check_reading(found: Reading, findings: FindingCollector) -> None:
    """Raise `TypeError` or `ValueError` unless a reading can be stored, or its findings refuse the file."""
    if not isinstance(found, Reading) or not all(isinstance(part, SignalPart) for part in found.parts):
        raise TypeError(f"it gave {type(found).__name__}, not a Reading with parts of signals")
    if not 0 <= found.rows_rejected <= found.rows_read:
        raise ValueError(f"{found.rows_rejected} of {found.rows_read} rows are rejected")
    if findings.refuse:
        return
    if not found.parts and not found.charges:
        raise ValueError("it gave neither samples nor recharges, and no finding that refuses the file")
    if not isinstance(found.role, FileRole):
        raise TypeError(f"the reading's role {found.role!r} is none")
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
    arrays = [part.time_s, *(channel.values for channel in part.channels)]
    if not all(isinstance(array, np.ndarray) and array.dtype == np.float64 and array.ndim == 1 for array in arrays):
        raise TypeError(f"{where} holds other than arrays of float64 in one dimension")
    if not part.time_s.size:
        raise ValueError(f"{where} has no sample")
    if not np.isfinite(part.time_s).all() or (np.diff(part.time_s) <= 0).any():
        raise ValueError(f"the times of {where} do not increase")
    if part.rate_hz is not None and not part.rate_hz > 0:
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
    if len(set(names)) < len(names) or not all(isinstance(name, str) and name for name in names):
        raise ValueError(f"the names of the {what} are not all different, or one is empty")
