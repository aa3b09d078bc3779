"""What a declared column may hold: a channel, time, a part of a charger sheet, or one's own quantity; and its unit."""

from __future__ import annotations

from data_schema.errors import UsageError, unknown_name
from data_schema.vocabulary import CHANNELS

TIME = "time"
DATE = "date"
"""The column of dates that go with a time column of times of day."""

OWN = "own."
"""Before a name that is no channel: `own.motor_current` is kept as `motor_current` and feeds no result."""
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


def channel_meant(text: str) -> str:
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
    from ingest.channels.names import channel_kind, factor, is_unit, normal_unit
    from ingest.findings import FindingCollector

    kind = None if channel is None else channel_kind(channel)
    written = normal_unit(unit) or unit
    if kind is not None:
        findings = FindingCollector()
        factor(kind, written, CHANNELS[kind].unit, findings)
        if findings.refuse:
            example = CHANNELS[kind].unit
            raise UsageError(f"{unit!r} is no unit of {channel}: give one of its quantity, for example {example!r}.")
        return
    if not is_unit(written) and not units.is_unit(written):
        raise UsageError(f"{unit!r} is no unit: give one such as ms, mm, m/s, N, V or 1 for none.")
