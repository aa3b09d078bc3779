"""What the tables refuse on both engines, and the traps of each that make it necessary."""

from __future__ import annotations

import math
import sqlite3
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import pytest
import sqlalchemy as sa
from sqlalchemy.exc import DBAPIError, IntegrityError, StatementError

from data_schema import journal
from data_schema.engine import reading, sqlite_engine, writing
from data_schema.errors import BookDamaged
from data_schema.tables import METADATA
from data_schema.tables.equipment import battery, instrument, robot
from data_schema.tables.files import file, ingest
from data_schema.tables.journal import config, person
from tests.helpers.journals import chain, write_all

TABLES = METADATA.sorted_tables


def add_person(connection: sa.Connection, name: str = "Ada") -> int:
    done = connection.execute(person.insert().values(uid=f"p-{name}", name=name, initials=name[:2]))
    assert done.inserted_primary_key is not None
    return int(done.inserted_primary_key[0])


def refused(engine: sa.Engine, table: sa.Table, match: str, **values: object) -> None:
    """Inserting the row breaks the rule of that name, and leaves nothing."""
    with pytest.raises(IntegrityError, match=match), writing(engine) as connection:
        connection.execute(table.insert().values(**values))
    with reading(engine) as connection:
        assert connection.execute(sa.select(sa.func.count()).select_from(table)).scalar_one() == 0


# --- names, types and references, of all tables


def test_every_rule_has_a_name_by_which_it_is_put_in_words(engine: sa.Engine) -> None:
    with reading(engine) as connection:
        found = sa.inspect(connection)
        for table in TABLES:
            rules = [
                found.get_pk_constraint(table.name),
                *found.get_unique_constraints(table.name),
                *found.get_check_constraints(table.name),
                *found.get_foreign_keys(table.name),
            ]
            assert all(constraint.name for constraint in table.constraints)
            assert {rule["name"] for rule in rules} == {constraint.name for constraint in table.constraints}


def test_every_table_is_strict_on_sqlite(sqlite_with_tables: Path) -> None:
    with closing(sqlite3.connect(sqlite_with_tables)) as connection:
        listed = connection.execute(
            "SELECT name, strict FROM pragma_table_list WHERE schema = 'main' AND type = 'table'"
        ).fetchall()
    strict = {name for name, is_strict in listed if is_strict}
    assert {table.name for table in TABLES} <= strict
    assert {name for name, is_strict in listed if not is_strict} <= {"sqlite_schema"}


def test_what_is_referred_to_cannot_go(engine: sa.Engine) -> None:
    with writing(engine) as connection:
        write_all(connection, chain([{}]))
    for statement in ("DELETE FROM person", "UPDATE person SET id = id + 1"):
        with pytest.raises(IntegrityError, match=r"FOREIGN KEY|fk_journal_person"), writing(engine) as connection:
            connection.exec_driver_sql(statement)


# --- values


def test_what_is_no_number_is_never_stored_as_one(engine: sa.Engine) -> None:
    for value in (math.nan, math.inf, -math.inf):
        with pytest.raises(StatementError, match="store NULL and"), writing(engine) as connection:
            connection.execute(battery.insert().values(uid="b", name="A", cells=4, capacity_mah=value))


def test_sizes_and_counts_have_64_bits_and_a_double_comes_back_to_the_last_bit(engine: sa.Engine) -> None:
    sizes = [2**31, 2**32 + 1, 2**53 + 1, 2**63 - 1]
    rows = [{"id": size - 1, "uid": f"f{size}", "sha256": f"s{size}", "n_bytes": size} for size in sizes]
    with writing(engine) as connection:
        connection.execute(file.insert(), [{**row, "store_path": "p"} for row in rows])
        connection.execute(battery.insert().values(uid="b", name="A", cells=4, capacity_mah=0.1 + 0.2))
    with reading(engine) as connection:
        found = connection.execute(sa.select(file.c.id, file.c.n_bytes).order_by(file.c.id)).all()
        assert connection.execute(sa.select(battery.c.capacity_mah)).scalar_one() == 0.1 + 0.2
    assert [tuple(row) for row in found] == [(size - 1, size) for size in sizes]


ROBOT = {
    "uid": "r", "name": "hopper", "valid_from_utc": "", "body_mass_kg": 1.8, "foot_mass_kg": 0.2, "link_1_m": 0.1,
    "link_2_m": 0.2, "rest_length_m": 0.27, "leg_min_m": 0.1, "leg_max_m": 0.3,
}  # fmt: skip


def test_closed_lists_and_ranges_are_kept_by_the_tables(engine: sa.Engine) -> None:
    refused(engine, battery, "ck_battery_cells_counted", uid="b", name="A", cells=0, capacity_mah=1.0)
    refused(engine, battery, "ck_battery_capacity_positive", uid="b", name="A", cells=1, capacity_mah=0.0)
    refused(engine, robot, "ck_robot_leg_range", **{**ROBOT, "leg_min_m": 0.4})
    refused(engine, instrument, "NOT NULL|null value", uid="i", name="plate", kind=None)


def test_the_same_bytes_are_imported_once_but_may_be_refused_often(engine: sa.Engine) -> None:
    with writing(engine) as connection:
        who = add_person(connection)
        connection.execute(config.insert().values(id=1, uid="c", sha256="s", text="", read_utc="now"))
        connection.execute(file.insert().values(id=1, uid="f", sha256="s", n_bytes=1, store_path="p"))

    def add(uid: str, status: str, file_key: int | None) -> None:
        with writing(engine) as connection:
            connection.execute(
                ingest.insert().values(
                    uid=uid, sha256="s", file=file_key, original_name="a.csv", status=status, reader="r",
                    reader_version=1, options_json="{}", declared_json="{}", rows_read=0, rows_kept=0, rows_rejected=0,
                    config=1, person=who, at_utc="now",
                )
            )  # fmt: skip

    add("i1", "refused", None)
    add("i2", "refused", None)
    add("i3", "imported", 1)
    with pytest.raises(IntegrityError, match=r"uq_ingest_imported_sha256|ingest.sha256"):
        add("i4", "imported", 1)
    with pytest.raises(IntegrityError, match="imported_has_file"):
        add("i5", "imported", None)


# --- the journal is only ever added to


def replace_on(dialect: str) -> str:
    """Insert over an entry that stands."""
    columns = "seq, following, at_utc, person, action, entity_kind, entity_uid, prev_hash, hash"
    row = "1, 0, 'never', 1, 'note', 'note', 'x', '0', 'forged'"
    if dialect == "sqlite":
        return f"INSERT OR REPLACE INTO journal (id, {columns}) VALUES (1, {row})"
    return f"INSERT INTO journal ({columns}) VALUES ({row}) ON CONFLICT (seq) DO UPDATE SET at_utc = 'never'"


CHANGES: dict[str, Callable[[str], str]] = {
    "update": lambda _dialect: "UPDATE journal SET reason = 'because'",
    "delete": lambda _dialect: "DELETE FROM journal WHERE seq = 2",
    "delete all": lambda _dialect: "DELETE FROM journal",
    "replace": replace_on,
    "upsert": lambda _dialect: replace_on("postgresql"),
    "truncate": lambda dialect: "TRUNCATE journal" if dialect == "postgresql" else "DELETE FROM journal WHERE 1",
    "truncate all": lambda dialect: (
        "TRUNCATE person CASCADE" if dialect == "postgresql" else "UPDATE OR REPLACE journal SET seq = 1"
    ),
}


def test_nothing_changes_a_journal_entry(engine: sa.Engine) -> None:
    entries = chain([{}, {}, {}])
    with writing(engine) as connection:
        write_all(connection, entries)
    for name, change in CHANGES.items():
        with pytest.raises(DBAPIError, match="only ever added"), writing(engine) as connection:
            connection.exec_driver_sql(change(engine.dialect.name))
        with reading(engine) as connection:
            assert list(journal.stored(connection)) == entries, name


def test_a_writer_without_our_settings_gets_past_the_triggers_but_not_past_the_hashes(
    sqlite_with_tables: Path, tmp_path: Path
) -> None:
    """The trap itself: INSERT OR REPLACE deletes without a trigger unless recursive_triggers is on."""
    path = tmp_path / "labbook.db"
    path.write_bytes(sqlite_with_tables.read_bytes())
    engine = sqlite_engine(path)
    with writing(engine) as connection:
        write_all(connection, chain([{}, {}, {}]))
    with closing(sqlite3.connect(path)) as foreign, foreign:
        foreign.execute(replace_on("sqlite"))
    with reading(engine) as connection, pytest.raises(BookDamaged, match=r"was changed|not follow"):
        list(journal.verified_chain(journal.stored(connection)))
    engine.dispose()
