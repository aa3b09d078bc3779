"""What a column of a log or of a charger sheet can be declared as, in a profile or on the command line."""

from __future__ import annotations

import re
from dataclasses import asdict
from typing import Any

from data_schema.calibration import Calibration
from data_schema.errors import InputRefused, UsageError, unknown_name
from data_schema.vocabulary import CHANNELS
from labbook.config.model import CalibrationKeys
from labbook.config.reading import read_model

TIME = "time"
DATE = "date"
"""The column of dates that go with a time column of times of day."""

OWN = "own."
"""Prefix of a name that is no channel: `own.motor_current` is stored as `motor_current`; no result uses it."""
SHEET_COLUMNS = {
    "run": "name of the run that was recharged after",
    "charge": "charge that was put back, in mAh or Ah",
    "duration": "how long the recharge took, in min, s or h",
    "end_voltage": "voltage of the pack in the end, in V",
    "pack": "name of the pack",
    "ended": "when the recharge ended",
    "date": "the day on which it ended, where `ended` is a time of day",
    "mode": "charge or discharge",
}
"""What the columns of a charger sheet can be declared as."""
_WHERE = "`labbook channels` lists all; a quantity of your own is written own.NAME."


def declared_channel(text: str) -> str:
    """Return the channel that a declaration names, `own.` taken off.

    Raises `UnknownName` with the nearest for what is no channel, `UsageError` for an own name that is none.
    """
    from ingest.channels.names import channel_kind  # here, for every command reads a configuration

    if text in (TIME, DATE, *SHEET_COLUMNS):
        return text
    if text.startswith(OWN):
        name = text.removeprefix(OWN)
        if not name.strip() or name == TIME or channel_kind(name) is not None:
            why = f"{name} is a channel, write {name}" if name.strip() else f"write for example {OWN}motor_current"
            raise UsageError(f"{text!r} is no name of your own: {why}.")
        return name
    if channel_kind(text) is None:
        raise unknown_name("channel", text, {TIME: 0, **CHANNELS, **SHEET_COLUMNS}, _WHERE)
    return text


def check_unit(unit: str, channel: str | None) -> None:
    """Raise `UsageError` for a unit that is none, or that `channel` cannot have; without one any unit will do."""
    from data_schema import units
    from ingest.channels.names import COUNTS, channel_kind, factor, is_unit, normal_unit, ticks_per_second
    from ingest.model import FindingCollector

    kind = None if channel is None else channel_kind(channel)
    written = normal_unit(unit) or unit
    if kind is not None and written in COUNTS and CHANNELS[kind].unit != "1":
        stored = CHANNELS[kind].unit
        raise UsageError(
            f"{unit!r} of {channel} needs a calibration: say the unit of the measured value and what a count is, "
            f"`{channel}:{stored},scale=SCALE,offset=OFFSET`, or what it shows at known values, "
            f"`{channel}:{stored},raw=812 3071,value=0.2 0.85`."
        )
    if kind is not None:
        findings = FindingCollector()
        factor(kind, written, CHANNELS[kind].unit, findings)
        if findings.refuse:
            example = CHANNELS[kind].unit
            raise UsageError(f"{unit!r} is no unit of {channel}: give one of its quantity, for example {example!r}.")
        return
    if not is_unit(written) and not units.is_unit(written) and ticks_per_second(written) is None:
        raise UsageError(f"{unit!r} is no unit: give one such as ms, mm, m/s, N, V or 1 for none.")


def calibration_in(text: str, option: str) -> Calibration | None:
    """Read `scale=0.29,offset=-4.7,source=ruler` or `raw=812 3071,value=0.2 0.85,se=0.001`; None for no text.

    Raises `UsageError` for what is none of that.
    """
    keys: dict[str, Any] = {}
    for part in filter(None, map(str.strip, text.split(","))):
        key, _equals, value = map(str.strip, part.partition("="))
        if key in keys:
            raise UsageError(f"{option} gives {key} twice: leave one of the two out.")
        keys[key] = [_number(each) for each in value.split()] if key in ("raw", "value", "height") else _number(value)
    faults: list[str] = []
    found = read_model(CalibrationKeys, keys, faults)
    if found is None:
        raise UsageError(f"{option}: {' '.join(faults)}")
    try:
        return found.calibration()
    except InputRefused as error:
        raise UsageError(f"{option}: {error}") from error


def _number(text: str) -> float | str:
    try:
        return float(text)
    except ValueError:
        return text


_COLUMN = re.compile(r"(.+?)=\s*([\w.]+)\s*(?::([^,]*))?((?:,\s*\w+\s*=[^,]*)*)")


def declared_column(text: str) -> tuple[str, dict[str, Any]]:
    """Return the column that `NAME=CHANNEL[:UNIT][,KEY=VALUE...]` names, and what it declares of it."""
    found = _COLUMN.fullmatch(text.strip())
    if found is None:
        name, channel = name_and_value("--column", text, "COLUMN=CHANNEL:UNIT")
        channel, unit, rest = *channel.partition(":")[::2], ""
    else:
        name, channel, unit, rest = found[1].strip(), found[2], (found[3] or "").strip(), found[4]
    channel = declared_channel(channel)
    if unit:
        check_unit(unit, channel)
    calibration = calibration_in(rest, f"--column {text!r}")
    if calibration is None:
        return name, {"channel": channel, "unit": unit or None}
    if not unit:
        example = f'--column "{name}={channel}:UNIT{rest}"'
        raise UsageError(f"--column {text!r} has a calibration without a unit: give that of its value, `{example}`.")
    return name, {"channel": channel, "unit": unit, "calibrations": [asdict(calibration)]}


def name_and_value(option: str, text: str, form: str) -> tuple[str, str]:
    """Return both sides of an option's last `=`; raises `UsageError` where one says nothing."""
    name, equals, value = text.rpartition("=")
    if not equals or not name.strip() or not value.strip():
        raise UsageError(f'{option} {text!r} says nothing: write {option} "{form}".')
    return name.strip(), value.strip()
