"""What a lab made for itself on a book's PostgreSQL tables, and what becomes of it when a rebuild changes them.

A view stands on tables, not on their names: left alone, it would show the old ones for ever. So every view is defined
again, in place, by its own text, which then means the new tables; owner, rights, comments and what stands on the view
stay. What cannot be defined again in place (materialized views, foreign keys of other tables, functions, rules,
policies, publications) stops the rebuild before it has begun, by name.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import sqlalchemy as sa

from data_schema.errors import UsageError

INSUFFICIENT_PRIVILEGE = "42501"
"""How the server names a refusal, in its own list of conditions."""


@dataclass(frozen=True, slots=True)
class View:
    """A view that stands on the book's tables: its quoted name, its options, and its text as it reads now."""

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
    """Raise `UsageError` where something other than a view stands on these tables."""
    others = [row.description for row in _standing_on(connection, schema, tables) if row.view is None]
    if others:
        raise UsageError(
            f"{', '.join(others)}: made on the book's tables by somebody else, and cannot follow to the new ones; "
            "nothing was changed. Drop it, rebuild, and make it again."
        )


def views_on(connection: sa.Connection, schema: str, tables: Sequence[str]) -> list[View]:
    """Return the views that stand on these tables, with texts that name them as the search path finds them."""
    oids = [row.view for row in _standing_on(connection, schema, tables) if row.view is not None]
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
    """Let views stand on the tables that now have the names in their texts; raises `UsageError` where one cannot."""
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


def _standing_on(connection: sa.Connection, schema: str, tables: Sequence[str]) -> Sequence[sa.Row[tuple[int, str]]]:
    return connection.execute(sa.text(_STANDING_ON), {"tables": list(tables), "schema": schema}).all()
