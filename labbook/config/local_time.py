"""Instants as people at the rig read them: stored in UTC, shown in the time zone of the study."""

from __future__ import annotations

from datetime import date, datetime
from zoneinfo import ZoneInfo

from data_schema.errors import UsageError


def local_text(utc: str, time_zone: str) -> str:
    """Write an instant, ISO 8601 in UTC, as a local date and time with the zone's name: 2021-06-14 09:30:00 EDT."""
    return datetime.fromisoformat(utc).astimezone(ZoneInfo(time_zone)).strftime("%Y-%m-%d %H:%M:%S %Z")


def today_in(time_zone: str) -> str:
    """Return the local date of now, as 2021-06-14."""
    return datetime.now(ZoneInfo(time_zone)).date().isoformat()


def day_named(option: str, text: str | None, time_zone: str) -> str:
    """Return the date that an option names, today without one; raises `UsageError` for what is no date."""
    return date_named(option, text) if text else today_in(time_zone)


def date_named(option: str, text: str) -> str:
    """Return the date that an option names; raises `UsageError` for what is none."""
    try:
        return date.fromisoformat(text).isoformat()
    except ValueError:
        raise UsageError(f"{option} {text!r} is not a date: write it as 2021-06-01.") from None
