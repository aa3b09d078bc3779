"""labbook.toml proposes, the book decides: what the file adds is stated, what it changes in use is refused.

The tables, through the journal, are the one truth. Additions (a person, a level, a pack) become statements of whoever
gives the next command. A change to a fact that stands already is refused with the `labbook correct` that would make it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from data_schema.errors import InputRefused
from data_schema.journal import canonical
from data_schema.queries.facts import find_uid, read_fact
from data_schema.queries.people import config_in_force, person_uid
from data_schema.queries.runs import the_study
from labbook.config import Configuration
from labbook.desk import Desk, now_utc


def propose(desk: Desk, configuration: Configuration) -> None:
    """Take over what the configuration adds; raises `InputRefused` when it contradicts what stands."""
    in_force = config_in_force(desk.connection)
    if in_force is not None and in_force[0] == configuration.sha256:
        return
    for name in sorted(configuration.people, key=lambda name: name != desk.person):
        if person_uid(desk.connection, name) is None:
            desk.declare("person", name=name, initials=configuration.people[name])
    desk.declare("config", sha256=configuration.sha256, text=configuration.text, read_utc=now_utc())
    changes: list[str] = []
    for kind, label, identity, values in _proposed(desk, configuration):
        uid = find_uid(desk.connection, kind, **identity)
        if uid is None:
            _refuse_second_study(desk, kind, label)
            desk.declare(kind, **identity, **values)
        else:
            changes += _differences(kind, label, read_fact(desk.connection, kind, uid, values), values)
    if changes:
        raise InputRefused("\n".join(changes))


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
    study_uid = find_uid(desk.connection, "study", name=study.name)
    for name, factor in configuration.factors.items():
        yield "factor", name, {"study": study_uid, "name": name}, {"kind": str(factor.kind), "unit": factor.unit}
        factor_uid = find_uid(desk.connection, "factor", study=study_uid, name=name)
        for level in factor.levels:
            yield (
                "level",
                f"{name}={level.label}",
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


def _refuse_second_study(desk: Desk, kind: str, name: str) -> None:
    """A book is about one study; another name is a renamed study or another book."""
    standing = the_study(desk.connection) if kind == "study" else None
    if standing is not None:
        raise InputRefused(
            f"labbook.toml calls the study {name!r}, the book calls it {standing.name!r}: set the old name again, or "
            "make another book with `labbook init`."
        )


def _differences(kind: str, label: str, standing: Mapping[str, Any], proposed: Mapping[str, Any]) -> list[str]:
    return [
        f"labbook.toml says {label} {field} = {value}, the book says {standing[field]}: set it back, or state the "
        f'change with `labbook correct {label} {field}={value} --why "..."`.'
        for field, value in proposed.items()
        if standing[field] != value and kind != "factor"
    ]
