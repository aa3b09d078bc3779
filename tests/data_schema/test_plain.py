"""Statements that SQLite's driver runs itself do what SQLAlchemy does with them, on both engines."""

from __future__ import annotations

import contextlib
import math
from typing import Any

import pytest
import sqlalchemy as sa

from data_schema.engine import reading, writing
from data_schema.tables import METADATA
from data_schema.tables.equipment import battery
from data_schema.tables.plain import change, fetch, insert, insert_all, scan
from data_schema.tables.runs import charge
from data_schema.vocabulary import ChargeState

NAMES = ("uid", "name", "cells", "capacity_mah")
BY_NAME = sa.select(battery.c.uid, battery.c.capacity_mah).where(battery.c.name == sa.bindparam("called"))
RENAME = battery.update().where(battery.c.uid == sa.bindparam("this_uid"))


def pack(uid: str, **changed: Any) -> dict[str, Any]:
    return {"uid": uid, "name": f"pack {uid}", "cells": 6, "capacity_mah": 5000.5, **changed}


def stored(connection: sa.Connection, table: sa.Table) -> list[dict[str, Any]]:
    return [dict(row) for row in connection.execute(sa.select(table).order_by(table.c.id)).mappings()]


def test_rows_stand_as_sqlalchemy_writes_and_reads_them(engine: sa.Engine) -> None:
    with writing(engine) as connection:
        keys = [insert(connection, battery, pack(uid)) for uid in ("a", "ä")]
        insert_all(connection, battery, NAMES, [tuple(pack(uid).values()) for uid in ("c", "d")])
        insert_all(connection, battery, NAMES, [])
        connection.execute(battery.insert(), pack("e"))
        assert change(connection, RENAME, {"this_uid": "d", "cells": 3}) == 1
        assert change(connection, RENAME, {"this_uid": "nobody", "cells": 3}) == 0
    with reading(engine) as connection:
        rows = stored(connection, battery)
        assert keys == [row["id"] for row in rows[:2]]
        assert [(row["uid"], row["cells"]) for row in rows] == [("a", 6), ("ä", 6), ("c", 6), ("d", 3), ("e", 6)]
        assert {row["capacity_mah"] for row in rows} == {5000.5}
        assert [tuple(row) for row in fetch(connection, BY_NAME, {"called": "pack ä"})] == [("ä", 5000.5)]
        assert not fetch(connection, BY_NAME, {"called": "none"})
        every = sa.select(battery).order_by(battery.c.id)
        assert [row for some in scan(connection, every) for row in some] == [tuple(row.values()) for row in rows]


def test_columns_that_are_not_given_have_their_usual_values(engine: sa.Engine) -> None:
    with writing(engine) as connection:
        insert(
            connection, charge, {"uid": "c", "row_number": 1, "charge_mah": 1.0, "resolution_mah": 1, "mode": "charge"}
        )
        (row,) = stored(connection, charge)
    assert (row["assigned"], row["added"], row["state"], row["file"]) == (0, 0, ChargeState.COUNTED, None)


@pytest.mark.parametrize("number", [math.nan, math.inf, -math.inf])
def test_what_is_no_number_is_refused(engine: sa.Engine, number: float) -> None:
    with writing(engine) as connection:
        with pytest.raises((ValueError, sa.exc.StatementError), match="NULL"):
            insert(connection, battery, pack("a", capacity_mah=number))
        with pytest.raises((ValueError, sa.exc.StatementError), match="NULL"):
            insert_all(connection, battery, NAMES, [tuple(pack("a", capacity_mah=number).values())])
        assert stored(connection, battery) == []


@pytest.mark.parametrize("column", [column.name for column in charge.c if column.nullable])
def test_no_number_becomes_null(engine: sa.Engine, column: str) -> None:
    row = {"uid": "c", "row_number": 1, "charge_mah": 1.0, "resolution_mah": 1, "mode": "charge"}
    with contextlib.suppress(ValueError, sa.exc.StatementError), writing(engine) as connection:
        insert(connection, charge, {**row, column: math.nan})
    with reading(engine) as connection:
        assert all(one[column] is not None for one in stored(connection, charge))


@pytest.mark.parametrize(
    ("changed", "error"),
    [
        ({"name": "pack a"}, sa.exc.IntegrityError),
        ({"cells": None}, sa.exc.IntegrityError),
        ({"cells": []}, sa.exc.DBAPIError),
    ],
)
def test_what_breaks_a_rule_is_refused_as_by_sqlalchemy(
    engine: sa.Engine, changed: dict[str, Any], error: type[Exception]
) -> None:
    with writing(engine) as connection:
        insert(connection, battery, pack("a"))
    with pytest.raises(error) as plain, writing(engine) as connection:
        insert(connection, battery, pack("b", **changed))
    with pytest.raises(error) as usual, writing(engine) as connection:
        connection.execute(battery.insert(), [pack("b", **changed)])
    assert type(plain.value) is type(usual.value)
    with reading(engine) as connection:
        assert [row["uid"] for row in stored(connection, battery)] == ["a"]


def test_nothing_is_written_outside_of_a_transaction(engine: sa.Engine) -> None:
    with engine.connect() as connection:
        insert(connection, battery, pack("a"))
    with reading(engine) as connection:
        assert stored(connection, battery) == []


def test_every_reference_begins_a_key_or_has_an_index_and_not_both(engine: sa.Engine) -> None:
    with reading(engine) as connection:
        found = sa.inspect(connection)
        for table in METADATA.sorted_tables:
            keys = [found.get_pk_constraint(table.name), *found.get_unique_constraints(table.name)]
            first = [key["column_names"] for key in found.get_indexes(table.name) if not key["unique"]]
            indexed = [names[0] for names in first if len(names) == 1]
            begun = {key.get("column_names", key.get("constrained_columns"))[0] for key in keys}
            references = {key["constrained_columns"][0] for key in found.get_foreign_keys(table.name)}
            assert references <= begun | set(indexed)
            assert not begun & references & set(indexed)
