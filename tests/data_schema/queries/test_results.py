"""Storing results by the thousand: what is stored comes back, and what became of their rivals."""

from __future__ import annotations

import sqlalchemy as sa

from data_schema.engine import reading, writing
from data_schema.queries.results import InputRow, NumberRow, ResultRow, add_results, mark_current, results_by_key
from data_schema.tables.base import CHUNK
from data_schema.tables.journal import config, person

MANY = 2 * CHUNK + 1


def result(number: int, version: int = 1) -> ResultRow:
    """A result of its own scope; another version is a rival."""
    key = f"{number}-{version}"
    return ResultRow(
        uid=f"uid-{key}",
        kind="kind",
        scope_json=f'{{"run":"r{number}"}}',
        key=key,
        algorithm="algorithm",
        version=version,
        payload_json="{}",
        stale=False,
        numbers=(
            NumberRow(f"n-{key}", "value", 0.1 * number, "m", 0.5, None, None, None, None, 3.0, number, None),
            NumberRow(f"u-{key}", "without", None, "J", None, None, None, None, None, None, None, "no charge"),
        ),
        inputs=(InputRow("log", "signal", f"s{number}", "ab"), InputRow("run", "run", f"r{number}", "cd")),
    )


def stored(engine: sa.Engine, *batches: list[ResultRow]) -> dict[str, ResultRow]:
    """Store batches, each in a transaction of its own, and read everything back."""
    with writing(engine) as connection:
        connection.execute(person.insert().values(uid="p", name="Ada", initials="AN"))
        connection.execute(config.insert().values(uid="c", sha256="00", text="", read_utc="2021-06-14T08:00:00Z"))
    for batch in batches:
        with writing(engine) as connection:
            add_results(connection, batch)
    with reading(engine) as connection:
        return results_by_key(connection)


def test_more_results_than_one_query_takes_come_back_as_they_were_in_their_order(engine: sa.Engine) -> None:
    rows = [result(number) for number in range(MANY)]
    found = stored(engine, rows)
    assert list(found.values()) == rows
    with reading(engine) as connection:
        assert results_by_key(connection, [row.key for row in rows[::-1]]) == found
        assert results_by_key(connection, []) == {}


def test_a_new_result_makes_its_rivals_stale_and_nothing_else(engine: sa.Engine) -> None:
    found = stored(engine, [result(number) for number in range(MANY)], [result(3, 2), result(CHUNK + 3, 2)])
    assert {key for key, row in found.items() if row.stale} == {"3-1", f"{CHUNK + 3}-1"}


def test_an_old_result_renewed_is_current_and_its_rival_is_not(engine: sa.Engine) -> None:
    old = [result(number) for number in range(MANY)]
    stored(engine, old, [result(number, 2) for number in range(MANY)])
    with writing(engine) as connection:
        mark_current(connection, old[:-1])
    with reading(engine) as connection:
        found = results_by_key(connection)
    assert {key for key, row in found.items() if not row.stale} == {row.key for row in old[:-1]} | {f"{MANY - 1}-2"}
