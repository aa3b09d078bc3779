"""A thing exists: a person, a study, a level, a run, a note."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from data_schema.journal import Entry
from data_schema.queries.charges import charges_of_run
from data_schema.queries.conditions import add_condition_levels, add_planned_run
from data_schema.queries.facts import insert_fact
from data_schema.queries.results import mark_stale
from data_schema.queries.waiting import waiting_for_run
from data_schema.vocabulary import FileRole
from labbook.statements.apply_context import ApplyContext, around, around_run, derived_uid, spoken
from labbook.statements.assigning import assign_charge, assign_file, assign_only_charge


def apply_declare(context: ApplyContext, entry: Entry, _prepared: object) -> list[tuple[str, str]]:
    """Add the row, and what follows from a thing of its kind being there."""
    values = dict(entry.new or {})
    beside = {name: values.pop(name) for name in _BESIDE.get(entry.entity_kind, ())}
    if entry.entity_kind in _SIGNED:
        values = spoken(context, entry, values)
    insert_fact(context.connection, entry.entity_kind, entry.entity_uid, values)
    follow = _FOLLOW.get(entry.entity_kind)
    if follow:
        follow(context, entry.entity_uid, {**values, **beside})
    if entry.entity_kind == "run":
        return mark_stale(context.connection, around(entry.entity_uid, values))
    return mark_stale(context.connection, around_run(context, values["run"])) if values.get("run") else []


def _condition_levels(context: ApplyContext, uid: str, values: Mapping[str, Any]) -> None:
    add_condition_levels(context.connection, uid, values["levels"])


def _planned_runs(context: ApplyContext, uid: str, values: Mapping[str, Any]) -> None:
    for position, planned in enumerate(values["runs"], start=1):
        add_planned_run(
            context.connection,
            uid=derived_uid("planned_run", uid, position),
            plan_uid=uid,
            position=position,
            **planned,
        )


def _link_what_waited(context: ApplyContext, uid: str, values: Mapping[str, Any]) -> None:
    """Files and charges that came before their run, and said its name, now belong to it."""
    files, charges = waiting_for_run(context.connection, values["name"])
    for file_uid, role in files:
        assign_file(context, file_uid, uid, FileRole(role))
        if not charges_of_run(context.connection, uid):
            assign_only_charge(context, file_uid, uid, FileRole(role))
    for charge_uid, may_be_second in charges:
        if may_be_second or not charges_of_run(context.connection, uid):
            assign_charge(context, charge_uid, uid)


_SIGNED = ("note", "day_check")
"""Kinds whose rows keep who said it and when."""

_BESIDE: dict[str, tuple[str, ...]] = {"condition": ("levels",), "plan": ("runs",)}
"""Parts of a declaration that are rows of other tables."""

_FOLLOW: dict[str, Callable[[ApplyContext, str, Mapping[str, Any]], None]] = {
    "condition": _condition_levels,
    "plan": _planned_runs,
    "run": _link_what_waited,
}
