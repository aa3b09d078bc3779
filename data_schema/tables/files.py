"""Raw files, how each was read, and what the reading found."""

from __future__ import annotations

import sqlalchemy as sa

from data_schema.tables.base import (
    key_column,
    one_of,
    partial_index,
    reference,
    table,
    text_column,
    uid_column,
    whole_column,
)
from data_schema.vocabulary import FileRole, IngestStatus, Severity

file = table(
    "file",
    key_column(),
    uid_column(),
    text_column("sha256", unique=True),
    whole_column("n_bytes"),
    text_column("store_path"),
    sa.CheckConstraint("n_bytes >= 0", name="n_bytes_counted"),
)

ingest = table(
    "ingest",
    key_column(),
    uid_column(),
    text_column("sha256"),
    reference("file", optional=True),
    text_column("original_name"),
    text_column("modified_utc", optional=True),
    text_column("status"),
    text_column("reader"),
    whole_column("reader_version"),
    text_column("options_json"),
    text_column("role", optional=True),
    text_column("stated_run", optional=True),
    whole_column("rows_read"),
    whole_column("rows_kept"),
    whole_column("rows_rejected"),
    reference("config"),
    reference("person"),
    text_column("at_utc"),
    text_column("declared_json"),
    one_of("status", IngestStatus),
    one_of("role", FileRole, optional=True),
    sa.CheckConstraint("status <> 'imported' OR file IS NOT NULL", name="imported_has_file"),
    partial_index("uq_ingest_imported_sha256", "sha256", "status = 'imported'", unique=True),
    sa.Index("ix_ingest_sha256", "sha256"),
    sa.Index("ix_ingest_original_name", "original_name"),
    sa.Index("ix_ingest_stated_run", "stated_run"),
    partial_index("ix_ingest_waiting", "id", "status = 'waiting'"),
)


def _has_status(status: IngestStatus) -> sa.ColumnElement[bool]:
    """Test for a status that stands in the query's text: SQLite plans one anew for each value if an index tests it."""
    return ingest.c.status == sa.text(f"'{status}'")


IN_USE = sa.or_(_has_status(IngestStatus.IMPORTED), _has_status(IngestStatus.WAITING))
"""The last reading of a file that is in use; it gave nothing where it waits for a declaration."""

LAST_READING = sa.or_(IN_USE, _has_status(IngestStatus.WITHDRAWN))
"""The last reading of every file that was imported, also where the file was withdrawn: exactly one a file."""

finding = table(
    "finding",
    key_column(),
    reference("ingest"),
    text_column("severity"),
    text_column("rule"),
    whole_column("line", optional=True),
    text_column("column_name", optional=True),
    text_column("value", optional=True),
    whole_column("n"),
    text_column("more_lines_json"),
    text_column("message"),
    one_of("severity", Severity),
    sa.CheckConstraint("n >= 1", name="n_counted"),
)

run_file = table(
    "run_file",
    key_column(),
    uid_column(),
    reference("run"),
    reference("file"),
    text_column("part"),
    text_column("role"),
    one_of("role", FileRole),
    sa.UniqueConstraint("run", "file", "part"),
)
