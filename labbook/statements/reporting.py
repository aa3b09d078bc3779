"""The statement that a report was made: of which runs, with which versions, and the hashes of its files."""

from __future__ import annotations

from data_schema.journal import Entry, canonical
from data_schema.queries.facts import insert_fact
from data_schema.queries.study import config_in_force
from labbook.statements.apply_context import ApplyContext


def apply_report(context: ApplyContext, entry: Entry, _prepared: object) -> None:
    """Add the report; its numbers are in its `numbers.json`."""
    new = entry.new or {}
    row = config_in_force(context.connection)
    assert row is not None, "a configuration is declared before any report is made"  # noqa: S101
    values = {
        "selection": new["where"] or "",
        "made_utc": new["made_at"],
        "config": row.uid,
        "versions_json": canonical(new["versions"]),
    }
    insert_fact(context.connection, "report", entry.entity_uid, values)
