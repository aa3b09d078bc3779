"""A fact was wrong, or a run is void: the row changes, the journal keeps the old value, results become stale."""

from __future__ import annotations

from data_schema.journal import Entry
from data_schema.queries.facts import update_fact
from data_schema.queries.results import mark_stale
from labbook.statements.scene import Scene, around_run


def apply_correct(scene: Scene, entry: Entry, _prepared: object) -> list[tuple[str, str]]:
    """Change the row; what rests on it, on the condition it leaves and on the one it joins becomes stale."""
    new = dict(entry.new or {})
    update_fact(scene.connection, entry.entity_kind, entry.entity_uid, new)
    changed = [(entry.entity_kind, entry.entity_uid)]
    for values in (entry.old or {}, new):
        changed += [("condition", values["condition"])] if values.get("condition") else []
        changed += around_run(scene, values["run"]) if values.get("run") else []
    return mark_stale(scene.connection, changed)
