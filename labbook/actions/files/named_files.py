"""Imported files as people name them."""

from __future__ import annotations

import hashlib
from pathlib import Path

import sqlalchemy as sa

from data_schema.errors import UsageError, unknown_name
from data_schema.queries.imported_files import FileRow, find_files, imported_names
from data_schema.vocabulary import IngestStatus


def file_named(connection: sa.Connection, name: str, *, withdrawn: bool = False) -> FileRow:
    """Return the one imported file meant by a name, a uid, the beginning of a hash, or a path of its bytes.

    Raises where it is none, several, or (unless `withdrawn` ones will do) one that was taken out of use.
    """
    found = find_files(connection, name)
    path = Path(name)
    if not found and path.is_file():
        found = find_files(connection, hashlib.sha256(path.read_bytes()).hexdigest())
    if not found:
        raise unknown_name("imported file", name, imported_names(connection), "Ingest it first.")
    if len(found) > 1:
        listed = ", ".join(f"{row.uid} ({row.at_utc})" for row in found)
        raise UsageError(f"{len(found)} imported files are called {name!r}: name one by its uid: {listed}.")
    (row,) = found
    if row.status is IngestStatus.WITHDRAWN and not withdrawn:
        raise UsageError(f"{row.name} was withdrawn: `labbook files restore {row.uid}` takes it into use again.")
    return row
