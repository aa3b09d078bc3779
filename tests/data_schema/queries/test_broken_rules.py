"""A table that refuses a row says what it allows, on both databases; what is allowed is read from its own rules."""

from __future__ import annotations

from typing import Any

import pytest
import sqlalchemy as sa

from data_schema.engine import writing
from data_schema.errors import InputRefused
from data_schema.queries.facts import insert_fact, rule_in_words, update_fact
from data_schema.tables import FACTS
from tests.helpers.wording import refuses

STUDY = {"name": "bed", "kind": "bed", "reference_voltage_v": 15.4, "jumps_nominal": 25, "time_zone": "UTC"}
PACK = {"name": "A", "cells": 4, "capacity_mah": 6600.0}
CHECKS = sorted(
    (rule for table in FACTS.values() for rule in table.constraints if isinstance(rule, sa.CheckConstraint)),
    key=lambda rule: str(rule.name),
)


@pytest.mark.parametrize("rule", CHECKS, ids=lambda rule: str(rule.name))
def test_every_rule_of_the_tables_has_words(rule: sa.CheckConstraint) -> None:
    said = rule_in_words(rule)
    assert str(rule.name) not in said
    assert ("must be" in said) != ("must hold that" in said)


@pytest.mark.parametrize(
    ("kind", "values", "said"),
    [
        ("study", {**STUDY, "reference_voltage_v": -1.0}, "study bed cannot be stored: reference_voltage_v must be"),
        ("study", {**STUDY, "jumps_nominal": 2**63}, "a whole number goes from -9223372036854775808 to"),
        ("study", {**STUDY, "kind": "sea"}, "kind must be one of bed, emulator, force_plate, field"),
        ("battery", {**PACK, "capacity_mah": 0.0}, "capacity_mah must be more than 0"),
        ("charge", {"charge_mah": -4.0, "row_number": 1, "resolution_mah": 1.0, "mode": "charge"}, "must be 0 or more"),
    ],
)
def test_what_is_allowed_is_told(engine: sa.Engine, kind: str, values: dict[str, Any], said: str) -> None:
    with engine.connect() as connection, pytest.raises(InputRefused, match=said):
        insert_fact(connection, kind, "u1", values)


def test_what_is_there_already_is_named(engine: sa.Engine) -> None:
    with writing(engine) as connection:
        insert_fact(connection, "battery", "u1", PACK)
        insert_fact(connection, "battery", "u2", {**PACK, "name": "B"})
    with engine.connect() as connection, refuses(InputRefused, "battery A already"):
        update_fact(connection, "battery", "u2", {"name": "A"})
    with engine.connect() as connection, refuses(InputRefused, "same uid already"):
        insert_fact(connection, "battery", "u1", {**PACK, "name": "C"})
