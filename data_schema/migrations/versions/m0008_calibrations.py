"""A channel may be calibrated."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0008"
down_revision = "0007"
branch_labels = None
depends_on = None


def upgrade() -> None:
    for name in ("calibration_json", "calibrated_unit"):
        op.add_column("channel", sa.Column(name, sa.Text()))
