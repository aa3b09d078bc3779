"""`labbook runs import`: a run sheet states runs; the same sheet again states nothing.

A row without a start, a duration and a count of jumps is a run still to be made, and waits. A later sheet may fill what
was blank; what it contradicts is refused with the `labbook correct` that would change it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from typing import Any
from zoneinfo import ZoneInfo

from data_schema.errors import InputRefused, UsageError
from data_schema.queries.files import inbox
from data_schema.queries.runs import RunRow, list_runs
from data_schema.queries.study import planned_runs, withdrawn_names
from data_schema.vocabulary import Action, RunKind, RunState
from ingest.tables.sheet import SheetFile
from labbook.actions.runs.remarks import Remark, remarks_on, remarks_on_names, remarks_on_places
from labbook.book.naming import ensure_condition, ensure_day, named_uid, study_of
from labbook.book.opening import Book
from labbook.book.write_session import Statement, WriteSession, new_uid
from labbook.config.parsing import Configuration
from labbook.config.run_names import RunNames
from labbook.plan.drawing import PlanFactor
from labbook.plan.local_time import to_utc
from labbook.plan.sheet_reader import RunSheetRow, read_run_sheet


@dataclass
class RunsImported:
    """What a run sheet brought.

    Names of runs stated, filled in, there already, still to be made, and blank though their plan was withdrawn;
    `taken_in` are the files and charges that waited for a run, by its name, `encoding` is the page of the sheet's text.
    """

    stated: list[str] = field(default_factory=list)
    filled_in: list[str] = field(default_factory=list)
    unchanged: list[str] = field(default_factory=list)
    not_made: list[str] = field(default_factory=list)
    withdrawn: list[str] = field(default_factory=list)
    remarks: list[Remark] = field(default_factory=list)
    taken_in: dict[str, list[str]] = field(default_factory=dict)
    encoding: str = "utf-8"


def import_runs(book: Book, session: WriteSession, sheet: SheetFile, *, dates: str | None = None) -> RunsImported:
    """State the runs of a sheet; raises with every contradiction at once, nothing being stored.

    `dates` is the order of dates with slashes; raises `SheetQuestion` where it is needed.
    """
    configuration = book.configuration
    rows, page = read_run_sheet(
        sheet,
        plan_factors(configuration),
        batteries=configuration.batteries,
        robots=configuration.robots,
        dates=dates,
    )
    done = RunsImported(encoding=page)
    waiting = inbox(session.connection)
    known = _Known(session, configuration)
    withdrawn = withdrawn_names(session.connection)
    planned = {row.name: row.uid for row in planned_runs(session.connection) if row.run_name is None}
    standing = {run.name: run for run in list_runs(session.connection)}
    named_before = {*standing, *planned, *withdrawn}
    contradictions: list[str] = []
    for row in rows:
        if not row.done:
            (done.withdrawn if row.name in withdrawn else done.not_made).append(row.name)
            continue
        values = _values(known, row)
        if row.name in standing:
            _fill_in(session, known, standing[row.name], row, values, done, contradictions)
            continue
        new = session.declare("run", **values, name=row.name, planned_run=planned.get(row.name))
        if row.note:
            about = {"target_kind": "run", "target_uid": new, "text": row.note}
            session.state(Statement(Action.NOTE, "note", new_uid(), new=about))
        done.stated.append(row.name)
    if contradictions:
        raise InputRefused("\n".join(contradictions))
    still = {(item.what, item.name) for item in inbox(session.connection)} if waiting else set()
    for item in waiting:
        if item.stated_run is not None and (item.what, item.name) not in still:
            done.taken_in.setdefault(item.stated_run, []).append(item.name)
    done.remarks = remarks_on(session.connection, configuration, [*done.stated, *done.filled_in])
    done.remarks += remarks_on_names(done.stated, named_before, RunNames(configuration.study.run_names))
    places = {row.name: (row.date.isoformat(), row.position) for row in rows if row.done and row.name not in standing}
    taken = {(run.day, run.position_in_day): run.name for run in standing.values() if run.state is not RunState.VOID}
    done.remarks += remarks_on_places(places, taken)
    return done


class _Known:
    """The uids of what rows name, asked for once each; days and conditions come into being with their first run."""

    def __init__(self, session: WriteSession, configuration: Configuration) -> None:
        connection, study = session.connection, study_of(session.connection)
        self.configuration, self.study, self.zone = configuration, study, ZoneInfo(study.time_zone)
        self.day = cache(lambda date: ensure_day(session, study.uid, date))
        self.condition_of = cache(lambda levels: ensure_condition(session, configuration, study.uid, dict(levels)))
        self.robot = cache(lambda name: named_uid(connection, "robot", name, configuration.robots))
        self.battery = cache(lambda name: named_uid(connection, "battery", name, configuration.batteries))

    def condition(self, levels: Mapping[str, str]) -> str | None:
        return self.condition_of(tuple(levels.items())) if levels else None


def plan_factors(configuration: Configuration) -> list[PlanFactor]:
    """Return the study's factors as plans and run sheets know them."""
    return [
        PlanFactor(name, tuple(level.label for level in factor.levels), factor.control)
        for name, factor in configuration.factors.items()
    ]


def _values(known: _Known, row: RunSheetRow) -> dict[str, Any]:
    started = row.started and to_utc(row.date, row.started, known.zone, f"run {row.name} (line {row.line})")
    complete = row.duration_s is not None and (row.jumps_made is not None or row.kind is RunKind.IDLE)
    return {
        "study": known.study.uid,
        "day": known.day(row.date.isoformat()),
        "kind": str(row.kind),
        "condition": known.condition(row.levels),
        "robot": known.robot(row.robot or _only("robot", known.configuration.robots, row)),
        "battery": known.battery(row.battery or _only("battery", known.configuration.batteries, row)),
        "position_in_day": row.position,
        "started_utc": started,
        "duration_s": row.duration_s,
        "jumps_made": row.jumps_made or 0,
        "starts": row.starts or 1,
        "state": str(RunState.COMPLETE if complete else RunState.OPEN),
    }


def _as_values(known: _Known, run: RunRow) -> dict[str, Any]:
    """Return a run of the book in the columns that a sheet states."""
    return {
        "study": known.study.uid,
        "day": known.day(run.day),
        "kind": str(run.kind),
        "condition": run.condition_uid,
        "robot": run.robot_uid,
        "battery": known.battery(run.battery),
        **{name: getattr(run, name) for name in _AS_STATED},
        "state": str(run.state),
    }


_AS_STATED = ("position_in_day", "started_utc", "duration_s", "jumps_made", "starts")


def _only(kind: str, known: Mapping[str, Any], row: RunSheetRow) -> str:
    """Take the only robot or pack there is; with several, the sheet must say which."""
    if len(known) == 1:
        return next(iter(known))
    raise UsageError(
        f"run {row.name} (line {row.line}) names no {kind} and the book has {len(known)}: write one of "
        f"{', '.join(known) or 'none, so declare one in labbook.toml first'} in its row."
    )


def _fill_in(
    session: WriteSession,
    known: _Known,
    run: RunRow,
    row: RunSheetRow,
    values: Mapping[str, Any],
    done: RunsImported,
    contradictions: list[str],
) -> None:
    name, standing = run.name, _as_values(known, run)
    is_open = standing["state"] == RunState.OPEN
    blank = [
        column
        for column in values
        if standing[column] is None or (is_open and column in ("jumps_made", "starts", "state"))
    ]
    differing = {
        column: value
        for column, value in values.items()
        if value is not None and standing[column] != value and not (column == "state" and not is_open)
    }
    contradicted = [column for column in differing if column not in blank]
    if contradicted:
        contradictions.append(_contradiction(run, row, values, contradicted))
    elif differing:
        old = {column: standing[column] for column in differing}
        session.state(
            Statement(Action.SET, "run", run.uid, new=differing, old=old, reason="filled in on the run sheet")
        )
        done.filled_in.append(name)
    else:
        done.unchanged.append(name)


def _contradiction(run: RunRow, row: RunSheetRow, values: Mapping[str, Any], columns: Sequence[str]) -> str:
    """Say what the book and the sheet each have, in the fields of `labbook correct`."""
    both: dict[str, tuple[Any, Any]] = {}
    for column in columns:
        if column == "condition":
            both |= {
                name: (run.levels.get(name), label)
                for name, label in row.levels.items()
                if run.levels.get(name) != label
            }
        elif column == "day":
            both[column] = run.day, row.date
        elif column in ("robot", "battery"):
            both[column] = getattr(run, column), getattr(row, column)
        else:
            both[column] = getattr(run, column), values[column]
    differing = ", ".join(
        f"{name}={_plain(book)} where the sheet has {_plain(sheet)}" for name, (book, sheet) in both.items()
    )
    return (
        f"run {run.name} is in the book with {differing}: correct the sheet, or the book with "
        f'`labbook correct {run.name} FIELD=VALUE --why "..."`.'
    )


def _plain(value: Any) -> str:
    return f"{value:g}" if isinstance(value, float) and value == float(f"{value:g}") else str(value)
