"""A fact was wrong, or a run or a plan is void: the row changes, the journal keeps what it was, results are stale."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from data_schema.journal import Entry
from data_schema.queries.facts import fact_exists, read_fact, update_fact
from data_schema.queries.results import mark_stale
from labbook.statements.apply_context import ApplyContext, around_run, no_such_row
from labbook.statements.assigning import assign_charge, links_meant

NUMBERS_REST_ON: Mapping[str, frozenset[str]] = {
    "run": frozenset(
        # what `labbook.analysis.results.facts.run_input` hashes, how many logs may be used, and the name, day and pack
        # under which results are stored
        {"kind", "state", "duration_s", "jumps_made", "condition", "robot", "starts", "name", "day", "battery"}
    ),
    "charge": frozenset({"run", "charge_mah", "resolution_mah", "mode"}),
    "study": frozenset({"reference_voltage_v"}),
    "robot": frozenset({"name", "rest_length_m"}),
}
"""The columns whose correction makes results stale; of a kind that is not here, every column does."""


SCENES_REST_ON = frozenset({"name", "body_mass_kg", "foot_mass_kg", "link_1_m", "link_2_m", "rest_length_m"})
"""The columns of a robot that its simulated scenes are made of."""


def apply_correct(context: ApplyContext, entry: Entry, _prepared: object) -> list[tuple[str, str]]:
    """Change the row; what rests on it, on the condition it leaves and on the one it joins becomes stale.

    A plan that is void changes no row: that it was withdrawn is read from the journal.
    """
    new = dict(entry.new or {})
    if not new:
        return []
    kind, uid = entry.entity_kind, entry.entity_uid
    if kind in ("charge", "run_file") and not fact_exists(context.connection, kind, uid):
        uids = links_meant(context, uid, (entry.old or {}).get("run")) if kind == "run_file" else []
        if not uids:
            no_such_row(context, entry)
            return []
    else:
        uids = [uid]
    for each in uids:
        update_fact(context.connection, kind, each, new)
    if kind == "charge" and new.get("run"):
        assign_charge(context, uid, new["run"])
    changed = [("robot_body", uid)] if kind == "robot" and SCENES_REST_ON & new.keys() else []
    if NUMBERS_REST_ON.get(kind, new.keys()) & new.keys():
        changed += [(kind, uid), *_around(context, kind, uid, new)]
        for values in (entry.old or {}, new):
            changed += _touched(context, values)
    return mark_stale(context.connection, list(dict.fromkeys(changed)))


def _around(context: ApplyContext, kind: str, uid: str, new: Mapping[str, Any]) -> list[tuple[str, str]]:
    """What may rest on the row as it is now, though nothing rested on it before."""
    if kind == "run":
        return around_run(context, uid)
    if kind == "charge" and "mode" in new:
        run_uid = read_fact(context.connection, "charge", uid, ["run"])["run"]
        return around_run(context, run_uid) if run_uid else []
    return [("idle_runs", uid)] if kind == "robot" and "name" in new else []


def _touched(context: ApplyContext, values: Mapping[str, Any]) -> list[tuple[str, str]]:
    """What the row belonged to, or belongs to now."""
    found = [("condition", values["condition"])] if values.get("condition") else []
    found += [("idle_runs", values["robot"])] if values.get("robot") else []
    return found + (around_run(context, values["run"]) if values.get("run") else [])
