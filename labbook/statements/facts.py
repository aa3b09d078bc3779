"""Facts that people state: a thing exists (a person, a study, a level, a run, a note, a verdict), or is corrected.

A correction, or a void run, changes the row; the journal keeps the old values.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from data_schema.journal import Entry
from data_schema.journal_rules import BESIDE
from data_schema.queries.charges import charges_naming
from data_schema.queries.facts import insert_fact, update_fact
from data_schema.queries.files import files_naming, unassigned_charges_of_file
from data_schema.queries.study import add_condition_levels
from data_schema.vocabulary import FileRole
from labbook.statements.apply_context import ApplyContext, derived_uid, with_author
from labbook.statements.assigning import assign_file
from labbook.statements.counted_charges import apply_to_charge, name_charges, state_of_charge


def apply_set(context: ApplyContext, entry: Entry, _prepared: object) -> None:
    """Add the row and link what waited for it, or change the row that the old values are of.

    A plan that is withdrawn changes no row: that it was is read from the journal.
    """
    kind, uid, values = entry.entity_kind, entry.entity_uid, dict(entry.new or {})
    if entry.makes:
        beside = {name: values.pop(name) for name in BESIDE.get(kind, ()) if name in values}
        if kind in _SIGNED:
            values = with_author(context, entry, values)
        insert_fact(context.connection, kind, uid, values)
        if follow := _FOLLOW.get(kind):
            follow(context, uid, {**values, **beside})
    elif kind == "charge":
        apply_to_charge(context, entry)
    elif values:
        update_fact(context.connection, kind, uid, values)
        if kind == "run" and "name" in values:
            name_charges(context.connection, charges_naming(context.connection, values["name"]), uid)


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
    state_of_charge(context.connection, uid, of_run)


_SIGNED = ("note", "day_check", "decision")
"""Kinds whose rows hold the person and time of their statement."""

_FOLLOW: dict[str, Callable[[ApplyContext, str, Mapping[str, Any]], None]] = {
    "condition": _condition_levels,
    "plan": _planned_runs,
    "run": _link_what_waited,
    "charge": _typed_charge,
}
