"""What was sampled, where samples are missing, and the jumps found; all of it derived from raw bytes."""

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
from data_schema.vocabulary import GapKind

signal = table(
    "signal",
    key_column(),
    uid_column(),
    reference("file"),
    reference("ingest"),
    text_column("part"),
    text_column("reader"),
    whole_column("reader_version"),
    text_column("start_utc", optional=True),
    real_column("rate_hz", optional=True),
    whole_column("n_samples"),
    text_column("sha256"),
    text_column("time_sha256", optional=True),
    text_column("recorded_sha256", optional=True),
    text_column("store_path"),
    sa.CheckConstraint("n_samples >= 0", name="n_samples_counted"),
    sa.UniqueConstraint("ingest", "part"),
    sa.Index("ix_signal_sha256", "sha256"),
    sa.Index("ix_signal_recorded_sha256", "recorded_sha256"),
)

channel = table(
    "channel",
    reference("signal"),
    whole_column("position"),
    text_column("name"),
    text_column("unit", optional=True),
    text_column("source_name"),
    text_column("source_unit", optional=True),
    real_column("scale"),
    real_column("zero_offset"),
    whole_column("sign"),
    real_column("lowest", optional=True),
    real_column("highest", optional=True),
    text_column("assumed_json"),
    text_column("calibration_json", optional=True),
    text_column("calibrated_unit", optional=True),
    reference("instrument", optional=True),
    sa.PrimaryKeyConstraint("signal", "position"),
    sa.CheckConstraint("sign IN (-1, 1)", name="sign_known"),
    sa.UniqueConstraint("signal", "name"),
)

gap = table(
    "gap",
    key_column(),
    reference("signal"),
    real_column("start_s"),
    real_column("length_s"),
    whole_column("samples_expected"),
    whole_column("samples_missing"),
    text_column("kind"),
    one_of("kind", GapKind),
    sa.CheckConstraint("length_s > 0", name="length_positive"),
)

detection = table(
    "detection",
    key_column(),
    uid_column(),
    reference("signal"),
    text_column("algorithm"),
    whole_column("version"),
    text_column("parameters_json"),
    text_column("key", unique=True),
    whole_column("n_jumps"),
    sa.CheckConstraint("n_jumps >= 0", name="n_jumps_counted"),
)

jump = table(
    "jump",
    key_column(),
    uid_column(),
    reference("detection"),
    whole_column("number"),
    real_column("touchdown_s", optional=True),
    real_column("liftoff_s", optional=True),
    real_column("apex_s", optional=True),
    real_column("apex_height_m", optional=True),
    real_column("apex_height_se_m", optional=True),
    text_column("undefined_reason", optional=True),
    real_column("flight_time_s", optional=True),
    whole_column("samples_used"),
    whole_column("gap_touched"),
    text_column("flags_json"),
    flag("gap_touched"),
    sa.CheckConstraint("(apex_height_m IS NULL) <> (undefined_reason IS NULL)", name="height_or_reason"),
    sa.UniqueConstraint("detection", "number"),
)
