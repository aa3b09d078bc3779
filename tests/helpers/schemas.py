"""The schema of a database as text that can be compared: one line a column, rule, index, trigger or function."""

from __future__ import annotations

import re

import sqlalchemy as sa

_POSTGRES = """
SELECT format('column %%s.%%s %%s%%s', c.relname, a.attname, format_type(a.atttypid, a.atttypmod),
              CASE WHEN a.attnotnull THEN ' NOT NULL' ELSE '' END)
  FROM pg_attribute a JOIN pg_class c ON c.oid = a.attrelid
 WHERE c.relnamespace = 'labbook'::regnamespace AND c.relkind = 'r' AND a.attnum > 0 AND NOT a.attisdropped
UNION ALL
SELECT format('rule %%s.%%s %%s', conrelid::regclass, conname, pg_get_constraintdef(oid))
  FROM pg_constraint WHERE connamespace = 'labbook'::regnamespace AND contype IN ('p', 'u', 'c', 'f')
UNION ALL
SELECT format('index %%s', indexdef) FROM pg_indexes WHERE schemaname = 'labbook'
UNION ALL
SELECT pg_get_triggerdef(oid) FROM pg_trigger WHERE NOT tgisinternal
UNION ALL
SELECT pg_get_functiondef(oid) FROM pg_proc WHERE pronamespace = 'labbook'::regnamespace
"""


def schema_lines(connection: sa.Connection) -> list[str]:
    """Everything that a database is made of, in an order of its own; the blanks in it are single."""
    if connection.dialect.name == "sqlite":
        found = connection.exec_driver_sql("SELECT sql FROM sqlite_master WHERE sql IS NOT NULL").scalars().all()
    else:
        found = connection.exec_driver_sql(_POSTGRES).scalars().all()
    return sorted(re.sub(r"\s+", " ", line).strip() for line in found)
