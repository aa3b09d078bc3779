"""Instants as people at the rig read them: stored in UTC, shown in the time zone of the study."""

from __future__ import annotations

from datetime import datetime
from zoneinfo import ZoneInfo


def local_text(utc: str, time_zone: str) -> str:
    """Write an instant, ISO 8601 in UTC, as a local date and time with the zone's name: 2021-06-14 09:30:00 EDT."""
    return datetime.fromisoformat(utc).astimezone(ZoneInfo(time_zone)).strftime("%Y-%m-%d %H:%M:%S %Z")
