"""Hashes of rows as they were written, by which a row that was altered outside labbook is found."""

from __future__ import annotations

import sqlalchemy as sa

from data_schema.tables.base import table, text_column

row_hash = table(
    "row_hash",
    text_column("kind"),
    text_column("uid"),
    text_column("sha256"),
    sa.PrimaryKeyConstraint("kind", "uid"),
)
