"""The first tables.

A frozen record: it is never edited once a book has been made with it.
"""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0001"
down_revision = None
branch_labels = None
depends_on = None

WHOLE = sa.BigInteger().with_variant(sa.Integer(), "sqlite")
REAL: sa.types.TypeEngine[float] = sa.Double().with_variant(sa.REAL(), "sqlite")
TEXT = sa.Text()

SQLITE_TRIGGER = """
CREATE TRIGGER journal_never_{verb} BEFORE {event} ON journal
BEGIN SELECT RAISE(ABORT, 'the journal is only ever added to'); END
"""
POSTGRES_FUNCTION = """
CREATE FUNCTION journal_is_append_only() RETURNS trigger LANGUAGE plpgsql AS
$$ BEGIN RAISE EXCEPTION 'the journal is only ever added to'; END $$
"""
POSTGRES_TRIGGER = """
CREATE TRIGGER journal_never_changed BEFORE UPDATE OR DELETE OR TRUNCATE ON journal
FOR EACH STATEMENT EXECUTE FUNCTION journal_is_append_only()
"""


def upgrade() -> None:
    op.create_table(
        "battery",
        sa.Column("id", WHOLE, nullable=False),
        sa.Column("uid", TEXT, nullable=False),
        sa.Column("name", TEXT, nullable=False),
        sa.Column("cells", WHOLE, nullable=False),
        sa.Column("capacity_mah", REAL, nullable=False),
        sa.CheckConstraint("capacity_mah > 0", name=op.f("ck_battery_capacity_positive")),
        sa.CheckConstraint("cells >= 1", name=op.f("ck_battery_cells_counted")),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_battery")),
        sa.UniqueConstraint("name", name=op.f("uq_battery_name")),
        sa.UniqueConstraint("uid", name=op.f("uq_battery_uid")),
        sqlite_strict=True,
    )
    op.create_table(
        "config",
        sa.Column("id", WHOLE, nullable=False),
        sa.Column("uid", TEXT, nullable=False),
        sa.Column("sha256", TEXT, nullable=False),
        sa.Column("text", TEXT, nullable=False),
        sa.Column("read_utc", TEXT, nullable=False),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_config")),
        sa.UniqueConstraint("uid", name=op.f("uq_config_uid")),
        sqlite_strict=True,
    )
    op.create_table(
        "file",
        sa.Column("id", WHOLE, nullable=False),
        sa.Column("uid", TEXT, nullable=False),
        sa.Column("sha256", TEXT, nullable=False),
        sa.Column("n_bytes", WHOLE, nullable=False),
        sa.Column("store_path", TEXT, nullable=False),
        sa.Column("state", TEXT, nullable=False),
        sa.CheckConstraint("state IN ('kept', 'quarantined')", name=op.f("ck_file_state_known")),
        sa.CheckConstraint("n_bytes >= 0", name=op.f("ck_file_n_bytes_counted")),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_file")),
        sa.UniqueConstraint("sha256", name=op.f("uq_file_sha256")),
        sa.UniqueConstraint("uid", name=op.f("uq_file_uid")),
        sqlite_strict=True,
    )
    op.create_table(
        "instrument",
        sa.Column("id", WHOLE, nullable=False),
        sa.Column("uid", TEXT, nullable=False),
        sa.Column("name", TEXT, nullable=False),
        sa.Column("kind", TEXT, nullable=False),
        sa.Column("make", TEXT, nullable=True),
        sa.Column("model", TEXT, nullable=True),
        sa.Column("serial", TEXT, nullable=True),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_instrument")),
        sa.UniqueConstraint("name", name=op.f("uq_instrument_name")),
        sa.UniqueConstraint("uid", name=op.f("uq_instrument_uid")),
        sqlite_strict=True,
    )
    op.create_table(
        "person",
        sa.Column("id", WHOLE, nullable=False),
        sa.Column("uid", TEXT, nullable=False),
        sa.Column("name", TEXT, nullable=False),
        sa.Column("initials", TEXT, nullable=False),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_person")),
        sa.UniqueConstraint("name", name=op.f("uq_person_name")),
        sa.UniqueConstraint("uid", name=op.f("uq_person_uid")),
        sqlite_strict=True,
    )
    op.create_table(
        "robot",
        sa.Column("id", WHOLE, nullable=False),
        sa.Column("uid", TEXT, nullable=False),
        sa.Column("name", TEXT, nullable=False),
        sa.Column("valid_from_utc", TEXT, nullable=False),
        sa.Column("body_mass_kg", REAL, nullable=False),
        sa.Column("foot_mass_kg", REAL, nullable=False),
        sa.Column("link_1_m", REAL, nullable=False),
        sa.Column("link_2_m", REAL, nullable=False),
        sa.Column("rest_length_m", REAL, nullable=False),
        sa.Column("leg_min_m", REAL, nullable=False),
        sa.Column("leg_max_m", REAL, nullable=False),
        sa.CheckConstraint("body_mass_kg > 0", name=op.f("ck_robot_body_mass_positive")),
        sa.CheckConstraint("foot_mass_kg > 0", name=op.f("ck_robot_foot_mass_positive")),
        sa.CheckConstraint("leg_min_m < leg_max_m", name=op.f("ck_robot_leg_range")),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_robot")),
        sa.UniqueConstraint("name", "valid_from_utc", name=op.f("uq_robot_name_valid_from_utc")),
        sa.UniqueConstraint("uid", name=op.f("uq_robot_uid")),
        sqlite_strict=True,
    )
    op.create_table(
        "study",
        sa.Column("id", WHOLE, nullable=False),
        sa.Column("uid", TEXT, nullable=False),
        sa.Column("name", TEXT, nullable=False),
        sa.Column("kind", TEXT, nullable=False),
        sa.Column("reference_voltage_v", REAL, nullable=False),
        sa.Column("jumps_nominal", WHOLE, nullable=False),
        sa.Column("time_zone", TEXT, nullable=False),
        sa.CheckConstraint("kind IN ('bed', 'emulator', 'force_plate', 'field')", name=op.f("ck_study_kind_known")),
        sa.CheckConstraint("jumps_nominal > 0", name=op.f("ck_study_jumps_nominal_positive")),
        sa.CheckConstraint("reference_voltage_v > 0", name=op.f("ck_study_reference_voltage_positive")),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_study")),
        sa.UniqueConstraint("name", name=op.f("uq_study_name")),
        sa.UniqueConstraint("uid", name=op.f("uq_study_uid")),
        sqlite_strict=True,
    )
    op.create_table(
        "calibration",
        sa.Column("id", WHOLE, nullable=False),
        sa.Column("uid", TEXT, nullable=False),
        sa.Column("instrument", WHOLE, nullable=False),
        sa.Column("quantity", TEXT, nullable=False),
        sa.Column("valid_from_utc", TEXT, nullable=False),
        sa.Column("valid_to_utc", TEXT, nullable=True),
        sa.Column("gain", REAL, nullable=False),
        sa.Column("gain_se", REAL, nullable=False),
        sa.Column("zero_offset", REAL, nullable=False),
        sa.Column("unit", TEXT, nullable=False),
        sa.Column("file", WHOLE, nullable=True),
        sa.CheckConstraint(
            "valid_to_utc IS NULL OR valid_to_utc > valid_from_utc", name=op.f("ck_calibration_valid_interval")
        ),
        sa.ForeignKeyConstraint(
            ["file"], ["file.id"], name=op.f("fk_calibration_file"), onupdate="RESTRICT", ondelete="RESTRICT"
        ),
        sa.ForeignKeyConstraint(
            ["instrument"],
            ["instrument.id"],
            name=op.f("fk_calibration_instrument"),
            onupdate="RESTRICT",
            ondelete="RESTRICT",
        ),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_calibration")),
        sa.UniqueConstraint(
            "instrument", "quantity", "valid_from_utc", name=op.f("uq_calibration_instrument_quantity_valid_from_utc")
        ),
        sa.UniqueConstraint("uid", name=op.f("uq_calibration_uid")),
        sqlite_strict=True,
    )
    op.create_index(op.f("ix_calibration_file"), "calibration", ["file"], unique=False)
    op.create_index(op.f("ix_calibration_instrument"), "calibration", ["instrument"], unique=False)
    op.create_table(
        "condition",
        sa.Column("id", WHOLE, nullable=False),
        sa.Column("uid", TEXT, nullable=False),
        sa.Column("study", WHOLE, nullable=False),
        sa.Column("key", TEXT, nullable=False),
        sa.Column("is_control", WHOLE, nullable=False),
        sa.CheckConstraint("is_control IN (0, 1)", name=op.f("ck_condition_is_control_flag")),
        sa.ForeignKeyConstraint(
            ["study"], ["study.id"], name=op.f("fk_condition_study"), onupdate="RESTRICT", ondelete="RESTRICT"
        ),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_condition")),
        sa.UniqueConstraint("study", "key", name=op.f("uq_condition_study_key")),
        sa.UniqueConstraint("uid", name=op.f("uq_condition_uid")),
        sqlite_strict=True,
    )
    op.create_index(op.f("ix_condition_study"), "condition", ["study"], unique=False)
    op.create_table(
        "day",
        sa.Column("id", WHOLE, nullable=False),
        sa.Column("uid", TEXT, nullable=False),
        sa.Column("study", WHOLE, nullable=False),
        sa.Column("date_local", TEXT, nullable=False),
        sa.ForeignKeyConstraint(
            ["study"], ["study.id"], name=op.f("fk_day_study"), onupdate="RESTRICT", ondelete="RESTRICT"
        ),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_day")),
        sa.UniqueConstraint("study", "date_local", name=op.f("uq_day_study_date_local")),
        sa.UniqueConstraint("uid", name=op.f("uq_day_uid")),
        sqlite_strict=True,
    )
    op.create_index(op.f("ix_day_study"), "day", ["study"], unique=False)
    op.create_table(
        "decision",
        sa.Column("id", WHOLE, nullable=False),
        sa.Column("uid", TEXT, nullable=False),
        sa.Column("target_kind", TEXT, nullable=False),
        sa.Column("target_uid", TEXT, nullable=False),
        sa.Column("signal_sha256", TEXT, nullable=True),
        sa.Column("anchor_s", REAL, nullable=True),
        sa.Column("verdict", TEXT, nullable=False),
        sa.Column("reason_code", TEXT, nullable=False),
        sa.Column("note", TEXT, nullable=True),
        sa.Column("old_value", REAL, nullable=True),
        sa.Column("new_value", REAL, nullable=True),
        sa.Column("algorithm", TEXT, nullable=True),
        sa.Column("version", WHOLE, nullable=True),
        sa.Column("blind", WHOLE, nullable=False),
        sa.Column("person", WHOLE, nullable=False),
        sa.Column("at_utc", TEXT, nullable=False),
        sa.CheckConstraint(
            "reason_code IN ('dropped_packet', 'wrong_apex', 'touched_by_hand', 'misfire', 'sensor_fault', 'looks_right', 'other')",
            name=op.f("ck_decision_reason_code_known"),
        ),
        sa.CheckConstraint(
            "target_kind <> 'jump' OR (signal_sha256 IS NOT NULL AND anchor_s IS NOT NULL)",
            name=op.f("ck_decision_jump_has_anchor"),
        ),
        sa.CheckConstraint(
            "target_kind IN ('jump', 'run', 'charge', 'condition', 'day', 'file')",
            name=op.f("ck_decision_target_kind_known"),
        ),
        sa.CheckConstraint("verdict IN ('accept', 'reject', 'move', 'clear')", name=op.f("ck_decision_verdict_known")),
        sa.CheckConstraint("blind IN (0, 1)", name=op.f("ck_decision_blind_flag")),
        sa.ForeignKeyConstraint(
            ["person"], ["person.id"], name=op.f("fk_decision_person"), onupdate="RESTRICT", ondelete="RESTRICT"
        ),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_decision")),
        sa.UniqueConstraint("uid", name=op.f("uq_decision_uid")),
        sqlite_strict=True,
    )
    op.create_index(op.f("ix_decision_person"), "decision", ["person"], unique=False)
    op.create_index("ix_decision_signal_sha256", "decision", ["signal_sha256"], unique=False)
    op.create_index("ix_decision_target", "decision", ["target_kind", "target_uid"], unique=False)
    op.create_table(
        "factor",
        sa.Column("id", WHOLE, nullable=False),
        sa.Column("uid", TEXT, nullable=False),
        sa.Column("study", WHOLE, nullable=False),
        sa.Column("name", TEXT, nullable=False),
        sa.Column("kind", TEXT, nullable=False),
        sa.Column("unit", TEXT, nullable=True),
        sa.CheckConstraint("kind IN ('number', 'label')", name=op.f("ck_factor_kind_known")),
        sa.ForeignKeyConstraint(
            ["study"], ["study.id"], name=op.f("fk_factor_study"), onupdate="RESTRICT", ondelete="RESTRICT"
        ),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_factor")),
        sa.UniqueConstraint("study", "name", name=op.f("uq_factor_study_name")),
        sa.UniqueConstraint("uid", name=op.f("uq_factor_uid")),
        sqlite_strict=True,
    )
    op.create_index(op.f("ix_factor_study"), "factor", ["study"], unique=False)
    op.create_table(
        "ingest",
        sa.Column("id", WHOLE, nullable=False),
        sa.Column("uid", TEXT, nullable=False),
        sa.Column("sha256", TEXT, nullable=False),
        sa.Column("file", WHOLE, nullable=True),
        sa.Column("original_name", TEXT, nullable=False),
        sa.Column("modified_utc", TEXT, nullable=True),
        sa.Column("status", TEXT, nullable=False),
        sa.Column("reader", TEXT, nullable=False),
        sa.Column("reader_version", WHOLE, nullable=False),
        sa.Column("options_json", TEXT, nullable=False),
        sa.Column("role", TEXT, nullable=True),
        sa.Column("stated_run", TEXT, nullable=True),
        sa.Column("rows_read", WHOLE, nullable=False),
        sa.Column("rows_kept", WHOLE, nullable=False),
        sa.Column("rows_rejected", WHOLE, nullable=False),
        sa.Column("config", WHOLE, nullable=False),
        sa.Column("person", WHOLE, nullable=False),
        sa.Column("at_utc", TEXT, nullable=False),
        sa.CheckConstraint(
            "role IS NULL OR role IN ('log', 'force', 'charge', 'video')", name=op.f("ck_ingest_role_known")
        ),
        sa.CheckConstraint("status <> 'imported' OR file IS NOT NULL", name=op.f("ck_ingest_imported_has_file")),
        sa.CheckConstraint("status IN ('imported', 'duplicate', 'refused')", name=op.f("ck_ingest_status_known")),
        sa.ForeignKeyConstraint(
            ["config"], ["config.id"], name=op.f("fk_ingest_config"), onupdate="RESTRICT", ondelete="RESTRICT"
        ),
        sa.ForeignKeyConstraint(
            ["file"], ["file.id"], name=op.f("fk_ingest_file"), onupdate="RESTRICT", ondelete="RESTRICT"
        ),
        sa.ForeignKeyConstraint(
            ["person"], ["person.id"], name=op.f("fk_ingest_person"), onupdate="RESTRICT", ondelete="RESTRICT"
        ),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_ingest")),
        sa.UniqueConstraint("uid", name=op.f("uq_ingest_uid")),
        sqlite_strict=True,
    )
    op.create_index(op.f("ix_ingest_config"), "ingest", ["config"], unique=False)
    op.create_index(op.f("ix_ingest_file"), "ingest", ["file"], unique=False)
    op.create_index(op.f("ix_ingest_person"), "ingest", ["person"], unique=False)
    op.create_index(
        "uq_ingest_imported_sha256",
        "ingest",
        ["sha256"],
        unique=True,
        sqlite_where=sa.text("status = 'imported'"),
        postgresql_where=sa.text("status = 'imported'"),
    )
    op.create_table(
        "journal",
        sa.Column("id", WHOLE, nullable=False),
        sa.Column("seq", WHOLE, nullable=False),
        sa.Column("following", WHOLE, nullable=False),
        sa.Column("at_utc", TEXT, nullable=False),
        sa.Column("person", WHOLE, nullable=False),
        sa.Column("action", TEXT, nullable=False),
        sa.Column("entity_kind", TEXT, nullable=False),
        sa.Column("entity_uid", TEXT, nullable=False),
        sa.Column("old_json", TEXT, nullable=True),
        sa.Column("new_json", TEXT, nullable=True),
        sa.Column("reason", TEXT, nullable=True),
        sa.Column("prev_hash", TEXT, nullable=False),
        sa.Column("hash", TEXT, nullable=False),
        sa.CheckConstraint(
            "action IN ('declare', 'correct', 'void', 'assign', 'decide', 'note', 'ingest', 'refuse', 'report')",
            name=op.f("ck_journal_action_known"),
        ),
        sa.CheckConstraint("following >= 0", name=op.f("ck_journal_following_counted")),
        sa.ForeignKeyConstraint(
            ["person"], ["person.id"], name=op.f("fk_journal_person"), onupdate="RESTRICT", ondelete="RESTRICT"
        ),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_journal")),
        sa.UniqueConstraint("hash", name=op.f("uq_journal_hash")),
        sa.UniqueConstraint("seq", name=op.f("uq_journal_seq")),
        sqlite_strict=True,
    )
    op.create_index("ix_journal_entity", "journal", ["entity_kind", "entity_uid"], unique=False)
    op.create_index(op.f("ix_journal_person"), "journal", ["person"], unique=False)
    op.create_table(
        "note",
        sa.Column("id", WHOLE, nullable=False),
        sa.Column("uid", TEXT, nullable=False),
        sa.Column("target_kind", TEXT, nullable=False),
        sa.Column("target_uid", TEXT, nullable=False),
        sa.Column("text", TEXT, nullable=False),
        sa.Column("file", WHOLE, nullable=True),
        sa.Column("person", WHOLE, nullable=False),
        sa.Column("at_utc", TEXT, nullable=False),
        sa.CheckConstraint(
            "target_kind IN ('jump', 'run', 'charge', 'condition', 'day', 'file')",
            name=op.f("ck_note_target_kind_known"),
        ),
        sa.ForeignKeyConstraint(
            ["file"], ["file.id"], name=op.f("fk_note_file"), onupdate="RESTRICT", ondelete="RESTRICT"
        ),
        sa.ForeignKeyConstraint(
            ["person"], ["person.id"], name=op.f("fk_note_person"), onupdate="RESTRICT", ondelete="RESTRICT"
        ),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_note")),
        sa.UniqueConstraint("uid", name=op.f("uq_note_uid")),
        sqlite_strict=True,
    )
    op.create_index(op.f("ix_note_file"), "note", ["file"], unique=False)
    op.create_index(op.f("ix_note_person"), "note", ["person"], unique=False)
    op.create_index("ix_note_target", "note", ["target_kind", "target_uid"], unique=False)
    op.create_table(
        "plan",
        sa.Column("id", WHOLE, nullable=False),
        sa.Column("uid", TEXT, nullable=False),
        sa.Column("study", WHOLE, nullable=False),
        sa.Column("seed", WHOLE, nullable=False),
        sa.Column("method", TEXT, nullable=False),
        sa.Column("created_utc", TEXT, nullable=False),
        sa.CheckConstraint("method IN ('randomised', 'blocked')", name=op.f("ck_plan_method_known")),
        sa.ForeignKeyConstraint(
            ["study"], ["study.id"], name=op.f("fk_plan_study"), onupdate="RESTRICT", ondelete="RESTRICT"
        ),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_plan")),
        sa.UniqueConstraint("uid", name=op.f("uq_plan_uid")),
        sqlite_strict=True,
    )
    op.create_index(op.f("ix_plan_study"), "plan", ["study"], unique=False)
    op.create_table(
        "report",
        sa.Column("id", WHOLE, nullable=False),
        sa.Column("uid", TEXT, nullable=False),
        sa.Column("options_json", TEXT, nullable=False),
        sa.Column("as_of_utc", TEXT, nullable=False),
        sa.Column("config", WHOLE, nullable=False),
        sa.Column("versions_json", TEXT, nullable=False),
        sa.Column("made_utc", TEXT, nullable=False),
        sa.ForeignKeyConstraint(
            ["config"], ["config.id"], name=op.f("fk_report_config"), onupdate="RESTRICT", ondelete="RESTRICT"
        ),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_report")),
        sa.UniqueConstraint("uid", name=op.f("uq_report_uid")),
        sqlite_strict=True,
    )
    op.create_index(op.f("ix_report_config"), "report", ["config"], unique=False)
    op.create_table(
        "result",
        sa.Column("id", WHOLE, nullable=False),
        sa.Column("uid", TEXT, nullable=False),
        sa.Column("kind", TEXT, nullable=False),
        sa.Column("scope_json", TEXT, nullable=False),
        sa.Column("key", TEXT, nullable=False),
        sa.Column("algorithm", TEXT, nullable=False),
        sa.Column("version", WHOLE, nullable=False),
        sa.Column("config", WHOLE, nullable=False),
        sa.Column("payload_json", TEXT, nullable=False),
        sa.Column("stale", WHOLE, nullable=False),
        sa.CheckConstraint("stale IN (0, 1)", name=op.f("ck_result_stale_flag")),
        sa.ForeignKeyConstraint(
            ["config"], ["config.id"], name=op.f("fk_result_config"), onupdate="RESTRICT", ondelete="RESTRICT"
        ),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_result")),
        sa.UniqueConstraint("key", name=op.f("uq_result_key")),
        sa.UniqueConstraint("uid", name=op.f("uq_result_uid")),
        sqlite_strict=True,
    )
    op.create_index(op.f("ix_result_config"), "result", ["config"], unique=False)
    op.create_index("ix_result_kind", "result", ["kind"], unique=False)
    op.create_table(
        "signal",
        sa.Column("id", WHOLE, nullable=False),
        sa.Column("uid", TEXT, nullable=False),
        sa.Column("file", WHOLE, nullable=False),
        sa.Column("part", TEXT, nullable=False),
        sa.Column("reader", TEXT, nullable=False),
        sa.Column("reader_version", WHOLE, nullable=False),
        sa.Column("start_utc", TEXT, nullable=True),
        sa.Column("rate_hz", REAL, nullable=True),
        sa.Column("n_samples", WHOLE, nullable=False),
        sa.Column("sha256", TEXT, nullable=False),
        sa.Column("store_path", TEXT, nullable=False),
        sa.CheckConstraint("n_samples >= 0", name=op.f("ck_signal_n_samples_counted")),
        sa.ForeignKeyConstraint(
            ["file"], ["file.id"], name=op.f("fk_signal_file"), onupdate="RESTRICT", ondelete="RESTRICT"
        ),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_signal")),
        sa.UniqueConstraint("file", "part", "reader_version", name=op.f("uq_signal_file_part_reader_version")),
        sa.UniqueConstraint("uid", name=op.f("uq_signal_uid")),
        sqlite_strict=True,
    )
    op.create_index(op.f("ix_signal_file"), "signal", ["file"], unique=False)
    op.create_table(
        "channel",
        sa.Column("signal", WHOLE, nullable=False),
        sa.Column("position", WHOLE, nullable=False),
        sa.Column("name", TEXT, nullable=False),
        sa.Column("unit", TEXT, nullable=True),
        sa.Column("source_name", TEXT, nullable=False),
        sa.Column("source_unit", TEXT, nullable=True),
        sa.Column("scale", REAL, nullable=False),
        sa.Column("zero_offset", REAL, nullable=False),
        sa.Column("sign", WHOLE, nullable=False),
        sa.Column("assumed_json", TEXT, nullable=False),
        sa.Column("instrument", WHOLE, nullable=True),
        sa.CheckConstraint("sign IN (-1, 1)", name=op.f("ck_channel_sign_known")),
        sa.ForeignKeyConstraint(
            ["instrument"],
            ["instrument.id"],
            name=op.f("fk_channel_instrument"),
            onupdate="RESTRICT",
            ondelete="RESTRICT",
        ),
        sa.ForeignKeyConstraint(
            ["signal"], ["signal.id"], name=op.f("fk_channel_signal"), onupdate="RESTRICT", ondelete="RESTRICT"
        ),
        sa.PrimaryKeyConstraint("signal", "position", name=op.f("pk_channel")),
        sa.UniqueConstraint("signal", "name", name=op.f("uq_channel_signal_name")),
        sqlite_strict=True,
    )
    op.create_index(op.f("ix_channel_instrument"), "channel", ["instrument"], unique=False)
    op.create_index(op.f("ix_channel_signal"), "channel", ["signal"], unique=False)
    op.create_table(
        "day_check",
        sa.Column("id", WHOLE, nullable=False),
        sa.Column("uid", TEXT, nullable=False),
        sa.Column("day", WHOLE, nullable=False),
        sa.Column("kind", TEXT, nullable=False),
        sa.Column("value", REAL, nullable=True),
        sa.Column("unit", TEXT, nullable=True),
        sa.Column("passed", WHOLE, nullable=False),
        sa.Column("person", WHOLE, nullable=False),
        sa.Column("at_utc", TEXT, nullable=False),
        sa.CheckConstraint("passed IN (0, 1)", name=op.f("ck_day_check_passed_flag")),
        sa.ForeignKeyConstraint(
            ["day"], ["day.id"], name=op.f("fk_day_check_day"), onupdate="RESTRICT", ondelete="RESTRICT"
        ),
        sa.ForeignKeyConstraint(
            ["person"], ["person.id"], name=op.f("fk_day_check_person"), onupdate="RESTRICT", ondelete="RESTRICT"
        ),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_day_check")),
        sa.UniqueConstraint("uid", name=op.f("uq_day_check_uid")),
        sqlite_strict=True,
    )
    op.create_index(op.f("ix_day_check_day"), "day_check", ["day"], unique=False)
    op.create_index(op.f("ix_day_check_person"), "day_check", ["person"], unique=False)
    op.create_table(
        "detection",
        sa.Column("id", WHOLE, nullable=False),
        sa.Column("uid", TEXT, nullable=False),
        sa.Column("signal", WHOLE, nullable=False),
        sa.Column("algorithm", TEXT, nullable=False),
        sa.Column("version", WHOLE, nullable=False),
        sa.Column("parameters_json", TEXT, nullable=False),
        sa.Column("key", TEXT, nullable=False),
        sa.Column("n_jumps", WHOLE, nullable=False),
        sa.CheckConstraint("n_jumps >= 0", name=op.f("ck_detection_n_jumps_counted")),
        sa.ForeignKeyConstraint(
            ["signal"], ["signal.id"], name=op.f("fk_detection_signal"), onupdate="RESTRICT", ondelete="RESTRICT"
        ),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_detection")),
        sa.UniqueConstraint("key", name=op.f("uq_detection_key")),
        sa.UniqueConstraint("uid", name=op.f("uq_detection_uid")),
        sqlite_strict=True,
    )
    op.create_index(op.f("ix_detection_signal"), "detection", ["signal"], unique=False)
    op.create_table(
        "finding",
        sa.Column("id", WHOLE, nullable=False),
        sa.Column("ingest", WHOLE, nullable=False),
        sa.Column("severity", TEXT, nullable=False),
        sa.Column("rule", TEXT, nullable=False),
        sa.Column("line", WHOLE, nullable=True),
        sa.Column("column_name", TEXT, nullable=True),
        sa.Column("value", TEXT, nullable=True),
        sa.Column("n", WHOLE, nullable=False),
        sa.Column("more_lines_json", TEXT, nullable=False),
        sa.Column("message", TEXT, nullable=False),
        sa.CheckConstraint("severity IN ('note', 'row', 'file')", name=op.f("ck_finding_severity_known")),
        sa.CheckConstraint("n >= 1", name=op.f("ck_finding_n_counted")),
        sa.ForeignKeyConstraint(
            ["ingest"], ["ingest.id"], name=op.f("fk_finding_ingest"), onupdate="RESTRICT", ondelete="RESTRICT"
        ),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_finding")),
        sqlite_strict=True,
    )
    op.create_index(op.f("ix_finding_ingest"), "finding", ["ingest"], unique=False)
    op.create_table(
        "gap",
        sa.Column("id", WHOLE, nullable=False),
        sa.Column("signal", WHOLE, nullable=False),
        sa.Column("start_s", REAL, nullable=False),
        sa.Column("length_s", REAL, nullable=False),
        sa.Column("samples_expected", WHOLE, nullable=False),
        sa.Column("samples_missing", WHOLE, nullable=False),
        sa.Column("kind", TEXT, nullable=False),
        sa.CheckConstraint("kind IN ('dropped', 'pause', 'rejected', 'held')", name=op.f("ck_gap_kind_known")),
        sa.CheckConstraint("length_s > 0", name=op.f("ck_gap_length_positive")),
        sa.ForeignKeyConstraint(
            ["signal"], ["signal.id"], name=op.f("fk_gap_signal"), onupdate="RESTRICT", ondelete="RESTRICT"
        ),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_gap")),
        sqlite_strict=True,
    )
    op.create_index(op.f("ix_gap_signal"), "gap", ["signal"], unique=False)
    op.create_table(
        "level",
        sa.Column("id", WHOLE, nullable=False),
        sa.Column("uid", TEXT, nullable=False),
        sa.Column("factor", WHOLE, nullable=False),
        sa.Column("label", TEXT, nullable=False),
        sa.Column("value", REAL, nullable=True),
        sa.Column("attributes_json", TEXT, nullable=False),
        sa.ForeignKeyConstraint(
            ["factor"], ["factor.id"], name=op.f("fk_level_factor"), onupdate="RESTRICT", ondelete="RESTRICT"
        ),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_level")),
        sa.UniqueConstraint("factor", "label", name=op.f("uq_level_factor_label")),
        sa.UniqueConstraint("uid", name=op.f("uq_level_uid")),
        sqlite_strict=True,
    )
    op.create_index(op.f("ix_level_factor"), "level", ["factor"], unique=False)
    op.create_table(
        "planned_run",
        sa.Column("id", WHOLE, nullable=False),
        sa.Column("uid", TEXT, nullable=False),
        sa.Column("plan", WHOLE, nullable=False),
        sa.Column("name", TEXT, nullable=False),
        sa.Column("position", WHOLE, nullable=False),
        sa.Column("day_number", WHOLE, nullable=False),
        sa.Column("block", TEXT, nullable=False),
        sa.Column("condition", WHOLE, nullable=True),
        sa.ForeignKeyConstraint(
            ["condition"],
            ["condition.id"],
            name=op.f("fk_planned_run_condition"),
            onupdate="RESTRICT",
            ondelete="RESTRICT",
        ),
        sa.ForeignKeyConstraint(
            ["plan"], ["plan.id"], name=op.f("fk_planned_run_plan"), onupdate="RESTRICT", ondelete="RESTRICT"
        ),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_planned_run")),
        sa.UniqueConstraint("plan", "position", name=op.f("uq_planned_run_plan_position")),
        sa.UniqueConstraint("uid", name=op.f("uq_planned_run_uid")),
        sqlite_strict=True,
    )
    op.create_index(op.f("ix_planned_run_condition"), "planned_run", ["condition"], unique=False)
    op.create_index(op.f("ix_planned_run_plan"), "planned_run", ["plan"], unique=False)
    op.create_table(
        "prediction",
        sa.Column("id", WHOLE, nullable=False),
        sa.Column("uid", TEXT, nullable=False),
        sa.Column("result", WHOLE, nullable=False),
        sa.Column("condition", WHOLE, nullable=True),
        sa.Column("scene_toml", TEXT, nullable=False),
        sa.Column("effects_json", TEXT, nullable=False),
        sa.Column("accuracy", REAL, nullable=False),
        sa.Column("outcome", TEXT, nullable=False),
        sa.Column("assumed_json", TEXT, nullable=False),
        sa.ForeignKeyConstraint(
            ["condition"],
            ["condition.id"],
            name=op.f("fk_prediction_condition"),
            onupdate="RESTRICT",
            ondelete="RESTRICT",
        ),
        sa.ForeignKeyConstraint(
            ["result"], ["result.id"], name=op.f("fk_prediction_result"), onupdate="RESTRICT", ondelete="RESTRICT"
        ),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_prediction")),
        sa.UniqueConstraint("result", name=op.f("uq_prediction_result")),
        sa.UniqueConstraint("uid", name=op.f("uq_prediction_uid")),
        sqlite_strict=True,
    )
    op.create_index(op.f("ix_prediction_condition"), "prediction", ["condition"], unique=False)
    op.create_table(
        "result_input",
        sa.Column("result", WHOLE, nullable=False),
        sa.Column("role", TEXT, nullable=False),
        sa.Column("input_kind", TEXT, nullable=False),
        sa.Column("input_uid", TEXT, nullable=False),
        sa.Column("input_sha256", TEXT, nullable=False),
        sa.ForeignKeyConstraint(
            ["result"], ["result.id"], name=op.f("fk_result_input_result"), onupdate="RESTRICT", ondelete="RESTRICT"
        ),
        sa.PrimaryKeyConstraint("result", "role", "input_kind", "input_uid", name=op.f("pk_result_input")),
        sqlite_strict=True,
    )
    op.create_index(op.f("ix_result_input_result"), "result_input", ["result"], unique=False)
    op.create_index("ix_result_input_what", "result_input", ["input_kind", "input_uid"], unique=False)
    op.create_table(
        "result_number",
        sa.Column("id", WHOLE, nullable=False),
        sa.Column("uid", TEXT, nullable=False),
        sa.Column("result", WHOLE, nullable=False),
        sa.Column("name", TEXT, nullable=False),
        sa.Column("value", REAL, nullable=True),
        sa.Column("unit", TEXT, nullable=False),
        sa.Column("se", REAL, nullable=True),
        sa.Column("shared_se", REAL, nullable=True),
        sa.Column("ci_low", REAL, nullable=True),
        sa.Column("ci_high", REAL, nullable=True),
        sa.Column("ci_level", REAL, nullable=True),
        sa.Column("df", REAL, nullable=True),
        sa.Column("n", WHOLE, nullable=True),
        sa.Column("undefined_reason", TEXT, nullable=True),
        sa.CheckConstraint(
            "(value IS NULL) <> (undefined_reason IS NULL)", name=op.f("ck_result_number_value_or_reason")
        ),
        sa.ForeignKeyConstraint(
            ["result"], ["result.id"], name=op.f("fk_result_number_result"), onupdate="RESTRICT", ondelete="RESTRICT"
        ),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_result_number")),
        sa.UniqueConstraint("result", "name", name=op.f("uq_result_number_result_name")),
        sa.UniqueConstraint("uid", name=op.f("uq_result_number_uid")),
        sqlite_strict=True,
    )
    op.create_index(op.f("ix_result_number_result"), "result_number", ["result"], unique=False)
    op.create_table(
        "condition_level",
        sa.Column("condition", WHOLE, nullable=False),
        sa.Column("factor", WHOLE, nullable=False),
        sa.Column("level", WHOLE, nullable=False),
        sa.ForeignKeyConstraint(
            ["condition"],
            ["condition.id"],
            name=op.f("fk_condition_level_condition"),
            onupdate="RESTRICT",
            ondelete="RESTRICT",
        ),
        sa.ForeignKeyConstraint(
            ["factor"], ["factor.id"], name=op.f("fk_condition_level_factor"), onupdate="RESTRICT", ondelete="RESTRICT"
        ),
        sa.ForeignKeyConstraint(
            ["level"], ["level.id"], name=op.f("fk_condition_level_level"), onupdate="RESTRICT", ondelete="RESTRICT"
        ),
        sa.PrimaryKeyConstraint("condition", "factor", name=op.f("pk_condition_level")),
        sqlite_strict=True,
    )
    op.create_index(op.f("ix_condition_level_condition"), "condition_level", ["condition"], unique=False)
    op.create_index(op.f("ix_condition_level_factor"), "condition_level", ["factor"], unique=False)
    op.create_index(op.f("ix_condition_level_level"), "condition_level", ["level"], unique=False)
    op.create_table(
        "jump",
        sa.Column("id", WHOLE, nullable=False),
        sa.Column("uid", TEXT, nullable=False),
        sa.Column("detection", WHOLE, nullable=False),
        sa.Column("number", WHOLE, nullable=False),
        sa.Column("touchdown_s", REAL, nullable=True),
        sa.Column("liftoff_s", REAL, nullable=True),
        sa.Column("apex_s", REAL, nullable=True),
        sa.Column("apex_height_m", REAL, nullable=True),
        sa.Column("apex_height_se_m", REAL, nullable=True),
        sa.Column("undefined_reason", TEXT, nullable=True),
        sa.Column("flight_time_s", REAL, nullable=True),
        sa.Column("samples_used", WHOLE, nullable=False),
        sa.Column("gap_touched", WHOLE, nullable=False),
        sa.Column("flags_json", TEXT, nullable=False),
        sa.CheckConstraint(
            "(apex_height_m IS NULL) <> (undefined_reason IS NULL)", name=op.f("ck_jump_height_or_reason")
        ),
        sa.CheckConstraint("gap_touched IN (0, 1)", name=op.f("ck_jump_gap_touched_flag")),
        sa.ForeignKeyConstraint(
            ["detection"], ["detection.id"], name=op.f("fk_jump_detection"), onupdate="RESTRICT", ondelete="RESTRICT"
        ),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_jump")),
        sa.UniqueConstraint("detection", "number", name=op.f("uq_jump_detection_number")),
        sa.UniqueConstraint("uid", name=op.f("uq_jump_uid")),
        sqlite_strict=True,
    )
    op.create_index(op.f("ix_jump_detection"), "jump", ["detection"], unique=False)
    op.create_table(
        "report_item",
        sa.Column("report", WHOLE, nullable=False),
        sa.Column("number_uid", TEXT, nullable=False),
        sa.Column("value", REAL, nullable=True),
        sa.Column("result_number", WHOLE, nullable=True),
        sa.ForeignKeyConstraint(
            ["report"], ["report.id"], name=op.f("fk_report_item_report"), onupdate="RESTRICT", ondelete="RESTRICT"
        ),
        sa.ForeignKeyConstraint(
            ["result_number"],
            ["result_number.id"],
            name=op.f("fk_report_item_result_number"),
            onupdate="RESTRICT",
            ondelete="RESTRICT",
        ),
        sa.PrimaryKeyConstraint("report", "number_uid", name=op.f("pk_report_item")),
        sqlite_strict=True,
    )
    op.create_index(op.f("ix_report_item_report"), "report_item", ["report"], unique=False)
    op.create_index(op.f("ix_report_item_result_number"), "report_item", ["result_number"], unique=False)
    op.create_table(
        "run",
        sa.Column("id", WHOLE, nullable=False),
        sa.Column("uid", TEXT, nullable=False),
        sa.Column("study", WHOLE, nullable=False),
        sa.Column("day", WHOLE, nullable=False),
        sa.Column("name", TEXT, nullable=False),
        sa.Column("kind", TEXT, nullable=False),
        sa.Column("condition", WHOLE, nullable=True),
        sa.Column("robot", WHOLE, nullable=False),
        sa.Column("battery", WHOLE, nullable=False),
        sa.Column("planned_run", WHOLE, nullable=True),
        sa.Column("position_in_day", WHOLE, nullable=False),
        sa.Column("started_utc", TEXT, nullable=True),
        sa.Column("duration_s", REAL, nullable=True),
        sa.Column("jumps_made", WHOLE, nullable=False),
        sa.Column("starts", WHOLE, nullable=False),
        sa.Column("state", TEXT, nullable=False),
        sa.CheckConstraint("kind IN ('jumps', 'idle', 'characterisation', 'field')", name=op.f("ck_run_kind_known")),
        sa.CheckConstraint("state IN ('open', 'complete', 'void')", name=op.f("ck_run_state_known")),
        sa.CheckConstraint("duration_s IS NULL OR duration_s > 0", name=op.f("ck_run_duration_positive")),
        sa.CheckConstraint("jumps_made >= 0", name=op.f("ck_run_jumps_counted")),
        sa.CheckConstraint("position_in_day >= 1", name=op.f("ck_run_position_counted")),
        sa.CheckConstraint("starts >= 1", name=op.f("ck_run_starts_counted")),
        sa.ForeignKeyConstraint(
            ["battery"], ["battery.id"], name=op.f("fk_run_battery"), onupdate="RESTRICT", ondelete="RESTRICT"
        ),
        sa.ForeignKeyConstraint(
            ["condition"], ["condition.id"], name=op.f("fk_run_condition"), onupdate="RESTRICT", ondelete="RESTRICT"
        ),
        sa.ForeignKeyConstraint(["day"], ["day.id"], name=op.f("fk_run_day"), onupdate="RESTRICT", ondelete="RESTRICT"),
        sa.ForeignKeyConstraint(
            ["planned_run"],
            ["planned_run.id"],
            name=op.f("fk_run_planned_run"),
            onupdate="RESTRICT",
            ondelete="RESTRICT",
        ),
        sa.ForeignKeyConstraint(
            ["robot"], ["robot.id"], name=op.f("fk_run_robot"), onupdate="RESTRICT", ondelete="RESTRICT"
        ),
        sa.ForeignKeyConstraint(
            ["study"], ["study.id"], name=op.f("fk_run_study"), onupdate="RESTRICT", ondelete="RESTRICT"
        ),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_run")),
        sa.UniqueConstraint("planned_run", name=op.f("uq_run_planned_run")),
        sa.UniqueConstraint("study", "name", name=op.f("uq_run_study_name")),
        sa.UniqueConstraint("uid", name=op.f("uq_run_uid")),
        sqlite_strict=True,
    )
    op.create_index(op.f("ix_run_battery"), "run", ["battery"], unique=False)
    op.create_index(op.f("ix_run_condition"), "run", ["condition"], unique=False)
    op.create_index(op.f("ix_run_day"), "run", ["day"], unique=False)
    op.create_index(op.f("ix_run_robot"), "run", ["robot"], unique=False)
    op.create_index(op.f("ix_run_study"), "run", ["study"], unique=False)
    op.create_table(
        "charge",
        sa.Column("id", WHOLE, nullable=False),
        sa.Column("uid", TEXT, nullable=False),
        sa.Column("file", WHOLE, nullable=True),
        sa.Column("row_number", WHOLE, nullable=False),
        sa.Column("run", WHOLE, nullable=True),
        sa.Column("stated_run", TEXT, nullable=True),
        sa.Column("battery", WHOLE, nullable=True),
        sa.Column("stated_pack", TEXT, nullable=True),
        sa.Column("charge_mah", REAL, nullable=False),
        sa.Column("resolution_mah", REAL, nullable=False),
        sa.Column("duration_s", REAL, nullable=True),
        sa.Column("end_voltage_v", REAL, nullable=True),
        sa.Column("mode", TEXT, nullable=False),
        sa.Column("ended_utc", TEXT, nullable=True),
        sa.Column("ended_original", TEXT, nullable=True),
        sa.CheckConstraint("mode IN ('charge', 'discharge')", name=op.f("ck_charge_mode_known")),
        sa.CheckConstraint("charge_mah >= 0", name=op.f("ck_charge_charge_counted")),
        sa.CheckConstraint("duration_s IS NULL OR duration_s > 0", name=op.f("ck_charge_duration_positive")),
        sa.CheckConstraint("resolution_mah > 0", name=op.f("ck_charge_resolution_positive")),
        sa.ForeignKeyConstraint(
            ["battery"], ["battery.id"], name=op.f("fk_charge_battery"), onupdate="RESTRICT", ondelete="RESTRICT"
        ),
        sa.ForeignKeyConstraint(
            ["file"], ["file.id"], name=op.f("fk_charge_file"), onupdate="RESTRICT", ondelete="RESTRICT"
        ),
        sa.ForeignKeyConstraint(
            ["run"], ["run.id"], name=op.f("fk_charge_run"), onupdate="RESTRICT", ondelete="RESTRICT"
        ),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_charge")),
        sa.UniqueConstraint("file", "row_number", name=op.f("uq_charge_file_row_number")),
        sa.UniqueConstraint("uid", name=op.f("uq_charge_uid")),
        sqlite_strict=True,
    )
    op.create_index(op.f("ix_charge_battery"), "charge", ["battery"], unique=False)
    op.create_index(op.f("ix_charge_file"), "charge", ["file"], unique=False)
    op.create_index(op.f("ix_charge_run"), "charge", ["run"], unique=False)
    op.create_table(
        "run_file",
        sa.Column("id", WHOLE, nullable=False),
        sa.Column("uid", TEXT, nullable=False),
        sa.Column("run", WHOLE, nullable=False),
        sa.Column("file", WHOLE, nullable=False),
        sa.Column("part", TEXT, nullable=False),
        sa.Column("role", TEXT, nullable=False),
        sa.CheckConstraint("role IN ('log', 'force', 'charge', 'video')", name=op.f("ck_run_file_role_known")),
        sa.ForeignKeyConstraint(
            ["file"], ["file.id"], name=op.f("fk_run_file_file"), onupdate="RESTRICT", ondelete="RESTRICT"
        ),
        sa.ForeignKeyConstraint(
            ["run"], ["run.id"], name=op.f("fk_run_file_run"), onupdate="RESTRICT", ondelete="RESTRICT"
        ),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_run_file")),
        sa.UniqueConstraint("run", "file", "part", name=op.f("uq_run_file_run_file_part")),
        sa.UniqueConstraint("uid", name=op.f("uq_run_file_uid")),
        sqlite_strict=True,
    )
    op.create_index(op.f("ix_run_file_file"), "run_file", ["file"], unique=False)
    op.create_index(op.f("ix_run_file_run"), "run_file", ["run"], unique=False)
    if op.get_bind().dialect.name == "sqlite":
        op.execute(SQLITE_TRIGGER.format(verb="changed", event="UPDATE"))
        op.execute(SQLITE_TRIGGER.format(verb="deleted", event="DELETE"))
    else:
        op.execute(POSTGRES_FUNCTION)
        op.execute(POSTGRES_TRIGGER)
