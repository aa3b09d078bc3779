"""The form of a database compared with what labbook makes: tables, columns, indexes, constraints, views and triggers.

On SQLite every object's own text is compared with that of an empty database made now. PostgreSQL keeps no text: there
columns, indexes and constraints are compared with the declared ones, and views as the server words them.
What a lab made beside these, as views of its own, is let be; a trigger is not, for it changes what is stated.
"""

from __future__ import annotations

from collections.abc import Iterator

import sqlalchemy as sa

from data_schema.engine import NOT_ALLOWED
from data_schema.schema import create_tables
from data_schema.tables import METADATA
from data_schema.tables.journal import POSTGRES_FUNCTION, SQLITE_TRIGGERS
from data_schema.views import VIEWS

GUARDS = {"sqlite": SQLITE_TRIGGERS, "postgresql": {"journal_never_changed": f"O {POSTGRES_FUNCTION}"}}
"""The triggers that labbook makes, with what they do: on PostgreSQL their function, after O for one that is enabled."""
_TRIGGERS = {
    "sqlite": "SELECT name, sql FROM sqlite_master WHERE type = 'trigger'",
    "postgresql": "SELECT t.tgname, t.tgenabled::text || ' ' || p.prosrc FROM pg_trigger t "
    "JOIN pg_class c ON c.oid = t.tgrelid JOIN pg_proc p ON p.oid = t.tgfoid "
    "WHERE NOT t.tgisinternal AND c.relnamespace = current_schema()::regnamespace",
}


def altered_schema(connection: sa.Connection) -> list[str]:
    """Return a sentence for each table, column, index, constraint, view or trigger that is not as labbook made it."""
    form = _form_on_sqlite if connection.dialect.name == "sqlite" else _form_on_postgres
    return [*form(connection), *_foreign_triggers(connection)]


def _form_on_sqlite(connection: sa.Connection) -> Iterator[str]:
    empty = sa.create_engine("sqlite://")
    with empty.connect() as fresh:
        create_tables(fresh)
        wanted = _objects(fresh)
    empty.dispose()
    found = _objects(connection)
    for name, (kind, text) in wanted.items():
        if name not in found:
            yield f"{kind} {name} of the database is gone."
        elif found[name][0] != kind:
            yield f"{name} of the database is a {found[name][0]} and should be a {kind}."
        elif found[name][1] != text:
            yield f"{kind} {name} of the database was changed: it is {found[name][1]!r} and should be {text!r}."


def _objects(connection: sa.Connection) -> dict[str, tuple[str, str]]:
    """Return kind and text of all that a SQLite database has but its triggers and what SQLite makes by itself."""
    rows = connection.exec_driver_sql("SELECT name, type, sql FROM sqlite_master WHERE type <> 'trigger'")
    return {name: (kind, " ".join((text or "").split())) for name, kind, text in rows if not name.startswith("sqlite_")}


_RELATIONS = "SELECT relname, relkind::text FROM pg_class WHERE relnamespace = current_schema()::regnamespace"
_COLUMNS = (
    "SELECT c.relname, a.attname, format_type(a.atttypid, a.atttypmod), a.attnotnull FROM pg_attribute a "
    "JOIN pg_class c ON c.oid = a.attrelid WHERE c.relnamespace = current_schema()::regnamespace "
    "AND a.attnum > 0 AND NOT a.attisdropped AND c.relkind IN ('r', 'v')"
)
_INDEXES = (
    "SELECT i.relname, x.indisunique, array_agg(a.attname::text ORDER BY k.place) FROM pg_index x "
    "JOIN pg_class i ON i.oid = x.indexrelid CROSS JOIN unnest(x.indkey) WITH ORDINALITY AS k(attnum, place) "
    "JOIN pg_attribute a ON a.attrelid = x.indrelid AND a.attnum = k.attnum "
    "WHERE i.relnamespace = current_schema()::regnamespace AND x.indisvalid GROUP BY i.relname, x.indisunique"
)
_CONSTRAINTS = "SELECT conname FROM pg_constraint WHERE connamespace = current_schema()::regnamespace AND convalidated"
_CALLED = {"float": "double precision"}
"""What PostgreSQL calls a type that is declared otherwise."""
_KINDS = {"r": "table", "v": "view"}


def _form_on_postgres(connection: sa.Connection) -> Iterator[str]:
    kinds = {name: _KINDS.get(kind, kind) for name, kind in connection.exec_driver_sql(_RELATIONS)}
    wanted = {**dict.fromkeys(METADATA.tables, "table"), **dict.fromkeys(VIEWS, "view")}
    for name, kind in wanted.items():
        if name not in kinds:
            yield f"{kind} {name} of the database is gone."
        elif kinds[name] != kind:
            yield f"{name} of the database is a {kinds[name]} and should be a {kind}."
    columns: dict[str, dict[str, str]] = {}
    for name, column, form, required in connection.exec_driver_sql(_COLUMNS):
        columns.setdefault(name, {})[column] = f"{form}{' NOT NULL' if required else ''}"
    indexes = {name: (unique, tuple(of)) for name, unique, of in connection.exec_driver_sql(_INDEXES)}
    constraints = set(connection.exec_driver_sql(_CONSTRAINTS).scalars())
    for table in METADATA.sorted_tables:
        if kinds.get(table.name) == "table":
            yield from _of_table(connection, table, columns[table.name], indexes, constraints)
    for name, view in VIEWS.items():
        if kinds.get(name) == "view" and kinds.keys() >= METADATA.tables.keys():
            yield from _of_view(connection, name, view.query)


def _of_table(
    connection: sa.Connection,
    table: sa.Table,
    columns: dict[str, str],
    indexes: dict[str, tuple[bool, tuple[str, ...]]],
    constraints: set[str],
) -> Iterator[str]:
    for column in table.c:
        form = column.type.compile(connection.dialect).lower()
        form = _CALLED.get(form, form) + ("" if column.nullable else " NOT NULL")
        if columns.pop(column.name, "gone") != form:
            yield f"column {column.name} of table {table.name} of the database was changed: it should be {form}."
    yield from (f"column {name} of table {table.name} of the database is not labbook's." for name in columns)
    for index in table.indexes:
        found = indexes.get(str(index.name))
        if found != (index.unique, tuple(index.columns.keys())):
            yield f"index {index.name} of the database {'is gone' if found is None else 'was changed'}."
    for constraint in table.constraints:
        name = connection.dialect.identifier_preparer.format_constraint(constraint)
        if name is not None and name.strip('"') not in constraints:
            yield f"constraint {name} of table {table.name} of the database is gone."


def _of_view(connection: sa.Connection, name: str, query: str) -> Iterator[str]:
    """Compare how the server words a view with how it words its query, in a view that is gone again at once."""
    savepoint, same = connection.begin_nested(), True
    worded = f"SELECT pg_get_viewdef('labbooks'::regclass) = pg_get_viewdef('{name}'::regclass)"
    try:
        connection.exec_driver_sql(f"CREATE TEMPORARY VIEW labbooks AS {query}")
        same = connection.exec_driver_sql(worded).scalar_one()
    except (sa.exc.ProgrammingError, sa.exc.InternalError) as error:
        same = getattr(error.orig, "sqlstate", None) in NOT_ALLOWED  # who may only read cannot compare them
    finally:
        savepoint.rollback()
    if not same:
        yield f"view {name} of the database was changed."


def _foreign_triggers(connection: sa.Connection) -> Iterator[str]:
    """Say which triggers labbook did not make, and which of its own were changed or are gone."""
    guards = GUARDS[connection.dialect.name]
    found = connection.exec_driver_sql(_TRIGGERS[connection.dialect.name])
    triggers = {name: " ".join(text.split()) for name, text in found}
    yield from (f"trigger {name} of the database is not labbook's." for name in sorted(triggers.keys() - guards.keys()))
    for name, text in guards.items():
        if triggers.get(name) != text:
            yield f"trigger {name}, which guards the journal, {'was changed' if name in triggers else 'is gone'}."
