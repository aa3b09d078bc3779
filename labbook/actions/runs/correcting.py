"""What a person states of runs: charges read off a display, checks of a day, what does not count, and corrections.

What a person types as the new value of a column is read as the column stores it. Corrections also go in the words of
the run sheet: `started=09:20`, `date=2021-06-05`, `jumps=24`, `mah=812`. A second charge of one run is refused by one
rule, whatever command gives it.
"""

from __future__ import annotations

import datetime
import json
import math
import re
import shlex
import zoneinfo
from collections.abc import Mapping, Sequence
from decimal import Decimal
from enum import StrEnum
from typing import Any, NamedTuple
from zoneinfo import ZoneInfo

import sqlalchemy as sa

from data_schema.errors import UsageError, unknown_name
from data_schema.journal import canonical
from data_schema.queries.charges import charges_of_run, rows_with_uids
from data_schema.queries.facts import find_uid, read_fact
from data_schema.queries.files import charges_of_file, place_of_charge
from data_schema.queries.runs import RunRow, list_runs
from data_schema.queries.study import factors, planned_runs
from data_schema.tables import FACTS
from data_schema.tables.base import Real
from data_schema.vocabulary import Action, ChargeMode, ChargeState, FactorKind, FileRole, RunKind, RunState, StudyKind
from ingest.tables.sheet import lone_number
from labbook.book.naming import (
    condition_key,
    ensure_condition,
    ensure_day,
    named_uid,
    old_values,
    refuse_empty,
    run_named,
    study_of,
)
from labbook.book.opening import Book
from labbook.book.write_session import Statement, WriteSession
from labbook.config.local_time import date_named, day_named
from labbook.config.parsing import Configuration
from labbook.plan.local_time import SheetQuestion, parse_clock, parse_date, to_utc

_NAMED = ("robot", "battery", "instrument", "factor")
_FIXED = {"id", "uid", "study", "state", "planned_run", "condition", "file", "row_number", "line", "factor", "label"}
_FIXED_OF: Mapping[str, set[str]] = {
    "factor": {"name"},  # it stands in the names of conditions
    "level": {"value"},  # the label holds it
    # what is found, or stated by `labbook assign` and `labbook runs dismiss`
    "charge": {"repeats", "added", "named_run", "assigned", "assigned_run", "dismissed", "corrected"},
}
_NO_LEVELS = "levels"
"""`levels=none` takes a run's levels away."""


def correct(
    book: Book, session: WriteSession, target: str, assignments: Sequence[str], why: str
) -> dict[str, tuple[Any, Any]]:
    """State corrections of one row; returns (old, new) by column.

    Words of the run sheet stand for their columns. The charge of a run is a row of its own, corrected with it.
    """
    refuse_empty("--why", why)
    kind, uid, run = _target(session.connection, target)
    zone = ZoneInfo(study_of(session.connection).time_zone)
    assigned = _assignments(assignments)
    charged = {MAH: assigned.pop(MAH)} if run is not None and MAH in assigned else {}
    given = in_columns(kind, assigned, run, zone)
    new: dict[str, Any] = {}
    levels = dict(run.levels) if run else {}
    for name, text in given.items():
        if run is not None and name in book.configuration.factors:
            levels[name] = _label(book.configuration, name, text)
        elif run is not None and name == _NO_LEVELS:
            if text != "none":
                raise UsageError(
                    f"levels={text} is not understood: write levels=none, or one level a factor, as foot=large."
                )
            levels = {}
        else:
            new |= _column(book, session, kind, name, text)
    if run is not None and levels != dict(run.levels):
        study_uid = study_of(session.connection).uid
        new["condition"] = ensure_condition(session, book.configuration, study_uid, levels) if levels else None
    if run is not None and new.keys() & {"kind", "jumps_made", "condition"}:
        _refuse_contradiction(book.configuration, run, {"kind": run.kind, "jumps_made": run.jumps_made, **new}, levels)
    if run is not None and new.keys() & {"position_in_day", "day"}:
        _refuse_taken_place(session.connection, run, new)
    if run is not None and "name" in new and not run.planned:
        plans = planned_runs(session.connection)  # a run renamed to one that was not made yet is that run
        waiting = (row.uid for row in plans if row.name == new["name"] and row.run_name is None)
        new |= {"planned_run": planned} if (planned := next(waiting, "")) else {}
    done = _state_changes(session, kind, uid, new, why)
    if run is not None and charged:
        ((column, text),) = in_columns("charge", charged, None, zone).items()
        done |= _state_changes(
            session,
            "charge",
            resolve_charge(session.connection, run),
            _column(book, session, "charge", column, text),
            why,
        )
    return done


def _state_changes(
    session: WriteSession, kind: str, uid: str, new: Mapping[str, Any], why: str
) -> dict[str, tuple[Any, Any]]:
    """State those columns of `new` that differ from a row; returns (old, new) by column."""
    old = old_values(session.connection, kind, uid, new) if new else {}
    changed = {name: value for name, value in new.items() if old[name] != value}
    if kind == "charge" and "run" in changed:  # one that was added to the charge of that run is so no longer
        old |= old_values(session.connection, kind, uid, {"added": 0})
        changed |= {"added": 0} if old["added"] else {}
    if kind == "charge" and changed.keys() & {"run", "mode"}:
        charge = {**read_fact(session.connection, "charge", uid, ["run", "mode"]), **changed}
        if charge["run"]:
            name = read_fact(session.connection, "run", charge["run"], ["name"])["name"]
            refuse_second_charge(session.connection, charge["run"], name, charge_uid=uid, mode=charge["mode"])
    before = {name: old[name] for name in changed}
    if changed:
        session.state(Statement(Action.SET, kind, uid, new=changed, old=before, reason=why))
    return {name: (before[name], value) for name, value in changed.items()}


def runs_corrected(connection: sa.Connection, target: str, changed: Mapping[str, tuple[Any, Any]]) -> list[str]:
    """Return the names of the runs that a correction of `target` is about: a run, or the run of a charge."""
    kind, colon, uid = target.partition(":")
    if target == "study" or (colon and kind != "charge"):
        return []
    if not colon:
        return [str(changed["name"][1]) if "name" in changed else target]
    run_uid = read_fact(connection, "charge", uid, ["run"])["run"]
    return [] if run_uid is None else [read_fact(connection, "run", run_uid, ["name"])["name"]]


def known_now(connection: sa.Connection, waiting: Sequence[str]) -> list[str]:
    """Return the names of those rows that waited in the inbox and say now what the charge of their run does."""
    known = [row for row in rows_with_uids(connection, waiting) if row.state is ChargeState.KNOWN]
    return [place_of_charge(connection, row.uid) or row.uid for row in known]


class StateChange(NamedTuple):
    """A change of a run's state in words; `made` is false where the run had that state already."""

    text: str
    made: bool


def void(session: WriteSession, name: str, reason: str) -> StateChange:
    """State that a run does not count; it stays in the book with everything that belongs to it."""
    refuse_empty("--reason", reason)
    run = run_named(session.connection, name)
    if run.state is RunState.VOID:
        journal = f"the journal keeps who said so and why (`labbook show {shlex.quote(name)}`)"
        text = f"run {name} is void already, and {journal}; for another reason, {other_reason(name)}"
        return StateChange(text, made=False)
    session.state(
        Statement(Action.EXCLUDE, "run", run.uid, new={"state": "void"}, old={"state": str(run.state)}, reason=reason)
    )
    return StateChange(f"run {name} is void", made=True)


def other_reason(name: str) -> str:
    """Say how a run that is void becomes so for another reason."""
    command = f"labbook void {shlex.quote(name)}"
    return f"take it back with `{command} --undo --reason ...` and give that with `{command} --reason ...`"


def unvoid(session: WriteSession, name: str, reason: str) -> StateChange:
    """State that a run counts after all; it is complete where its duration is known, open otherwise."""
    refuse_empty("--reason", reason)
    run = run_named(session.connection, name)
    if run.state is not RunState.VOID:
        return StateChange(f"run {name} is not void: there is nothing to take back", made=False)
    state = RunState.OPEN if run.duration_s is None else RunState.COMPLETE
    session.state(
        Statement(Action.INCLUDE, "run", run.uid, new={"state": str(state)}, old={"state": "void"}, reason=reason)
    )
    return StateChange(f"run {name} counts again", made=True)


def _label(configuration: Configuration, factor: str, text: str) -> str:
    """Return the label of the level meant: `100.0` is the level 100. What is no level is refused later."""
    labels = [level.label for level in configuration.factors[factor].levels]
    value = _as_float(text)
    if text in labels or value is None:
        return text
    return next((label for label in labels if _as_float(label) == value), text)


def _as_float(text: str) -> float | None:
    try:
        return float(text)
    except ValueError:
        return None


def _refuse_contradiction(
    configuration: Configuration, run: RunRow, facts: Mapping[str, Any], levels: Mapping[str, str]
) -> None:
    """Raise `UsageError` where a run would be idle and have jumps or levels, or be a run of jumps without levels."""
    if facts["kind"] == RunKind.IDLE:
        has = {
            "jumps_made=0": f"{facts['jumps_made']} jumps made" if facts["jumps_made"] else "",
            f"{_NO_LEVELS}=none": f"levels {condition_key(levels)}" if levels else "",
        }
        odd = {remedy: what for remedy, what in has.items() if what}
        if odd:
            raise UsageError(
                f"run {run.name} would be idle with {' and '.join(odd.values())}, and an idle run has none: give "
                f"{' '.join(odd)} in the same command, or kind=jumps."
            )
    if facts["kind"] == RunKind.JUMPS and configuration.factors and not levels:
        needed = " ".join(f"{name}={factor.levels[0].label}" for name, factor in configuration.factors.items())
        raise UsageError(
            f"run {run.name} would be a run of jumps without levels: give one of each factor in the same command, for "
            f"example {needed}, or kind=idle."
        )


def _refuse_taken_place(connection: sa.Connection, run: RunRow, new: Mapping[str, Any]) -> None:
    """Raise `UsageError` where a day would have two runs in one place: their order would not be known."""
    day = read_fact(connection, "day", new["day"], ["date_local"])["date_local"] if "day" in new else run.day
    position = new.get("position_in_day", run.position_in_day)
    if (day, position) == (run.day, run.position_in_day):
        return
    of_day = {other.position_in_day: other.name for other in list_runs(connection) if other.day == day}
    if position in of_day and of_day[position] != run.name:
        free = max(of_day) + 1
        raise UsageError(
            f"run {of_day[position]} has position_in_day={position} of {day} already: give run {run.name} one that is "
            f"free, for example position_in_day={free}, or move {of_day[position]} there first."
        )


def _assignments(texts: Sequence[str]) -> dict[str, str]:
    given = {}
    for text in texts:
        name, equals, value = text.partition("=")
        if not equals or not name.strip():
            raise UsageError(f"{text!r} is not a correction: write FIELD=VALUE, for example foot=large.")
        given[name.strip()] = value.strip()
    return given


def _target(connection: sa.Connection, target: str) -> tuple[str, str, RunRow | None]:
    kind, colon, name = target.partition(":")
    if target == "study":
        return "study", study_of(connection).uid, None
    if colon and kind in (*_NAMED, "charge"):
        uid = find_uid(connection, kind, **({"uid": name} if kind == "charge" else {"name": name}))
        if uid is None:
            raise UsageError(f"there is no {kind} {name!r}: look it up with `labbook show RUN` or in labbook.toml.")
        return kind, uid, None
    if colon and kind == "level":
        known = {f"{one.name}={level.label}": level.uid for one in factors(connection) for level in one.levels}
        if name not in known:
            raise unknown_name("level", name, known, "Write it as level:FACTOR=LABEL.")
        return "level", known[name], None
    run = run_named(connection, target)
    return "run", run.uid, run


def _column(book: Book, session: WriteSession, kind: str, name: str, text: str) -> dict[str, Any]:
    table = FACTS[kind]
    fixed = _FIXED | _FIXED_OF.get(kind, set())
    allowed = [column.name for column in table.c if column.name not in fixed]
    if name not in allowed:
        of_study = list(book.configuration.factors) if kind == "run" else []
        words = [*_COLUMNS.get(kind, {}), *([MAH] if kind == "run" else [])]
        raise unknown_name(f"field of a {kind}", name, [*of_study, *words, *allowed])
    column = table.c[name]
    if name in ("robot", "battery"):
        known: Mapping[str, Any] = getattr(book.configuration, {"battery": "batteries"}.get(name, f"{name}s"))
        return {name: named_uid(session.connection, name, text, known)}
    if name == "day":
        return {name: ensure_day(session, study_of(session.connection).uid, date_named("day", text))}
    if name == "run":
        return {name: None if text == "none" else run_named(session.connection, text).uid}
    if isinstance(column.type, sa.Text):
        return {name: text_value(kind, text, column)}
    value = number_value(name, text, column)
    if name == "charge_mah" and value < 0:
        raise UsageError(
            f"a charge of {text} mAh is not possible: give 0 or more; `labbook correct charge:ID mode=discharge --why "
            "...` states a discharge, and `labbook show RUN` has the ID."
        )
    return {name: value}


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
        try:
            return canonical(json.loads(text))
        except ValueError:
            raise UsageError(
                f'{column.name}={text} is not JSON: write it as {column.name}={{"radius_m":0.038}}.'
            ) from None
    if not column.name.endswith("_utc"):
        return text
    try:
        moment = datetime.datetime.fromisoformat(text)
    except ValueError:
        moment = None
    if moment is None or moment.tzinfo is None:
        raise UsageError(f"{column.name}={text} is no instant: write it with its zone, as 2021-06-01T14:30:00Z.")
    return moment.astimezone(datetime.UTC).isoformat().replace("+00:00", "Z")


_LARGEST = 1e15
"""Beyond, squares and sums of a report would overflow."""


def number_value(name: str, text: str, column: sa.Column[Any]) -> float | int:
    """Read a number as its column stores it: whole, or finite."""
    try:
        value = float(text)
    except ValueError:
        raise UsageError(f"{name}={text} is not a number: write it with a decimal point, for example 720.") from None
    if isinstance(column.type, Real):
        if abs(value) < _LARGEST:
            return value
        if math.isfinite(value):
            raise UsageError(
                f"{name}={text} is beyond {_LARGEST:g}, as nothing that is measured: check number and unit."
            )
    elif value.is_integer():
        whole = int(text) if _DIGITS.fullmatch(text) else int(value)
        if -(2**63) <= whole < 2**63:
            return whole
        raise UsageError(f"{name}={text} cannot be stored: a whole number goes from {-(2**63)} to {2**63 - 1}.")
    raise UsageError(
        f"{name}={text} cannot be stored: {name} is a {'finite' if isinstance(column.type, Real) else 'whole'} number."
    )


MAH = "mah"
"""Of a run it is the charge of its only recharge."""
_DATE, _STARTED, _MINUTES = "date", "started", "minutes"
_COLUMNS: Mapping[str, Mapping[str, str]] = {
    "run": {
        "run": "name",
        _DATE: "day",
        "position": "position_in_day",
        _STARTED: "started_utc",
        _MINUTES: "duration_s",
        "jumps": "jumps_made",
    },
    "charge": {MAH: "charge_mah", _MINUTES: "duration_s"},
}
"""The column that a word of the sheets stands for."""


def in_columns(kind: str, given: Mapping[str, str], run: RunRow | None, zone: ZoneInfo) -> dict[str, str]:
    """Return what was given by column; a new date takes the time of day of the start along.

    Raises `UsageError` where a word and its column are both given.
    """
    columns = _COLUMNS.get(kind, {})
    texts: dict[str, str] = {}
    for word, text in given.items():
        column = columns.get(word, word)
        if column in texts:
            raise UsageError(f"{column} is given twice, also as {word}: leave one of the two out.")
        texts[column] = _text(word, text) if word in columns else text
    if run is None:
        return texts
    date = _date(texts["day"]) if _DATE in given else None
    started = given.get(_STARTED)
    if started and "T" not in started:  # an instant, or nothing, is left as it is
        texts["started_utc"] = to_utc(_date(texts.get("day", run.day)), parse_clock(started), zone)
    elif date is not None and run.started_utc is not None and "started_utc" not in texts:
        clock = datetime.datetime.fromisoformat(run.started_utc).astimezone(zone).time()
        texts["started_utc"] = to_utc(date, clock, zone)
    return texts


def resolve_charge(connection: sa.Connection, run: RunRow) -> str:
    """Return the uid of the only charge of a run; raises `UsageError` where it has none, or several."""
    uids = [charge.uid for charge in charges_of_run(connection, run.uid)]
    if not uids:
        raise UsageError(f"run {run.name} has no charge to correct: state it with `labbook charge {run.name} MAH`.")
    if len(uids) > 1:
        listed = ", ".join(f"charge:{uid}" for uid in uids)
        raise UsageError(f"run {run.name} has {len(uids)} charges: correct one of {listed}.")
    return uids[0]


def _text(word: str, text: str) -> str:
    """Return a value as its column takes it: a date as ISO, a number with a decimal point, minutes in seconds."""
    if word == _DATE:
        return _date(text).isoformat()
    number = lone_number(text)
    if word == _MINUTES and text:
        if number is None:
            raise UsageError(f"minutes={text} is not a number of minutes: write for example 12 or 12.5.")
        return repr(60.0 * number)
    return text if number is None or "," not in text else repr(number)


def _date(text: str) -> datetime.date:
    try:
        return parse_date(text)
    except SheetQuestion as question:
        raise UsageError(f"{question.sentence}: write it as year-month-day, such as 2021-06-01.") from None


def state_charge(
    session: WriteSession,
    configuration: Configuration,
    name: str,
    charge_mah: float,
    minutes: float | None,
    end_voltage_v: float | None,
    *,
    add: bool = False,
) -> str:
    """State what a charger put back after a run, beside what the run has where `add`; returns the charge's uid."""
    from ingest.formats.chargers.sheet import MOST_OF_CAPACITY  # with readers of files, which others need not load

    run = run_named(session.connection, name)
    if not (math.isfinite(charge_mah) and charge_mah >= 0):
        raise UsageError(f"MAH {charge_mah:g} is not possible: give what the charger put back, 0 or more.")
    for what, value in (("--minutes", minutes), ("--end-voltage", end_voltage_v)):
        if value is not None and not (math.isfinite(value) and value > 0):
            raise UsageError(f"{what} {value:g} is not possible: give a number above 0.")
    most = (
        MOST_OF_CAPACITY * configuration.batteries[run.battery].capacity_mah
        if run.battery in configuration.batteries
        else math.inf
    )
    if charge_mah > most:
        raise UsageError(
            f"{charge_mah:g} mAh is more than pack {run.battery} can take ({most:g} mAh): check number and unit."
        )
    if add:
        refuse_added_to_nothing(session.connection, run)
    else:
        refuse_second_charge(session.connection, run.uid, name)
    digits = Decimal(repr(charge_mah)).normalize().as_tuple()
    return session.declare(
        "charge",
        row_number=1,
        run=run.uid,
        battery=find_uid(session.connection, "battery", name=run.battery),
        charge_mah=charge_mah,
        resolution_mah=10.0 ** min(0, int(digits.exponent)),  # the step of the last digit as it was typed, at most 1
        duration_s=None if minutes is None else minutes * 60.0,
        end_voltage_v=end_voltage_v,
        mode=str(ChargeMode.CHARGE),
        **({"added": 1} if add else {}),
    )


def refuse_added_to_nothing(connection: sa.Connection, run: RunRow) -> None:
    """Raise `UsageError` where a run has no charge that another one could be added to."""
    if all(charge.added or charge.mode != ChargeMode.CHARGE for charge in charges_of_run(connection, run.uid)):
        raise UsageError(f"run {run.name} has no charge yet that this one could be added to: leave --add out.")


def refuse_second_of_file(connection: sa.Connection, file_uid: str, role: str | None, run: RunRow) -> None:
    """Raise `UsageError` where a file that comes to a run brings its only charge along, and the run has one."""
    charges = charges_of_file(connection, file_uid)
    waiting = [charge for charge in charges if charge.run_uid is None and charge.state is ChargeState.COUNTED]
    if role == FileRole.CHARGE and len(waiting) == 1:
        refuse_second_charge(connection, run.uid, run.name, charge_uid=waiting[0].uid, mode=waiting[0].mode)


def refuse_second_charge(
    connection: sa.Connection,
    run_uid: str,
    run_name: str,
    *,
    charge_uid: str | None = None,
    mode: str = ChargeMode.CHARGE,
) -> None:
    """Raise `UsageError`, which names the first, where a run has a charge other than this one already.

    `charge_uid` is None for one that is being typed in.
    """
    if mode != ChargeMode.CHARGE:
        return
    for first in charges_of_run(connection, run_uid):
        if first.uid == charge_uid or first.added or first.mode != ChargeMode.CHARGE:
            continue
        place = place_of_charge(connection, first.uid)
        where = "typed in" if place is None else place
        off = (
            f"`labbook assign {place} none --why ...`"
            if place
            else f"`labbook correct charge:{first.uid} run=none --why ...`"
        )
        add = "give it with --add" if charge_uid is None else f"`labbook assign charge:{charge_uid} {run_name} --add`"
        raise UsageError(
            f"run {run_name} has a charge already, {first.charge_mah:g} mAh ({where}, charge:{first.uid}): correct "
            f"that one with `labbook correct charge:{first.uid} charge_mah=VALUE --why ...`, or take it off first with "
            f"{off}; if the pack was charged in parts, {add}; a row of the inbox that is no charge of a run goes with "
            "`labbook runs dismiss NAME#ROW --why ...`."
        )


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
