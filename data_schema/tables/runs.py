"""Runs, their charges, and people's notes and decisions on them."""

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
from data_schema.vocabulary import ChargeMode, ChargeState, ReasonCode, RunKind, RunState, TargetKind, Verdict

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
    sa.Index("ix_run_name", "name"),
)

charge = table(
    "charge",
    key_column(),
    uid_column(),
    # What the reading in force says, with the values that people corrected:
    reference("file", optional=True),
    whole_column("row_number"),
    whole_column("line", optional=True),
    text_column("stated_run", optional=True),
    reference("run", called="named_run", optional=True),
    reference("battery", optional=True),
    text_column("stated_pack", optional=True),
    real_column("charge_mah"),
    real_column("resolution_mah"),
    real_column("duration_s", optional=True),
    real_column("end_voltage_v", optional=True),
    text_column("mode"),
    text_column("ended_utc", optional=True),
    text_column("ended_original", optional=True),
    # What people said of it: `assigned` rises with the assignments to a run, `corrected` is JSON, by column what was
    # read and what is right.
    whole_column("assigned", usually=0),
    reference("run", called="assigned_run", optional=True),
    whole_column("added", usually=0),
    whole_column("dismissed", usually=0),
    text_column("corrected", optional=True),
    # What follows from all rows about a run; but `gone`, which says that no reading in force has it:
    text_column("state", usually=ChargeState.COUNTED),
    reference("run", optional=True),
    text_column("repeats", optional=True),
    one_of("mode", ChargeMode),
    one_of("state", ChargeState),
    flag("added"),
    flag("dismissed"),
    sa.CheckConstraint("charge_mah >= 0", name="charge_counted"),
    sa.CheckConstraint("resolution_mah > 0", name="resolution_positive"),
    sa.CheckConstraint("duration_s IS NULL OR duration_s > 0", name="duration_positive"),
    sa.UniqueConstraint("file", "row_number"),
    sa.Index("ix_charge_stated_run", "stated_run", "named_run"),
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
    sa.Index("ix_note_target_uid", "target_uid"),
)

decision = table(
    "decision",
    key_column(),
    uid_column(),
    text_column("target_kind"),
    text_column("target_uid"),
    text_column("signal_sha256", optional=True),
    real_column("anchor_s", optional=True),
    real_column("at_s", optional=True),
    text_column("verdict"),
    text_column("reason_code"),
    text_column("note", optional=True),
    real_column("old_value", optional=True),
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
    sa.CheckConstraint("(verdict IN ('move', 'add')) = (at_s IS NOT NULL)", name="placed_apex_has_time"),
    sa.Index("ix_decision_target", "target_kind", "target_uid"),
    sa.Index("ix_decision_signal_sha256", "signal_sha256"),
)
