"""Apex heights of each run: the jumps that count, by a person's word and the protocol."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, replace

from data_schema.queries.results import InputRow, ResultRow
from data_schema.queries.runs import RunRow
from data_schema.queries.signals import DetectionRow, SignalRow
from labbook.analysis.detections import Detections, rest_length_m
from labbook.analysis.facts import decision_input, run_input, signal_input
from labbook.analysis.gathering import Evidence
from labbook.analysis.judging import Judgement, Rules, judge
from labbook.analysis.workbench import Algorithm, NewNumber, Outcome, Request, Workbench, rests_on
from stats.summary import describe

ALGORITHM = Algorithm("run_apexes", 2, ("labbook.analysis.run_apexes", "labbook.analysis.judging", "stats.summary"))


@dataclass(frozen=True, slots=True)
class RunApexes:
    """Apex results by run uid with the judgements behind them, and why other runs have none."""

    results: dict[str, ResultRow]
    judgements: dict[str, Judgement]
    missing: dict[str, str]


@dataclass(frozen=True, slots=True)
class ApexVariant:
    """How jumps are found and judged: as the protocol says, or otherwise to see what depends on it."""

    detector: str
    rules: Rules
    heed_decisions: bool = True


def as_protocol(evidence: Evidence) -> ApexVariant:
    """Return the protocol's own way."""
    protocol = evidence.configuration.protocol
    return ApexVariant(protocol.detector, Rules(protocol.exclude_first_jumps, protocol.exclude_gap_jumps))


def without_exclusions(evidence: Evidence) -> ApexVariant:
    """Return the protocol's way, but with every apex that was found."""
    return replace(as_protocol(evidence), rules=Rules(0, exclude_gap_jumps=False), heed_decisions=False)


def usable_log(logs: list[SignalRow]) -> SignalRow | str:
    """Return the one log that a run's apexes rest on, or why there is none."""
    if not logs:
        return "no log with a body height"
    if len(logs) > 1:
        return f"{len(logs)} logs with a body height"
    return logs[0]


def run_apexes(bench: Workbench, detections: Detections, evidence: Evidence, variant: ApexVariant) -> RunApexes:
    """Ensure the apex heights of every selected jump run that has a log."""
    logs: dict[str, SignalRow] = {}
    missing: dict[str, str] = {}
    for run in evidence.runs:
        log = usable_log(evidence.logs.get(run.uid, []))
        if isinstance(log, str):
            missing[run.uid] = log
        else:
            logs[run.uid] = log
    runs = {run.uid: run for run in evidence.runs}
    robots = sorted({runs[uid].robot_uid for uid in logs})
    lengths_m = {robot: rest_length_m(detections.connection, robot) for robot in robots}
    found = _detected(detections, evidence, logs, lengths_m, variant.detector)
    requests: dict[str, Request] = {}
    judgements: dict[str, Judgement] = {}
    for uid, detection in found.items():
        decisions = evidence.decisions.get(detection.signal_sha256, []) if variant.heed_decisions else []
        judgements[uid] = judge(detection, decisions, variant.rules)
        inputs = [run_input(runs[uid]), signal_input(logs[uid])]
        robot = runs[uid].robot_uid
        inputs.append(rests_on("robot", "robot", robot, repr(lengths_m[robot])))
        inputs.append(InputRow("detection", "detection", detection.uid, detection.key))
        inputs += [decision_input(decision) for decision in judgements[uid].in_force]
        requests[uid] = _request(runs[uid], judgements[uid], variant, tuple(inputs))
    return RunApexes(dict(zip(requests, bench.ensure(list(requests.values())), strict=True)), judgements, missing)


def _detected(
    detections: Detections,
    evidence: Evidence,
    logs: dict[str, SignalRow],
    lengths_m: dict[str, float],
    detector: str,
) -> dict[str, DetectionRow]:
    by_length: dict[float, dict[str, SignalRow]] = {}
    for run in evidence.runs:
        if run.uid in logs:
            by_length.setdefault(lengths_m[run.robot_uid], {})[run.uid] = logs[run.uid]
    found: dict[str, DetectionRow] = {}
    for length_m, of_length in by_length.items():
        found |= detections.of(of_length, detector, length_m)
    return {uid: found[uid] for uid in logs}


def _request(run: RunRow, judgement: Judgement, variant: ApexVariant, inputs: tuple[InputRow, ...]) -> Request:
    settings = {
        "detector": variant.detector,
        "exclude_first_jumps": variant.rules.exclude_first_jumps,
        "exclude_gap_jumps": variant.rules.exclude_gap_jumps,
        "heed_decisions": variant.heed_decisions,
    }
    return Request(ALGORITHM, {"run": run.name, **settings}, inputs, settings, lambda: _outcome(judgement))


def _outcome(judgement: Judgement) -> Outcome:
    counted = judgement.counted
    heights = [jump.apex_height_m for jump in counted if jump.apex_height_m is not None]
    about = describe(heights)
    excluded = Counter(item.excluded for item in judgement.jumps if item.excluded is not None)
    return Outcome(
        (
            NewNumber("apex_height", about.mean, "m", about.se, n=about.n),
            NewNumber("jumps_found", float(len(judgement.jumps)), "1", n=len(judgement.jumps)),
        ),
        {"heights_m": heights, "excluded": dict(sorted(excluded.items())), "waiting": len(judgement.waiting)},
    )
