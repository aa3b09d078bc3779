"""Results that no report shows and that nothing shown rests on: caches, computed again when they are wanted."""

from __future__ import annotations

from collections.abc import Sequence

import sqlalchemy as sa

from data_schema.chunks import in_chunks
from data_schema.row_hashes import STALE, written
from data_schema.tables.results import prediction, report_item, result, result_input, result_number


def unshown_results(connection: sa.Connection) -> list[str]:
    """Return the uids of these results; one that a shown one rests on, over however many others, is not among them."""
    shown = (
        sa.select(result.c.uid)
        .distinct()
        .join(result_number, result_number.c.result == result.c.id)
        .join(report_item, report_item.c.result_number == result_number.c.id)
    )
    below = sa.select(result.c.uid, result_input.c.input_uid).join(result_input, result_input.c.result == result.c.id)
    inputs: dict[str, list[str]] = {}
    for uid, used in connection.execute(below.where(result_input.c.input_kind == "result")):
        inputs.setdefault(uid, []).append(used)
    step = list(connection.execute(shown).scalars())
    needed: set[str] = set()
    while step:
        needed.update(step)
        step = [used for uid in step for used in inputs.get(uid, ()) if used not in needed]
    return [
        uid for uid in connection.execute(sa.select(result.c.uid).order_by(result.c.id)).scalars() if uid not in needed
    ]


def remove_results(connection: sa.Connection, uids: Sequence[str]) -> None:
    """Remove results with their numbers, inputs and predictions, in a writing transaction."""
    for some in in_chunks(uids):
        keys = sa.select(result.c.id).where(result.c.uid.in_(some)).scalar_subquery()
        for table in (prediction, result_input, result_number):
            connection.execute(table.delete().where(table.c.result.in_(keys)))
        connection.execute(result.delete().where(result.c.uid.in_(some)))
        for kind in ("result", STALE):
            written(connection, kind, some)
