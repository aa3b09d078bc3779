"""Predictions: what was simulated for a result, and how it ended."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import sqlalchemy as sa

from data_schema.row_hashes import written
from data_schema.tables.base import in_chunks
from data_schema.tables.design import condition
from data_schema.tables.results import prediction, result


@dataclass(frozen=True, slots=True)
class PredictionRow:
    """A simulated scene; `result_uid` names the result with its numbers, `uid` is the prediction's own."""

    uid: str
    result_uid: str
    condition_key: str
    scene_toml: str
    effects_json: str
    accuracy: float
    outcome: str
    assumed_json: str


_OWN = ("scene_toml", "effects_json", "accuracy", "outcome", "assumed_json")


def add_predictions(connection: sa.Connection, rows: Sequence[PredictionRow]) -> None:
    """Store predictions, after the results that they belong to; what is stored already stays as it is."""
    for some in in_chunks(rows):
        stored = sa.select(prediction.c.uid).where(prediction.c.uid.in_([row.uid for row in some]))
        known = set(connection.execute(stored).scalars())
        results = _keys(connection, result.c.uid, result.c.id, [row.result_uid for row in some])
        conditions = _keys(connection, condition.c.key, condition.c.id, [row.condition_key for row in some])
        values = [
            {
                "uid": row.uid,
                "result": results[row.result_uid],
                "condition": conditions.get(row.condition_key),
                **{name: getattr(row, name) for name in _OWN},
            }
            for row in some
            if row.uid not in known
        ]
        if values:
            connection.execute(prediction.insert(), values)
            written(connection, "result", list(results))


def _keys(
    connection: sa.Connection, name: sa.ColumnElement[str], key: sa.ColumnElement[int], names: Sequence[str]
) -> dict[str, int]:
    rows = connection.execute(sa.select(name.label("name"), key.label("key")).where(name.in_(names)))
    return {row.name: row.key for row in rows}
