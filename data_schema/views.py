"""The views of a book's database that people query themselves: words and units as in reports, one row a thing in use.

The tables behind them are labbook's own, and may be others in the next version; docs/schema.md is made from here.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class View:
    """A view: of what a row is, the query behind it, and what each of its columns means, with the unit."""

    row: str
    query: str
    columns: Mapping[str, str]


_ANCHOR = "coalesce({0}.apex_s, {0}.touchdown_s, {0}.liftoff_s, 0)"
_IS_NEAR = f"abs(decision.anchor_s - {_ANCHOR}) <= coalesce({{0}}.flight_time_s, 0.25) / 2"
"""As `labbook.analysis.outcomes.run_apexes` judges jumps: a verdict is on the jump at whose apex or touchdown it was
given, else on the only one about it."""
_VERDICT = f"""
    SELECT max(decision.id) FROM decision
    WHERE decision.target_kind = 'jump' AND decision.signal_sha256 IN (signal.sha256, signal.recorded_sha256)
        AND (decision.anchor_s = {_ANCHOR.format("jump")} OR ({_IS_NEAR.format("jump")} AND NOT EXISTS (
            SELECT 1 FROM jump AS other WHERE other.detection = jump.detection AND other.id <> jump.id
                AND {_IS_NEAR.format("other")}
        )))
"""  # noqa: S608 - nothing of it is given by anybody

VIEWS: Mapping[str, View] = {
    "v_run": View(
        "a run, void ones too",
        """
SELECT run.name AS run, run.kind, run.state, day.date_local AS day, run.position_in_day AS position,
    condition.key AS condition, condition.is_control, robot.name AS robot, battery.name AS pack,
    run.started_utc, run.duration_s, run.jumps_made, run.starts, planned_run.name AS planned_as, run.uid
FROM run
JOIN day ON day.id = run.day
JOIN robot ON robot.id = run.robot
JOIN battery ON battery.id = run.battery
LEFT JOIN condition ON condition.id = run.condition
LEFT JOIN planned_run ON planned_run.id = run.planned_run
""",
        {
            "run": "its name",
            "kind": "jumps, idle, characterisation or field",
            "state": "open, complete or void; no result uses a void one",
            "day": "local date in the study's time zone",
            "position": "its place in the day, from 1",
            "condition": "its levels, as `foot=small k_gain=400`; NULL of an idle run",
            "is_control": "1 where the condition is a control",
            "robot": "the robot's name",
            "pack": "the battery pack's name",
            "started_utc": "when it began, ISO 8601; NULL where nobody wrote it down",
            "duration_s": "how long it lasted, s",
            "jumps_made": "jumps that the person counted",
            "starts": "how often the run was started",
            "planned_as": "the name of the planned run that it carries out",
            "uid": "what the journal calls it",
        },
    ),
    "v_level": View(
        "a level of one factor that a run was made with",
        """
SELECT run.name AS run, factor.name AS factor, level.label AS level, level.value
FROM run
JOIN condition_level ON condition_level.condition = run.condition
JOIN factor ON factor.id = condition_level.factor
JOIN level ON level.id = condition_level.level
""",
        {
            "run": "the run's name",
            "factor": "the factor's name in labbook.toml",
            "level": "the level as it is written there",
            "value": "the same as a number; NULL where the factor is a label",
        },
    ),
    "v_charge": View(
        "a charge that counts for a run",
        """
SELECT run.name AS run, charge.charge_mah, charge.resolution_mah, charge.mode, charge.duration_s AS charging_s,
    charge.end_voltage_v, charge.ended_utc, charge.stated_pack, charge.added,
    ingest.original_name AS file, charge.row_number AS row, charge.uid
FROM charge
JOIN run ON run.id = charge.run
LEFT JOIN file ON file.id = charge.file
LEFT JOIN ingest ON ingest.file = file.id AND ingest.status IN ('imported', 'waiting')
WHERE charge.state = 'counted'
""",
        {
            "run": "the run's name",
            "charge_mah": "the charge, mAh",
            "resolution_mah": "the step of the charger's display, mAh",
            "mode": "charge or discharge; joules come from charges",
            "charging_s": "how long it took, s",
            "end_voltage_v": "the pack's voltage at the end, V",
            "ended_utc": "when it ended, ISO 8601",
            "stated_pack": "the pack that the sheet names",
            "added": "1 where a person added it to another charge of the run",
            "file": "the sheet's name; NULL of one that was typed in",
            "row": "its row in the sheet, from 1",
            "uid": "what the journal calls it",
        },
    ),
    "v_signal": View(
        "a table of samples of a file in use that belongs to a run",
        """
SELECT run.name AS run, run_file.role, ingest.original_name AS file, signal.part, signal.start_utc, signal.rate_hz,
    signal.n_samples, signal.store_path AS samples, signal.uid, file.sha256 AS file_sha256
FROM signal
JOIN ingest ON ingest.id = signal.ingest AND ingest.status = 'imported'
JOIN file ON file.id = signal.file
JOIN run_file ON run_file.file = signal.file AND run_file.part = signal.part
JOIN run ON run.id = run_file.run
""",
        {
            "run": "the run's name",
            "role": "log or force",
            "file": "the file's name",
            "part": "which table of the file",
            "start_utc": "the instant of its first sample, ISO 8601; NULL where the file has none",
            "rate_hz": "its rate, Hz; NULL where it has none",
            "n_samples": "how many samples",
            "samples": "the Parquet file with its channels, below the folder of the book (or of `[store]`)",
            "uid": "what the journal calls it",
            "file_sha256": "the SHA-256 of the file's bytes",
        },
    ),
    "v_jump": View(
        "a stance and the jump out of it, found in a log in use as it was ingested, with the verdict on it, "
        "whether or not it counts",
        f"""
SELECT run.name AS run, signal.uid AS signal, jump.number AS jump, jump.touchdown_s, jump.liftoff_s AS lift_off_s,
    jump.apex_s, jump.apex_height_m, jump.apex_height_se_m, jump.flight_time_s, jump.undefined_reason AS why_no_apex,
    jump.gap_touched, jump.flags_json AS flags,
    CASE said.verdict WHEN 'clear' THEN NULL ELSE said.verdict END AS verdict,
    CASE said.verdict WHEN 'clear' THEN NULL ELSE said.reason_code END AS reason,
    detection.algorithm AS detector, detection.version AS detector_version
FROM jump
JOIN detection ON detection.id = jump.detection
JOIN signal ON signal.id = detection.signal
JOIN ingest ON ingest.id = signal.ingest AND ingest.status = 'imported'
JOIN run_file ON run_file.file = signal.file AND run_file.part = signal.part AND run_file.role = 'log'
JOIN run ON run.id = run_file.run
LEFT JOIN decision AS said ON said.id = ({_VERDICT})
""",  # noqa: S608 - nothing of it is given by anybody
        {
            "run": "the run's name",
            "signal": "the uid of its signal in v_signal",
            "jump": "its number in the log, from 1",
            "touchdown_s": "when the stance before it began, s from the log's first sample",
            "lift_off_s": "when it left the ground, s",
            "apex_s": "when it was highest, s",
            "apex_height_m": "how high, m; NULL where there is no apex",
            "apex_height_se_m": "the standard error of that, m",
            "flight_time_s": "how long it flew, s",
            "why_no_apex": "why there is no apex; NULL where there is one",
            "gap_touched": "1 where samples are missing in the flight",
            "flags": "the detector's doubts, a JSON list",
            "verdict": "accept, reject, move or add: the last one said, on the same flight; NULL where none stands",
            "reason": "the reason given with it",
            "detector": "which detector",
            "detector_version": "and its version",
        },
    ),
    "v_verdict": View(
        "a verdict on a jump, also one that another took back later",
        """
SELECT run.name AS run, decision.anchor_s, decision.verdict, decision.reason_code AS reason,
    decision.note, decision.at_s AS placed_s, decision.blind, person.name AS person, decision.at_utc
FROM decision
JOIN run ON run.uid = decision.target_uid
JOIN person ON person.id = decision.person
WHERE decision.target_kind = 'jump'
""",
        {
            "run": "the run's name",
            "anchor_s": "the apex or touchdown of the jump that was judged, s from the log's first sample",
            "verdict": "accept, reject, move, add or clear",
            "reason": "why",
            "note": "what was written beside it",
            "placed_s": "where a person put the apex, s",
            "blind": "1 where the run and its condition were not shown",
            "person": "who",
            "at_utc": "when, ISO 8601",
        },
    ),
}
"""The views by name, in the order in which they are described."""


def create_statements() -> list[str]:
    """Return what makes the views, on either engine."""
    return [f"CREATE VIEW {name} AS {view.query.strip()}" for name, view in VIEWS.items()]
