"""The jumps of one run with the verdicts on them, and giving verdicts."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import sqlalchemy as sa

from data_schema.errors import UsageError, unknown_name
from data_schema.queries.detections import DecisionRow, DetectionRow, WaitingVerdict, jump_decisions, verdicts_waiting
from data_schema.queries.files import waiting_files
from data_schema.queries.runs import RunRow
from data_schema.queries.signals import SignalRow, signals_of_runs
from data_schema.vocabulary import Action, FileRole, ReasonCode, RunKind, TargetKind, Undefined, Verdict
from labbook.analysis.outcomes.detection import BODY_HEIGHT, Detections, rest_length_m
from labbook.analysis.outcomes.run_apexes import (
    JudgedJump,
    Reviewed,
    anchor_of,
    judge,
    not_reviewed,
    reviewed,
    rules_of,
    usable_logs,
)
from labbook.analysis.preregistration.planned import AS_A_WHOLE, is_allowed, planned_analysis
from labbook.book.naming import run_named
from labbook.book.opening import Book
from labbook.book.write_session import Statement, WriteSession, new_uid
from labbook.config.parsing import Configuration
from labbook.terminal import listed
from stats.apexes.jumps import FLAGS


@dataclass(frozen=True, slots=True)
class RunReview:
    """A run's logs in their order, what the study's detector finds in them, and what counts.

    `waiting` are verdicts that fit no jump of the logs any more, `lost` those on samples that are not in force.
    `reviewed` and `not_reviewed` have the numbers of the jumps on which a person's verdict stands, and of the others.
    """

    run: RunRow
    signals: tuple[SignalRow, ...]
    detections: tuple[DetectionRow, ...]
    jumps: tuple[JudgedJump, ...]
    reviewed: tuple[Reviewed, ...]
    not_reviewed: tuple[int, ...]
    waiting: tuple[DecisionRow, ...]
    lost: tuple[WaitingVerdict, ...] = ()


def review(book: Book, connection: sa.Connection, name: str) -> RunReview:
    """Find and judge the jumps of a run; raises when it has no log, or too many, or one waits for a declaration."""
    run = run_named(connection, name)
    for file in waiting_files(connection):
        if run.uid in file.runs and file.role == FileRole.LOG:
            raise UsageError(f"{file.why.reason}.")
    logs = [
        signal
        for signal in signals_of_runs(connection, FileRole.LOG, run_uids=[run.uid])
        if BODY_HEIGHT in signal.channels
    ]
    if run.kind != RunKind.JUMPS and not logs:
        raise UsageError(
            f"run {name} has no log with a body_height channel, and as one of kind {run.kind} no jumps: "
            f"`labbook show {name}` lists what it has."
        )
    if not logs:
        others = sorted({str(signal.role) for signal in signals_of_runs(connection, run_uids=[run.uid])})
        only = f", only {' and '.join(others)}" if others else ""
        raise UsageError(
            f"run {name} has no log with a body_height channel{only}: add its log with `labbook ingest FILE --run "
            f"{name}`, or declare the column of the height with --column."
        )
    signals = usable_logs(run, logs)
    if isinstance(signals, Undefined):
        raise UsageError(
            f"run {name} has {signals.reason}: `labbook show {name}` lists its files; take one off with `labbook "
            f"assign FILE none`, or state the starts with `labbook correct {name} starts=...`."
        )
    protocol = book.configuration.protocol
    detections = Detections(connection, book.store)
    length_m = rest_length_m(connection, run.robot_uid)
    found = detections.of({run.uid: signals}, protocol.detector, length_m)[run.uid]
    return _judged(book, connection, run, signals, found)


def _judged(
    book: Book,
    connection: sa.Connection,
    run: RunRow,
    signals: tuple[SignalRow, ...],
    detections: tuple[DetectionRow, ...],
) -> RunReview:
    """Judge jumps by the protocol and by the verdicts that stand now."""
    decisions = jump_decisions(connection, [signal.sha256 for signal in signals])
    judgement = judge(detections, decisions, rules_of(book.configuration.protocol))
    lost = tuple(verdicts_waiting(connection, run.uid))
    jumps = judgement.jumps
    return RunReview(run, signals, detections, jumps, reviewed(jumps), not_reviewed(jumps), judgement.waiting, lost)


def resolve_jumps(texts: Sequence[str], found: RunReview) -> list[int]:
    """Read numbers of jumps and ranges of them, `4` or `3-5`, each jump once.

    Raises `UsageError` for what is neither, and for a jump that the run does not have.
    """
    ranges = []
    for text in texts:
        match = _NUMBERS.fullmatch(text.strip())
        if match is None:
            raise UsageError(f"{text!r} names no jump: write a number or a range, for example 4 or 3-5.")
        first, last = int(match[1]), int(match[2] or match[1])
        if last < first:
            raise UsageError(f"{text!r} runs backwards: write {last}-{first}.")
        ranges.append(range(first, last + 1))
    known = {item.jump.number for item in found.jumps}
    for numbers in ranges:
        _refuse_unknown(found, known, numbers)
    return list(dict.fromkeys(number for numbers in ranges for number in numbers))


def decide(
    book: Book,
    session: WriteSession,
    name: str,
    numbers: Sequence[int],
    verdict: str,
    reason: str,
    note: str | None,
    found: RunReview | None = None,
) -> list[int]:
    """State a verdict on each of the jumps on which this person's last one differs; all of them or none.

    Returns the numbers of these jumps. `found` is the run's review where it was made before the session opened: others
    wait while a session finds jumps.
    """
    if reason not in tuple(ReasonCode):
        raise unknown_name("reason", reason, tuple(ReasonCode))
    if found is None:
        found = review(book, session.connection, name)
    else:  # verdicts may have come since, also from a command that was cut off
        found = _judged(book, session.connection, found.run, found.signals, found.detections)
    jumps = {item.jump.number: item for item in found.jumps}
    _refuse_unknown(found, jumps, numbers)
    changed = [
        number for number in numbers if not _stands(jumps[number].decision, session.person, verdict, reason, note)
    ]
    for number in changed:
        item, detection = jumps[number], found.detections[0]
        found_as = {
            "old_value": item.jump.apex_height_m,
            "algorithm": detection.algorithm,
            "version": detection.version,
        }
        _state_verdict(
            session, found.run, item.signal_sha256, anchor_of(item.jump), Verdict(verdict), reason, note, found_as
        )
    return changed


def without_apex(found: RunReview, numbers: Collection[int]) -> list[str]:
    """Say which of these are no jumps: without an apex nothing of them counts, whatever the verdict."""
    return [
        f"{item.jump.number} of run {found.run.name} has no apex ({item.jump.undefined_reason}): it counts neither way."
        for item in found.jumps
        if item.jump.number in numbers and item.jump.apex_height_m is None
    ]


def _stands(standing: DecisionRow | None, person: str, verdict: str, reason: str, note: str | None) -> bool:
    """Tell whether a verdict would repeat the standing one; one that is taken back leaves none."""
    if standing is None:
        return verdict == Verdict.CLEAR
    present = (standing.person, standing.verdict, standing.reason_code, standing.note)
    return present == (person, verdict, reason, note)


def clear_waiting(book: Book, session: WriteSession, name: str, note: str | None, found: RunReview | None) -> int:
    """Take back the verdicts of a run that wait; returns how many.

    These are those on samples that are not in force, and those that fit no jump of the run, whose review is `found`;
    None where it cannot be reviewed.
    """
    run = run_named(session.connection, name)
    unfit = () if found is None else _judged(book, session.connection, run, found.signals, found.detections).waiting
    waiting: list[WaitingVerdict | DecisionRow] = [*verdicts_waiting(session.connection, run.uid), *unfit]
    for verdict in waiting:
        _state_verdict(session, run, verdict.signal_sha256, verdict.anchor_s, Verdict.CLEAR, ReasonCode.OTHER, note, {})
    return len(waiting)


def _state_verdict(
    session: WriteSession,
    run: RunRow,
    signal_sha256: str,
    anchor_s: float,
    verdict: Verdict,
    reason: str,
    note: str | None,
    found_as: Mapping[str, Any],
) -> None:
    """State a verdict on the jump of a log at a time; `found_as` says what was found there, and by what."""
    new = {
        "target_kind": str(TargetKind.JUMP),
        "target_uid": run.uid,
        "signal_sha256": signal_sha256,
        "anchor_s": anchor_s,
        "verdict": str(verdict),
        "reason_code": str(reason),
        "note": note,
        "old_value": None,
        "algorithm": None,
        "version": None,
        **found_as,
        "blind": 0,
    }
    session.state(Statement(Action.DECIDE, "decision", new_uid(), new=new, reason=note))


def _refuse_unknown(found: RunReview, known: Collection[int], numbers: Iterable[int]) -> None:
    for number in numbers:
        if number not in known:
            name = found.run.name
            raise UsageError(
                f"run {name} has no jump {number}: it has {len(known)}, `labbook jumps list {name}` shows them."
            )


_NUMBERS = re.compile(r"([0-9]{1,9})(?:-([0-9]{1,9}))?")


def jump_lines(found: RunReview) -> tuple[tuple[str, ...], list[tuple[str, ...]], list[str]]:
    """Return head and rows of the list of jumps, and lines: what the flags in it mean, and each verdict that waits."""
    head = ("jump", "touchdown", "apex", "height", "+-", "flight time", "counts", "reviewed", "flags")
    rows: list[tuple[str, ...]] = [
        (
            str(item.jump.number),
            "" if item.jump.touchdown_s is None else f"{item.jump.touchdown_s:.3f} s",
            "" if item.jump.apex_s is None else f"{item.jump.apex_s:.3f} s",
            "" if item.jump.apex_height_m is None else f"{item.jump.apex_height_m * 1e3:.2f} mm",
            "" if item.jump.apex_height_se_m is None else f"{item.jump.apex_height_se_m * 1e3:.2f} mm",
            "" if item.jump.flight_time_s is None else f"{item.jump.flight_time_s * 1e3:.0f} ms",
            "yes" if item.excluded is None else f"no: {item.excluded}",
            "" if item.decision is None else _said(item.decision),
            " ".join(item.jump.flags),
        )
        for item in found.jumps
    ]
    waiting = [
        f"waiting for review: {decision.verdict} at {decision.anchor_s:.3f} s by {decision.person} fits none now."
        for decision in found.waiting
    ]
    raised = {flag for item in found.jumps for flag in item.jump.flags}
    meant = [f"{flag}: {meaning}." for flag, meaning in FLAGS.items() if flag in raised]
    return head, rows, [*meant, *waiting, *(verdict.sentence for verdict in found.lost)]


def _said(verdict: DecisionRow | Reviewed) -> str:
    return f"{verdict.verdict}ed by {verdict.person}{', blind' if verdict.blind else ''}"


def review_lines(found: Sequence[Reviewed], others: Sequence[int]) -> list[str]:
    """Say which jumps of a run were reviewed, by whom, and how many were not; nothing where there are none."""
    lines = []
    for item in found:
        several = "s" if len(item.jumps) > 1 else ""
        lines.append(f"jump{several} {listed([*map(str, item.jumps)])} {_said(item)} ({item.reason_code})")
    if others:
        n_jumps = len(others) + sum(len(item.jumps) for item in found)
        lines.append(f"{len(others)} of {n_jumps} jumps not reviewed by a person")
    return lines


def reason_remarks(
    connection: sa.Connection,
    configuration: Configuration,
    reason: str,
    concerned: str = "every comparison",
    remedy: str = "",
) -> list[str]:
    """Return a remark on a reason that the preregistration does not allow, while it can still be changed; or none.

    `concerned` are the comparisons that become exploratory: all by a void run, those of heights by a rejected jump.
    `remedy` explains how to give another reason, where any is allowed.
    """
    planned = planned_analysis(connection, configuration)
    if not planned.stated or is_allowed(reason, planned.settings.exclusions):
        return []
    listed = ", ".join(map(str, planned.settings.exclusions)) or "no reason"
    cure = f" {remedy}" if remedy and planned.settings.exclusions else ""
    return [f"[analysis] allows {listed}, so the report calls {concerned} exploratory ({reason}): {AS_A_WHOLE}.{cure}"]
