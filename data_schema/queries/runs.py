"""Runs with their conditions, charges and days, one query a list; and what `--where` selects of them.

What names no level, or no run, is refused with the nearest that there are.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import sqlalchemy as sa

from data_schema.errors import UsageError, nearest
from data_schema.queries.study import condition_levels, factors
from data_schema.tables.base import columns_of, in_chunks
from data_schema.tables.design import condition, condition_level, day, factor, level, planned_run
from data_schema.tables.equipment import battery, robot
from data_schema.tables.plain import fetch
from data_schema.tables.runs import run
from data_schema.vocabulary import RunKind, RunState
from data_schema.where import (
    DATE,
    And,
    ColumnKind,
    Comparison,
    Expression,
    Membership,
    Not,
    Operator,
    Or,
    WhereColumn,
    Word,
    as_number,
    compile_expression,
    parse,
)


@dataclass(frozen=True, slots=True)
class RunRow:
    """One run as lists show it; `levels` maps a factor's name to the label of its level."""

    uid: str
    name: str
    kind: RunKind
    state: RunState
    day: str
    position_in_day: int
    condition_uid: str | None
    condition_key: str
    is_control: bool
    levels: Mapping[str, str]
    robot: str
    robot_uid: str
    battery: str
    started_utc: str | None
    duration_s: float | None
    jumps_made: int
    starts: int
    planned: bool


def condition_columns(connection: sa.Connection) -> dict[str, dict[str, Any]]:
    """Return the columns of a `RunRow` that describe its condition, for every condition's uid."""
    levels = condition_levels(connection)
    query = sa.select(condition.c.id, condition.c.uid, condition.c.key, condition.c.is_control)
    return {
        uid: {
            "condition_uid": uid,
            "condition_key": key,
            "is_control": bool(control),
            "levels": levels.get(condition_id, {}),
        }
        for condition_id, uid, key, control in connection.execute(query)
    }


_SHOWN = (
    run.c.name,
    day.c.date_local,
    run.c.position_in_day,
    run.c.kind,
    condition.c.key,
    battery.c.name,
    run.c.duration_s,
    run.c.jumps_made,
    run.c.starts,
    run.c.state,
)

# A book has thousands of runs, and looking a word up costs a tenth of asking the enumeration for it.
_KINDS = {str(kind): kind for kind in RunKind}

_STATES = {str(state): state for state in RunState}


def has_runs(connection: sa.Connection, where: sa.ColumnElement[bool] | None = None) -> bool:
    """Tell whether the book has any run, or any that fulfils `where` (see `where_columns`)."""
    return connection.execute(_in_order((run.c.id,), where).limit(1)).first() is not None


def _values_of_runs(connection: sa.Connection, expression: sa.ColumnElement[Any]) -> set[Any]:
    """Return what runs have of a column of `where_columns`."""
    return set(connection.execute(_in_order((expression,), expression.is_not(None))).scalars())


def list_runs(connection: sa.Connection, where: sa.ColumnElement[bool] | None = None) -> list[RunRow]:
    """List runs by day and position, all of them or those that fulfil `where` (see `where_columns`)."""
    levels = condition_levels(connection)
    nothing: dict[str, str] = {}
    columns = columns_of(
        RunRow,
        run,
        day=day.c.date_local,
        condition_uid=condition.c.uid,
        condition_key=sa.func.coalesce(condition.c.key, ""),
        is_control=sa.func.coalesce(condition.c.is_control, 0) == 1,
        levels=run.c.condition,
        robot=robot.c.name,
        robot_uid=robot.c.uid,
        battery=battery.c.name,
        planned=run.c.planned_run.is_not(None),
    )
    texts: dict[Any, Any] = {}
    one = texts.setdefault  # a hundred thousand runs are of the same few days, conditions and packs
    return [
        RunRow(
            uid,
            name,
            _KINDS[kind],
            _STATES[state],
            one(day_local, day_local),
            position,
            one(condition_uid, condition_uid),
            one(key, key),
            control,
            levels.get(condition_id, nothing),
            *(one(named, named) for named in rest[:3]),
            *rest[3:],
        )
        for uid, name, kind, state, day_local, position, condition_uid, key, control, condition_id, *rest in (
            connection.execute(_in_order(columns, where))
        )
    ]


def shown_runs(connection: sa.Connection, where: sa.ColumnElement[bool] | None = None) -> Sequence[Sequence[Any]]:
    """List the columns of `labbook runs list` for each run, in the order of `list_runs`.

    Rows of a hundred thousand runs take twice as long as what a line shows of them.

    Returns:
        name, date, position in the day, kind, key of the condition, pack, duration in s, jumps made, starts, state.
    """
    return connection.execute(_in_order(_SHOWN, where)).all()


def find_run(connection: sa.Connection, name: str) -> RunRow | None:
    """Return the run of this name."""
    return next(iter(list_runs(connection, run.c.name == name)), None)


def idle_runs(connection: sa.Connection) -> list[RunRow]:
    """List the idle runs by day and position."""
    return list_runs(connection, run.c.kind == RunKind.IDLE)


def runs_of_conditions(connection: sa.Connection, condition_uids: Sequence[str]) -> list[RunRow]:
    """List the runs of some conditions by day and position."""
    return list_runs(
        connection, run.c.condition.in_(sa.select(condition.c.id).where(condition.c.uid.in_(condition_uids)))
    )


def stated_of_run(connection: sa.Connection, run_uid: str) -> Mapping[str, Any]:
    """Return what was stated of a run that its files are held against: name, kind, jumps made, starts, local date."""
    (row,) = fetch(connection, _STATED, {"uid": run_uid})
    return dict(zip(_STATED.selected_columns.keys(), row, strict=True))


# Built once: an ingest of many files asks it for each, and building it takes longer than asking it.
_STATED = (
    sa.select(run.c.name, run.c.kind, run.c.jumps_made, run.c.starts, day.c.date_local)
    .join(day, run.c.day == day.c.id)
    .where(run.c.uid == sa.bindparam("uid"))
)


def run_uids_by_name(connection: sa.Connection, names: Sequence[str]) -> dict[str, str]:
    """Return the uids of those of these runs that there are, by name."""
    found: dict[str, str] = {}
    for some in in_chunks(names):
        for name, uid in connection.execute(sa.select(run.c.name, run.c.uid).where(run.c.name.in_(some))):
            found.setdefault(name, uid)
    return found


def runs_named(connection: sa.Connection, names: Sequence[str]) -> list[RunRow]:
    """List the runs of these names by day and position, as far as there are such."""
    found = [row for some in in_chunks(names) for row in list_runs(connection, run.c.name.in_(some))]
    return sorted(found, key=lambda row: (row.day, row.position_in_day))


def run_names(connection: sa.Connection) -> list[str]:
    """Return the names of all runs."""
    return list(connection.execute(sa.select(run.c.name).order_by(run.c.id)).scalars())


def names_beginning(connection: sa.Connection, text: str) -> list[str]:
    """Return the names of runs, made or planned, that a text begins with."""
    names = (run.c.name, planned_run.c.name)
    begun = (sa.select(name).where(sa.func.substr(text, 1, sa.func.length(name)) == name) for name in names)
    return list(connection.execute(sa.union(*begun)).scalars())


def _in_order(columns: Sequence[sa.ColumnElement[Any]], where: sa.ColumnElement[bool] | None) -> sa.Select[Any]:
    """Return the query for these columns of the runs, by day and position."""
    query = (
        sa.select(*columns)
        .select_from(
            run.join(day, run.c.day == day.c.id)
            .join(robot, run.c.robot == robot.c.id)
            .join(battery, run.c.battery == battery.c.id)
            .outerjoin(condition, run.c.condition == condition.c.id)
        )
        .order_by(day.c.date_local, run.c.position_in_day, run.c.id)
    )
    return query if where is None else query.where(where)


def where_columns(connection: sa.Connection) -> dict[str, WhereColumn]:
    """Return every name that a `--where` may use: the study's factors, then the columns of a run."""
    columns: dict[str, WhereColumn] = {}
    for row in factors(connection):
        number = row.kind == "number"
        value = (
            sa.select(level.c.value if number else level.c.label)
            .join(condition_level, condition_level.c.level == level.c.id)
            .join(factor, condition_level.c.factor == factor.c.id)
            .where(condition_level.c.condition == run.c.condition, factor.c.uid == row.uid)
            .scalar_subquery()
        )
        choices = tuple(item.label for item in row.levels)
        columns[row.name] = WhereColumn(ColumnKind.NUMBER if number else ColumnKind.LABEL, value, choices)
    of_run = {
        "run": WhereColumn(ColumnKind.TEXT, run.c.name),
        "kind": WhereColumn(ColumnKind.CHOICE, run.c.kind, tuple(RunKind)),
        "state": WhereColumn(ColumnKind.CHOICE, run.c.state, tuple(RunState)),
        "day": WhereColumn(ColumnKind.DATE, day.c.date_local),
        "position": WhereColumn(ColumnKind.NUMBER, run.c.position_in_day),
        "robot": WhereColumn(ColumnKind.TEXT, robot.c.name),
        "battery": WhereColumn(ColumnKind.TEXT, battery.c.name),
        "duration_s": WhereColumn(ColumnKind.NUMBER, run.c.duration_s),
        "jumps_made": WhereColumn(ColumnKind.NUMBER, run.c.jumps_made),
        "starts": WhereColumn(ColumnKind.NUMBER, run.c.starts),
    }
    return of_run | columns


_SAME = (Operator.EQUAL, Operator.NOT_EQUAL)


def refuse_empty_selection(connection: sa.Connection, where: str | None) -> None:
    """Raise `UsageError` where no run fulfils `where`; it names the nearest values that runs have."""
    if not where:
        return
    columns, expression = where_columns(connection), parse(where)
    condition = compile_known(expression, columns)
    if has_runs(connection, condition):
        return
    why = "some run fulfils each part of it, and none all"
    for one in _comparisons(expression):
        if not has_runs(connection, compile_expression(one, columns)):
            name = one.column.text
            near = _nearest(_words(one)[0].text, _values_of_runs(connection, columns[name].expression))
            why = f"the nearest is {name}={near}" if near else f"no run has {name}"
            break
    raise UsageError(f"no run fulfils --where {where!r}: {why}; `labbook runs list` lists all.")


def compile_known(expression: Expression, columns: Mapping[str, WhereColumn]) -> sa.ColumnElement[bool]:
    """Build the condition; raises `UsageError`, too, for a number that is no level of its factor, as for such a word.

    Selections recorded earlier may select no run: only a new one is refused.
    """
    condition = compile_expression(expression, columns)
    for one in _comparisons(expression):
        levels = {number for label in columns[one.column.text].choices if (number := as_number(label)) is not None}
        for word in _words(one) if levels and (isinstance(one, Membership) or one.operator in _SAME) else ():
            if as_number(word.text) not in (None, *levels):
                raise UsageError(
                    f"{word.text!r} is not a known level of {one.column.text} (character {word.position} of --where): "
                    f"the nearest is {_nearest(word.text, levels)}."
                )
    return condition


def _comparisons(expression: Expression) -> Iterator[Comparison | Membership]:
    match expression:
        case Not(operand):
            yield from _comparisons(operand)
        case And(operands) | Or(operands):
            for operand in operands:
                yield from _comparisons(operand)
        case Comparison() | Membership():
            yield expression


def _words(one: Comparison | Membership) -> Sequence[Word]:
    return one.values if isinstance(one, Membership) else [one.value]


def _nearest(given: str, values: Collection[float | str]) -> str:
    """Return the values on both sides of a number or a date; of words the one that looks most like it, or the first."""
    number, dates = as_number(given), all(DATE.fullmatch(str(value)) for value in values)
    if number is None and not dates:
        return nearest(given, map(str, values)) or " or ".join(sorted(map(str, values))[:3])
    wanted: Any = given if dates else number
    numbers: list[Any] = sorted(values)
    if wanted in values:
        return f"{given}"
    below, above = [each for each in numbers if each < wanted], [each for each in numbers if each > wanted]
    return " or ".join(str(each) if dates else f"{each:g}" for each in (*below[-1:], *above[:1]))
