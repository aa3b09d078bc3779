"""The jumps of one run with the verdicts on them, and giving verdicts."""

from __future__ import annotations

import contextlib
import re
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import sqlalchemy as sa

from data_schema.errors import UsageError, unknown_name
from data_schema.queries.detections import DecisionRow, DetectionRow, WaitingVerdict, jump_decisions, verdicts_waiting
from data_schema.queries.files import waiting_files
from data_schema.queries.runs import RunRow
from data_schema.queries.signals import SignalRow, signals_of_runs
from data_schema.reasons import Reason
from data_schema.vocabulary import FileRole, ReasonCode, TargetKind, Undefined, Verdict
from labbook.analysis.outcomes.detection import BODY_HEIGHT, Detections, placed_apex, rest_length_m
from labbook.analysis.outcomes.run_apexes import (
    JudgedJump,
    Reviewed,
    anchor_of,
    by_protocol,
    judge_runs,
    jumps_near,
    not_reviewed,
    reviewed,
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
    return _judged(book, connection, *_usable(connection, name))


@contextlib.contextmanager
def judging(book: Book, person: str | None, name: str) -> Iterator[tuple[WriteSession, RunReview]]:
    """Review a run, then open a session of who judges it: others wait while a session finds jumps."""
    book.speaker(person)  # who may not speak need not wait for the jumps to be found
    book.catch_up()
    with book.reading() as connection:
        found = review(book, connection, name)
    with book.session(person) as session:
        yield session, found


def _usable(connection: sa.Connection, name: str) -> tuple[RunRow, tuple[SignalRow, ...]]:
    """Return a run and its logs; raises as `review` does."""
    run = run_named(connection, name)
    logs, without = logs_of(connection, [run])
    why = without.get(run.uid)
    if why is None:
        return run, logs[run.uid]
    if why.code in (Reason.FILE_WAITS, Reason.FILE_LOST):
        raise UsageError(f"{why.reason}.")
    raise UsageError(
        f"run {name} has {why.reason}: `labbook show {name}` lists its files, `labbook ingest FILE --run {name}` adds "
        f"one, `labbook assign FILE none` takes one off, `labbook correct {name} starts=...` states its starts."
    )


def logs_of(
    connection: sa.Connection, runs: Sequence[RunRow]
) -> tuple[dict[str, tuple[SignalRow, ...]], dict[str, Undefined]]:
    """Return by the run's uid the logs that count, and why runs have none."""
    waits = {uid: file.why for file in waiting_files(connection) if file.role == FileRole.LOG for uid in file.runs}
    by_run: dict[str, list[SignalRow]] = {}
    for signal in signals_of_runs(connection, FileRole.LOG, [run.uid for run in runs]):
        if BODY_HEIGHT in signal.channels:
            by_run.setdefault(signal.run_uid, []).append(signal)
    logs: dict[str, tuple[SignalRow, ...]] = {}
    without: dict[str, Undefined] = {}
    for run in runs:
        found = waits[run.uid] if run.uid in waits else usable_logs(run, by_run.get(run.uid, []))
        if isinstance(found, Undefined):
            without[run.uid] = found
        else:
            logs[run.uid] = found
    return logs, without


def _judged(
    book: Book,
    connection: sa.Connection,
    run: RunRow,
    signals: tuple[SignalRow, ...],
    known: Sequence[DetectionRow] = (),
) -> RunReview:
    """Judge jumps by the protocol and by the verdicts that stand now; `known` was found before."""
    detections = Detections(connection, book.store, known={row.key: row for row in known})
    decisions = jump_decisions(connection, [signal.sha256 for signal in signals])
    way = by_protocol(book.configuration.protocol)
    judged = judge_runs(detections, [run], {run.uid: signals}, decisions, way)[run.uid]
    lost = tuple(verdicts_waiting(connection, run.uid))
    jumps, waiting = judged.judgement.jumps, judged.judgement.waiting
    return RunReview(run, signals, judged.detections, jumps, reviewed(jumps), not_reviewed(jumps), waiting, lost)


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
    *,
    blind: bool = False,
) -> list[int]:
    """State a verdict on each of the jumps on which this person's last one differs; all of them or none.

    Returns the numbers of these jumps. `found` is the run's review where it was made before the session opened: others
    wait while a session finds jumps. `blind`: the person saw neither condition nor run, nor what others said.
    """
    _refuse_unknown_reason(reason)
    found = judged_now(book, session, name, found)
    jumps = {item.jump.number: item for item in found.jumps}
    _refuse_unknown(found, jumps, numbers)
    changed = [
        number
        for number in numbers
        if not _stands(jumps[number].decision, session.person, verdict, reason, note, blind)
    ]
    for number in changed:
        item = jumps[number]
        _state_verdict(
            session,
            found.run,
            item.signal_sha256,
            anchor_of(item.before),
            Verdict(verdict),
            reason,
            note,
            _found_as(found, item.before.apex_height_m),
            blind,
        )
    return changed


def move(
    book: Book,
    session: WriteSession,
    name: str,
    number: int,
    at_s: float,
    reason: str,
    note: str | None,
    found: RunReview | None = None,
    *,
    blind: bool = False,
) -> tuple[JudgedJump, bool]:
    """State that a jump has its apex at another time of its log, in s.

    Returns the jump as it is now, and whether that was stated: not where this person said the same last. Raises
    `UsageError` for a time at which no apex can be measured, or where another jump has its own. `found` and `blind` are
    those of `decide`.
    """
    found = judged_now(book, session, name, found)
    _refuse_unknown(found, [item.jump.number for item in found.jumps], [number])
    item = found.jumps[number - 1]
    others = [each for each in found.jumps if each is not item and each.signal_sha256 == item.signal_sha256]
    taken = [each for each in others if each.jump.apex_height_m is not None and jumps_near(at_s, [each.jump])]
    _refuse_taken(found, taken, at_s, f"reject jump {number} where that is the only jump of the two")
    anchor_s, height_m = anchor_of(item.before), item.before.apex_height_m
    return _place(book, session, found, item.signal_sha256, Verdict.MOVE, anchor_s, at_s, height_m, reason, note, blind)


def add(
    book: Book,
    session: WriteSession,
    name: str,
    at_s: float,
    reason: str,
    note: str | None,
    found: RunReview | None = None,
    *,
    log: int | None = None,
    blind: bool = False,
) -> tuple[JudgedJump, bool]:
    """State that a run has a jump that the detector has not, with its apex at a time of log number `log`, in s.

    Returns and raises as `move` does; `log` counts from 1, and may be left out where the run has one log.
    """
    found = judged_now(book, session, name, found)
    count = len(found.signals)
    if log is None and count > 1:
        raise UsageError(f"run {name} has {count} logs, each with its own time: add --log with a number up to {count}.")
    if log is not None and not 1 <= log <= count:
        raise UsageError(f"run {name} has no log {log}: give --log from 1 to {count}, or leave it out if that is 1.")
    sha256 = found.signals[(log or 1) - 1].sha256
    here = [item for item in found.jumps if item.signal_sha256 == sha256]
    repeated = [
        item for item in here if item.placed and item.placed.verdict is Verdict.ADD and item.placed.at_s == at_s
    ]
    if not repeated:
        taken = [item for item in here if jumps_near(at_s, [item.jump, item.before])]
        _refuse_taken(
            found, taken, at_s, f"give its apex another time with `labbook jumps move {name} NUMBER --at TIME`"
        )
    return _place(book, session, found, sha256, Verdict.ADD, at_s, at_s, None, reason, note, blind)


def _place(
    book: Book,
    session: WriteSession,
    found: RunReview,
    sha256: str,
    verdict: Verdict,
    anchor_s: float,
    at_s: float,
    height_m: float | None,
    reason: str,
    note: str | None,
    blind: bool,
) -> tuple[JudgedJump, bool]:
    """State where an apex is, unless this person said so last; of an added jump the height is kept that it has now."""
    _refuse_unknown_reason(reason)
    signal = next(one for one in found.signals if one.sha256 == sha256)
    length_m = rest_length_m(session.connection, found.run.robot_uid)
    apex = placed_apex(Detections(session.connection, book.store).log(signal), sha256, at_s, length_m)
    if apex.undefined_reason is not None:
        name = found.run.name
        raise UsageError(
            f"run {name} has no apex at {at_s:g} s: {apex.undefined_reason}; `labbook plot {name}` shows its flights."
        )
    standing = _placed_by(found, sha256, verdict, at_s)
    if standing is not None and _stands(standing.decision, session.person, verdict, reason, note, blind):
        return standing, False
    found_as = _found_as(found, apex.apex_height_m if verdict is Verdict.ADD else height_m)
    _state_verdict(session, found.run, sha256, anchor_s, verdict, reason, note, found_as, blind, at_s)
    now = _placed_by(
        _judged(book, session.connection, found.run, found.signals, found.detections), sha256, verdict, at_s
    )
    assert now is not None, (verdict, at_s)  # noqa: S101 - it was stated just now
    return now, True


def _placed_by(found: RunReview, sha256: str, verdict: Verdict, at_s: float) -> JudgedJump | None:
    """Return the jump whose apex such a verdict put at a time, if there is one."""
    of_signal = ((item, item.placed) for item in found.jumps if item.signal_sha256 == sha256 and item.placed)
    return next((item for item, said in of_signal if (said.verdict, said.at_s) == (verdict, at_s)), None)


def judged_now(book: Book, session: WriteSession, name: str, found: RunReview | None) -> RunReview:
    """Review a run in a session; verdicts may have come since it was `found`, also from a command that was cut off.

    Raises `UsageError` where jumps have other numbers than they had, or are of other logs.
    """
    run, signals = _usable(session.connection, name)
    if found is None:
        return _judged(book, session.connection, run, signals)
    if [one.sha256 for one in signals] != [one.sha256 for one in found.signals]:
        raise UsageError(
            f"the logs of run {name} were exchanged or read again meanwhile: see `labbook jumps list {name}`, and say "
            "it again."
        )
    now = _judged(book, session.connection, run, signals, found.detections)
    before, after = ([(item.signal_sha256, item.before.uid) for item in each.jumps] for each in (found, now))
    if before != after:
        raise UsageError(
            f"jumps of run {name} were added or taken back meanwhile, so that others have their numbers: see `labbook "
            f"jumps list {name}`, and say it again."
        )
    return now


def _refuse_taken(found: RunReview, taken: Sequence[JudgedJump], at_s: float, remedy: str) -> None:
    if taken:
        raise UsageError(f"run {found.run.name} has jump {taken[0].jump.number} at {at_s:g} s already: {remedy}.")


def _refuse_unknown_reason(reason: str) -> None:
    if reason not in tuple(ReasonCode):
        raise unknown_name("reason", reason, tuple(ReasonCode))


def _found_as(found: RunReview, height_m: float | None) -> dict[str, Any]:
    """Return what was found where a verdict is given, and by what."""
    detection = found.detections[0]
    return {"old_value": height_m, "algorithm": detection.algorithm, "version": detection.version}


def without_apex(found: RunReview, numbers: Collection[int]) -> list[str]:
    """Say which of these are no jumps: without an apex nothing of them counts, whatever the verdict."""
    return [
        f"{item.jump.number} of run {found.run.name} has no apex ({item.jump.undefined_reason}): it counts neither way."
        for item in found.jumps
        if item.jump.number in numbers and item.jump.apex_height_m is None
    ]


def _stands(
    standing: DecisionRow | None, person: str, verdict: str, reason: str, note: str | None, blind: bool
) -> bool:
    """Tell whether a verdict would repeat the standing one; one that is taken back leaves none."""
    if standing is None:
        return verdict == Verdict.CLEAR
    present = (standing.person, standing.verdict, standing.reason_code, standing.note, standing.blind)
    return present == (person, verdict, reason, note, blind)


def clear_waiting(book: Book, session: WriteSession, name: str, note: str | None, found: RunReview | None) -> int:
    """Take back the verdicts of a run that wait; returns how many.

    These are those on samples that are not in force, and those that fit no jump of the run, whose review is `found`;
    None where it cannot be reviewed.
    """
    run = run_named(session.connection, name)
    unfit = () if found is None else judged_now(book, session, name, found).waiting
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
    blind: bool = False,
    at_s: float | None = None,
) -> None:
    """State a verdict on the jump of a log at a time; `found_as` says what was found there, and by what.

    `at_s` is where its apex is, of a jump that is moved or added.
    """
    new = {
        "target_kind": str(TargetKind.JUMP),
        "target_uid": run.uid,
        "signal_sha256": signal_sha256,
        "anchor_s": anchor_s,
        "at_s": at_s,
        "verdict": str(verdict),
        "reason_code": str(reason),
        "note": note,
        "old_value": None,
        "algorithm": None,
        "version": None,
        **found_as,
        "blind": int(blind),
    }
    session.state(Statement(verdict.action, "decision", new_uid(), new=new, reason=note))


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
    return f"{_PAST[verdict.verdict]} by {verdict.person}{', blind' if verdict.blind else ''}"


_PAST = {
    Verdict.ACCEPT: "accepted",
    Verdict.REJECT: "rejected",
    Verdict.MOVE: "moved",
    Verdict.ADD: "added",
    Verdict.CLEAR: "taken back",
}


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
