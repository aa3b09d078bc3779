"""A person's verdict on a jump, run, charge or condition: a row is added, nothing is changed or deleted."""

from __future__ import annotations

from data_schema.journal import Entry
from data_schema.queries.facts import insert_fact
from data_schema.queries.results import mark_stale
from labbook.statements.scene import Scene, spoken


def apply_decide(scene: Scene, entry: Entry, _prepared: object) -> list[tuple[str, str]]:
    """Add the decision; results on its target become stale."""
    values = entry.new or {}
    insert_fact(scene.connection, "decision", entry.entity_uid, spoken(scene, entry, values))
    if values["target_kind"] == "jump":
        return mark_stale(scene.connection, [("signal", values["signal_sha256"])])
    return mark_stale(scene.connection, [(values["target_kind"], values["target_uid"])])
