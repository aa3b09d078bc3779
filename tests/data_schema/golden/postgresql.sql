CREATE OR REPLACE FUNCTION public.journal_is_append_only() RETURNS trigger LANGUAGE plpgsql AS $function$ BEGIN RAISE EXCEPTION 'the journal is only ever added to'; END $function$
CREATE TRIGGER journal_never_changed BEFORE DELETE OR UPDATE OR TRUNCATE ON public.journal FOR EACH STATEMENT EXECUTE FUNCTION journal_is_append_only()
column alembic_version.version_num character varying(32) NOT NULL
column battery.capacity_mah double precision NOT NULL
column battery.cells bigint NOT NULL
column battery.id bigint NOT NULL
column battery.name text NOT NULL
column battery.uid text NOT NULL
column calibration.file bigint
column calibration.gain double precision NOT NULL
column calibration.gain_se double precision NOT NULL
column calibration.id bigint NOT NULL
column calibration.instrument bigint NOT NULL
column calibration.quantity text NOT NULL
column calibration.uid text NOT NULL
column calibration.unit text NOT NULL
column calibration.valid_from_utc text NOT NULL
column calibration.valid_to_utc text
column calibration.zero_offset double precision NOT NULL
column channel.assumed_json text NOT NULL
column channel.calibrated_unit text
column channel.calibration_json text
column channel.instrument bigint
column channel.name text NOT NULL
column channel.position bigint NOT NULL
column channel.scale double precision NOT NULL
column channel.sign bigint NOT NULL
column channel.signal bigint NOT NULL
column channel.source_name text NOT NULL
column channel.source_unit text
column channel.unit text
column channel.zero_offset double precision NOT NULL
column charge.added bigint NOT NULL
column charge.battery bigint
column charge.charge_mah double precision NOT NULL
column charge.duration_s double precision
column charge.end_voltage_v double precision
column charge.ended_original text
column charge.ended_utc text
column charge.file bigint
column charge.id bigint NOT NULL
column charge.line bigint
column charge.mode text NOT NULL
column charge.repeats text
column charge.resolution_mah double precision NOT NULL
column charge.row_number bigint NOT NULL
column charge.run bigint
column charge.state text NOT NULL
column charge.stated_pack text
column charge.stated_run text
column charge.uid text NOT NULL
column condition.id bigint NOT NULL
column condition.is_control bigint NOT NULL
column condition.key text NOT NULL
column condition.study bigint NOT NULL
column condition.uid text NOT NULL
column condition_level.condition bigint NOT NULL
column condition_level.factor bigint NOT NULL
column condition_level.level bigint NOT NULL
column config.id bigint NOT NULL
column config.read_utc text NOT NULL
column config.sha256 text NOT NULL
column config.text text NOT NULL
column config.uid text NOT NULL
column day.date_local text NOT NULL
column day.id bigint NOT NULL
column day.study bigint NOT NULL
column day.uid text NOT NULL
column day_check.at_utc text NOT NULL
column day_check.day bigint NOT NULL
column day_check.id bigint NOT NULL
column day_check.kind text NOT NULL
column day_check.passed bigint NOT NULL
column day_check.person bigint NOT NULL
column day_check.uid text NOT NULL
column day_check.unit text
column day_check.value double precision
column decision.algorithm text
column decision.anchor_s double precision
column decision.at_utc text NOT NULL
column decision.blind bigint NOT NULL
column decision.id bigint NOT NULL
column decision.new_value double precision
column decision.note text
column decision.old_value double precision
column decision.person bigint NOT NULL
column decision.reason_code text NOT NULL
column decision.signal_sha256 text
column decision.target_kind text NOT NULL
column decision.target_uid text NOT NULL
column decision.uid text NOT NULL
column decision.verdict text NOT NULL
column decision.version bigint
column detection.algorithm text NOT NULL
column detection.id bigint NOT NULL
column detection.key text NOT NULL
column detection.n_jumps bigint NOT NULL
column detection.parameters_json text NOT NULL
column detection.signal bigint NOT NULL
column detection.uid text NOT NULL
column detection.version bigint NOT NULL
column factor.id bigint NOT NULL
column factor.kind text NOT NULL
column factor.name text NOT NULL
column factor.study bigint NOT NULL
column factor.uid text NOT NULL
column factor.unit text
column file.id bigint NOT NULL
column file.n_bytes bigint NOT NULL
column file.sha256 text NOT NULL
column file.state text NOT NULL
column file.store_path text NOT NULL
column file.uid text NOT NULL
column finding.column_name text
column finding.id bigint NOT NULL
column finding.ingest bigint NOT NULL
column finding.line bigint
column finding.message text NOT NULL
column finding.more_lines_json text NOT NULL
column finding.n bigint NOT NULL
column finding.rule text NOT NULL
column finding.severity text NOT NULL
column finding.value text
column gap.id bigint NOT NULL
column gap.kind text NOT NULL
column gap.length_s double precision NOT NULL
column gap.samples_expected bigint NOT NULL
column gap.samples_missing bigint NOT NULL
column gap.signal bigint NOT NULL
column gap.start_s double precision NOT NULL
column ingest.at_utc text NOT NULL
column ingest.config bigint NOT NULL
column ingest.declared_json text
column ingest.file bigint
column ingest.id bigint NOT NULL
column ingest.modified_utc text
column ingest.options_json text NOT NULL
column ingest.original_name text NOT NULL
column ingest.person bigint NOT NULL
column ingest.reader text NOT NULL
column ingest.reader_version bigint NOT NULL
column ingest.role text
column ingest.rows_kept bigint NOT NULL
column ingest.rows_read bigint NOT NULL
column ingest.rows_rejected bigint NOT NULL
column ingest.sha256 text NOT NULL
column ingest.stated_run text
column ingest.status text NOT NULL
column ingest.uid text NOT NULL
column instrument.id bigint NOT NULL
column instrument.kind text NOT NULL
column instrument.make text
column instrument.model text
column instrument.name text NOT NULL
column instrument.serial text
column instrument.uid text NOT NULL
column journal.action text NOT NULL
column journal.at_utc text NOT NULL
column journal.entity_kind text NOT NULL
column journal.entity_uid text NOT NULL
column journal.following bigint NOT NULL
column journal.hash text NOT NULL
column journal.id bigint NOT NULL
column journal.new_json text
column journal.old_json text
column journal.origin_json text
column journal.person bigint NOT NULL
column journal.prev_hash text NOT NULL
column journal.reason text
column journal.seq bigint NOT NULL
column jump.apex_height_m double precision
column jump.apex_height_se_m double precision
column jump.apex_s double precision
column jump.detection bigint NOT NULL
column jump.flags_json text NOT NULL
column jump.flight_time_s double precision
column jump.gap_touched bigint NOT NULL
column jump.id bigint NOT NULL
column jump.liftoff_s double precision
column jump.number bigint NOT NULL
column jump.samples_used bigint NOT NULL
column jump.touchdown_s double precision
column jump.uid text NOT NULL
column jump.undefined_reason text
column level.attributes_json text NOT NULL
column level.factor bigint NOT NULL
column level.id bigint NOT NULL
column level.label text NOT NULL
column level.uid text NOT NULL
column level.value double precision
column note.at_utc text NOT NULL
column note.file bigint
column note.id bigint NOT NULL
column note.person bigint NOT NULL
column note.target_kind text NOT NULL
column note.target_uid text NOT NULL
column note.text text NOT NULL
column note.uid text NOT NULL
column person.id bigint NOT NULL
column person.initials text NOT NULL
column person.name text NOT NULL
column person.uid text NOT NULL
column plan.created_utc text NOT NULL
column plan.id bigint NOT NULL
column plan.method text NOT NULL
column plan.seed bigint NOT NULL
column plan.study bigint NOT NULL
column plan.uid text NOT NULL
column planned_run.block text NOT NULL
column planned_run.condition bigint
column planned_run.day_number bigint NOT NULL
column planned_run.id bigint NOT NULL
column planned_run.name text NOT NULL
column planned_run.plan bigint NOT NULL
column planned_run.position bigint NOT NULL
column planned_run.uid text NOT NULL
column prediction.accuracy double precision NOT NULL
column prediction.assumed_json text NOT NULL
column prediction.condition bigint
column prediction.effects_json text NOT NULL
column prediction.id bigint NOT NULL
column prediction.outcome text NOT NULL
column prediction.result bigint NOT NULL
column prediction.scene_toml text NOT NULL
column prediction.uid text NOT NULL
column report.as_of_utc text NOT NULL
column report.config bigint NOT NULL
column report.id bigint NOT NULL
column report.made_utc text NOT NULL
column report.options_json text NOT NULL
column report.uid text NOT NULL
column report.versions_json text NOT NULL
column report_item.number_uid text NOT NULL
column report_item.report bigint NOT NULL
column report_item.result_number bigint
column report_item.value double precision
column result.algorithm text NOT NULL
column result.config bigint NOT NULL
column result.id bigint NOT NULL
column result.key text NOT NULL
column result.kind text NOT NULL
column result.payload_json text NOT NULL
column result.scope_json text NOT NULL
column result.stale bigint NOT NULL
column result.uid text NOT NULL
column result.version bigint NOT NULL
column result_input.input_kind text NOT NULL
column result_input.input_sha256 text NOT NULL
column result_input.input_uid text NOT NULL
column result_input.result bigint NOT NULL
column result_input.role text NOT NULL
column result_number.ci_high double precision
column result_number.ci_level double precision
column result_number.ci_low double precision
column result_number.df double precision
column result_number.id bigint NOT NULL
column result_number.n bigint
column result_number.name text NOT NULL
column result_number.result bigint NOT NULL
column result_number.se double precision
column result_number.shared_se double precision
column result_number.uid text NOT NULL
column result_number.undefined_reason text
column result_number.unit text NOT NULL
column result_number.value double precision
column robot.body_mass_kg double precision NOT NULL
column robot.foot_mass_kg double precision NOT NULL
column robot.id bigint NOT NULL
column robot.leg_max_m double precision NOT NULL
column robot.leg_min_m double precision NOT NULL
column robot.link_1_m double precision NOT NULL
column robot.link_2_m double precision NOT NULL
column robot.name text NOT NULL
column robot.rest_length_m double precision NOT NULL
column robot.uid text NOT NULL
column robot.valid_from_utc text NOT NULL
column row_hash.kind text NOT NULL
column row_hash.sha256 text NOT NULL
column row_hash.uid text NOT NULL
column run.battery bigint NOT NULL
column run.condition bigint
column run.day bigint NOT NULL
column run.duration_s double precision
column run.id bigint NOT NULL
column run.jumps_made bigint NOT NULL
column run.kind text NOT NULL
column run.name text NOT NULL
column run.planned_run bigint
column run.position_in_day bigint NOT NULL
column run.robot bigint NOT NULL
column run.started_utc text
column run.starts bigint NOT NULL
column run.state text NOT NULL
column run.study bigint NOT NULL
column run.uid text NOT NULL
column run_file.file bigint NOT NULL
column run_file.id bigint NOT NULL
column run_file.part text NOT NULL
column run_file.role text NOT NULL
column run_file.run bigint NOT NULL
column run_file.uid text NOT NULL
column signal.file bigint NOT NULL
column signal.id bigint NOT NULL
column signal.ingest bigint NOT NULL
column signal.n_samples bigint NOT NULL
column signal.part text NOT NULL
column signal.rate_hz double precision
column signal.reader text NOT NULL
column signal.reader_version bigint NOT NULL
column signal.recorded_sha256 text
column signal.sha256 text NOT NULL
column signal.start_utc text
column signal.store_path text NOT NULL
column signal.time_sha256 text
column signal.uid text NOT NULL
column study.id bigint NOT NULL
column study.jumps_nominal bigint NOT NULL
column study.kind text NOT NULL
column study.name text NOT NULL
column study.reference_voltage_v double precision NOT NULL
column study.time_zone text NOT NULL
column study.uid text NOT NULL
index CREATE INDEX ix_calibration_file ON public.calibration USING btree (file)
index CREATE INDEX ix_calibration_instrument ON public.calibration USING btree (instrument)
index CREATE INDEX ix_channel_instrument ON public.channel USING btree (instrument)
index CREATE INDEX ix_channel_signal ON public.channel USING btree (signal)
index CREATE INDEX ix_charge_battery ON public.charge USING btree (battery)
index CREATE INDEX ix_charge_file ON public.charge USING btree (file)
index CREATE INDEX ix_charge_repeats ON public.charge USING btree (repeats)
index CREATE INDEX ix_charge_run ON public.charge USING btree (run)
index CREATE INDEX ix_charge_stated_run ON public.charge USING btree (stated_run)
index CREATE INDEX ix_condition_level_condition ON public.condition_level USING btree (condition)
index CREATE INDEX ix_condition_level_factor ON public.condition_level USING btree (factor)
index CREATE INDEX ix_condition_level_level ON public.condition_level USING btree (level)
index CREATE INDEX ix_condition_study ON public.condition USING btree (study)
index CREATE INDEX ix_day_check_day ON public.day_check USING btree (day)
index CREATE INDEX ix_day_check_person ON public.day_check USING btree (person)
index CREATE INDEX ix_day_study ON public.day USING btree (study)
index CREATE INDEX ix_decision_person ON public.decision USING btree (person)
index CREATE INDEX ix_decision_signal_sha256 ON public.decision USING btree (signal_sha256)
index CREATE INDEX ix_decision_target ON public.decision USING btree (target_kind, target_uid)
index CREATE INDEX ix_detection_signal ON public.detection USING btree (signal)
index CREATE INDEX ix_factor_study ON public.factor USING btree (study)
index CREATE INDEX ix_finding_ingest ON public.finding USING btree (ingest)
index CREATE INDEX ix_gap_signal ON public.gap USING btree (signal)
index CREATE INDEX ix_ingest_config ON public.ingest USING btree (config)
index CREATE INDEX ix_ingest_file ON public.ingest USING btree (file)
index CREATE INDEX ix_ingest_original_name ON public.ingest USING btree (original_name)
index CREATE INDEX ix_ingest_person ON public.ingest USING btree (person)
index CREATE INDEX ix_ingest_sha256 ON public.ingest USING btree (sha256)
index CREATE INDEX ix_ingest_stated_run ON public.ingest USING btree (stated_run)
index CREATE INDEX ix_ingest_waiting ON public.ingest USING btree (id) WHERE (status = 'waiting'::text)
index CREATE INDEX ix_journal_entity ON public.journal USING btree (entity_kind, entity_uid)
index CREATE INDEX ix_journal_entity_uid ON public.journal USING btree (entity_uid)
index CREATE INDEX ix_journal_person ON public.journal USING btree (person)
index CREATE INDEX ix_jump_detection ON public.jump USING btree (detection)
index CREATE INDEX ix_level_factor ON public.level USING btree (factor)
index CREATE INDEX ix_note_file ON public.note USING btree (file)
index CREATE INDEX ix_note_person ON public.note USING btree (person)
index CREATE INDEX ix_note_target ON public.note USING btree (target_kind, target_uid)
index CREATE INDEX ix_note_target_uid ON public.note USING btree (target_uid)
index CREATE INDEX ix_plan_study ON public.plan USING btree (study)
index CREATE INDEX ix_planned_run_condition ON public.planned_run USING btree (condition)
index CREATE INDEX ix_planned_run_plan ON public.planned_run USING btree (plan)
index CREATE INDEX ix_prediction_condition ON public.prediction USING btree (condition)
index CREATE INDEX ix_report_config ON public.report USING btree (config)
index CREATE INDEX ix_report_item_report ON public.report_item USING btree (report)
index CREATE INDEX ix_report_item_result_number ON public.report_item USING btree (result_number)
index CREATE INDEX ix_result_config ON public.result USING btree (config)
index CREATE INDEX ix_result_input_result ON public.result_input USING btree (result)
index CREATE INDEX ix_result_input_what ON public.result_input USING btree (input_kind, input_uid)
index CREATE INDEX ix_result_kind ON public.result USING btree (kind)
index CREATE INDEX ix_result_number_result ON public.result_number USING btree (result)
index CREATE INDEX ix_run_battery ON public.run USING btree (battery)
index CREATE INDEX ix_run_condition ON public.run USING btree (condition)
index CREATE INDEX ix_run_day ON public.run USING btree (day)
index CREATE INDEX ix_run_file_file ON public.run_file USING btree (file)
index CREATE INDEX ix_run_file_run ON public.run_file USING btree (run)
index CREATE INDEX ix_run_name ON public.run USING btree (name)
index CREATE INDEX ix_run_robot ON public.run USING btree (robot)
index CREATE INDEX ix_run_study ON public.run USING btree (study)
index CREATE INDEX ix_signal_file ON public.signal USING btree (file)
index CREATE INDEX ix_signal_ingest ON public.signal USING btree (ingest)
index CREATE INDEX ix_signal_recorded_sha256 ON public.signal USING btree (recorded_sha256)
index CREATE INDEX ix_signal_sha256 ON public.signal USING btree (sha256)
index CREATE UNIQUE INDEX alembic_version_pkc ON public.alembic_version USING btree (version_num)
index CREATE UNIQUE INDEX pk_battery ON public.battery USING btree (id)
index CREATE UNIQUE INDEX pk_calibration ON public.calibration USING btree (id)
index CREATE UNIQUE INDEX pk_channel ON public.channel USING btree (signal, "position")
index CREATE UNIQUE INDEX pk_charge ON public.charge USING btree (id)
index CREATE UNIQUE INDEX pk_condition ON public.condition USING btree (id)
index CREATE UNIQUE INDEX pk_condition_level ON public.condition_level USING btree (condition, factor)
index CREATE UNIQUE INDEX pk_config ON public.config USING btree (id)
index CREATE UNIQUE INDEX pk_day ON public.day USING btree (id)
index CREATE UNIQUE INDEX pk_day_check ON public.day_check USING btree (id)
index CREATE UNIQUE INDEX pk_decision ON public.decision USING btree (id)
index CREATE UNIQUE INDEX pk_detection ON public.detection USING btree (id)
index CREATE UNIQUE INDEX pk_factor ON public.factor USING btree (id)
index CREATE UNIQUE INDEX pk_file ON public.file USING btree (id)
index CREATE UNIQUE INDEX pk_finding ON public.finding USING btree (id)
index CREATE UNIQUE INDEX pk_gap ON public.gap USING btree (id)
index CREATE UNIQUE INDEX pk_ingest ON public.ingest USING btree (id)
index CREATE UNIQUE INDEX pk_instrument ON public.instrument USING btree (id)
index CREATE UNIQUE INDEX pk_journal ON public.journal USING btree (id)
index CREATE UNIQUE INDEX pk_jump ON public.jump USING btree (id)
index CREATE UNIQUE INDEX pk_level ON public.level USING btree (id)
index CREATE UNIQUE INDEX pk_note ON public.note USING btree (id)
index CREATE UNIQUE INDEX pk_person ON public.person USING btree (id)
index CREATE UNIQUE INDEX pk_plan ON public.plan USING btree (id)
index CREATE UNIQUE INDEX pk_planned_run ON public.planned_run USING btree (id)
index CREATE UNIQUE INDEX pk_prediction ON public.prediction USING btree (id)
index CREATE UNIQUE INDEX pk_report ON public.report USING btree (id)
index CREATE UNIQUE INDEX pk_report_item ON public.report_item USING btree (report, number_uid)
index CREATE UNIQUE INDEX pk_result ON public.result USING btree (id)
index CREATE UNIQUE INDEX pk_result_input ON public.result_input USING btree (result, role, input_kind, input_uid)
index CREATE UNIQUE INDEX pk_result_number ON public.result_number USING btree (id)
index CREATE UNIQUE INDEX pk_robot ON public.robot USING btree (id)
index CREATE UNIQUE INDEX pk_row_hash ON public.row_hash USING btree (kind, uid)
index CREATE UNIQUE INDEX pk_run ON public.run USING btree (id)
index CREATE UNIQUE INDEX pk_run_file ON public.run_file USING btree (id)
index CREATE UNIQUE INDEX pk_signal ON public.signal USING btree (id)
index CREATE UNIQUE INDEX pk_study ON public.study USING btree (id)
index CREATE UNIQUE INDEX uq_battery_name ON public.battery USING btree (name)
index CREATE UNIQUE INDEX uq_battery_uid ON public.battery USING btree (uid)
index CREATE UNIQUE INDEX uq_calibration_instrument_quantity_valid_from_utc ON public.calibration USING btree (instrument, quantity, valid_from_utc)
index CREATE UNIQUE INDEX uq_calibration_uid ON public.calibration USING btree (uid)
index CREATE UNIQUE INDEX uq_channel_signal_name ON public.channel USING btree (signal, name)
index CREATE UNIQUE INDEX uq_charge_file_row_number ON public.charge USING btree (file, row_number)
index CREATE UNIQUE INDEX uq_charge_uid ON public.charge USING btree (uid)
index CREATE UNIQUE INDEX uq_condition_study_key ON public.condition USING btree (study, key)
index CREATE UNIQUE INDEX uq_condition_uid ON public.condition USING btree (uid)
index CREATE UNIQUE INDEX uq_config_uid ON public.config USING btree (uid)
index CREATE UNIQUE INDEX uq_day_check_uid ON public.day_check USING btree (uid)
index CREATE UNIQUE INDEX uq_day_study_date_local ON public.day USING btree (study, date_local)
index CREATE UNIQUE INDEX uq_day_uid ON public.day USING btree (uid)
index CREATE UNIQUE INDEX uq_decision_uid ON public.decision USING btree (uid)
index CREATE UNIQUE INDEX uq_detection_key ON public.detection USING btree (key)
index CREATE UNIQUE INDEX uq_detection_uid ON public.detection USING btree (uid)
index CREATE UNIQUE INDEX uq_factor_study_name ON public.factor USING btree (study, name)
index CREATE UNIQUE INDEX uq_factor_uid ON public.factor USING btree (uid)
index CREATE UNIQUE INDEX uq_file_sha256 ON public.file USING btree (sha256)
index CREATE UNIQUE INDEX uq_file_uid ON public.file USING btree (uid)
index CREATE UNIQUE INDEX uq_ingest_imported_sha256 ON public.ingest USING btree (sha256) WHERE (status = 'imported'::text)
index CREATE UNIQUE INDEX uq_ingest_uid ON public.ingest USING btree (uid)
index CREATE UNIQUE INDEX uq_instrument_name ON public.instrument USING btree (name)
index CREATE UNIQUE INDEX uq_instrument_uid ON public.instrument USING btree (uid)
index CREATE UNIQUE INDEX uq_journal_hash ON public.journal USING btree (hash)
index CREATE UNIQUE INDEX uq_journal_seq ON public.journal USING btree (seq)
index CREATE UNIQUE INDEX uq_jump_detection_number ON public.jump USING btree (detection, number)
index CREATE UNIQUE INDEX uq_jump_uid ON public.jump USING btree (uid)
index CREATE UNIQUE INDEX uq_level_factor_label ON public.level USING btree (factor, label)
index CREATE UNIQUE INDEX uq_level_uid ON public.level USING btree (uid)
index CREATE UNIQUE INDEX uq_note_uid ON public.note USING btree (uid)
index CREATE UNIQUE INDEX uq_person_name ON public.person USING btree (name)
index CREATE UNIQUE INDEX uq_person_uid ON public.person USING btree (uid)
index CREATE UNIQUE INDEX uq_plan_uid ON public.plan USING btree (uid)
index CREATE UNIQUE INDEX uq_planned_run_plan_position ON public.planned_run USING btree (plan, "position")
index CREATE UNIQUE INDEX uq_planned_run_uid ON public.planned_run USING btree (uid)
index CREATE UNIQUE INDEX uq_prediction_result ON public.prediction USING btree (result)
index CREATE UNIQUE INDEX uq_prediction_uid ON public.prediction USING btree (uid)
index CREATE UNIQUE INDEX uq_report_uid ON public.report USING btree (uid)
index CREATE UNIQUE INDEX uq_result_key ON public.result USING btree (key)
index CREATE UNIQUE INDEX uq_result_number_result_name ON public.result_number USING btree (result, name)
index CREATE UNIQUE INDEX uq_result_number_uid ON public.result_number USING btree (uid)
index CREATE UNIQUE INDEX uq_result_uid ON public.result USING btree (uid)
index CREATE UNIQUE INDEX uq_robot_name_valid_from_utc ON public.robot USING btree (name, valid_from_utc)
index CREATE UNIQUE INDEX uq_robot_uid ON public.robot USING btree (uid)
index CREATE UNIQUE INDEX uq_run_file_run_file_part ON public.run_file USING btree (run, file, part)
index CREATE UNIQUE INDEX uq_run_file_uid ON public.run_file USING btree (uid)
index CREATE UNIQUE INDEX uq_run_planned_run ON public.run USING btree (planned_run)
index CREATE UNIQUE INDEX uq_run_study_name ON public.run USING btree (study, name)
index CREATE UNIQUE INDEX uq_run_uid ON public.run USING btree (uid)
index CREATE UNIQUE INDEX uq_signal_ingest_part ON public.signal USING btree (ingest, part)
index CREATE UNIQUE INDEX uq_signal_uid ON public.signal USING btree (uid)
index CREATE UNIQUE INDEX uq_study_name ON public.study USING btree (name)
index CREATE UNIQUE INDEX uq_study_uid ON public.study USING btree (uid)
rule alembic_version.alembic_version_pkc PRIMARY KEY (version_num)
rule battery.ck_battery_capacity_positive CHECK ((capacity_mah > (0)::double precision))
rule battery.ck_battery_cells_counted CHECK ((cells >= 1))
rule battery.pk_battery PRIMARY KEY (id)
rule battery.uq_battery_name UNIQUE (name)
rule battery.uq_battery_uid UNIQUE (uid)
rule calibration.ck_calibration_valid_interval CHECK (((valid_to_utc IS NULL) OR (valid_to_utc > valid_from_utc)))
rule calibration.fk_calibration_file FOREIGN KEY (file) REFERENCES file(id) ON UPDATE RESTRICT ON DELETE RESTRICT
rule calibration.fk_calibration_instrument FOREIGN KEY (instrument) REFERENCES instrument(id) ON UPDATE RESTRICT ON DELETE RESTRICT
rule calibration.pk_calibration PRIMARY KEY (id)
rule calibration.uq_calibration_instrument_quantity_valid_from_utc UNIQUE (instrument, quantity, valid_from_utc)
rule calibration.uq_calibration_uid UNIQUE (uid)
rule channel.ck_channel_sign_known CHECK ((sign = ANY (ARRAY[('-1'::integer)::bigint, (1)::bigint])))
rule channel.fk_channel_instrument FOREIGN KEY (instrument) REFERENCES instrument(id) ON UPDATE RESTRICT ON DELETE RESTRICT
rule channel.fk_channel_signal FOREIGN KEY (signal) REFERENCES signal(id) ON UPDATE RESTRICT ON DELETE RESTRICT
rule channel.pk_channel PRIMARY KEY (signal, "position")
rule channel.uq_channel_signal_name UNIQUE (signal, name)
rule charge.ck_charge_added_flag CHECK ((added = ANY (ARRAY[(0)::bigint, (1)::bigint])))
rule charge.ck_charge_charge_counted CHECK ((charge_mah >= (0)::double precision))
rule charge.ck_charge_duration_positive CHECK (((duration_s IS NULL) OR (duration_s > (0)::double precision)))
rule charge.ck_charge_mode_known CHECK ((mode = ANY (ARRAY['charge'::text, 'discharge'::text])))
rule charge.ck_charge_resolution_positive CHECK ((resolution_mah > (0)::double precision))
rule charge.ck_charge_state_known CHECK ((state = ANY (ARRAY['counted'::text, 'known'::text, 'gone'::text, 'dismissed'::text])))
rule charge.fk_charge_battery FOREIGN KEY (battery) REFERENCES battery(id) ON UPDATE RESTRICT ON DELETE RESTRICT
rule charge.fk_charge_file FOREIGN KEY (file) REFERENCES file(id) ON UPDATE RESTRICT ON DELETE RESTRICT
rule charge.fk_charge_run FOREIGN KEY (run) REFERENCES run(id) ON UPDATE RESTRICT ON DELETE RESTRICT
rule charge.pk_charge PRIMARY KEY (id)
rule charge.uq_charge_file_row_number UNIQUE (file, row_number)
rule charge.uq_charge_uid UNIQUE (uid)
rule condition.ck_condition_is_control_flag CHECK ((is_control = ANY (ARRAY[(0)::bigint, (1)::bigint])))
rule condition.fk_condition_study FOREIGN KEY (study) REFERENCES study(id) ON UPDATE RESTRICT ON DELETE RESTRICT
rule condition.pk_condition PRIMARY KEY (id)
rule condition.uq_condition_study_key UNIQUE (study, key)
rule condition.uq_condition_uid UNIQUE (uid)
rule condition_level.fk_condition_level_condition FOREIGN KEY (condition) REFERENCES condition(id) ON UPDATE RESTRICT ON DELETE RESTRICT
rule condition_level.fk_condition_level_factor FOREIGN KEY (factor) REFERENCES factor(id) ON UPDATE RESTRICT ON DELETE RESTRICT
rule condition_level.fk_condition_level_level FOREIGN KEY (level) REFERENCES level(id) ON UPDATE RESTRICT ON DELETE RESTRICT
rule condition_level.pk_condition_level PRIMARY KEY (condition, factor)
rule config.pk_config PRIMARY KEY (id)
rule config.uq_config_uid UNIQUE (uid)
rule day.fk_day_study FOREIGN KEY (study) REFERENCES study(id) ON UPDATE RESTRICT ON DELETE RESTRICT
rule day.pk_day PRIMARY KEY (id)
rule day.uq_day_study_date_local UNIQUE (study, date_local)
rule day.uq_day_uid UNIQUE (uid)
rule day_check.ck_day_check_passed_flag CHECK ((passed = ANY (ARRAY[(0)::bigint, (1)::bigint])))
rule day_check.fk_day_check_day FOREIGN KEY (day) REFERENCES day(id) ON UPDATE RESTRICT ON DELETE RESTRICT
rule day_check.fk_day_check_person FOREIGN KEY (person) REFERENCES person(id) ON UPDATE RESTRICT ON DELETE RESTRICT
rule day_check.pk_day_check PRIMARY KEY (id)
rule day_check.uq_day_check_uid UNIQUE (uid)
rule decision.ck_decision_blind_flag CHECK ((blind = ANY (ARRAY[(0)::bigint, (1)::bigint])))
rule decision.ck_decision_jump_has_anchor CHECK (((target_kind <> 'jump'::text) OR ((signal_sha256 IS NOT NULL) AND (anchor_s IS NOT NULL))))
rule decision.ck_decision_reason_code_known CHECK ((reason_code = ANY (ARRAY['dropped_packet'::text, 'wrong_apex'::text, 'touched_by_hand'::text, 'misfire'::text, 'sensor_fault'::text, 'looks_right'::text, 'other'::text])))
rule decision.ck_decision_target_kind_known CHECK ((target_kind = ANY (ARRAY['jump'::text, 'run'::text, 'charge'::text, 'condition'::text, 'day'::text, 'file'::text])))
rule decision.ck_decision_verdict_known CHECK ((verdict = ANY (ARRAY['accept'::text, 'reject'::text, 'move'::text, 'clear'::text])))
rule decision.fk_decision_person FOREIGN KEY (person) REFERENCES person(id) ON UPDATE RESTRICT ON DELETE RESTRICT
rule decision.pk_decision PRIMARY KEY (id)
rule decision.uq_decision_uid UNIQUE (uid)
rule detection.ck_detection_n_jumps_counted CHECK ((n_jumps >= 0))
rule detection.fk_detection_signal FOREIGN KEY (signal) REFERENCES signal(id) ON UPDATE RESTRICT ON DELETE RESTRICT
rule detection.pk_detection PRIMARY KEY (id)
rule detection.uq_detection_key UNIQUE (key)
rule detection.uq_detection_uid UNIQUE (uid)
rule factor.ck_factor_kind_known CHECK ((kind = ANY (ARRAY['number'::text, 'label'::text])))
rule factor.fk_factor_study FOREIGN KEY (study) REFERENCES study(id) ON UPDATE RESTRICT ON DELETE RESTRICT
rule factor.pk_factor PRIMARY KEY (id)
rule factor.uq_factor_study_name UNIQUE (study, name)
rule factor.uq_factor_uid UNIQUE (uid)
rule file.ck_file_n_bytes_counted CHECK ((n_bytes >= 0))
rule file.ck_file_state_known CHECK ((state = ANY (ARRAY['kept'::text, 'quarantined'::text])))
rule file.pk_file PRIMARY KEY (id)
rule file.uq_file_sha256 UNIQUE (sha256)
rule file.uq_file_uid UNIQUE (uid)
rule finding.ck_finding_n_counted CHECK ((n >= 1))
rule finding.ck_finding_severity_known CHECK ((severity = ANY (ARRAY['note'::text, 'row'::text, 'file'::text])))
rule finding.fk_finding_ingest FOREIGN KEY (ingest) REFERENCES ingest(id) ON UPDATE RESTRICT ON DELETE RESTRICT
rule finding.pk_finding PRIMARY KEY (id)
rule gap.ck_gap_kind_known CHECK ((kind = ANY (ARRAY['dropped'::text, 'pause'::text, 'rejected'::text, 'held'::text])))
rule gap.ck_gap_length_positive CHECK ((length_s > (0)::double precision))
rule gap.fk_gap_signal FOREIGN KEY (signal) REFERENCES signal(id) ON UPDATE RESTRICT ON DELETE RESTRICT
rule gap.pk_gap PRIMARY KEY (id)
rule ingest.ck_ingest_imported_has_file CHECK (((status <> 'imported'::text) OR (file IS NOT NULL)))
rule ingest.ck_ingest_role_known CHECK (((role IS NULL) OR (role = ANY (ARRAY['log'::text, 'force'::text, 'charge'::text, 'video'::text, 'sheet'::text]))))
rule ingest.ck_ingest_status_known CHECK ((status = ANY (ARRAY['imported'::text, 'duplicate'::text, 'refused'::text, 'superseded'::text, 'withdrawn'::text, 'waiting'::text])))
rule ingest.fk_ingest_config FOREIGN KEY (config) REFERENCES config(id) ON UPDATE RESTRICT ON DELETE RESTRICT
rule ingest.fk_ingest_file FOREIGN KEY (file) REFERENCES file(id) ON UPDATE RESTRICT ON DELETE RESTRICT
rule ingest.fk_ingest_person FOREIGN KEY (person) REFERENCES person(id) ON UPDATE RESTRICT ON DELETE RESTRICT
rule ingest.pk_ingest PRIMARY KEY (id)
rule ingest.uq_ingest_uid UNIQUE (uid)
rule instrument.pk_instrument PRIMARY KEY (id)
rule instrument.uq_instrument_name UNIQUE (name)
rule instrument.uq_instrument_uid UNIQUE (uid)
rule journal.ck_journal_action_known CHECK ((action = ANY (ARRAY['declare'::text, 'correct'::text, 'void'::text, 'assign'::text, 'decide'::text, 'note'::text, 'ingest'::text, 'refuse'::text, 'report'::text, 'read'::text, 'withdraw'::text, 'restore'::text, 'dismiss'::text, 'merge'::text])))
rule journal.ck_journal_following_counted CHECK ((following >= 0))
rule journal.fk_journal_person FOREIGN KEY (person) REFERENCES person(id) ON UPDATE RESTRICT ON DELETE RESTRICT
rule journal.pk_journal PRIMARY KEY (id)
rule journal.uq_journal_hash UNIQUE (hash)
rule journal.uq_journal_seq UNIQUE (seq)
rule jump.ck_jump_gap_touched_flag CHECK ((gap_touched = ANY (ARRAY[(0)::bigint, (1)::bigint])))
rule jump.ck_jump_height_or_reason CHECK (((apex_height_m IS NULL) <> (undefined_reason IS NULL)))
rule jump.fk_jump_detection FOREIGN KEY (detection) REFERENCES detection(id) ON UPDATE RESTRICT ON DELETE RESTRICT
rule jump.pk_jump PRIMARY KEY (id)
rule jump.uq_jump_detection_number UNIQUE (detection, number)
rule jump.uq_jump_uid UNIQUE (uid)
rule level.fk_level_factor FOREIGN KEY (factor) REFERENCES factor(id) ON UPDATE RESTRICT ON DELETE RESTRICT
rule level.pk_level PRIMARY KEY (id)
rule level.uq_level_factor_label UNIQUE (factor, label)
rule level.uq_level_uid UNIQUE (uid)
rule note.ck_note_target_kind_known CHECK ((target_kind = ANY (ARRAY['jump'::text, 'run'::text, 'charge'::text, 'condition'::text, 'day'::text, 'file'::text])))
rule note.fk_note_file FOREIGN KEY (file) REFERENCES file(id) ON UPDATE RESTRICT ON DELETE RESTRICT
rule note.fk_note_person FOREIGN KEY (person) REFERENCES person(id) ON UPDATE RESTRICT ON DELETE RESTRICT
rule note.pk_note PRIMARY KEY (id)
rule note.uq_note_uid UNIQUE (uid)
rule person.pk_person PRIMARY KEY (id)
rule person.uq_person_name UNIQUE (name)
rule person.uq_person_uid UNIQUE (uid)
rule plan.ck_plan_method_known CHECK ((method = ANY (ARRAY['randomised'::text, 'blocked'::text])))
rule plan.fk_plan_study FOREIGN KEY (study) REFERENCES study(id) ON UPDATE RESTRICT ON DELETE RESTRICT
rule plan.pk_plan PRIMARY KEY (id)
rule plan.uq_plan_uid UNIQUE (uid)
rule planned_run.fk_planned_run_condition FOREIGN KEY (condition) REFERENCES condition(id) ON UPDATE RESTRICT ON DELETE RESTRICT
rule planned_run.fk_planned_run_plan FOREIGN KEY (plan) REFERENCES plan(id) ON UPDATE RESTRICT ON DELETE RESTRICT
rule planned_run.pk_planned_run PRIMARY KEY (id)
rule planned_run.uq_planned_run_plan_position UNIQUE (plan, "position")
rule planned_run.uq_planned_run_uid UNIQUE (uid)
rule prediction.fk_prediction_condition FOREIGN KEY (condition) REFERENCES condition(id) ON UPDATE RESTRICT ON DELETE RESTRICT
rule prediction.fk_prediction_result FOREIGN KEY (result) REFERENCES result(id) ON UPDATE RESTRICT ON DELETE RESTRICT
rule prediction.pk_prediction PRIMARY KEY (id)
rule prediction.uq_prediction_result UNIQUE (result)
rule prediction.uq_prediction_uid UNIQUE (uid)
rule report.fk_report_config FOREIGN KEY (config) REFERENCES config(id) ON UPDATE RESTRICT ON DELETE RESTRICT
rule report.pk_report PRIMARY KEY (id)
rule report.uq_report_uid UNIQUE (uid)
rule report_item.fk_report_item_report FOREIGN KEY (report) REFERENCES report(id) ON UPDATE RESTRICT ON DELETE RESTRICT
rule report_item.fk_report_item_result_number FOREIGN KEY (result_number) REFERENCES result_number(id) ON UPDATE RESTRICT ON DELETE RESTRICT
rule report_item.pk_report_item PRIMARY KEY (report, number_uid)
rule result.ck_result_stale_flag CHECK ((stale = ANY (ARRAY[(0)::bigint, (1)::bigint])))
rule result.fk_result_config FOREIGN KEY (config) REFERENCES config(id) ON UPDATE RESTRICT ON DELETE RESTRICT
rule result.pk_result PRIMARY KEY (id)
rule result.uq_result_key UNIQUE (key)
rule result.uq_result_uid UNIQUE (uid)
rule result_input.fk_result_input_result FOREIGN KEY (result) REFERENCES result(id) ON UPDATE RESTRICT ON DELETE RESTRICT
rule result_input.pk_result_input PRIMARY KEY (result, role, input_kind, input_uid)
rule result_number.ck_result_number_value_or_reason CHECK (((value IS NULL) <> (undefined_reason IS NULL)))
rule result_number.fk_result_number_result FOREIGN KEY (result) REFERENCES result(id) ON UPDATE RESTRICT ON DELETE RESTRICT
rule result_number.pk_result_number PRIMARY KEY (id)
rule result_number.uq_result_number_result_name UNIQUE (result, name)
rule result_number.uq_result_number_uid UNIQUE (uid)
rule robot.ck_robot_body_mass_positive CHECK ((body_mass_kg > (0)::double precision))
rule robot.ck_robot_foot_mass_positive CHECK ((foot_mass_kg > (0)::double precision))
rule robot.ck_robot_leg_range CHECK ((leg_min_m < leg_max_m))
rule robot.pk_robot PRIMARY KEY (id)
rule robot.uq_robot_name_valid_from_utc UNIQUE (name, valid_from_utc)
rule robot.uq_robot_uid UNIQUE (uid)
rule row_hash.pk_row_hash PRIMARY KEY (kind, uid)
rule run.ck_run_duration_positive CHECK (((duration_s IS NULL) OR (duration_s > (0)::double precision)))
rule run.ck_run_jumps_counted CHECK ((jumps_made >= 0))
rule run.ck_run_kind_known CHECK ((kind = ANY (ARRAY['jumps'::text, 'idle'::text, 'characterisation'::text, 'field'::text])))
rule run.ck_run_position_counted CHECK ((position_in_day >= 1))
rule run.ck_run_starts_counted CHECK ((starts >= 1))
rule run.ck_run_state_known CHECK ((state = ANY (ARRAY['open'::text, 'complete'::text, 'void'::text])))
rule run.fk_run_battery FOREIGN KEY (battery) REFERENCES battery(id) ON UPDATE RESTRICT ON DELETE RESTRICT
rule run.fk_run_condition FOREIGN KEY (condition) REFERENCES condition(id) ON UPDATE RESTRICT ON DELETE RESTRICT
rule run.fk_run_day FOREIGN KEY (day) REFERENCES day(id) ON UPDATE RESTRICT ON DELETE RESTRICT
rule run.fk_run_planned_run FOREIGN KEY (planned_run) REFERENCES planned_run(id) ON UPDATE RESTRICT ON DELETE RESTRICT
rule run.fk_run_robot FOREIGN KEY (robot) REFERENCES robot(id) ON UPDATE RESTRICT ON DELETE RESTRICT
rule run.fk_run_study FOREIGN KEY (study) REFERENCES study(id) ON UPDATE RESTRICT ON DELETE RESTRICT
rule run.pk_run PRIMARY KEY (id)
rule run.uq_run_planned_run UNIQUE (planned_run)
rule run.uq_run_study_name UNIQUE (study, name)
rule run.uq_run_uid UNIQUE (uid)
rule run_file.ck_run_file_role_known CHECK ((role = ANY (ARRAY['log'::text, 'force'::text, 'charge'::text, 'video'::text, 'sheet'::text])))
rule run_file.fk_run_file_file FOREIGN KEY (file) REFERENCES file(id) ON UPDATE RESTRICT ON DELETE RESTRICT
rule run_file.fk_run_file_run FOREIGN KEY (run) REFERENCES run(id) ON UPDATE RESTRICT ON DELETE RESTRICT
rule run_file.pk_run_file PRIMARY KEY (id)
rule run_file.uq_run_file_run_file_part UNIQUE (run, file, part)
rule run_file.uq_run_file_uid UNIQUE (uid)
rule signal.ck_signal_n_samples_counted CHECK ((n_samples >= 0))
rule signal.fk_signal_file FOREIGN KEY (file) REFERENCES file(id) ON UPDATE RESTRICT ON DELETE RESTRICT
rule signal.fk_signal_ingest FOREIGN KEY (ingest) REFERENCES ingest(id) ON UPDATE RESTRICT ON DELETE RESTRICT
rule signal.pk_signal PRIMARY KEY (id)
rule signal.uq_signal_ingest_part UNIQUE (ingest, part)
rule signal.uq_signal_uid UNIQUE (uid)
rule study.ck_study_jumps_nominal_positive CHECK ((jumps_nominal > 0))
rule study.ck_study_kind_known CHECK ((kind = ANY (ARRAY['bed'::text, 'emulator'::text, 'force_plate'::text, 'field'::text])))
rule study.ck_study_reference_voltage_positive CHECK ((reference_voltage_v > (0)::double precision))
rule study.pk_study PRIMARY KEY (id)
rule study.uq_study_name UNIQUE (name)
rule study.uq_study_uid UNIQUE (uid)
