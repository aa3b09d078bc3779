"""Rows have hashes, by which one that was altered outside labbook is found; and charges are found by what they name.

The table of hashes stays empty here: what stands in the other tables may have been altered already. The rebuild that follows an
upgrade writes the hashes of the rows that it makes.
"""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0003"
down_revision = "0002"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_table(
        "row_hash",
        sa.Column("kind", sa.Text(), nullable=False),
        sa.Column("uid", sa.Text(), nullable=False),
        sa.Column("sha256", sa.Text(), nullable=False),
        sa.PrimaryKeyConstraint("kind", "uid", name=op.f("pk_row_hash")),
        sqlite_strict=True,
    )
    op.create_index(op.f("ix_charge_stated_run"), "charge", ["stated_run"])
    op.create_index(op.f("ix_charge_repeats"), "charge", ["repeats"])
