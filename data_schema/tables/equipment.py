"""Robots, batteries and instruments."""

from __future__ import annotations

import sqlalchemy as sa

from data_schema.tables.base import (
    key_column,
    real_column,
    table,
    text_column,
    uid_column,
    whole_column,
)

robot = table(
    "robot",
    key_column(),
    uid_column(),
    text_column("name"),
    text_column("valid_from_utc"),
    real_column("body_mass_kg"),
    real_column("foot_mass_kg"),
    real_column("link_1_m"),
    real_column("link_2_m"),
    real_column("rest_length_m"),
    real_column("leg_min_m"),
    real_column("leg_max_m"),
    sa.CheckConstraint("body_mass_kg > 0", name="body_mass_positive"),
    sa.CheckConstraint("foot_mass_kg > 0", name="foot_mass_positive"),
    sa.CheckConstraint("leg_min_m < leg_max_m", name="leg_range"),
    sa.UniqueConstraint("name", "valid_from_utc"),
)

battery = table(
    "battery",
    key_column(),
    uid_column(),
    text_column("name", unique=True),
    whole_column("cells"),
    real_column("capacity_mah"),
    sa.CheckConstraint("cells >= 1", name="cells_counted"),
    sa.CheckConstraint("capacity_mah > 0", name="capacity_positive"),
)

instrument = table(
    "instrument",
    key_column(),
    uid_column(),
    text_column("name", unique=True),
    text_column("kind"),
    text_column("make", optional=True),
    text_column("model", optional=True),
    text_column("serial", optional=True),
)
