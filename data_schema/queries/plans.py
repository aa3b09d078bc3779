"""Plans: what they hold, what is left of them, and what was withdrawn."""

from __future__ import annotations

from dataclasses import dataclass

import sqlalchemy as sa

from data_schema.tables.base import columns_of
from data_schema.tables.design import condition, plan, planned_run
from data_schema.tables.people import journal
from data_schema.tables.runs import run
from data_schema.vocabulary import Action


@dataclass(frozen=True, slots=True)
class PlannedRow:
    """A run of a plan and, once done, the run."""

    uid: str
    name: str
    position: int
    day_number: int
    block: str
    condition_key: str | None
    run_name: str | None


def planned_runs(connection: sa.Connection) -> list[PlannedRow]:
    """List what all plans hold, in the order in which they were stated; what was withdrawn is left out."""
    query = (
        sa.select(*columns_of(PlannedRow, planned_run, condition_key=condition.c.key, run_name=run.c.name))
        .select_from(
            planned_run.outerjoin(condition, planned_run.c.condition == condition.c.id).outerjoin(
                run, run.c.planned_run == planned_run.c.id
            )
        )
        .where(sa.or_(run.c.id.is_not(None), planned_run.c.plan.not_in(withdrawn_plans())))
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
        .where(plan.c.id.not_in(withdrawn_plans()))
        .order_by(plan.c.id, planned_run.c.position)
    )
    found: dict[tuple[str, int], tuple[list[str], list[str]]] = {}
    for uid, seed, name, made in connection.execute(query):
        to_be_made, done = found.setdefault((uid, seed), ([], []))
        (to_be_made if made is None else done).append(name)
    return [OpenPlan(*key, tuple(left), tuple(done)) for key, (left, done) in found.items() if left]


def withdrawn_names(connection: sa.Connection) -> set[str]:
    """Return the names of the runs that were planned, not made, and withdrawn."""
    query = (
        sa.select(planned_run.c.name)
        .outerjoin(run, run.c.planned_run == planned_run.c.id)
        .where(run.c.id.is_(None), planned_run.c.plan.in_(withdrawn_plans()))
    )
    return set(connection.execute(query).scalars())


def withdrawn_plans() -> sa.Select[tuple[int]]:
    """Select the plans that the journal says are void; a run made after that belongs to none of them."""
    said = sa.and_(
        journal.c.entity_uid == plan.c.uid, journal.c.entity_kind == "plan", journal.c.action == str(Action.VOID)
    )
    return sa.select(plan.c.id).join(journal, said)
