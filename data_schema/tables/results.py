"""Results, the numbers in them, what they came from, and the reports that show them."""

from __future__ import annotations

import sqlalchemy as sa

from data_schema.tables.base import (
    flag,
    key_column,
    real_column,
    reference,
    table,
    text_column,
    uid_column,
    whole_column,
)

result = table(
    "result",
    key_column(),
    uid_column(),
    text_column("kind"),
    text_column("scope_json"),
    text_column("key", unique=True),
    text_column("algorithm"),
    whole_column("version"),
    reference("config"),
    text_column("payload_json"),
    whole_column("stale"),
    flag("stale"),
    sa.Index("ix_result_kind", "kind"),
)

result_number = table(
    "result_number",
    key_column(),
    uid_column(),
    reference("result"),
    text_column("name"),
    real_column("value", optional=True),
    text_column("unit"),
    real_column("se", optional=True),
    real_column("shared_se", optional=True),
    real_column("ci_low", optional=True),
    real_column("ci_high", optional=True),
    real_column("ci_level", optional=True),
    real_column("df", optional=True),
    whole_column("n", optional=True),
    text_column("undefined_reason", optional=True),
    sa.CheckConstraint("(value IS NULL) <> (undefined_reason IS NULL)", name="value_or_reason"),
    sa.UniqueConstraint("result", "name"),
)

result_input = table(
    "result_input",
    reference("result"),
    text_column("role"),
    text_column("input_kind"),
    text_column("input_uid"),
    text_column("input_sha256"),
    sa.PrimaryKeyConstraint("result", "role", "input_kind", "input_uid"),
    sa.Index("ix_result_input_what", "input_kind", "input_uid"),
)

report = table(
    "report",
    key_column(),
    uid_column(),
    text_column("options_json"),
    text_column("as_of_utc"),
    reference("config"),
    text_column("versions_json"),
    text_column("made_utc"),
)

report_item = table(
    "report_item",
    reference("report"),
    text_column("number_uid"),
    real_column("value", optional=True),
    reference("result_number", optional=True),
    sa.PrimaryKeyConstraint("report", "number_uid"),
)
