"""Entries of the journal may come from another book: then they say which entry of it they are."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op
from sqlalchemy.util import OrderedSet

revision = "0004"
down_revision = "0003"
branch_labels = None
depends_on = None

ACTION = (
    "action IN ('declare', 'correct', 'void', 'assign', 'decide', 'note', 'ingest', 'refuse', 'report', 'read', "
    "'withdraw', 'restore', 'dismiss', 'merge')"
)


TRIGGERS = "SELECT sql FROM sqlite_master WHERE type = 'trigger' AND tbl_name = 'journal'"


def upgrade() -> None:
    sqlite = op.get_bind().dialect.name == "sqlite"
    triggers = op.get_bind().execute(sa.text(TRIGGERS)).scalars().all() if sqlite else ()
    table = sa.Table("journal", sa.MetaData(), autoload_with=op.get_bind())
    table.constraints = OrderedSet(sorted(table.constraints, key=lambda rule: str(rule.name)))
    table.indexes = OrderedSet(sorted(table.indexes, key=lambda index: str(index.name)))
    with op.batch_alter_table("journal", copy_from=table) as batch:
        batch.add_column(sa.Column("origin_json", sa.Text(), nullable=True))
        batch.drop_constraint(op.f("ck_journal_action_known"), type_="check")
        batch.create_check_constraint(op.f("ck_journal_action_known"), ACTION)
    for trigger in triggers:  # SQLite makes the table anew without them
        op.execute(trigger)
