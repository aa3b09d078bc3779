"""Plans: what is left of them, and what was withdrawn."""

from __future__ import annotations

from dataclasses import dataclass

import sqlalchemy as sa

from data_schema.tables.design import plan, planned_run
from data_schema.tables.people import journal
from data_schema.tables.runs import run
from data_schema.vocabulary import Action


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
