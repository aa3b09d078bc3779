"""Stating that a check of a day was made, one of those that `[protocol] checks` lists."""

from __future__ import annotations

import math

from data_schema.errors import UsageError, unknown_name
from labbook.book.naming import ensure_day, study_of
from labbook.book.write_session import WriteSession
from labbook.config.local_time import day_named
from labbook.config.model import Configuration


def state_check(
    session: WriteSession,
    configuration: Configuration,
    kind: str,
    value: float | None,
    unit: str | None,
    passed: bool,
    day: str | None,
) -> str:
    """State that a check of `[protocol] checks` was made on a day (default: today in the study's time zone).

    Returns the date. Raises `UsageError` for a check that is not listed, a value or a date that is none.
    """
    listed = configuration.protocol.checks
    if kind not in listed:
        remedy = 'A day\'s checks are those that labbook.toml lists under [protocol], as checks = ["rail_angle"].'
        raise unknown_name("check", kind, listed, remedy)
    if value is not None and not math.isfinite(value):
        raise UsageError(f"--value {value} is not a measurement: give a finite number.")
    date = day_named("--day", day, configuration.study.time_zone)
    day_uid = ensure_day(session, study_of(session.connection).uid, date)
    session.declare("day_check", day=day_uid, kind=kind, value=value, unit=unit, passed=int(passed))
    return date
