"""A person's verdict on a jump, run, charge or condition: a row is added, nothing is changed or deleted."""

from __future__ import annotations

from data_schema.journal import Entry
from data_schema.queries.facts import insert_fact
from data_schema.queries.results import mark_stale
from labbook.statements.apply_context import ApplyContext, spoken


def apply_decide(context: ApplyContext, entry: Entry, _prepared: object) -> list[tuple[str, str]]:
    """Add the decision; results on its target become stale."""
    values = entry.new or {}
    insert_fact(context.connection, "decision", entry.entity_uid, spoken(context, entry, values))
    if values["target_kind"] == "jump":
        return mark_stale(context.connection, [("signal", values["signal_sha256"])])
    return mark_stale(context.connection, [(values["target_kind"], values["target_uid"])])
