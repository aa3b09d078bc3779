"""`[profiles.NAME]`: how files of one logger, charger or instrument are read, where they do not say it.

A declared column holds a channel, time, a part of a charger sheet, or one's own quantity, in its unit.
"""

from __future__ import annotations

from typing import Any

from data_schema.errors import UsageError, unknown_name
from data_schema.vocabulary import CHANNELS
from labbook.config.calibrations import read_calibrations
from labbook.config.model import ProfileColumn, ProfileSettings
from labbook.config.tables import TableReader, is_plain

_MOST_PROFILES = 200
_MOST_NAMES = 64
LONGEST_TEXT = 200
_LAST_HEADER_ROW = 400
"""Lines of a file in which a header is looked for."""

_NOT_DELIMITERS = frozenset("\"'.+-\r\n")


def read_profiles(top: TableReader, *, in_force: bool) -> dict[str, ProfileSettings]:
    """Read all profiles; of those `in_force` already, channels and units that would be refused now stand."""
    profiles = {name: _profile(table, in_force) for name, table in top.tables("profiles")}
    if len(profiles) > _MOST_PROFILES:
        top.fault("profiles", f"there are {len(profiles)}, more than {_MOST_PROFILES}: remove those no longer used.")
    return profiles


def _profile(table: TableReader, in_force: bool) -> ProfileSettings:
    recognise = table.items("recognise", "column names")
    files = _text(table, "files")
    if files is None and not recognise:
        table.fault("recognise", "names no column: list one or more that only this logger has, or give `files`.")
    elif not all(isinstance(name, str) and is_plain(name) for name in recognise) or len(recognise) > _MOST_NAMES:
        table.fault("recognise", f"{recognise!r} are no column names: list one or more that only this logger has.")
    settings = {
        "rate_hz": table.optional_number("rate_hz", above=0.0),
        **_time(table, in_force),
        "encoding": _encoding(table),
        "delimiter": _delimiter(table),
        "decimal_sign": _one_of(table, "decimal", (".", ",")),
        "header_row": _row(table, "header_row", least=0),
        "units_row": _row(table, "units_row", least=1),
        "first_row": _row(table, "first_row", least=1),
        "comment": _text(table, "comment"),
        "footer": _text(table, "footer"),
        **_words(table),
        "trials": _text(table, "trials"),
        "format": _text(table, "format"),
        "instrument": _text(table, "instrument"),
        **{key: table.flag(key, False) or None for key in ("override_units", "complete", "no_robot_check")},
    }
    columns = {name: _column(below, in_force) for name, below in table.tables("columns", text_key="channel")}
    channels = [column.channel for column in columns.values() if column.channel]
    for channel in sorted({channel for channel in channels if channels.count(channel) > 1}):
        table.fault("columns", f"{channel!r} is the channel of several columns: name each channel once.")
    table.finish()
    given = {name: value for name, value in settings.items() if value is not None}
    return ProfileSettings(tuple(recognise), files, columns, given)


def _time(table: TableReader, in_force: bool) -> dict[str, Any]:
    if table.value("time") is None:
        return {}
    if table.value("rate_hz") is not None:
        table.fault("rate_hz", "stands beside a time column: leave one of the two out.")
    below = table.table("time")
    unit = below.optional_text("unit")
    try:
        if unit and not in_force:
            check_unit(unit, None)
    except UsageError as error:
        below.fault("unit", str(error))
    options = {
        "time_column": below.text("column"),
        "time_unit": unit,
        "date_column": below.optional_text("date_column"),
    }
    below.finish()
    return options


def _words(table: TableReader) -> dict[str, str | None]:
    """Read the keys whose words the readers define; their modules are loaded only where such a key stands."""
    words: dict[str, str | None] = {}
    if table.value("date") is not None or table.value("clock") is not None:
        from ingest.timebase.clock_formats import CLOCK_FORMATS, DATE_FORMATS

        words["date_format"] = _one_of(table, "date", DATE_FORMATS)
        words["clock_format"] = _one_of(table, "clock", CLOCK_FORMATS)
    if table.value("axes") is not None:
        from ingest.channels.forces import AXES

        words["axes"] = _one_of(table, "axes", AXES)
    return words


def _column(table: TableReader, in_force: bool) -> ProfileColumn:
    sign = table.optional_number("sign")
    if sign is not None and abs(sign) != 1.0:
        table.fault("sign", f"{sign:g} is no sign: write 1, or -1 to turn the column round.")
    channel, unit = table.optional_text("channel"), table.optional_text("unit")
    key = "channel"
    try:
        channel = declared_channel(channel) if channel else channel
        key = "unit"
        if unit and not in_force:
            check_unit(unit, channel)
    except UsageError as error:
        if not in_force:
            table.fault(key, str(error))
    calibrations = read_calibrations(table)
    if calibrations and unit is None:
        table.fault("unit", "is missing: give the unit of the calibrated value.")
    table.finish()
    return ProfileColumn(channel, unit, None if sign is None else -1 if sign < 0 else 1, calibrations)


def _text(table: TableReader, key: str) -> str | None:
    text = table.optional_text(key)
    if text is not None and len(text) > LONGEST_TEXT:
        table.fault(key, f"has {len(text)} letters, more than {LONGEST_TEXT}: shorten it.")
    return text


def _one_of(table: TableReader, key: str, allowed: Any) -> str | None:
    given = table.value(key)
    return None if given is None else table.known(key, given, list(allowed), key)


def _row(table: TableReader, key: str, *, least: int) -> int | None:
    if table.value(key) is None:
        return None
    row = table.whole(key, least=least)
    if row > _LAST_HEADER_ROW:
        table.fault(key, f"{row} is beyond line {_LAST_HEADER_ROW}, up to which a header is looked for: correct it.")
    return row


def _encoding(table: TableReader) -> str | None:
    given = _text(table, "encoding")
    if given is not None:
        try:
            if "a1;".encode(given) != b"a1;":
                table.fault("encoding", f"{given!r} does not hold plain letters as bytes: give one such as cp1252.")
        except (LookupError, UnicodeError):
            table.fault("encoding", f"{given!r} is not known: give for example cp1252 or cp1250.")
    return given


def is_delimiter(sign: object) -> bool:
    """Whether something is a sign that may stand between cells."""
    one_sign = isinstance(sign, str) and len(sign) == 1 and sign.isascii()
    return one_sign and not str(sign).isalnum() and sign not in _NOT_DELIMITERS


def _delimiter(table: TableReader) -> str | None:
    given = table.value("delimiter")
    if given is None:
        return None
    if not is_delimiter(given):
        table.fault("delimiter", f'{given!r} cannot part cells: give one sign such as ";", ",", "|" or "\\t".')
        return None
    return str(given)


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
    from ingest.channels.names import COUNTS, channel_kind, factor, is_unit, normal_unit
    from ingest.findings import FindingCollector
    from ingest.timebase.stamps import ticks_per_second

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
