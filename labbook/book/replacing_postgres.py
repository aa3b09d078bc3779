"""Rebuilding on a PostgreSQL database: the new tables grow in a schema of their own, which is then renamed.

The two schemas change their names in one transaction; until then the old tables are in use. Afterwards these lie in a
schema `before_rebuild_<time>`, which can be dropped when nothing is missing. The new tables have the owners and rights
of the old ones. What a lab made on the book's tables itself (views, foreign keys, functions) would stay on the old
ones: it stops the rebuild before it has begun, by name.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator

import sqlalchemy as sa

from data_schema import journal
from data_schema.disk import stamp
from data_schema.engine import BUSY_TIMEOUT_S, POSTGRES_SCHEMA, postgres_engine, translated_errors
from data_schema.errors import UsageError
from data_schema.tables import METADATA
from labbook.book.making import make_tables
from labbook.book.opening import shown

FRESH = f"{POSTGRES_SCHEMA}_rebuild"
"""The schema in which new tables grow; what an interrupted rebuild left there is removed by the next."""

INSUFFICIENT_PRIVILEGE = "42501"
"""How the server names a refusal, in its own list of conditions."""


_STAYS = (
    "it would stay with the old tables, and nothing was changed: drop it, rebuild, and make it again on the new ones."
)


def replace_postgres(
    url: str,
    fill: Callable[[sa.Engine], None],
    finish: Callable[[sa.Engine, tuple[int, str]], None],
    busy_timeout_s: float = BUSY_TIMEOUT_S,
) -> str | None:
    """Make the book's tables anew; returns the schema in which the old ones are kept, None where there were none.

    `fill` writes everything into an engine whose tables are empty; `finish` brings them up to date and gets number and
    hash of the old journal's last entry: nobody else can write to the book while it runs, nor until all is done.
    """
    engine, fresh = postgres_engine(url, busy_timeout_s=busy_timeout_s), postgres_engine(url, schema=FRESH)
    try:
        with _allowed(engine), engine.begin() as connection:
            _refuse_dependents(connection, POSTGRES_SCHEMA, _STAYS)
            connection.exec_driver_sql(f"DROP SCHEMA IF EXISTS {FRESH} CASCADE")
            connection.exec_driver_sql(f"CREATE SCHEMA {FRESH}")
        make_tables(fresh)
        fill(fresh)
        with _allowed(engine), translated_errors(), engine.begin() as connection:
            tables = set(sa.inspect(connection).get_table_names(POSTGRES_SCHEMA))
            if "journal" in tables:
                connection.exec_driver_sql("LOCK TABLE journal IN ACCESS EXCLUSIVE MODE")
                finish(fresh, journal.head(connection))
            else:
                finish(fresh, (0, journal.GENESIS))
            fresh.dispose()
            return _change_names(connection, sorted(tables))
    finally:
        fresh.dispose()
        with engine.begin() as connection:
            connection.exec_driver_sql(f"DROP SCHEMA IF EXISTS {FRESH} CASCADE")
        engine.dispose()


def _change_names(connection: sa.Connection, tables: list[str]) -> str | None:
    aside = None
    if tables:
        names = ", ".join(map(_quoted(connection), tables))
        connection.exec_driver_sql(f"LOCK TABLE {names}")  # those who read have finished then
        _refuse_dependents(connection, POSTGRES_SCHEMA, _STAYS)
        aside = f"before_rebuild_{stamp().lower()}"
        connection.exec_driver_sql(f"ALTER SCHEMA {POSTGRES_SCHEMA} RENAME TO {aside}")
    else:
        connection.exec_driver_sql(f"DROP SCHEMA IF EXISTS {POSTGRES_SCHEMA}")
    connection.exec_driver_sql(f"ALTER SCHEMA {FRESH} RENAME TO {POSTGRES_SCHEMA}")
    if aside is not None:
        rights = connection.execute(sa.text(_RIGHTS), {"old": aside}).scalars().all()
        for statement in rights:
            connection.exec_driver_sql(statement)
    return aside


_WHO = "CASE grantee WHEN 0 THEN 'PUBLIC' ELSE quote_ident(pg_get_userbyid(grantee)) END"
_RIGHTS = f"""
WITH schema AS (SELECT * FROM pg_namespace WHERE nspname = :old),
    relation AS (SELECT * FROM pg_class WHERE relnamespace = (SELECT oid FROM schema) AND relkind IN ('r', 'S'))
SELECT format('GRANT %s ON SCHEMA %I TO %s', privilege_type, '{POSTGRES_SCHEMA}', {_WHO})
    FROM schema, aclexplode(nspacl) WHERE grantee <> nspowner
UNION ALL
SELECT format('GRANT %s ON %s %I.%I TO %s', privilege_type, CASE relkind WHEN 'S' THEN 'SEQUENCE' ELSE 'TABLE' END,
    '{POSTGRES_SCHEMA}', relname, {_WHO}) FROM relation, aclexplode(relacl) WHERE grantee <> relowner
UNION ALL
SELECT format('ALTER TABLE %I.%I OWNER TO %I', '{POSTGRES_SCHEMA}', relname, pg_get_userbyid(relowner))
    FROM relation WHERE relkind = 'r' AND pg_get_userbyid(relowner) <> current_user
UNION ALL
SELECT format('ALTER SCHEMA %I OWNER TO %I', '{POSTGRES_SCHEMA}', pg_get_userbyid(nspowner))
    FROM schema WHERE pg_get_userbyid(nspowner) <> current_user
"""  # noqa: S608 - nothing of it is given by anybody
"""Statements that give the new tables the rights and owners that the old ones of the same names have."""


def _refuse_dependents(connection: sa.Connection, schema: str, sentence: str) -> None:
    """Raise `UsageError` where somebody else made something in the schema of a book, or on its tables."""
    made = set(sa.inspect(connection).get_table_names(schema)) - set(METADATA.tables)
    others = [f"table {name}" for name in sorted(made)]
    others += connection.execute(sa.text(_DEPENDENTS), {"schema": schema}).scalars().all()
    if others:
        raise UsageError(f"{', '.join(others)} in {schema} or on its tables: made by somebody else; {sentence}")


_DEPENDENTS = """
WITH book AS (
    SELECT oid, reltype FROM pg_class
    WHERE relkind = 'r' AND relnamespace = (SELECT oid FROM pg_namespace WHERE nspname = :schema)
), found AS (
    SELECT DISTINCT d.classid, d.objid FROM pg_depend d
    JOIN book ON (d.refclassid = 'pg_class'::regclass AND d.refobjid = book.oid)
        OR (d.refclassid = 'pg_type'::regclass AND d.refobjid = book.reltype)
    WHERE d.deptype = 'n' OR d.classid IN ('pg_policy'::regclass, 'pg_publication_rel'::regclass)
)
SELECT DISTINCT CASE WHEN r.rulename = '_RETURN' THEN pg_describe_object('pg_class'::regclass, r.ev_class, 0)
    ELSE pg_describe_object(f.classid, f.objid, 0) END AS description
FROM found f
LEFT JOIN pg_rewrite r ON f.classid = 'pg_rewrite'::regclass AND r.oid = f.objid
LEFT JOIN pg_constraint c ON f.classid = 'pg_constraint'::regclass AND c.oid = f.objid
WHERE c.oid IS NULL OR c.conrelid NOT IN (SELECT oid FROM book)
ORDER BY description
"""
"""Whatever names the book's tables in its own definition, except the book's own foreign keys."""


@contextlib.contextmanager
def _allowed(engine: sa.Engine) -> Iterator[None]:
    """Say what a rebuild needs where the server refuses it."""
    try:
        yield
    except sa.exc.ProgrammingError as error:
        if getattr(error.orig, "sqlstate", None) != INSUFFICIENT_PRIVILEGE:
            raise
        raise UsageError(
            f"the database {shown(engine)} refused ({str(error.orig).splitlines()[0]}) and nothing was changed: "
            "rebuild as the role that owns the book's tables, and let it make schemas with GRANT CREATE ON DATABASE."
        ) from error


def _quoted(connection: sa.Connection) -> Callable[[str], str]:
    return connection.dialect.identifier_preparer.quote


def old_schemas(connection: sa.Connection) -> list[tuple[str, int]]:
    """List the schemas that hold old tables, with their sizes in bytes."""
    rows = connection.execute(
        sa.text(
            "SELECT n.nspname, coalesce(sum(pg_total_relation_size(c.oid)), 0) FROM pg_namespace n "
            "LEFT JOIN pg_class c ON c.relnamespace = n.oid AND c.relkind = 'r' "
            "WHERE n.nspname ~ '^before_rebuild_[0-9]{8}t[0-9]{12}z$' GROUP BY n.nspname ORDER BY n.nspname"
        )
    )
    return [(name, int(n_bytes)) for name, n_bytes in rows]


def drop_old(connection: sa.Connection, schema: str) -> None:
    """Remove a schema of old tables; raises `UsageError` where something that a lab made depends on them."""
    _refuse_dependents(connection, schema, "nothing was removed, drop it first.")
    with _allowed(connection.engine):
        connection.exec_driver_sql(f"DROP SCHEMA {_quoted(connection)(schema)} CASCADE")
