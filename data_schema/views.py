"""The views of a book's database that people query themselves: words and units as in reports, one row a thing in use.

The tables behind them are labbook's own, and may be others in the next version; docs/schema.md is made from here.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum

from data_schema.columns import Column, ValueKind
from data_schema.vocabulary import ChargeMode, FileRole, RunKind, RunState, Severity


@dataclass(frozen=True, slots=True)
class View:
    """A view: of what a row is, the query behind it, and what each of its columns means."""

    row: str
    query: str
    columns: Mapping[str, Column]


def words(known: type[StrEnum]) -> str:
    """List the words of a closed list."""
    return ", ".join(known)


NUMBER, COUNT, FLAG, DATE, TIME = (
    ValueKind.NUMBER,
    ValueKind.COUNT,
    ValueKind.FLAG,
    ValueKind.DATE,
    ValueKind.TIME,
)
SHEET, TOML, PLAN, JOURNAL = "run sheet", "labbook.toml", "plan", "journal"
CHARGER, FILE, DETECTOR = "charger's sheet, or typed in", "instrument's file", "found in the log by the detector"
PERSON, CHECK = "stated by a person", "found when the file was read"
VERDICTS = "accept, reject, move, add"

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
            "run": Column("its name", source=SHEET),
            "kind": Column("what it was made for", allowed=words(RunKind), source=SHEET),
            "state": Column("how far it is; no result uses a void one", allowed=words(RunState), source=SHEET),
            "day": Column("local date in the study's time zone", DATE, source=SHEET),
            "position": Column("its place in the day, from 1", COUNT, source=SHEET),
            "condition": Column("its levels, as `foot=small k_gain=400`", missing="an idle run", source=SHEET),
            "is_control": Column("whether the condition is a control", FLAG, missing="an idle run", source=TOML),
            "robot": Column("the robot's name", source=SHEET),
            "pack": Column("the battery pack's name", source=SHEET),
            "started_utc": Column("when it began", TIME, missing="nobody wrote it down", source=SHEET),
            "duration_s": Column("how long it lasted", NUMBER, "s", "nobody wrote it down", source=SHEET),
            "jumps_made": Column("jumps that the person counted", COUNT, source=SHEET),
            "starts": Column("how often the run was started", COUNT, source=SHEET),
            "planned_as": Column("the planned run that it carries out", missing="it was not planned", source=PLAN),
            "uid": Column("what the journal calls it", source=JOURNAL),
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
            "run": Column("the run's name", source=SHEET),
            "factor": Column("the factor's name in labbook.toml", source=TOML),
            "level": Column("the level as it is written there", source=TOML),
            "value": Column("the same as a number", NUMBER, missing="the factor is a label", source=TOML),
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
            "run": Column("the run's name", source=CHARGER),
            "charge_mah": Column("the charge", NUMBER, "mAh", source=CHARGER),
            "resolution_mah": Column("the step of the charger's display", NUMBER, "mAh", source=CHARGER),
            "mode": Column("joules come from charges", allowed=words(ChargeMode), source=CHARGER),
            "charging_s": Column("how long it took", NUMBER, "s", "the sheet does not say", source=CHARGER),
            "end_voltage_v": Column(
                "the pack's voltage at the end", NUMBER, "V", "the sheet does not say", source=CHARGER
            ),
            "ended_utc": Column("when it ended", TIME, missing="the sheet does not say", source=CHARGER),
            "stated_pack": Column("the pack that the sheet names", missing="it names none", source=CHARGER),
            "added": Column("whether a person added it to another charge of the run", FLAG, source=JOURNAL),
            "file": Column("the sheet's name", missing="it was typed in", source=FILE),
            "row": Column("its row in the sheet, from 1", COUNT, source=CHARGER),
            "uid": Column("what the journal calls it", source=JOURNAL),
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
            "run": Column("the run's name", source=JOURNAL),
            "role": Column("what it is of the run", allowed="log or force", source=FILE),
            "file": Column("the file's name", source=FILE),
            "part": Column("which table of the file", source=FILE),
            "start_utc": Column("the instant of its first sample", TIME, missing="the file does not say", source=FILE),
            "rate_hz": Column("its rate", NUMBER, "Hz", "it has none", source=FILE),
            "n_samples": Column("how many samples", COUNT, source=FILE),
            "samples": Column(
                "the Parquet file with its channels, below the folder of the book (or of `[store]`)", source=FILE
            ),
            "uid": Column("what the journal calls it", source=JOURNAL),
            "file_sha256": Column("the SHA-256 of the file's bytes", source=FILE),
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
            "run": Column("the run's name", source=JOURNAL),
            "signal": Column("the uid of its signal in v_signal", source=JOURNAL),
            "jump": Column("its number in the log, from 1", COUNT, source=DETECTOR),
            "touchdown_s": Column(
                "when the stance before it began, from the log's first sample", NUMBER, "s", "not seen", source=DETECTOR
            ),
            "lift_off_s": Column("when it left the ground", NUMBER, "s", "not seen", source=DETECTOR),
            "apex_s": Column("when it was highest", NUMBER, "s", "there is no apex", source=DETECTOR),
            "apex_height_m": Column("how high", NUMBER, "m", "there is no apex", source=DETECTOR),
            "apex_height_se_m": Column("the standard error of that", NUMBER, "m", "there is no apex", source=DETECTOR),
            "flight_time_s": Column("how long it flew", NUMBER, "s", "not seen", source=DETECTOR),
            "why_no_apex": Column("why there is no apex", missing="there is one", source=DETECTOR),
            "gap_touched": Column("whether samples are missing in the flight", FLAG, source=DETECTOR),
            "flags": Column("the detector's doubts, a JSON list", source=DETECTOR),
            "verdict": Column(
                "the last one said, on the same flight", missing="none stands", allowed=VERDICTS, source=PERSON
            ),
            "reason": Column("the reason given with it", missing="no verdict stands", source=PERSON),
            "detector": Column("which detector", source=DETECTOR),
            "detector_version": Column("and its version", COUNT, source=DETECTOR),
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
            "run": Column("the run's name", source=JOURNAL),
            "anchor_s": Column(
                "the apex or touchdown of the jump that was judged, from the log's first sample",
                NUMBER,
                "s",
                source=PERSON,
            ),
            "verdict": Column("what was said", allowed=f"{VERDICTS}, clear", source=PERSON),
            "reason": Column("why", source=PERSON),
            "note": Column("what was written beside it", missing="nothing was", source=PERSON),
            "placed_s": Column("where a person put the apex", NUMBER, "s", "nobody moved it", source=PERSON),
            "blind": Column("whether the run and its condition were not shown", FLAG, source=PERSON),
            "person": Column("who", source=PERSON),
            "at_utc": Column("when", TIME, source=JOURNAL),
        },
    ),
    "v_finding": View(
        "what a check found in a file as it was read last",
        """
SELECT (
        SELECT CASE WHEN count(DISTINCT run.id) = 1 THEN min(run.name) END
        FROM run_file JOIN run ON run.id = run_file.run WHERE run_file.file = ingest.file
    ) AS run, ingest.original_name AS file, ingest.role, finding.severity, finding.rule, finding.message,
    finding.line, finding.column_name AS file_column, finding.value, finding.n
FROM finding
JOIN ingest ON ingest.id = finding.ingest AND ingest.status IN ('imported', 'waiting')
""",
        {
            "run": Column("the run that the file belongs to", missing="none, or several", source=JOURNAL),
            "file": Column("the file's name", source=FILE),
            "role": Column("what the file is", allowed=words(FileRole), source=FILE),
            "severity": Column("what it made of the file", allowed=words(Severity), source=CHECK),
            "rule": Column("which check", source=CHECK),
            "message": Column("what was found, in words", source=CHECK),
            "line": Column(
                "the first line of the file concerned", COUNT, missing="no line in particular", source=CHECK
            ),
            "file_column": Column("the column of the file concerned", missing="no column in particular", source=CHECK),
            "value": Column("the value found there", missing="no value in particular", source=CHECK),
            "n": Column("how often it was found", COUNT, source=CHECK),
        },
    ),
    "v_note": View(
        "a note that a person wrote",
        """
SELECT run.name AS run, note.target_kind AS about, note.text, person.name AS person, note.at_utc
FROM note
JOIN person ON person.id = note.person
LEFT JOIN run ON note.target_kind = 'run' AND run.uid = note.target_uid
""",
        {
            "run": Column("the run that it is about", missing="it is about something else", source=JOURNAL),
            "about": Column("what it is about", source=JOURNAL),
            "text": Column("what was written", source=PERSON),
            "person": Column("who", source=PERSON),
            "at_utc": Column("when", TIME, source=JOURNAL),
        },
    ),
}
"""The views by name, in the order in which they are described."""


def create_statements() -> list[str]:
    """Return what makes the views, on either engine."""
    return [f"CREATE VIEW {name} AS {view.query.strip()}" for name, view in VIEWS.items()]
