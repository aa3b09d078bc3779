"""Whether a log begins on the day of its run, and whether its date is yet to come or has day and month exchanged."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from datetime import UTC, date, datetime, time, timedelta
from zoneinfo import ZoneInfo

from data_schema.vocabulary import Severity
from ingest.model import Finding, SignalPart
from ingest.timebase.clock import day_of, parse_stamp

ABOUT_DAY = "log_day_differs"
"""The rule of a log that begins on another day than its run."""
SWAPPED = "day_month_swapped"
"""The rule of dates that are right only with day and month exchanged."""
AHEAD = "date_in_future"
"""The rule of dates that are yet to come."""

_NEAR = timedelta(days=1)
"""A run may go on after midnight, and dates of other time zones differ by a day."""
_ABOUT_MIDNIGHT = timedelta(hours=3)
"""A log that begins so long before or after its run's day, by the clock of the place, may be of that run."""


@dataclass(frozen=True, slots=True)
class DifferingDay:
    """The local date at which a log begins and the other one that its run has; `swapped`: day and month explain it."""

    of_log: date
    of_run: date
    swapped: bool

    def sentence(self, run: str) -> str:
        """Say both dates, and what decides between them."""
        problem = f"the log begins on {self.of_log} and run {run} is of {self.of_run}"
        if self.swapped:
            problem += ", with day and month the other way round (`--dates` says their order)"
        return (
            f"{problem}: if it is another run's, `labbook assign` it to that; if the run's date is wrong, "
            f'`labbook correct {run} date={self.of_log} --why "..."`; if the clock was, leave it'
        )


def differing_day(start_utc: str | None, run_day: str, zone: str | None) -> DifferingDay | None:
    """Return both dates where a log begins on another day than its run, and not about the midnight between the two.

    None where it has no date of its own.
    """
    if start_utc is None or zone is None:
        return None
    begins = datetime.fromisoformat(start_utc).astimezone(ZoneInfo(zone)).replace(tzinfo=None)
    of_run = date.fromisoformat(run_day)
    midnight = datetime.combine(of_run, time())
    if midnight - _ABOUT_MIDNIGHT <= begins <= midnight + timedelta(days=1) + _ABOUT_MIDNIGHT:
        return None
    return DifferingDay(begins.date(), of_run, is_swapped(begins.date(), of_run))


def is_swapped(read_as: date, day: date) -> bool:
    """Tell whether a date is that of a day, or the next one, with day and month exchanged alone."""
    other = day_month_swapped(read_as)
    return other is not None and read_as != other and timedelta(0) <= other - day <= _NEAR < abs(read_as - day)


def day_notes(parts: Iterable[SignalPart], run: str, run_day: str, zone: str | None) -> list[Finding]:
    """Return the finding on the first part that begins on another day than its run; empty where none does."""
    for part in parts:
        other = differing_day(part.start_utc, run_day, zone)
        if other is not None:
            message = other.sentence(run)
            return [_finding(Severity.NOTE, ABOUT_DAY, f"{message[0].upper()}{message[1:]}.", str(other.of_log))]
    return []


def swapped_day(parts: Iterable[SignalPart], run: str, run_day: str, zone: str | None) -> list[Finding]:
    """Return the refusal of the first part whose date `--dates` would make that of its run; empty where none is."""
    for part in parts:
        other = differing_day(part.start_utc, run_day, zone)
        order = other_order(part.start_original or "", other.of_log) if other is not None and other.swapped else None
        if other is None or order is None:
            continue
        message = (
            f"The log's first date, {part.start_original!r}, is read as {other.of_log}, and run {run} is of "
            f"{other.of_run}, which it is with day and month the other way round: say `--dates {order}`, or, if the "
            f'run\'s date is wrong, `labbook correct {run} date={other.of_log} --why "..."` first.'
        )
        return [_finding(Severity.FILE, SWAPPED, message, part.start_original)]
    return []


def is_future(day: date, today_utc: date) -> bool:
    """Tell whether a date lies in the future in every time zone."""
    return day > today_utc + _NEAR


def future_date_sentence(text: str | None, read_as: date, today_utc: date) -> str:
    """Say that the date of a file is yet to come, and what to do; another order of day and month may explain it."""
    order, other = other_order(text or "", read_as), day_month_swapped(read_as)
    problem = f"{text!r} is read as {read_as}, which is yet to come" if text else f"The date {read_as} is yet to come"
    exchanged = order is not None and other is not None and not is_future(other, today_utc)
    remedy = (
        f"say `--dates {order}` if it is {other}, else correct it in the file"
        if exchanged
        else "correct it in the file"
    )
    return f"{problem}: {remedy}; where the instrument's clock is wrong, set that and leave the file."


def future_log(parts: Iterable[SignalPart], zone: str) -> list[Finding]:
    """Return the finding on the first part that begins on a future day; empty where none does."""
    today = datetime.now(UTC).date()
    for part in parts:
        day = part.start_utc and datetime.fromisoformat(part.start_utc).astimezone(ZoneInfo(zone)).date()
        if day and is_future(day, today):
            message = future_date_sentence(part.start_original, day, today)
            return [_finding(Severity.NOTE, AHEAD, message, part.start_original)]
    return []


def day_month_swapped(day: date) -> date | None:
    """Return a date with day and month exchanged, None where there is no such date."""
    try:
        return day.replace(month=day.day, day=day.month)
    except ValueError:
        return None


def other_order(text: str, read_as: date) -> str | None:
    """Return the order of `--dates` that exchanges day and month of a text; None where the year stands first."""
    stamp = parse_stamp(text)
    if stamp is None or stamp.date is None or len(stamp.date[0]) == 4:
        return None
    for order, other in (("m/d/y", "d/m/y"), ("d/m/y", "m/d/y")):
        if day_of(stamp, order) == read_as and day_of(stamp, other) == day_month_swapped(read_as):
            return other
    return None


def _finding(severity: Severity, rule: str, message: str, value: str | None) -> Finding:
    return Finding(severity, rule, message, None, None, value, 1, ())
