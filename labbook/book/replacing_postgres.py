"""Rebuilding on the book's own PostgreSQL database: the new tables grow in a schema of their own, then change places.

The change is one transaction; until then the old tables are in use. Afterwards they lie in a schema
`before_rebuild_<time>`, which can be dropped when nothing is missing. The new tables have the owners and rights of the
old ones, and a lab's own views show the new.

A view depends on tables, not on their names: left alone, it would show the old ones for ever. So every view is defined
again, in place, by its own text, which then means the new tables; owner, rights, comments and what depends on the view
stay. What cannot be defined again in place (materialized views, foreign keys of other tables, functions, rules,
policies, publications) stops the rebuild before it has begun, by name.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import sqlalchemy as sa

from data_schema import journal
from data_schema.disk import stamp
from data_schema.engine import postgres_engine, reading, translated_errors
from data_schema.errors import UsageError
from data_schema.schema import schema_of
from data_schema.tables import METADATA
from labbook.book.making import make_tables
from labbook.book.opening import shown

INSUFFICIENT_PRIVILEGE = "42501"
"""How the server names a refusal, in its own list of conditions."""


@dataclass(frozen=True, slots=True)
class View:
    """A view that depends on the book's tables: its quoted name, its options, and its text as it reads now."""

    name: str
    options: tuple[str, ...]
    text: str


_STANDING_ON = """
WITH book AS (
    SELECT c.oid, c.reltype FROM pg_class c
    WHERE c.relname = ANY(:tables) AND c.relnamespace = (SELECT oid FROM pg_namespace WHERE nspname = :schema)
), found AS (
    SELECT DISTINCT d.classid, d.objid FROM pg_depend d
    JOIN book ON (d.refclassid = 'pg_class'::regclass AND d.refobjid = book.oid)
        OR (d.refclassid = 'pg_type'::regclass AND d.refobjid = book.reltype)
    WHERE d.deptype = 'n' OR d.classid IN ('pg_policy'::regclass, 'pg_publication_rel'::regclass)
)
SELECT v.oid AS view, CASE WHEN r.rulename = '_RETURN' THEN pg_describe_object('pg_class'::regclass, r.ev_class, 0)
    ELSE pg_describe_object(f.classid, f.objid, 0) END AS description
FROM found f
LEFT JOIN pg_rewrite r ON f.classid = 'pg_rewrite'::regclass AND r.oid = f.objid
LEFT JOIN pg_class v ON v.oid = r.ev_class AND v.relkind = 'v' AND r.rulename = '_RETURN'
LEFT JOIN pg_constraint c ON f.classid = 'pg_constraint'::regclass AND c.oid = f.objid
WHERE c.oid IS NULL OR c.conrelid NOT IN (SELECT oid FROM book)
ORDER BY description
"""
"""Whatever names the book's tables in its own definition, except the book's own foreign keys."""


def refuse_what_cannot_follow(connection: sa.Connection, schema: str, tables: Sequence[str]) -> None:
    """Raise `UsageError` where something other than a view depends on these tables."""
    others = [row.description for row in _dependent_views(connection, schema, tables) if row.view is None]
    if others:
        raise UsageError(
            f"{', '.join(others)}: made on the book's tables by somebody else, and cannot follow to the new ones; "
            "nothing was changed. Drop it, rebuild, and make it again."
        )


def views_on(connection: sa.Connection, schema: str, tables: Sequence[str]) -> list[View]:
    """Return the views that depend on these tables, with texts that name them as the search path finds them."""
    oids = [row.view for row in _dependent_views(connection, schema, tables) if row.view is not None]
    rows = connection.execute(
        sa.text(
            "SELECT quote_ident(n.nspname) || '.' || quote_ident(c.relname) AS name, c.reloptions AS options, "
            "pg_get_viewdef(c.oid) AS text FROM pg_class c JOIN pg_namespace n ON n.oid = c.relnamespace "
            "WHERE c.oid = ANY(:oids) ORDER BY name"
        ),
        {"oids": oids},
    )
    return [View(row.name, tuple(row.options or ()), row.text) for row in rows]


def define_again(connection: sa.Connection, views: Sequence[View]) -> None:
    """Define views again on the tables that now have the names in their texts; raises `UsageError` where one cannot."""
    for view in views:
        options = f" WITH ({', '.join(view.options)})" if view.options else ""
        statement = f"CREATE OR REPLACE VIEW {view.name}{options} AS {view.text}"
        try:  # a text may hold a %, which is no place for a parameter
            connection.exec_driver_sql(statement, execution_options={"no_parameters": True})
        except (sa.exc.ProgrammingError, sa.exc.NotSupportedError) as error:
            if getattr(error.orig, "sqlstate", None) == INSUFFICIENT_PRIVILEGE:
                raise
            raise UsageError(
                f"the view {view.name} cannot stand on the new tables ({str(error.orig).splitlines()[0]}); nothing was "
                "changed. Drop it, rebuild, and make it again."
            ) from error


def _dependent_views(
    connection: sa.Connection, schema: str, tables: Sequence[str]
) -> Sequence[sa.Row[tuple[int, str]]]:
    return connection.execute(sa.text(_STANDING_ON), {"tables": list(tables), "schema": schema}).all()


FRESH = "labbook_rebuild"
"""The schema in which new tables grow; what an interrupted rebuild left there is removed by the next."""

_OWN = set(METADATA.tables)


def replace_postgres(
    engine: sa.Engine,
    url: str,
    fill: Callable[[sa.Engine], None],
    finish: Callable[[sa.Engine, tuple[int, str]], None],
) -> str | None:
    """Make the book's tables anew; returns the schema in which the old ones are kept, None where there were none.

    `fill` writes everything into an engine whose tables are empty; `finish` brings them up to date and gets number and
    hash of the old journal's last entry: nobody else can write to the book while it runs, nor until all is done.
    """
    _refuse_foreign(engine)
    with _allowed(engine), engine.begin() as connection:
        connection.exec_driver_sql(f"DROP SCHEMA IF EXISTS {FRESH} CASCADE")
        connection.exec_driver_sql(f"CREATE SCHEMA {FRESH}")
    fresh = postgres_engine(url, schema=FRESH)
    try:
        make_tables(fresh)
        fill(fresh)
        with _allowed(engine), translated_errors(), engine.begin() as connection:
            old = _tables(connection, _schema_of_book(connection))
            if "journal" in old:
                connection.exec_driver_sql("LOCK TABLE journal IN ACCESS EXCLUSIVE MODE")
                finish(fresh, journal.head(connection))
            else:
                finish(fresh, (0, journal.GENESIS))
            fresh.dispose()
            return _change_places(connection, old)
    finally:
        fresh.dispose()
        with engine.begin() as connection:
            connection.exec_driver_sql(f"DROP SCHEMA IF EXISTS {FRESH} CASCADE")


def _refuse_foreign(engine: sa.Engine) -> None:
    """Refuse a database that holds another program's tables only, or a newer labbook's."""
    with reading(engine) as connection:
        tables = _tables(connection, _schema_of_book(connection))
        others = sorted(set(sa.inspect(connection).get_table_names()) - set(tables))
        found = schema_of(connection)
    if found is not None and "journal" in tables:
        with reading(engine) as connection:  # now, and not only when all is computed anew
            refuse_what_cannot_follow(connection, _schema_of_book(connection), tables)
    elif tables or others:
        raise UsageError(
            f"the database {shown(engine)} holds {', '.join([*others, *tables][:3])} and no book: give [database] url "
            "of the book's own, or of an empty one."
        )


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


def _schema_of_book(connection: sa.Connection) -> str:
    home: str = connection.exec_driver_sql("SELECT current_schema()").scalar_one()
    return home


def _tables(connection: sa.Connection, schema: str) -> list[str]:
    """Return the book's own tables in a schema, in one order for all."""
    return sorted(_OWN & set(sa.inspect(connection).get_table_names(schema)))


def _change_places(connection: sa.Connection, old: Sequence[str]) -> str | None:
    home = _schema_of_book(connection)
    if not old:
        _move(connection, sorted(_OWN), FRESH, home)
        return None
    aside = f"before_rebuild_{stamp().lower()}"
    connection.exec_driver_sql(f"LOCK TABLE {', '.join(_name(connection, home, name) for name in old)}")
    refuse_what_cannot_follow(connection, home, old)
    views = views_on(connection, home, old)
    connection.exec_driver_sql(f"CREATE SCHEMA {aside}")
    _move(connection, old, home, aside)
    _move(connection, sorted(_OWN), FRESH, home)
    _same_rights(connection, aside, home)
    define_again(connection, views)
    return aside


def _move(connection: sa.Connection, tables: Sequence[str], source: str, target: str) -> None:
    """Move tables to another schema with all that is theirs: indexes, rules, sequences, triggers' functions."""
    quoted = connection.dialect.identifier_preparer.quote
    functions = connection.execute(
        sa.text(
            "SELECT DISTINCT f.proname FROM pg_trigger t JOIN pg_proc f ON f.oid = t.tgfoid "
            "JOIN pg_class c ON c.oid = t.tgrelid WHERE NOT t.tgisinternal AND c.relname = ANY(:tables) "
            "AND c.relnamespace = (SELECT oid FROM pg_namespace WHERE nspname = :source)"
        ),
        {"tables": list(tables), "source": source},
    ).scalars()
    for name in functions:
        connection.exec_driver_sql(f"ALTER FUNCTION {_name(connection, source, name)}() SET SCHEMA {quoted(target)}")
    for name in tables:
        connection.exec_driver_sql(f"ALTER TABLE {_name(connection, source, name)} SET SCHEMA {quoted(target)}")


def _same_rights(connection: sa.Connection, old: str, new: str) -> None:
    """Give the new tables the owner and the rights of the old ones of the same name."""
    quoted = connection.dialect.identifier_preparer.quote
    rows = connection.execute(
        sa.text(
            "SELECT c.relname AS name, pg_get_userbyid(c.relowner) AS owner, pg_get_userbyid(a.grantee) AS role, "
            "a.grantee = 0 AS public, a.privilege_type AS may, a.is_grantable AS may_pass_on, "
            "c.relkind = 'S' AS sequence FROM pg_class c "
            "LEFT JOIN LATERAL aclexplode(c.relacl) a ON a.grantee <> c.relowner "
            "WHERE c.relkind IN ('r', 'S') AND c.relnamespace = (SELECT oid FROM pg_namespace WHERE nspname = :old) "
            "AND c.relname IN (SELECT relname FROM pg_class WHERE relnamespace = "
            "(SELECT oid FROM pg_namespace WHERE nspname = :new)) ORDER BY c.relname"
        ),
        {"old": old, "new": new},
    ).all()
    me = connection.exec_driver_sql("SELECT current_user").scalar_one()
    for name, owner in sorted({(row.name, row.owner) for row in rows if not row.sequence and row.owner != me}):
        connection.exec_driver_sql(f"ALTER TABLE {_name(connection, new, name)} OWNER TO {quoted(owner)}")
    for row in rows:
        if row.may is not None:
            kind = "SEQUENCE" if row.sequence else "TABLE"
            who = "PUBLIC" if row.public else quoted(row.role)
            pass_on = " WITH GRANT OPTION" if row.may_pass_on else ""
            connection.exec_driver_sql(
                f"GRANT {row.may} ON {kind} {_name(connection, new, row.name)} TO {who}{pass_on}"
            )


def _name(connection: sa.Connection, schema: str, name: str) -> str:
    quoted = connection.dialect.identifier_preparer.quote
    return f"{quoted(schema)}.{quoted(name)}"


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
    tables = _tables(connection, schema)
    standing = [view.name for view in views_on(connection, schema, tables)]
    if standing:
        raise UsageError(
            f"the view {standing[0]} stands on the old tables in {schema}, and nothing was removed: drop it first."
        )
    refuse_what_cannot_follow(connection, schema, tables)
    try:
        connection.exec_driver_sql(f"DROP SCHEMA {connection.dialect.identifier_preparer.quote(schema)} CASCADE")
    except sa.exc.ProgrammingError as error:
        if getattr(error.orig, "sqlstate", None) != INSUFFICIENT_PRIVILEGE:
            raise
        raise UsageError(
            f"the server refused ({str(error.orig).splitlines()[0]}) and nothing was removed: prune as the role that "
            "owns the schema."
        ) from error
