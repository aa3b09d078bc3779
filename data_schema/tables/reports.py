"""The reports that were made of the book."""

from __future__ import annotations

from data_schema.tables.base import key_column, reference, table, text_column, uid_column

report = table(
    "report",
    key_column(),
    uid_column(),
    text_column("selection"),
    text_column("made_utc"),
    reference("config"),
    text_column("versions_json"),
)
