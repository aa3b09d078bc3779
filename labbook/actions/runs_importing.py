"""`labbook runs import`: a run sheet states runs; the same sheet again states nothing.

A row without a start, a duration and a count of jumps is a run still to be made, and waits. A later sheet may fill what
was blank; what it contradicts is refused with the `labbook correct` that would change it.
"""

from __future__ import annotations

import datetime
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any
from zoneinfo import ZoneInfo

from data_schema.errors import InputRefused, UsageError
from data_schema.queries.facts import find_uid, read_fact
from data_schema.queries.runs import planned_runs
from data_schema.vocabulary import Action, RunKind, RunState
from labbook.book.desk import Desk, Statement, new_uid
from labbook.book.naming import ensure_condition, ensure_day, named_uid, study_of
from labbook.book.opening import Book
from labbook.config.parsing import Configuration
from labbook.plan.drawing import PlanFactor
from labbook.plan.sheet_reader import RunSheetRow, read_run_sheet


@dataclass
class RunsImported:
    """What a run sheet brought: names of runs stated, filled in, there already, and still to be made."""

    stated: list[str] = field(default_factory=list)
    filled_in: list[str] = field(default_factory=list)
    unchanged: list[str] = field(default_factory=list)
    not_made: list[str] = field(default_factory=list)
    remarks: list[str] = field(default_factory=list)


def import_runs(book: Book, desk: Desk, text: str, source: str) -> RunsImported:
    """State the runs of a sheet; raises with every contradiction at once, nothing being stored."""
    configuration = book.configuration
    rows = read_run_sheet(
        text,
        plan_factors(configuration),
        source=source,
        batteries=configuration.batteries,
        robots=configuration.robots,
        jumps_nominal=configuration.study.jumps_nominal,
    )
    done = RunsImported()
    planned = {row.name: row.uid for row in planned_runs(desk.connection) if row.run_name is None}
    contradictions: list[str] = []
    for row in rows:
        done.remarks += [f"{row.name}: {remark}" for remark in row.remarks]
        if not row.done:
            done.not_made.append(row.name)
            continue
        uid = find_uid(desk.connection, "run", name=row.name)
        values = _values(book, desk, row)
        if uid is None:
            new = desk.declare("run", **values, name=row.name, planned_run=planned.get(row.name))
            if row.note:
                desk.state(_note(new, row.note))
            done.stated.append(row.name)
        else:
            _fill_in(desk, row.name, uid, values, done, contradictions)
    if contradictions:
        raise InputRefused("\n".join(contradictions))
    return done


def plan_factors(configuration: Configuration) -> list[PlanFactor]:
    """Return the study's factors as plans and run sheets know them."""
    return [
        PlanFactor(name, tuple(level.label for level in factor.levels), factor.control)
        for name, factor in configuration.factors.items()
    ]


def _values(book: Book, desk: Desk, row: RunSheetRow) -> dict[str, Any]:
    configuration, study = book.configuration, study_of(desk.connection)
    complete = row.duration_s is not None and (row.jumps_made is not None or row.kind is RunKind.IDLE)
    robot = row.robot or _only("robot", configuration.robots, row)
    battery = row.battery or _only("battery", configuration.batteries, row)
    levels = dict(row.levels)
    return {
        "study": study.uid,
        "day": ensure_day(desk, study.uid, row.date.isoformat()),
        "kind": str(row.kind),
        "condition": ensure_condition(desk, configuration, study.uid, levels) if levels else None,
        "robot": named_uid(desk.connection, "robot", robot, configuration.robots),
        "battery": named_uid(desk.connection, "battery", battery, configuration.batteries),
        "position_in_day": row.position,
        "started_utc": _utc(row.date, row.started, study.time_zone),
        "duration_s": row.duration_s,
        "jumps_made": row.jumps_made or 0,
        "starts": row.starts or 1,
        "state": str(RunState.COMPLETE if complete else RunState.OPEN),
    }


def _only(kind: str, known: Mapping[str, Any], row: RunSheetRow) -> str:
    """Take the only robot or pack there is; with several, the sheet must say which."""
    if len(known) == 1:
        return next(iter(known))
    raise UsageError(
        f"run {row.name} (line {row.line}) names no {kind} and the book has {len(known)}: write one of "
        f"{', '.join(known) or 'none, so declare one in labbook.toml first'} in its row."
    )


def _utc(date: datetime.date, started: datetime.time | None, time_zone: str) -> str | None:
    if started is None:
        return None
    local = datetime.datetime.combine(date, started, ZoneInfo(time_zone))
    return local.astimezone(datetime.UTC).isoformat(timespec="seconds").replace("+00:00", "Z")


def _fill_in(
    desk: Desk, name: str, uid: str, values: Mapping[str, Any], done: RunsImported, contradictions: list[str]
) -> None:
    standing = read_fact(desk.connection, "run", uid, values)
    is_open = standing["state"] == RunState.OPEN
    blank: Sequence[str] = [
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
        contradictions.append(
            f"run {name} is in the book with other values of {', '.join(contradicted)}: correct the sheet, or the book "
            f'with `labbook correct {name} FIELD=VALUE --why "..."`.'
        )
    elif differing:
        old = {column: standing[column] for column in differing}
        desk.state(Statement(Action.CORRECT, "run", uid, new=differing, old=old, reason="filled in on the run sheet"))
        done.filled_in.append(name)
    else:
        done.unchanged.append(name)


def _note(run_uid: str, text: str) -> Statement:
    return Statement(Action.NOTE, "note", new_uid(), new={"target_kind": "run", "target_uid": run_uid, "text": text})
