"""Alembic's entry: migrations run on the connection they are given, in its transaction."""

from __future__ import annotations

from alembic import context

from data_schema.tables import METADATA

context.configure(
    connection=context.config.attributes["connection"],
    target_metadata=METADATA,
    render_as_batch=True,
)
context.run_migrations()
