"""Facts that people state: a thing exists (a person, a study, a level, a run, a note), is corrected, or is judged.

A correction, or a void run, changes the row; the journal keeps the old values. A verdict on a jump, run, charge or
condition adds a row. Results that depend on either become stale.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from data_schema.journal import Entry
from data_schema.queries.charges import charges_of_run
from data_schema.queries.facts import fact_exists, insert_fact, read_fact, update_fact
from data_schema.queries.imported_files import waiting_for_run
from data_schema.queries.results import mark_stale
from data_schema.queries.study import add_condition_levels
from data_schema.vocabulary import FileRole
from labbook.statements.apply_context import (
    ApplyContext,
    derived_uid,
    inputs_around,
    inputs_around_run,
    missing_row,
    with_author,
)
from labbook.statements.assigning import assign_charge, assign_file, assign_only_charge, resolve_links


def apply_declare(context: ApplyContext, entry: Entry, _prepared: object) -> list[tuple[str, str]]:
    """Add the row, and link what waited for it."""
    values = dict(entry.new or {})
    beside = {name: values.pop(name) for name in _BESIDE.get(entry.entity_kind, ()) if name in values}
    if entry.entity_kind in _SIGNED:
        values = with_author(context, entry, values)
    insert_fact(context.connection, entry.entity_kind, entry.entity_uid, values)
    follow = _FOLLOW.get(entry.entity_kind)
    if follow:
        follow(context, entry.entity_uid, {**values, **beside})
    if entry.entity_kind == "run":
        return mark_stale(context.connection, inputs_around(entry.entity_uid, values))
    return mark_stale(context.connection, inputs_around_run(context, values["run"])) if values.get("run") else []


def _condition_levels(context: ApplyContext, uid: str, values: Mapping[str, Any]) -> None:
    add_condition_levels(context.connection, uid, values["levels"])


def _planned_runs(context: ApplyContext, uid: str, values: Mapping[str, Any]) -> None:
    for position, planned in enumerate(values["runs"], start=1):
        values_of_run = {"plan": uid, "position": position, **planned}
        insert_fact(context.connection, "planned_run", derived_uid("planned_run", uid, position), values_of_run)


def _link_what_waited(context: ApplyContext, uid: str, values: Mapping[str, Any]) -> None:
    """Link files and charges that came before their run, and name it, to that run."""
    files, charges = waiting_for_run(context.connection, values["name"])
    for file_uid, role in files:
        assign_file(context, file_uid, uid, FileRole(role))
        if not charges_of_run(context.connection, uid):
            assign_only_charge(context, file_uid, uid, FileRole(role))
    for charge_uid in charges:
        if not charges_of_run(context.connection, uid):
            assign_charge(context, charge_uid, uid)


_SIGNED = ("note", "day_check")
"""Kinds whose rows hold the person and time of their statement."""

_BESIDE: dict[str, tuple[str, ...]] = {"condition": ("levels",), "plan": ("runs", "looks")}
"""Parts of a declaration that are rows of other tables, or are read from the journal."""

_FOLLOW: dict[str, Callable[[ApplyContext, str, Mapping[str, Any]], None]] = {
    "condition": _condition_levels,
    "plan": _planned_runs,
    "run": _link_what_waited,
}


NUMBERS_REST_ON: Mapping[str, frozenset[str]] = {
    "run": frozenset(
        # what `run_input` of `analysis.results.result_cache` hashes, how many logs may be used, and the name, day and
        # pack under which results are stored
        {"kind", "state", "duration_s", "jumps_made", "condition", "robot", "starts", "name", "day", "battery"}
    ),
    "charge": frozenset({"run", "added", "charge_mah", "resolution_mah", "mode"}),
    "study": frozenset({"reference_voltage_v"}),
    "robot": frozenset({"name", "rest_length_m"}),
}
"""The columns whose correction makes results stale; of a kind that is not here, every column does."""


SCENES_REST_ON = frozenset({"name", "body_mass_kg", "foot_mass_kg", "link_1_m", "link_2_m", "rest_length_m"})
"""The columns of a robot that its simulated scenes are made of."""


def apply_correct(context: ApplyContext, entry: Entry, _prepared: object) -> list[tuple[str, str]]:
    """Change the row; results that depend on it, on the condition it leaves or on the one it joins become stale.

    A plan that is void changes no row: that it was withdrawn is read from the journal.
    """
    new = dict(entry.new or {})
    if not new:
        return []
    kind, uid = entry.entity_kind, entry.entity_uid
    if kind in ("charge", "run_file") and not fact_exists(context.connection, kind, uid):
        uids = resolve_links(context, uid, (entry.old or {}).get("run")) if kind == "run_file" else []
        if not uids:
            missing_row(context, entry)
            return []
    else:
        uids = [uid]
    for each in uids:
        update_fact(context.connection, kind, each, new)
    if kind == "charge" and new.get("run"):
        assign_charge(context, uid, new["run"], added=bool(new.get("added")))
    changed = [("robot_body", uid)] if kind == "robot" and SCENES_REST_ON & new.keys() else []
    changed += [("position", uid)] if kind == "run" and "position_in_day" in new else []
    if NUMBERS_REST_ON.get(kind, new.keys()) & new.keys():
        changed += [(kind, uid), *_dependents_around(context, kind, uid, new)]
        for values in (entry.old or {}, new):
            changed += _owners(context, values)
    return mark_stale(context.connection, list(dict.fromkeys(changed)))


def _dependents_around(context: ApplyContext, kind: str, uid: str, new: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Return what may depend on the row as it is now, though nothing depended on it before."""
    if kind == "run":
        return inputs_around_run(context, uid)
    if kind == "charge" and "mode" in new:
        run_uid = read_fact(context.connection, "charge", uid, ["run"])["run"]
        return inputs_around_run(context, run_uid) if run_uid else []
    return [("idle_runs", uid)] if kind == "robot" and "name" in new else []


def _owners(context: ApplyContext, values: Mapping[str, Any]) -> list[tuple[str, str]]:
    """What the row belonged to, or belongs to now."""
    found = [("condition", values["condition"])] if values.get("condition") else []
    found += [("idle_runs", values["robot"])] if values.get("robot") else []
    return found + (inputs_around_run(context, values["run"]) if values.get("run") else [])


def apply_decide(context: ApplyContext, entry: Entry, _prepared: object) -> list[tuple[str, str]]:
    """Add the decision; results on its target become stale."""
    values = entry.new or {}
    insert_fact(context.connection, "decision", entry.entity_uid, with_author(context, entry, values))
    if values["target_kind"] == "jump":
        return mark_stale(context.connection, [("signal", values["signal_sha256"])])
    return mark_stale(context.connection, [(values["target_kind"], values["target_uid"])])
