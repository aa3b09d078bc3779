"""The design of a study: days and their checks, factors, levels, conditions, plans, people's equipment."""

from __future__ import annotations

import sqlalchemy as sa

from data_schema.tables.base import (
    flag,
    key_column,
    one_of,
    real_column,
    reference,
    table,
    text_column,
    uid_column,
    whole_column,
)
from data_schema.vocabulary import FactorKind, PlanMethod, StudyKind

study = table(
    "study",
    key_column(),
    uid_column(),
    text_column("name", unique=True),
    text_column("kind"),
    real_column("reference_voltage_v"),
    whole_column("jumps_nominal"),
    text_column("time_zone"),
    one_of("kind", StudyKind),
    sa.CheckConstraint("reference_voltage_v > 0", name="reference_voltage_positive"),
    sa.CheckConstraint("jumps_nominal > 0", name="jumps_nominal_positive"),
)

day = table(
    "day",
    key_column(),
    uid_column(),
    reference("study"),
    text_column("date_local"),
    sa.UniqueConstraint("study", "date_local"),
)

day_check = table(
    "day_check",
    key_column(),
    uid_column(),
    reference("day"),
    text_column("kind"),
    real_column("value", optional=True),
    text_column("unit", optional=True),
    whole_column("passed"),
    reference("person"),
    text_column("at_utc"),
    flag("passed"),
)

factor = table(
    "factor",
    key_column(),
    uid_column(),
    reference("study"),
    text_column("name"),
    text_column("kind"),
    text_column("unit", optional=True),
    one_of("kind", FactorKind),
    sa.UniqueConstraint("study", "name"),
)

level = table(
    "level",
    key_column(),
    uid_column(),
    reference("factor"),
    text_column("label"),
    real_column("value", optional=True),
    text_column("attributes_json"),
    sa.UniqueConstraint("factor", "label"),
)

condition = table(
    "condition",
    key_column(),
    uid_column(),
    reference("study"),
    text_column("key"),
    whole_column("is_control"),
    flag("is_control"),
    sa.UniqueConstraint("study", "key"),
)

condition_level = table(
    "condition_level",
    reference("condition"),
    reference("factor"),
    reference("level"),
    sa.PrimaryKeyConstraint("condition", "factor"),
)

plan = table(
    "plan",
    key_column(),
    uid_column(),
    reference("study"),
    whole_column("seed"),
    text_column("method"),
    text_column("created_utc"),
    one_of("method", PlanMethod),
)

planned_run = table(
    "planned_run",
    key_column(),
    uid_column(),
    reference("plan"),
    text_column("name"),
    whole_column("position"),
    whole_column("day_number"),
    text_column("block"),
    reference("condition", optional=True),
    sa.UniqueConstraint("plan", "position"),
)
