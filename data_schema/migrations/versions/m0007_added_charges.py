"""A charge may be a further part of the charge of its run."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator

import sqlalchemy as sa
from alembic import op
from alembic.operations import BatchOperations
from sqlalchemy.util import OrderedSet

revision = "0007"
down_revision = "0006"
branch_labels = None
depends_on = None

WHOLE = sa.BigInteger().with_variant(sa.Integer(), "sqlite")


def upgrade() -> None:
    with _altering() as batch:
        batch.add_column(sa.Column("added", WHOLE, nullable=True))
    op.execute("UPDATE charge SET added = 0")
    with _altering() as batch:
        batch.alter_column("added", existing_type=WHOLE, nullable=False)
        batch.create_check_constraint(op.f("ck_charge_added_flag"), "added IN (0, 1)")


@contextlib.contextmanager
def _altering() -> Iterator[BatchOperations]:
    """Alter the table; where SQLite has it made anew, its rules keep one order."""
    table = sa.Table("charge", sa.MetaData(), autoload_with=op.get_bind())
    table.constraints = OrderedSet(sorted(table.constraints, key=lambda rule: str(rule.name)))
    table.indexes = OrderedSet(sorted(table.indexes, key=lambda index: str(index.name)))
    with op.batch_alter_table("charge", copy_from=table) as batch:
        yield batch
