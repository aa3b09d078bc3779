"""The statement that a report was made: of which runs, with which versions, and the hashes of its files."""

from __future__ import annotations

from data_schema.journal import Entry, canonical
from data_schema.queries.facts import insert_fact
from data_schema.queries.history import recorded_configurations
from data_schema.queries.study import config_in_force
from labbook.statements.apply_context import ApplyContext


def apply_report(context: ApplyContext, entry: Entry, _prepared: object) -> None:
    """Add the report; its numbers are in its `numbers.json`."""
    new = entry.new or {}
    config = _config_of(context, entry)
    values = {
        "selection": new["where"] or "",
        "made_utc": new["made_at"],
        "config": config,
        "versions_json": canonical(new["versions"]),
    }
    insert_fact(context.connection, "report", entry.entity_uid, values)


def _config_of(context: ApplyContext, entry: Entry) -> str:
    """Return the uid of the configuration that was in force when the report was made, others may have stated since."""
    as_of = (entry.new or {}).get("as_of")
    if as_of is not None and entry.origin is None:
        return [item for item in recorded_configurations(context.connection) if item.seq <= as_of][-1].uid
    row = config_in_force(context.connection)
    assert row is not None, "a configuration is declared before any report is made"  # noqa: S101
    return row.uid
