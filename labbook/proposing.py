"""labbook.toml proposes, the book decides: what the file adds is stated, what it changes in use is refused.

The tables, through the journal, are the one truth. Additions (a person, a level, a pack) become statements of whoever
gives the next command; so do changes while the book is still being described, before its first day, plan or file. A
later change to a fact that stands is refused with the `labbook correct` that would make it.
"""

from __future__ import annotations

import shlex
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import sqlalchemy as sa

from data_schema.errors import InputRefused
from data_schema.journal import canonical
from data_schema.queries.days import day_uids
from data_schema.queries.facts import find_uid, read_fact
from data_schema.queries.imports import imported_names
from data_schema.queries.people import config_in_force, person_uid
from data_schema.queries.runs import planned_runs, the_study
from data_schema.vocabulary import Action
from labbook.config import Configuration
from labbook.desk import Desk, Statement, now_utc


def propose(desk: Desk, configuration: Configuration, *, correcting: bool = False) -> None:
    """Take over what the configuration adds; raises `InputRefused` when it contradicts what stands.

    With `correcting`, contradictions are left to the correction that is being stated, and to the next command.
    """
    in_force = config_in_force(desk.connection)
    if in_force is not None and in_force.sha256 == configuration.sha256:
        return
    for name in sorted(configuration.people, key=lambda name: name != desk.person):
        if person_uid(desk.connection, name) is None:
            desk.declare("person", name=name, initials=configuration.people[name])
    changes: list[_Change] = []
    for kind, label, identity, values in _proposed(desk, configuration):
        uid = _standing(desk.connection, kind, identity)
        if uid is None:
            desk.declare(kind, **identity, **values)
        else:
            changes += _differences(desk.connection, kind, label, uid, {**identity, **values})
    if changes and _in_use(desk.connection):
        if correcting:
            return
        raise InputRefused("\n".join(change.sentence for change in changes))
    for change in changes:
        new, old = {change.field: change.proposed}, {change.field: change.standing}
        reason = "labbook.toml was changed before anything was measured"
        desk.state(Statement(Action.CORRECT, change.kind, change.uid, new=new, old=old, reason=reason))
    desk.declare("config", sha256=configuration.sha256, text=configuration.text, read_utc=now_utc())


@dataclass(frozen=True, slots=True)
class _Change:
    """A fact that labbook.toml states otherwise than the book."""

    kind: str
    label: str
    uid: str
    field: str
    standing: Any
    proposed: Any

    @property
    def sentence(self) -> str:
        assignment = f"{self.field}={'' if self.proposed is None else self.proposed}"
        command = f"labbook correct {shlex.quote(self.label)} {shlex.quote(assignment)}"
        return (
            f"labbook.toml says {self.label} {self.field} = {_shown(self.proposed)}, the book says "
            f'{_shown(self.standing)}: set it back, or state the change with `{command} --why "..."`.'
        )


def _shown(value: Any) -> str:
    return "nothing" if value is None else str(value)


def _proposed(desk: Desk, configuration: Configuration) -> Iterator[tuple[str, str, dict[str, Any], dict[str, Any]]]:
    """Give (kind, label, what it is called, what is said of it); parents before what refers to them."""
    study = configuration.study
    yield (
        "study",
        "study",
        {"name": study.name},
        {
            "kind": str(study.kind),
            "reference_voltage_v": study.reference_voltage_v,
            "jumps_nominal": study.jumps_nominal,
            "time_zone": study.time_zone,
        },
    )
    study_uid = _standing(desk.connection, "study", {})
    for name, factor in configuration.factors.items():
        yield (
            "factor",
            f"factor:{name}",
            {"study": study_uid, "name": name},
            {"kind": str(factor.kind), "unit": factor.unit},
        )
        factor_uid = find_uid(desk.connection, "factor", study=study_uid, name=name)
        for level in factor.levels:
            yield (
                "level",
                f"level:{name}={level.label}",
                {"factor": factor_uid, "label": level.label},
                {"value": level.value, "attributes_json": canonical(dict(level.attributes))},
            )
    for name, robot in configuration.robots.items():
        values = {field: getattr(robot, field) for field in type(robot).__slots__}
        yield "robot", f"robot:{name}", {"name": name, "valid_from_utc": ""}, values
    for name, battery in configuration.batteries.items():
        yield (
            "battery",
            f"battery:{name}",
            {"name": name},
            {"cells": battery.cells, "capacity_mah": battery.capacity_mah},
        )
    for name, instrument in configuration.instruments.items():
        values = {field: getattr(instrument, field) for field in type(instrument).__slots__}
        yield "instrument", f"instrument:{name}", {"name": name}, values


def _standing(connection: sa.Connection, kind: str, identity: Mapping[str, Any]) -> str | None:
    """Return the uid of what is proposed where it stands already; a book has one study, whatever it is called."""
    if kind == "study":
        study = the_study(connection)
        return None if study is None else study.uid
    return find_uid(connection, kind, **identity)


def _differences(
    connection: sa.Connection, kind: str, label: str, uid: str, proposed: Mapping[str, Any]
) -> list[_Change]:
    standing = read_fact(connection, kind, uid, proposed)
    return [
        _Change(kind, label, uid, field, standing[field], value)
        for field, value in proposed.items()
        if standing[field] != value
    ]


def _in_use(connection: sa.Connection) -> bool:
    """Tell whether the book's description has been built on: a day, a plan or a file."""
    return bool(day_uids(connection) or planned_runs(connection) or imported_names(connection))
