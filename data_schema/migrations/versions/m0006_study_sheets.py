"""A file may be the sheet of a study, or a log that one names, which is about no run."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op
from sqlalchemy.util import OrderedSet

revision = "0006"
down_revision = "0005"
branch_labels = None
depends_on = None

ROLE = "role IN ('log', 'force', 'charge', 'video', 'sheet')"


def upgrade() -> None:
    _widen("ingest", f"role IS NULL OR {ROLE}")
    _widen("run_file", ROLE)


def _widen(name: str, roles: str) -> None:
    """Let a table's column `role` hold the new word; where SQLite has the table made anew, its rules keep one order."""
    table = sa.Table(name, sa.MetaData(), autoload_with=op.get_bind())
    table.constraints = OrderedSet(sorted(table.constraints, key=lambda rule: str(rule.name)))
    table.indexes = OrderedSet(sorted(table.indexes, key=lambda index: str(index.name)))
    with op.batch_alter_table(name, copy_from=table) as batch:
        batch.drop_constraint(op.f(f"ck_{name}_role_known"), type_="check")
        batch.create_check_constraint(op.f(f"ck_{name}_role_known"), roles)
