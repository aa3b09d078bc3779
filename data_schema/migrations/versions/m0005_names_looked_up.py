"""What commands look rows up by has an index, so that no command reads a table through to find a few rows."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0005"
down_revision = "0004"
branch_labels = None
depends_on = None

WAITING = sa.text("status = 'waiting'")


def upgrade() -> None:
    for table, column in (
        ("run", "name"),
        ("ingest", "sha256"),
        ("ingest", "original_name"),
        ("ingest", "stated_run"),
        ("signal", "sha256"),
        ("signal", "recorded_sha256"),
        ("journal", "entity_uid"),
        ("note", "target_uid"),
    ):
        op.create_index(op.f(f"ix_{table}_{column}"), table, [column])
    op.create_index(op.f("ix_ingest_waiting"), "ingest", ["id"], sqlite_where=WAITING, postgresql_where=WAITING)
