"""The journal: people, their statements, and the configuration in force.

Triggers let nobody change or delete an entry.
"""

from __future__ import annotations

from typing import Any

import sqlalchemy as sa

from data_schema.tables.base import (
    WHOLE,
    key_column,
    one_of,
    reference,
    table,
    text_column,
    uid_column,
    whole_column,
)
from data_schema.vocabulary import Action

labbook = table("labbook", sa.Column("schema", WHOLE, primary_key=True, autoincrement=False))
"""One row: the number of the form of the database."""

person = table(
    "person",
    key_column(),
    uid_column(),
    text_column("name", unique=True),
    text_column("initials"),
)

journal = table(
    "journal",
    key_column(),
    whole_column("seq", unique=True),
    whole_column("following"),
    text_column("at_utc"),
    reference("person"),
    text_column("action"),
    text_column("entity_kind"),
    text_column("entity_uid"),
    text_column("old_json", optional=True),
    text_column("new_json", optional=True),
    text_column("reason", optional=True),
    text_column("prev_hash"),
    text_column("hash", unique=True),
    text_column("origin_json", optional=True),
    one_of("action", Action),
    sa.CheckConstraint("following >= 0", name="following_counted"),
    sa.Index("ix_journal_entity", "entity_kind", "entity_uid"),
    sa.Index("ix_journal_entity_uid", "entity_uid"),
)

_ONLY_ADDED_TO = "the journal is only ever added to"
SQLITE_TRIGGERS = {
    name: f"CREATE TRIGGER {name} BEFORE {event} ON journal BEGIN SELECT RAISE(ABORT, '{_ONLY_ADDED_TO}'); END"
    for name, event in (("journal_never_changed", "UPDATE"), ("journal_never_deleted", "DELETE"))
}
"""What SQLite has of the triggers of the journal, by their names."""
POSTGRES_FUNCTION = f"BEGIN RAISE EXCEPTION '{_ONLY_ADDED_TO}'; END"
"""What the trigger `journal_never_changed` does on PostgreSQL."""

_TRIGGERS = {
    "sqlite": (*SQLITE_TRIGGERS.values(),),
    "postgresql": (
        f"CREATE FUNCTION journal_is_append_only() RETURNS trigger LANGUAGE plpgsql AS $$ {POSTGRES_FUNCTION} $$",
        "CREATE TRIGGER journal_never_changed BEFORE UPDATE OR DELETE OR TRUNCATE ON journal "
        "FOR EACH STATEMENT EXECUTE FUNCTION journal_is_append_only()",
    ),
}


@sa.event.listens_for(journal, "after_create")
def _make_triggers(_table: sa.Table, connection: sa.Connection, **_options: Any) -> None:
    for statement in _TRIGGERS[connection.dialect.name]:
        connection.exec_driver_sql(statement)


config = table(
    "config",
    key_column(),
    uid_column(),
    text_column("sha256"),
    text_column("text"),
    text_column("read_utc"),
)
