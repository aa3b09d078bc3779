"""The numbers that now stand for one run."""

from __future__ import annotations

import sqlalchemy as sa

from data_schema.tables.results import result, result_number


def standing_number(connection: sa.Connection, kind: str, scope_json: str, name: str) -> tuple[float, str] | None:
    """Return (value, unit) of a number in the newest result of this kind and scope that is not stale; None without."""
    row = connection.execute(
        sa.select(result_number.c.value, result_number.c.unit)
        .join(result, result_number.c.result == result.c.id)
        .where(
            result.c.kind == kind,
            result.c.scope_json == scope_json,
            result.c.stale == 0,
            result_number.c.name == name,
            result_number.c.value.is_not(None),
        )
        .order_by(result.c.id.desc())
    ).first()
    return None if row is None else (row.value, row.unit)
