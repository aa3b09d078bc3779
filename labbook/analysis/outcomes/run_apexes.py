"""Apex heights of each run: the jumps that count, by a person's word and the protocol.

A verdict is tied to a signal and a time, not to a row, so it outlives the detector it was given under. It is matched
to the jump whose apex lies within half a flight time of its anchor, whichever detector found it. If the detector has a
new version that moves the apex by more than three standard errors, or no jump or several match, the verdict waits for
a person again, until a later verdict about the same moment settles it.

A person also puts the apex of a jump at another time, or adds a jump that no detector found. What is measured there is
found in the samples each time; whether it counts is decided as for other jumps. One that is found after all where it
was added is the same jump.
"""

from __future__ import annotations

import hashlib
import math
import re
import shlex
from collections import Counter
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType

from data_schema.grouping import grouped
from data_schema.queries.detections import DecisionRow, DetectionRow, JumpRow, jump_decisions
from data_schema.queries.runs import RunRow
from data_schema.queries.signals import CalibratedChannel, SignalRow
from data_schema.queries.sources import InputRow
from data_schema.reasons import Reason
from data_schema.vocabulary import ReasonCode, Undefined, Verdict
from labbook.analysis.outcomes.detection import (
    BODY_HEIGHT,
    Detections,
    PlacedApexes,
    jumps_found,
    rest_length_m,
    version,
)
from labbook.analysis.results import (
    Algorithm,
    Results,
    RunResults,
    decision_input,
    fingerprint,
    run_input,
    signal_input,
)
from labbook.analysis.study_data import StudyData
from labbook.config.model import ProtocolSettings
from reports.numbers import Number, Result
from stats.apexes.jumps import ZERO_DOUBTFUL
from stats.compare.shared_error import SharedError
from stats.compare.summary import describe

UNKNOWN_FLIGHT_S = 0.25
"""Flight time assumed for matching where a jump has none: that of a 7.7 cm hop."""
MOVED_STANDARD_ERRORS = 3.0


@dataclass(frozen=True, slots=True)
class JudgedJump:
    """A jump, numbered through the run, the signal it was found in, and why it does not count (None where it does).

    `decision` is the verdict that stands, `verdicts` are the last ones of each person, in the order they were given.
    `placed` is the one by which a person put the apex where it is, `as_found` the jump without that.
    """

    jump: JumpRow
    signal_sha256: str
    excluded: str | None
    decision: DecisionRow | None
    verdicts: tuple[DecisionRow, ...] = ()
    placed: DecisionRow | None = None
    as_found: JumpRow | None = None

    @property
    def before(self) -> JumpRow:
        """The jump that verdicts are tied to: as the detector found it or, of an added one, as it was added."""
        return self.jump if self.as_found is None else self.as_found

    @property
    def rejected(self) -> bool:
        """Whether a person's rejection of it stands."""
        return self.decision is not None and self.decision.verdict is Verdict.REJECT


@dataclass(frozen=True, slots=True)
class Judgement:
    """All jumps of a run, and the verdicts that fit none of them any more."""

    jumps: tuple[JudgedJump, ...]
    waiting: tuple[DecisionRow, ...]

    @property
    def counted(self) -> tuple[JumpRow, ...]:
        """The jumps that count."""
        return tuple(item.jump for item in self.jumps if item.excluded is None)

    @property
    def zero_doubtful(self) -> bool:
        """Whether the body stands higher than its leg is long, so that heights may be too high."""
        return any(ZERO_DOUBTFUL in item.jump.flags for item in self.jumps)

    @property
    def in_force(self) -> tuple[DecisionRow, ...]:
        """The verdicts that stand: taken back or overruled ones say nothing any more."""
        of_jumps = (said for item in self.jumps for said in (item.decision, item.placed) if said is not None)
        return tuple(dict.fromkeys((*of_jumps, *self.waiting)))


@dataclass(frozen=True, slots=True)
class Reviewed:
    """Jumps of a run, by their numbers, on which the same verdict of the same person stands."""

    verdict: Verdict
    reason_code: ReasonCode
    person: str
    blind: bool
    jumps: tuple[int, ...]


def reviewed(jumps: Sequence[JudgedJump]) -> tuple[Reviewed, ...]:
    """Return the jumps of a run that a person reviewed, those with the same verdict together."""
    said = [(item.decision, item.jump.number) for item in jumps if item.decision is not None]
    verdicts = [(one.verdict, one.reason_code, one.person, one.blind) for one, _number in said]
    numbers = grouped([number for _decision, number in said], verdicts)
    return tuple(Reviewed(*same, tuple(of)) for same, of in numbers.items())


def to_review(jumps: Sequence[JudgedJump]) -> list[JudgedJump]:
    """Return what a person looks at: all but the last landing of a log, of which no jump came, unless it was judged."""
    last = {item.signal_sha256: item for item in jumps}
    return [
        item
        for item in jumps
        if item.decision is not None or item.jump.apex_height_m is not None or item is not last[item.signal_sha256]
    ]


def not_reviewed(jumps: Sequence[JudgedJump]) -> tuple[int, ...]:
    """Return the numbers of the jumps to review that have no verdict."""
    return tuple(item.jump.number for item in to_review(jumps) if item.decision is None)


@dataclass(frozen=True, slots=True)
class Rules:
    """What the protocol excludes without asking."""

    exclude_first_jumps: int
    exclude_gap_jumps: bool


@dataclass(frozen=True, slots=True)
class ApexVariant:
    """How jumps are found and judged: as the protocol says, or otherwise to see what depends on it."""

    detector: str
    rules: Rules
    heed_decisions: bool = True


def judge(
    detections: Sequence[DetectionRow],
    decisions: Mapping[str, Sequence[DecisionRow]],
    rules: Rules,
    placed: PlacedApexes = MappingProxyType({}),
) -> Judgement:
    """Decide for every jump of a run whether it counts: a person's word first, then the protocol.

    `detections` are those of the run's logs one after the other; `decisions` are by signal; `placed` has what is found
    at each time at which these put an apex.
    """
    parts: list[Judgement] = []
    for detection in detections:
        first = 1 + sum(len(part.jumps) for part in parts)
        said = decisions.get(detection.signal_sha256, [])
        parts.append(_judge_log(detection, said, rules, placed, first))
    return Judgement(
        tuple(jump for part in parts for jump in part.jumps), tuple(item for part in parts for item in part.waiting)
    )


@dataclass(frozen=True, slots=True)
class JudgedRun:
    """What was found in the logs of a run, in their order, and what counts of it."""

    detections: tuple[DetectionRow, ...]
    judgement: Judgement


def judge_runs(
    detections: Detections,
    runs: Iterable[RunRow],
    logs: Mapping[str, Sequence[SignalRow]],
    decisions: Mapping[str, Sequence[DecisionRow]],
    variant: ApexVariant,
) -> dict[str, JudgedRun]:
    """Find and judge the jumps of each run that `logs` has signals of, in their order, by the run's uid."""
    by_robot: dict[str, dict[str, Sequence[SignalRow]]] = {}
    for run in runs:
        if run.uid in logs:
            by_robot.setdefault(run.robot_uid, {})[run.uid] = logs[run.uid]
    heeded = decisions if variant.heed_decisions else {}
    found: dict[str, JudgedRun] = {}
    for robot, of_robot in by_robot.items():
        length_m = rest_length_m(detections.connection, robot)
        detected = detections.of(of_robot, variant.detector, length_m)
        placed = detections.placed((log for several in of_robot.values() for log in several), heeded, length_m)
        found |= {
            uid: JudgedRun(several, judge(several, heeded, variant.rules, placed)) for uid, several in detected.items()
        }
    return {uid: found[uid] for uid in logs if uid in found}  # in the order of the logs, whatever the robots


def _judge_log(
    detection: DetectionRow, decisions: Sequence[DecisionRow], rules: Rules, placed: PlacedApexes, first: int
) -> Judgement:
    """Judge the jumps of one log, the first of which has the number `first`."""
    jumps = {jump.uid: jump for jump in detection.jumps}
    detected = frozenset(jumps)
    verdicts: dict[str, DecisionRow] = {}
    places: dict[str, DecisionRow] = {}
    by_person: dict[str, dict[str, DecisionRow]] = {}
    waiting: dict[float, DecisionRow] = {}
    for decision in decisions:
        near = jumps_near(decision.anchor_s, jumps.values())
        if decision.verdict is Verdict.ADD and not near:
            jump: JumpRow | None = placed[detection.signal_sha256, _time_of(decision)]
        else:
            jump = match(near, detection, decision)
        half_flight_s = UNKNOWN_FLIGHT_S / 2.0 if jump is None else _half_flight(jump)
        for anchor_s in [at_s for at_s in waiting if abs(at_s - decision.anchor_s) <= half_flight_s]:
            del waiting[anchor_s]
        if jump is None:
            waiting[decision.anchor_s] = decision
            continue
        own = by_person.setdefault(jump.uid, {})
        own.pop(decision.person, None)
        if decision.verdict is Verdict.CLEAR:
            verdicts.pop(jump.uid, None)
            places.pop(jump.uid, None)
            if jump.uid not in detected:
                del jumps[jump.uid], by_person[jump.uid]
            continue
        jumps[jump.uid] = jump
        verdicts[jump.uid] = own[decision.person] = decision
        if decision.at_s is not None:
            places[jump.uid] = decision
    judged = []
    for number, found in enumerate(_in_time([*detection.jumps], jumps.values(), detected), start=first):
        place, verdict = places.get(found.uid), verdicts.get(found.uid)
        jump = found if found.number == number else replace(found, number=number)
        if place is not None:
            apex = placed[detection.signal_sha256, _time_of(place)]
            jump = _with_apex(jump, apex, "moved" if found.uid in detected else "added")
        judged.append(
            JudgedJump(
                jump,
                detection.signal_sha256,
                _excluded(jump, verdict, rules),
                verdict,
                tuple(by_person.get(found.uid, {}).values()),
                place,
                None if place is None else found,
            )
        )
    return Judgement(tuple(judged), tuple(item for item in waiting.values() if item.verdict is not Verdict.CLEAR))


def _time_of(decision: DecisionRow) -> float:
    assert decision.at_s is not None, decision  # noqa: S101 - the table holds no placed apex without a time
    return decision.at_s


def _in_time(found: list[JumpRow], jumps: Iterable[JumpRow], detected: Collection[str]) -> list[JumpRow]:
    """Return the jumps that were found, in their order, with the added ones between them by time."""
    for added in [jump for jump in jumps if jump.uid not in detected]:
        later = (place for place, jump in enumerate(found) if anchor_of(jump) > anchor_of(added))
        found.insert(next(later, len(found)), added)
    return found


def _with_apex(jump: JumpRow, apex: JumpRow, flag: str) -> JumpRow:
    """Return a jump with the apex that a person saw; in the flight that was found its ends stay as they were found."""
    of_flight = apex
    if jump.liftoff_s is not None and jump.flight_time_s is not None and apex.apex_s is not None:
        of_flight = jump if 0.0 <= apex.apex_s - jump.liftoff_s <= jump.flight_time_s else apex
    return replace(
        apex,
        uid=jump.uid,
        number=jump.number,
        touchdown_s=jump.touchdown_s if apex.touchdown_s is None else apex.touchdown_s,
        liftoff_s=of_flight.liftoff_s,
        flight_time_s=of_flight.flight_time_s,
        flags=(*apex.flags, flag),
    )


def jumps_near(at_s: float, jumps: Iterable[JumpRow]) -> list[JumpRow]:
    """Return the jumps whose apex, or touchdown, lies within half their flight of a time of their log."""
    return [jump for jump in jumps if abs(anchor_of(jump) - at_s) <= _half_flight(jump)]


def match(near: Sequence[JumpRow], detection: DetectionRow, decision: DecisionRow) -> JumpRow | None:
    """Return the one jump near the anchor of a verdict that it is about, or None when it must be asked again.

    Another detector's apex differs by its nature, so only a new version of the same detector calls for a new review.
    """
    meant = [
        jump for jump in near if anchor_of(jump) == decision.anchor_s
    ]  # a landing may lie near the flight before it
    if len(meant or near) != 1:
        return None
    jump = (meant or near)[0]
    if detection.algorithm != decision.algorithm or detection.version == decision.version:
        return jump
    if decision.old_value is None or jump.apex_height_m is None:
        return jump if decision.old_value is None and jump.apex_height_m is None else None
    if jump.apex_height_se_m is None:
        return jump
    moved_m = abs(jump.apex_height_m - decision.old_value)
    return jump if moved_m <= MOVED_STANDARD_ERRORS * jump.apex_height_se_m else None


def anchor_of(jump: JumpRow) -> float:
    """Return the time a verdict on this jump is tied to: its apex, or where it touched down."""
    for moment in (jump.apex_s, jump.touchdown_s, jump.liftoff_s):
        if moment is not None:
            return moment
    return 0.0


def _half_flight(jump: JumpRow) -> float:
    return (jump.flight_time_s or UNKNOWN_FLIGHT_S) / 2.0


def _excluded(jump: JumpRow, decision: DecisionRow | None, rules: Rules) -> str | None:
    if decision is not None and decision.verdict is Verdict.REJECT:
        return f"rejected: {decision.reason_code}"
    if jump.apex_height_m is None:
        return jump.undefined_reason
    if decision is not None and decision.verdict is Verdict.ACCEPT:
        return None
    if jump.number <= rules.exclude_first_jumps:
        return f"among the first {rules.exclude_first_jumps}"
    if jump.gap_touched and rules.exclude_gap_jumps:
        return "touches a gap"
    return None


@dataclass(frozen=True, slots=True)
class RunApexes(Result):
    """Mean apex height of a run, and its jumps: how many were found, and the heights in m of those that count.

    `excluded` counts the others by reason, `waiting` the verdicts that fit no jump any more. `calibration_terms_m` has
    what each error of the height's calibration makes of the mean, a signed standard error in m by "calibration term",
    `calibration_df` the degrees of freedom of calibrations that were fitted.
    """

    apex_height: Number
    jumps_found: Number
    heights_m: tuple[float, ...]
    excluded: Mapping[str, int]
    waiting: int
    calibration_terms_m: Mapping[str, float] = field(default_factory=dict)
    calibration_df: Mapping[str, int] = field(default_factory=dict)

    @property
    def shared_error(self) -> SharedError:
        """What the mean has in common with that of other runs: the errors of the height's calibration."""
        terms = {tuple(name.split(" ", 1)): size for name, size in self.calibration_terms_m.items()}
        df = {fit: float(self.calibration_df.get(fit, math.inf)) for fit, _term in terms}
        return SharedError({(fit, term): size for (fit, term), size in terms.items()}, df)


ALGORITHM = Algorithm("run_apexes", 15)


@dataclass(frozen=True, slots=True)
class ApexResults(RunResults[RunApexes]):
    """Apex results with the judgements behind them, by run uid."""

    judgements: Mapping[str, Judgement]


def by_protocol(protocol: ProtocolSettings) -> ApexVariant:
    """Return a protocol's own way."""
    return ApexVariant(protocol.detector, Rules(protocol.exclude_first_jumps, protocol.exclude_gap_jumps))


def as_protocol(evidence: StudyData) -> ApexVariant:
    """Return the protocol's own way."""
    return by_protocol(evidence.configuration.protocol)


def without_exclusions(evidence: StudyData) -> ApexVariant:
    """Return the protocol's way, but with every apex that was found."""
    return replace(as_protocol(evidence), rules=Rules(0, exclude_gap_jumps=False), heed_decisions=False)


_NO_LOG = Undefined(Reason.NO_HEIGHT_LOG)


def usable_logs(run: RunRow, logs: Sequence[SignalRow]) -> tuple[SignalRow, ...] | Undefined:
    """Return the logs that a run's apexes come from, in their order, or why there are none.

    A run that was started again leaves several: segments of one file, or as many files as the run had starts. More
    files than starts are copies or mistakes, and which one counts is for a person to say; the same samples saved twice
    are one log. Logs follow each other by the clock where all have one, else by their files' names, so that it does not
    matter which was ingested first.
    """
    if not logs:
        return _NO_LOG
    distinct = list({log.sha256: log for log in reversed(logs)}.values())[::-1]
    files = len({log.file_sha256 for log in distinct})
    if files > max(run.starts, 1):
        return Undefined(Reason.MORE_LOGS_THAN_STARTS, files=files, n=run.starts)
    if all(log.start_utc is not None for log in distinct):
        return tuple(sorted(distinct, key=lambda log: log.start_utc or ""))
    return tuple(sorted(distinct, key=lambda log: _in_number_order(log.file_name)))


def calibrated_for_other_day(
    run: RunRow, logs: Sequence[SignalRow], calibrated: Mapping[str, Sequence[CalibratedChannel]]
) -> Undefined | None:
    """Say of which log a height has a calibration that does not hold on the run's day; None where there is none.

    The day of a log with dates of its own is in these. `calibrated` has the channels by the signal's uid.
    """
    for log in logs:
        heights = [channel for channel in calibrated.get(log.uid, ()) if channel.name == BODY_HEIGHT]
        if log.start_utc is None and any(not channel.calibration.holds_on(run.day) for channel in heights):
            quoted = shlex.quote(log.file_name)
            return Undefined(Reason.CALIBRATION_OF_OTHER_DAY, file=log.file_name, day=run.day, quoted=quoted)
    return None


def judged_run(
    detections: Detections, run: RunRow, logs: Sequence[SignalRow], variant: ApexVariant
) -> JudgedRun | Undefined:
    """Find and judge the jumps of a run in all its `logs` with a body height, or say why they do not count."""
    usable = usable_logs(run, logs)
    if isinstance(usable, Undefined):
        return usable
    decisions = jump_decisions(detections.connection, [log.sha256 for log in usable])
    return judge_runs(detections, [run], {run.uid: usable}, decisions, variant)[run.uid]


def jumps_found_in_run(
    detections: Detections, run: RunRow, logs: Sequence[SignalRow], detector: str
) -> int | Undefined:
    """Count the jumps found of a run over all its `logs` with a body height, or say why they do not count.

    Those that a person added are found, too.
    """
    judged = judged_run(detections, run, logs, ApexVariant(detector, Rules(0, exclude_gap_jumps=False)))
    return judged if isinstance(judged, Undefined) else jumps_found(item.jump for item in judged.judgement.jumps)


def _in_number_order(name: str) -> list[tuple[str, int]]:
    """Sort LOG9 before LOG10; segments of one file keep their order, for sorting is stable."""
    return [(text, int(digits or 0)) for text, digits in re.findall(r"(\D*)(\d*)", name)]


def logs_that_count(
    runs: Sequence[RunRow],
    logs: Mapping[str, Sequence[SignalRow]],
    calibrated: Mapping[str, Sequence[CalibratedChannel]],
) -> tuple[dict[str, tuple[SignalRow, ...]], dict[str, Undefined]]:
    """Return the logs that each run's apexes come from, by the run's uid, and why the other runs have none."""
    found: dict[str, tuple[SignalRow, ...]] = {}
    missing: dict[str, Undefined] = {}
    for run in runs:
        usable = usable_logs(run, logs.get(run.uid, []))
        if not isinstance(usable, Undefined):
            other_day = calibrated_for_other_day(run, usable, calibrated)
            usable = usable if other_day is None else other_day
        if isinstance(usable, Undefined):
            missing[run.uid] = usable
        else:
            found[run.uid] = usable
    return found, missing


def run_apexes(computed: Results, detections: Detections, evidence: StudyData, variant: ApexVariant) -> ApexResults:
    """Compute the apex heights of every selected jump run that has logs."""
    logs, missing = logs_that_count(evidence.runs, evidence.logs, evidence.calibrated)
    runs = {run.uid: run for run in evidence.runs}
    lengths_m = {
        robot: rest_length_m(detections.connection, robot) for robot in sorted({runs[uid].robot_uid for uid in logs})
    }
    results: dict[str, RunApexes] = {}
    calibrated = {
        uid: channel
        for uid, channels in evidence.calibrated.items()
        for channel in channels
        if channel.name == BODY_HEIGHT
    }
    settings = {
        "detector": variant.detector,
        "exclude_first_jumps": variant.rules.exclude_first_jumps,
        "exclude_gap_jumps": variant.rules.exclude_gap_jumps,
        "heed_decisions": variant.heed_decisions,
    }
    judged = judge_runs(detections, evidence.runs, logs, evidence.decisions, variant)
    placing = f" robust, version {version('robust')}"
    for uid, found in judged.items():
        run, judgement = runs[uid], found.judgement
        inputs = [run_input(run)]
        inputs += [signal_input(log, f"log {place}") for place, log in enumerate(logs[uid], start=1)]
        inputs.append(fingerprint("robot", "robot", run.robot_uid, repr(lengths_m[run.robot_uid])))
        inputs += [
            InputRow("detection", "detection", f"{item.algorithm}, version {item.version}", item.key)
            for item in found.detections
        ]
        inputs += [decision_input(said, "" if said.at_s is None else placing) for said in judgement.in_force]
        heights = {log.sha256: calibrated[log.uid] for log in logs[uid] if log.uid in calibrated}
        inputs += [
            fingerprint("calibration", "signal", log.uid, repr(heights[log.sha256].calibration))
            for log in logs[uid]
            if log.sha256 in heights
        ]
        about = {"run": run.name, **settings}
        results[uid] = computed.record(ALGORITHM, about, inputs, _apexes(judgement, heights), settings)
    return ApexResults(results, missing, {uid: found.judgement for uid, found in judged.items()})


def _apexes(judgement: Judgement, calibrated: Mapping[str, CalibratedChannel]) -> RunApexes:
    counted = judgement.counted
    terms, df = _calibration_errors(judgement, calibrated)
    heights = [jump.apex_height_m for jump in counted if jump.apex_height_m is not None]
    about = describe(heights)
    found = jumps_found(item.jump for item in judgement.jumps)
    excluded = Counter(item.excluded for item in judgement.jumps if item.excluded is not None)
    return RunApexes(
        apex_height=Number(about.mean, "m", about.se, math.hypot(*terms.values()) if terms else None, n=about.n),
        jumps_found=Number(float(found), "1", n=found),
        heights_m=tuple(heights),
        excluded=dict(sorted(excluded.items())),
        waiting=len(judgement.waiting),
        calibration_terms_m=terms,
        calibration_df=df,
    )


def _calibration_errors(
    judgement: Judgement, calibrated: Mapping[str, CalibratedChannel]
) -> tuple[dict[str, float], dict[str, int]]:
    """Return what each error of the calibrations of a run's logs makes of its mean height, in m, and their df.

    A log's height channel is in `calibrated` by the hash of its samples.
    """
    heights = [
        (calibrated.get(item.signal_sha256), item.jump.apex_height_m)
        for item in judgement.jumps
        if item.excluded is None and item.jump.apex_height_m is not None
    ]
    terms: dict[str, float] = {}
    df: dict[str, int] = {}
    for channel, height_m in heights:
        if channel is None or not channel.calibration.errors:
            continue
        name = hashlib.sha256(repr(channel.calibration).encode()).hexdigest()[:12]
        if channel.calibration.df is not None:
            df[name] = channel.calibration.df
        for number, error_m in enumerate(channel.error_terms(height_m), start=1):
            key = f"{name} {number}"
            terms[key] = terms.get(key, 0.0) + error_m / len(heights)
    return terms, df


measured = run_apexes
