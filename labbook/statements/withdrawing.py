"""A file is taken out of use, or comes back.

Nothing is deleted: the readings, the samples and the links to runs stay, and no query counts them.
"""

from __future__ import annotations

from data_schema.journal import Entry
from data_schema.queries.facts import read_fact
from data_schema.queries.files import findings_of, last_reading, set_status
from data_schema.queries.history import reading_entries
from data_schema.tables.base import private_keys
from data_schema.tables.files import ingest
from data_schema.vocabulary import Action, IngestStatus, Severity
from labbook.statements.apply_context import ApplyContext
from labbook.statements.sheet_charges import mark_charges_gone, restore_charges


def apply_use(context: ApplyContext, entry: Entry, _prepared: object) -> None:
    """Take a file out of use: its samples and charges count no more; or into use again, under the reading it had."""
    file_uid = entry.entity_uid
    status = IngestStatus.WITHDRAWN if entry.action is Action.EXCLUDE else IngestStatus.IMPORTED
    sha256 = read_fact(context.connection, "file", file_uid, ["sha256"])["sha256"]
    reading = last_reading(context.connection, sha256)
    assert reading is not None, "a file in the book was read"  # noqa: S101
    refused = any(finding.severity == Severity.FILE for finding in findings_of(context.connection, reading.uid))
    if refused and status is IngestStatus.IMPORTED:
        status = IngestStatus.WAITING
    set_status(context.connection, reading.uid, status)
    if status is IngestStatus.WITHDRAWN:
        mark_charges_gone(context, file_uid)
    elif status is IngestStatus.IMPORTED:
        content = reading_entries(context.connection, sha256)[-1]
        key = private_keys(context.connection, ingest.c.uid, [reading.uid])[reading.uid]
        restore_charges(context, file_uid, key, content)
