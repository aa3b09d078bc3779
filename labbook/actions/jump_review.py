"""The jumps of one run with the verdicts on them, and giving verdicts."""

from __future__ import annotations

from dataclasses import dataclass

import sqlalchemy as sa

from data_schema.errors import UsageError, unknown_name
from data_schema.queries.runs import RunRow
from data_schema.queries.signals import DecisionRow, DetectionRow, SignalRow, jump_decisions, signals_of_runs
from data_schema.vocabulary import Action, FileRole, ReasonCode, TargetKind, Verdict
from labbook.analysis.detecting import BODY_HEIGHT
from labbook.analysis.detections import Detections, rest_length_m
from labbook.analysis.judging import JudgedJump, Rules, anchor_of, judge
from labbook.analysis.run_apexes import usable_log
from labbook.book.desk import Desk, Statement, new_uid
from labbook.book.naming import run_named
from labbook.book.opening import Book


@dataclass(frozen=True, slots=True)
class RunReview:
    """A run's log, what the study's detector finds in it, and what counts."""

    run: RunRow
    signal: SignalRow
    detection: DetectionRow
    jumps: tuple[JudgedJump, ...]
    waiting: tuple[DecisionRow, ...]


def review(book: Book, connection: sa.Connection, name: str) -> RunReview:
    """Find and judge the jumps of a run; raises when it has no log, or several."""
    run = run_named(connection, name)
    logs = [
        signal
        for signal in signals_of_runs(connection, FileRole.LOG)
        if signal.run_uid == run.uid and BODY_HEIGHT in signal.channels
    ]
    log = usable_log(logs)
    if isinstance(log, str):
        raise UsageError(f"run {name} has {log}: `labbook show {name}` lists its files.")
    protocol = book.configuration.protocol
    detections = Detections(connection, book.store)
    length_m = rest_length_m(connection, run.robot_uid)
    detection = detections.of({run.uid: log}, protocol.detector, length_m)[run.uid]
    decisions = jump_decisions(connection).get(log.sha256, [])
    judgement = judge(detection, decisions, Rules(protocol.exclude_first_jumps, protocol.exclude_gap_jumps))
    return RunReview(run, log, detection, judgement.jumps, judgement.waiting)


def decide(book: Book, desk: Desk, name: str, numbers: list[int], verdict: str, reason: str, note: str | None) -> None:
    """State a verdict on each of the jumps; all of them or none."""
    if reason not in tuple(ReasonCode):
        raise unknown_name("reason", reason, tuple(ReasonCode))
    found = review(book, desk.connection, name)
    jumps = {item.jump.number: item.jump for item in found.jumps}
    for number in numbers:
        if number not in jumps:
            raise UsageError(
                f"run {name} has no jump {number}: it has {len(jumps)}, `labbook jumps list {name}` shows them."
            )
        jump = jumps[number]
        new = {
            "target_kind": str(TargetKind.JUMP),
            "target_uid": found.run.uid,
            "signal_sha256": found.signal.sha256,
            "anchor_s": anchor_of(jump),
            "verdict": str(Verdict(verdict)),
            "reason_code": reason,
            "note": note,
            "old_value": jump.apex_height_m,
            "algorithm": found.detection.algorithm,
            "version": found.detection.version,
            "blind": 0,
        }
        desk.state(Statement(Action.DECIDE, "decision", new_uid(), new=new, reason=note))


def jump_lines(found: RunReview) -> tuple[tuple[str, ...], list[tuple[str, ...]], list[str]]:
    """Return head and rows of the list of jumps, and a line for each verdict that waits."""
    head = ("jump", "apex at", "height", "+-", "flight", "counts", "flags")
    rows: list[tuple[str, ...]] = [
        (
            str(item.jump.number),
            f"{anchor_of(item.jump):.3f} s",
            "" if item.jump.apex_height_m is None else f"{item.jump.apex_height_m * 1e3:.2f} mm",
            "" if item.jump.apex_height_se_m is None else f"{item.jump.apex_height_se_m * 1e3:.2f} mm",
            "" if item.jump.flight_time_s is None else f"{item.jump.flight_time_s * 1e3:.0f} ms",
            "yes" if item.excluded is None else f"no: {item.excluded}",
            " ".join(item.jump.flags),
        )
        for item in found.jumps
    ]
    waiting = [
        f"waiting for review: {decision.verdict} at {decision.anchor_s:.3f} s by {decision.person} fits none now."
        for decision in found.waiting
    ]
    return head, rows, waiting
