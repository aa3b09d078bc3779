"""Runs, their charges, and what people said about them."""

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
from data_schema.vocabulary import ChargeMode, ReasonCode, RunKind, RunState, TargetKind, Verdict

run = table(
    "run",
    key_column(),
    uid_column(),
    reference("study"),
    reference("day"),
    text_column("name"),
    text_column("kind"),
    reference("condition", optional=True),
    reference("robot"),
    reference("battery"),
    reference("planned_run", optional=True, unique=True),
    whole_column("position_in_day"),
    text_column("started_utc", optional=True),
    real_column("duration_s", optional=True),
    whole_column("jumps_made"),
    whole_column("starts"),
    text_column("state"),
    one_of("kind", RunKind),
    one_of("state", RunState),
    sa.CheckConstraint("duration_s IS NULL OR duration_s > 0", name="duration_positive"),
    sa.CheckConstraint("jumps_made >= 0", name="jumps_counted"),
    sa.CheckConstraint("starts >= 1", name="starts_counted"),
    sa.CheckConstraint("position_in_day >= 1", name="position_counted"),
    sa.UniqueConstraint("study", "name"),
)

charge = table(
    "charge",
    key_column(),
    uid_column(),
    reference("file", optional=True),
    whole_column("row_number"),
    reference("run", optional=True),
    text_column("stated_run", optional=True),
    reference("battery", optional=True),
    text_column("stated_pack", optional=True),
    real_column("charge_mah"),
    real_column("resolution_mah"),
    real_column("duration_s", optional=True),
    real_column("end_voltage_v", optional=True),
    text_column("mode"),
    text_column("ended_utc", optional=True),
    text_column("ended_original", optional=True),
    one_of("mode", ChargeMode),
    sa.CheckConstraint("charge_mah >= 0", name="charge_counted"),
    sa.CheckConstraint("resolution_mah > 0", name="resolution_positive"),
    sa.CheckConstraint("duration_s IS NULL OR duration_s > 0", name="duration_positive"),
    sa.UniqueConstraint("file", "row_number"),
)

note = table(
    "note",
    key_column(),
    uid_column(),
    text_column("target_kind"),
    text_column("target_uid"),
    text_column("text"),
    reference("file", optional=True),
    reference("person"),
    text_column("at_utc"),
    one_of("target_kind", TargetKind),
    sa.Index("ix_note_target", "target_kind", "target_uid"),
)

decision = table(
    "decision",
    key_column(),
    uid_column(),
    text_column("target_kind"),
    text_column("target_uid"),
    text_column("signal_sha256", optional=True),
    real_column("anchor_s", optional=True),
    text_column("verdict"),
    text_column("reason_code"),
    text_column("note", optional=True),
    real_column("old_value", optional=True),
    real_column("new_value", optional=True),
    text_column("algorithm", optional=True),
    whole_column("version", optional=True),
    whole_column("blind"),
    reference("person"),
    text_column("at_utc"),
    one_of("target_kind", TargetKind),
    one_of("verdict", Verdict),
    one_of("reason_code", ReasonCode),
    flag("blind"),
    sa.CheckConstraint(
        "target_kind <> 'jump' OR (signal_sha256 IS NOT NULL AND anchor_s IS NOT NULL)",
        name="jump_has_anchor",
    ),
    sa.Index("ix_decision_target", "target_kind", "target_uid"),
    sa.Index("ix_decision_signal_sha256", "signal_sha256"),
)
