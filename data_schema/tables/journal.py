"""The journal: people, their statements, the configuration in force, and hashes of rows as they were written.

The hashes reveal a row that was altered outside labbook.
"""

from __future__ import annotations

import sqlalchemy as sa

from data_schema.tables.base import (
    key_column,
    one_of,
    reference,
    table,
    text_column,
    uid_column,
    whole_column,
)
from data_schema.vocabulary import Action

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

config = table(
    "config",
    key_column(),
    uid_column(),
    text_column("sha256"),
    text_column("text"),
    text_column("read_utc"),
)


row_hash = table(
    "row_hash",
    text_column("kind"),
    text_column("uid"),
    text_column("sha256"),
    sa.PrimaryKeyConstraint("kind", "uid"),
)
