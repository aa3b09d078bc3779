"""Conditions, which are sets of levels, and the runs that a plan foresees for them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import sqlalchemy as sa

from data_schema.queries.facts import insert_fact, key_of
from data_schema.row_hashes import written
from data_schema.tables.design import condition, condition_level, level


def add_condition_levels(connection: sa.Connection, condition_uid: str, level_uids: Sequence[str]) -> None:
    """Store which level of each factor a condition has."""
    owner = key_of(connection, "condition", condition_uid)
    rows = connection.execute(
        sa.select(level.c.factor, level.c.id).where(level.c.uid.in_(level_uids)).order_by(level.c.id)
    )
    connection.execute(
        condition_level.insert(), [{"condition": owner, "factor": row.factor, "level": row.id} for row in rows]
    )
    written(connection, "condition", [condition_uid])


def add_planned_run(connection: sa.Connection, *, uid: str, plan_uid: str, position: int, **values: Any) -> None:
    """Store one run of a plan."""
    insert_fact(connection, "planned_run", uid, {"plan": plan_uid, "position": position, **values})


def conditions_by_key(connection: sa.Connection) -> Mapping[str, str]:
    """Return the uid of every condition by its canonical key."""
    rows = connection.execute(sa.select(condition.c.key, condition.c.uid).order_by(condition.c.id))
    return {row.key: row.uid for row in rows}
