"""What the book is about: the study, its factors, conditions and plans, its days, its people, its configuration."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import sqlalchemy as sa

from data_schema.queries.facts import find_uid, key_of
from data_schema.tables.base import columns_of
from data_schema.tables.design import (
    condition,
    condition_level,
    day,
    day_check,
    factor,
    level,
    plan,
    planned_run,
    study,
)
from data_schema.tables.journal import config, journal, person
from data_schema.tables.runs import run
from data_schema.vocabulary import Action, PlanMethod


@dataclass(frozen=True, slots=True)
class LevelRow:
    """One level of a factor."""

    uid: str
    label: str
    value: float | None
    attributes_json: str


@dataclass(frozen=True, slots=True)
class FactorRow:
    """A factor with its levels, in the order they were declared."""

    uid: str
    name: str
    kind: str
    levels: tuple[LevelRow, ...]


def factors(connection: sa.Connection) -> tuple[FactorRow, ...]:
    """Return all factors and levels in the order of their declaration."""
    rows = connection.execute(
        sa.select(factor.c.uid.label("factor_uid"), factor.c.name, factor.c.kind, *columns_of(LevelRow, level))
        .join(level, level.c.factor == factor.c.id)
        .order_by(factor.c.id, level.c.id)
    ).all()
    found: dict[tuple[str, str, str], list[LevelRow]] = {}
    for factor_uid, name, kind, *of_level in rows:
        found.setdefault((factor_uid, name, kind), []).append(LevelRow(*of_level))
    return tuple(FactorRow(*key, tuple(levels)) for key, levels in found.items())


@dataclass(frozen=True, slots=True)
class StudyRow:
    """The study that a book is about."""

    uid: str
    name: str
    kind: str
    reference_voltage_v: float
    jumps_nominal: int
    time_zone: str


def the_study(connection: sa.Connection) -> StudyRow | None:
    """Return the book's study; a book has one."""
    row = connection.execute(sa.select(*columns_of(StudyRow, study)).order_by(study.c.id)).first()
    return None if row is None else StudyRow(*row)


def add_condition_levels(connection: sa.Connection, condition_uid: str, level_uids: Sequence[str]) -> None:
    """Store which level of each factor a condition has."""
    owner = key_of(connection, "condition", condition_uid)
    rows = connection.execute(
        sa.select(level.c.factor, level.c.id).where(level.c.uid.in_(level_uids)).order_by(level.c.id)
    )
    connection.execute(
        condition_level.insert(), [{"condition": owner, "factor": row.factor, "level": row.id} for row in rows]
    )


def conditions_by_key(connection: sa.Connection) -> Mapping[str, str]:
    """Return the uid of every condition by its canonical key."""
    rows = connection.execute(sa.select(condition.c.key, condition.c.uid).order_by(condition.c.id))
    return {row.key: row.uid for row in rows}


@dataclass(frozen=True, slots=True)
class CheckRow:
    """A check made on a day; the newest of its kind counts."""

    kind: str
    value: float | None
    unit: str | None
    passed: bool
    person: str
    at_utc: str


def day_uids(connection: sa.Connection) -> dict[str, str]:
    """Return the uid of every day by its date."""
    return {row.date_local: row.uid for row in connection.execute(sa.select(day.c.date_local, day.c.uid))}


def days_with_runs(connection: sa.Connection) -> list[str]:
    """Return the dates on which runs were made, in their order."""
    query = sa.select(day.c.date_local).join(run, run.c.day == day.c.id).distinct()
    return sorted(connection.execute(query).scalars())


def checks_by_day(connection: sa.Connection) -> dict[str, list[CheckRow]]:
    """Return the newest check of each kind, by date."""
    query = (
        sa.select(day.c.date_local, *columns_of(CheckRow, day_check, person=person.c.name))
        .join(day, day_check.c.day == day.c.id)
        .join(person, day_check.c.person == person.c.id)
        .order_by(day_check.c.id)
    )
    newest: dict[tuple[str, str], CheckRow] = {}
    for date, kind, value, unit, passed, name, at_utc in connection.execute(query):
        newest[(date, kind)] = CheckRow(kind, value, unit, bool(passed), name, at_utc)
    found: dict[str, list[CheckRow]] = {}
    for (date, _kind), row in newest.items():
        found.setdefault(date, []).append(row)
    return found


def person_uid(connection: sa.Connection, name: str) -> str | None:
    """Return the uid of a person by name."""
    return find_uid(connection, "person", name=name)


def people(connection: sa.Connection) -> dict[str, str]:
    """Return everyone's initials by name."""
    rows = connection.execute(sa.select(person.c.name, person.c.initials).order_by(person.c.id))
    return {row.name: row.initials for row in rows}


@dataclass(frozen=True, slots=True)
class ConfigRow:
    """A configuration as labbook.toml stood when it was taken over; an earlier text may be taken over again."""

    uid: str
    sha256: str
    text: str


def config_in_force(connection: sa.Connection) -> ConfigRow | None:
    """Return the newest configuration; None before the first."""
    newest = sa.select(*columns_of(ConfigRow, config)).order_by(config.c.id.desc()).limit(1)
    row = connection.execute(newest).first()
    return ConfigRow(*row) if row else None


@dataclass(frozen=True, slots=True)
class PlannedRow:
    """A run of a plan and, once done, the run."""

    uid: str
    name: str
    position: int
    block: str
    condition_key: str | None
    run_name: str | None


def planned_runs(connection: sa.Connection) -> list[PlannedRow]:
    """List the runs of all plans, in the order in which they were stated, without those that were withdrawn."""
    query = (
        sa.select(*columns_of(PlannedRow, planned_run, condition_key=condition.c.key, run_name=run.c.name))
        .select_from(
            planned_run.outerjoin(condition, planned_run.c.condition == condition.c.id).outerjoin(
                run, run.c.planned_run == planned_run.c.id
            )
        )
        .where(sa.or_(run.c.id.is_not(None), planned_run.c.plan.not_in(_withdrawn_plans())))
        .order_by(planned_run.c.plan, planned_run.c.position)
    )
    return [PlannedRow(*row) for row in connection.execute(query)]


@dataclass(frozen=True, slots=True)
class OpenPlan:
    """A plan of which runs are still to be made; names of runs in their order."""

    uid: str
    seed: int
    to_be_made: tuple[str, ...]
    made: tuple[str, ...]


def open_plans(connection: sa.Connection) -> list[OpenPlan]:
    """List the plans that were not withdrawn and have runs still to be made."""
    query = (
        sa.select(plan.c.uid, plan.c.seed, planned_run.c.name, run.c.id)
        .join(planned_run, planned_run.c.plan == plan.c.id)
        .outerjoin(run, run.c.planned_run == planned_run.c.id)
        .where(plan.c.id.not_in(_withdrawn_plans()))
        .order_by(plan.c.id, planned_run.c.position)
    )
    found: dict[tuple[str, int], tuple[list[str], list[str]]] = {}
    for uid, seed, name, made in connection.execute(query):
        to_be_made, done = found.setdefault((uid, seed), ([], []))
        (to_be_made if made is None else done).append(name)
    return [OpenPlan(*key, tuple(left), tuple(done)) for key, (left, done) in found.items() if left]


def condition_levels(connection: sa.Connection) -> dict[int, dict[str, str]]:
    """Return, for every condition's key, its levels by factor name."""
    found: dict[int, dict[str, str]] = {}
    query = (
        sa.select(condition_level.c.condition, factor.c.name, level.c.label)
        .join(factor, condition_level.c.factor == factor.c.id)
        .join(level, condition_level.c.level == level.c.id)
        .order_by(condition_level.c.condition, factor.c.id)
    )
    for key, name, label in connection.execute(query):
        found.setdefault(key, {})[name] = label
    return found


@dataclass(frozen=True, slots=True)
class PlannedEntry:
    """One run of a plan as it is stated; `levels` are those of its condition by factor, None of an idle run."""

    name: str
    day: int
    block: str
    levels: Mapping[str, str] | None


def stated_plan(connection: sa.Connection, seed: int) -> tuple[PlanMethod, list[PlannedEntry]] | None:
    """Return the last plan with a seed that was not withdrawn, its runs in their order; None where there is none."""
    last = sa.select(plan).where(plan.c.seed == seed, plan.c.id.not_in(_withdrawn_plans())).order_by(plan.c.id.desc())
    found = connection.execute(last).first()
    if found is None:
        return None
    levels = condition_levels(connection)
    runs = sa.select(planned_run).where(planned_run.c.plan == found.id).order_by(planned_run.c.position)
    return PlanMethod(found.method), [
        PlannedEntry(row.name, row.day_number, row.block, None if row.condition is None else levels[row.condition])
        for row in connection.execute(runs)
    ]


def seeds_of_plans(connection: sa.Connection) -> tuple[list[int], set[int]]:
    """Return the seeds of the plans that were not withdrawn, in their order, and those of the withdrawn ones."""
    withdrawn = set(connection.execute(_withdrawn_plans()).scalars())
    plans = connection.execute(sa.select(plan.c.id, plan.c.seed).order_by(plan.c.id)).all()
    standing = dict.fromkeys(row.seed for row in plans if row.id not in withdrawn)
    return list(standing), {row.seed for row in plans if row.id in withdrawn}


def withdrawn_names(connection: sa.Connection) -> set[str]:
    """Return the names of the runs that were planned, not made, and withdrawn."""
    query = (
        sa.select(planned_run.c.name)
        .outerjoin(run, run.c.planned_run == planned_run.c.id)
        .where(run.c.id.is_(None), planned_run.c.plan.in_(_withdrawn_plans()))
    )
    return set(connection.execute(query).scalars())


def _withdrawn_plans() -> sa.Select[tuple[int]]:
    """Select the plans that are void by the journal; a run made after that belongs to none of them."""
    voids_plan = sa.and_(
        journal.c.entity_uid == plan.c.uid, journal.c.entity_kind == "plan", journal.c.action == Action.EXCLUDE
    )
    return sa.select(plan.c.id).join(journal, voids_plan)
