"""Facts that people state: a thing exists (a person, a study, a level, a run, a note), is corrected, or is judged.

A correction, or a void run, changes the row; the journal keeps the old values. A verdict on a jump, run, charge or
condition adds a row.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from data_schema.journal import Entry
from data_schema.queries.charges import charges_naming
from data_schema.queries.facts import fact_exists, insert_fact, update_fact
from data_schema.queries.files import files_naming, unassigned_charges_of_file
from data_schema.queries.study import add_condition_levels
from data_schema.vocabulary import Action, FileRole
from labbook.statements.apply_context import (
    ApplyContext,
    derived_uid,
    missing_row,
    with_author,
)
from labbook.statements.assigning import assign_file, resolve_links
from labbook.statements.counted_charges import apply_to_charge, name_charges, state_of_charge


def apply_declare(context: ApplyContext, entry: Entry, _prepared: object) -> None:
    """Add the row, and link what waited for it."""
    values = dict(entry.new or {})
    beside = {name: values.pop(name) for name in _BESIDE.get(entry.entity_kind, ()) if name in values}
    if entry.entity_kind in _SIGNED:
        values = with_author(context, entry, values)
    insert_fact(context.connection, entry.entity_kind, entry.entity_uid, values)
    follow = _FOLLOW.get(entry.entity_kind)
    if follow:
        follow(context, entry.entity_uid, {**values, **beside})


def _condition_levels(context: ApplyContext, uid: str, values: Mapping[str, Any]) -> None:
    add_condition_levels(context.connection, uid, values["levels"])


def _planned_runs(context: ApplyContext, uid: str, values: Mapping[str, Any]) -> None:
    for position, planned in enumerate(values["runs"], start=1):
        values_of_run = {"plan": uid, "position": position, **planned}
        insert_fact(context.connection, "planned_run", derived_uid("planned_run", uid, position), values_of_run)


def _link_what_waited(context: ApplyContext, uid: str, values: Mapping[str, Any]) -> None:
    """Link files and charges that came before their run, and name it, to that run."""
    charges = charges_naming(context.connection, values["name"])
    for file_uid, role in files_naming(context.connection, values["name"]):
        assign_file(context, file_uid, uid, FileRole(role))
        if role == FileRole.CHARGE:
            of_file = unassigned_charges_of_file(context.connection, file_uid)
            charges += of_file if len(of_file) == 1 else []
    name_charges(context.connection, list(dict.fromkeys(charges)), uid)


def _typed_charge(context: ApplyContext, uid: str, values: Mapping[str, Any]) -> None:
    """A person who types a charge in gives it to its run."""
    of_run = {"run": values["run"], "added": values.get("added", 0)}
    state_of_charge(context.connection, uid, Action.ASSIGN, of_run)


_SIGNED = ("note", "day_check")
"""Kinds whose rows hold the person and time of their statement."""

_BESIDE: dict[str, tuple[str, ...]] = {"condition": ("levels",), "plan": ("runs", "looks")}
"""Parts of a declaration that are rows of other tables, or are read from the journal."""

_FOLLOW: dict[str, Callable[[ApplyContext, str, Mapping[str, Any]], None]] = {
    "condition": _condition_levels,
    "plan": _planned_runs,
    "run": _link_what_waited,
    "charge": _typed_charge,
}


def apply_correct(context: ApplyContext, entry: Entry, _prepared: object) -> None:
    """Change the row.

    A plan that is void changes no row: that it was withdrawn is read from the journal.
    """
    new = dict(entry.new or {})
    if not new:
        return
    kind, uid = entry.entity_kind, entry.entity_uid
    if kind == "charge":
        apply_to_charge(context, entry)
        return
    if kind == "run_file" and not fact_exists(context.connection, kind, uid):
        uids = resolve_links(context, uid, (entry.old or {}).get("run"))
        if not uids:
            missing_row(context, entry)
            return
    else:
        uids = [uid]
    for each in uids:
        update_fact(context.connection, kind, each, new)
    if kind == "run" and "name" in new:
        name_charges(context.connection, charges_naming(context.connection, new["name"]), uid)


def apply_decide(context: ApplyContext, entry: Entry, _prepared: object) -> None:
    """Add the decision."""
    insert_fact(context.connection, "decision", entry.entity_uid, with_author(context, entry, entry.new or {}))
