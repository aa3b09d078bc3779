"""The jumps of one run, or of a whole book, with the verdicts on them; giving verdicts, and how far people agree.

Over a book the doubtful come first: doubt adds up what the detector flagged, what the checks say, and how far a jump
lies from the other ones of its run. It orders jumps and is no probability. Drawn at random, the order depends on the
jumps and the seed alone, not on what was said of them, so that a review can go on another day.
"""

from __future__ import annotations

import contextlib
import itertools
import re
import statistics
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import sqlalchemy as sa

from data_schema.errors import UsageError, unknown_name
from data_schema.grouping import grouped
from data_schema.queries.detections import DecisionRow, DetectionRow, WaitingVerdict, jump_decisions, verdicts_waiting
from data_schema.queries.files import waiting_files
from data_schema.queries.runs import RunRow, list_runs, refuse_empty_selection, where_columns
from data_schema.queries.signals import SignalRow, signals_of_runs
from data_schema.reasons import Reason
from data_schema.vocabulary import (
    REASONS,
    FileRole,
    ReasonCode,
    ReviewOrder,
    RunKind,
    RunState,
    TargetKind,
    Undefined,
    Verdict,
)
from data_schema.where import compile_where
from labbook.analysis.outcomes.detection import BODY_HEIGHT, Detections, placed_apex, rest_length_m
from labbook.analysis.outcomes.run_apexes import (
    JudgedJump,
    Judgement,
    Reviewed,
    anchor_of,
    by_protocol,
    judge_runs,
    jumps_near,
    not_reviewed,
    reviewed,
    to_review,
    usable_logs,
)
from labbook.analysis.preregistration.planned import AS_A_WHOLE, is_allowed, planned_analysis
from labbook.book.naming import run_named
from labbook.book.opening import Book
from labbook.book.write_session import Statement, WriteSession, new_uid
from labbook.config.parsing import Configuration
from labbook.plan.drawing import SeededChance
from labbook.terminal import columns, listed
from stats.apexes.jumps import FLAGS
from stats.compare.agreement import Kappa, cohen_kappa
from stats.compare.summary import robust_z


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

    def jump(self, number: int) -> JudgedJump:
        """Return a jump by its number; raises `UsageError` where the run has none."""
        if not 1 <= number <= len(self.jumps):
            name = self.run.name
            raise UsageError(
                f"run {name} has no jump {number}: it has {len(self.jumps)}, `labbook jumps list {name}` shows them."
            )
        return self.jumps[number - 1]


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
    of_logs = signals_of_runs(connection, FileRole.LOG, [run.uid for run in runs])
    signals = [one for one in of_logs if BODY_HEIGHT in one.channels]
    by_run = grouped(signals, [signal.run_uid for signal in signals])
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


_NUMBERS = re.compile(r"([0-9]{1,9})(?:-([0-9]{1,9}))?")


def resolve_jumps(texts: Sequence[str], found: RunReview) -> list[int]:
    """Read numbers of jumps and ranges of them, `4` or `3-5`, each jump once.

    Raises `UsageError` for what is neither, and for a jump that the run does not have.
    """
    numbers: dict[int, None] = {}
    for text in texts:
        match = _NUMBERS.fullmatch(text.strip())
        if match is None:
            raise UsageError(f"{text!r} names no jump: write a number or a range, for example 4 or 3-5.")
        first, last = int(match[1]), int(match[2] or match[1])
        if last < first:
            raise UsageError(f"{text!r} runs backwards: write {last}-{first}.")
        for number in range(first, last + 1):
            numbers[found.jump(number).jump.number] = None
    return list(numbers)


class _Said(NamedTuple):
    """What a person says of a jump; `at_s` is where its apex is, of one that is moved or added."""

    person: str
    verdict: Verdict
    reason: str
    note: str | None
    blind: bool
    at_s: float | None = None

    def stands(self, standing: DecisionRow | None) -> bool:
        """Tell whether it repeats the standing verdict; one that is taken back leaves none."""
        if standing is None:
            return self.verdict is Verdict.CLEAR
        present = (standing.person, standing.verdict, standing.reason_code, standing.note, standing.blind)
        return present == self[:5]


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
    found = judged_now(book, session, name, found)
    said = _Said(session.person, Verdict(verdict), reason, note, blind)
    changed = [item for item in map(found.jump, numbers) if not said.stands(item.decision)]
    for item in changed:
        before = item.before
        _state(
            session, found.run, item.signal_sha256, anchor_of(before), said, found.detections[0], before.apex_height_m
        )
    return [item.jump.number for item in changed]


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
    item = found.jump(number)
    others = [each for each in found.jumps if each is not item and each.signal_sha256 == item.signal_sha256]
    taken = [each for each in others if each.jump.apex_height_m is not None and jumps_near(at_s, [each.jump])]
    _refuse_taken(found, taken, at_s, f"reject jump {number} where that is the only jump of the two")
    said = _Said(session.person, Verdict.MOVE, reason, note, blind, at_s)
    return _place(book, session, found, item.signal_sha256, said, item)


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
    sha256, said = found.signals[(log or 1) - 1].sha256, _Said(session.person, Verdict.ADD, reason, note, blind, at_s)
    if _placed_by(found, sha256, said) is None:
        here = [item for item in found.jumps if item.signal_sha256 == sha256]
        taken = [item for item in here if jumps_near(at_s, [item.jump, item.before])]
        _refuse_taken(
            found, taken, at_s, f"give its apex another time with `labbook jumps move {name} NUMBER --at TIME`"
        )
    return _place(book, session, found, sha256, said)


def _refuse_taken(found: RunReview, taken: Sequence[JudgedJump], at_s: float, remedy: str) -> None:
    if taken:
        raise UsageError(f"run {found.run.name} has jump {taken[0].jump.number} at {at_s:g} s already: {remedy}.")


def _place(
    book: Book, session: WriteSession, found: RunReview, sha256: str, said: _Said, moved: JudgedJump | None = None
) -> tuple[JudgedJump, bool]:
    """State where an apex is, unless this person said so last; of an added jump the height is kept that it has now."""
    connection, run, at_s = session.connection, found.run, said.at_s or 0.0
    (signal,) = (one for one in found.signals if one.sha256 == sha256)
    log = Detections(connection, book.store).log(signal)
    apex = placed_apex(log, sha256, at_s, rest_length_m(connection, run.robot_uid))
    if apex.undefined_reason is not None:
        raise UsageError(
            f"run {run.name} has no apex at {at_s:g} s: {apex.undefined_reason}; `labbook plot {run.name}` shows its "
            "flights."
        )
    standing = _placed_by(found, sha256, said)
    if standing is not None and said.stands(standing.decision):
        return standing, False
    anchor_s, height_m = at_s, apex.apex_height_m
    if moved is not None:
        anchor_s, height_m = anchor_of(moved.before), moved.before.apex_height_m
    _state(session, run, sha256, anchor_s, said, found.detections[0], height_m)
    now = _placed_by(_judged(book, connection, run, found.signals, found.detections), sha256, said)
    assert now is not None, said  # noqa: S101 - it was stated just now
    return now, True


def _placed_by(found: RunReview, sha256: str, said: _Said) -> JudgedJump | None:
    """Return the jump whose apex such a verdict put at its time, if there is one."""
    for item in found.jumps:
        placed = item.placed
        if item.signal_sha256 == sha256 and placed and (placed.verdict, placed.at_s) == (said.verdict, said.at_s):
            return item
    return None


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


def clear_waiting(book: Book, session: WriteSession, name: str, note: str | None, found: RunReview | None) -> int:
    """Take back the verdicts of a run that wait; returns how many.

    These are those on samples that are not in force, and those that fit no jump of the run, whose review is `found`;
    None where it cannot be reviewed.
    """
    run = run_named(session.connection, name)
    unfit = () if found is None else judged_now(book, session, name, found).waiting
    waiting: list[WaitingVerdict | DecisionRow] = [*verdicts_waiting(session.connection, run.uid), *unfit]
    said = _Said(session.person, Verdict.CLEAR, ReasonCode.OTHER, note, False)
    for verdict in waiting:
        _state(session, run, verdict.signal_sha256, verdict.anchor_s, said)
    return len(waiting)


def _state(
    session: WriteSession,
    run: RunRow,
    sha256: str,
    anchor_s: float,
    said: _Said,
    by: DetectionRow | None = None,
    height_m: float | None = None,
) -> None:
    """State a verdict on the jump of a log at a time, where a height was found, and by what."""
    reasons = REASONS.get(said.verdict, tuple(ReasonCode))
    if said.reason not in reasons:
        if said.reason in tuple(ReasonCode):
            raise UsageError(
                f"{said.reason} is no reason to {said.verdict} a jump: give {', '.join(reasons[:-1])} or {reasons[-1]}."
            )
        raise unknown_name("reason", said.reason, reasons)
    new = {
        "target_kind": str(TargetKind.JUMP),
        "target_uid": run.uid,
        "signal_sha256": sha256,
        "anchor_s": anchor_s,
        "at_s": said.at_s,
        "verdict": str(said.verdict),
        "reason_code": str(said.reason),
        "note": said.note,
        "old_value": height_m,
        "algorithm": by and by.algorithm,
        "version": by and by.version,
        "blind": int(said.blind),
    }
    session.state(Statement(said.verdict.action, "decision", new_uid(), new=new, reason=said.note))


def without_apex(found: RunReview, numbers: Collection[int]) -> list[str]:
    """Say which of these are no jumps: without an apex nothing of them counts, whatever the verdict."""
    return [
        f"{item.jump.number} of run {found.run.name} has no apex ({item.jump.undefined_reason}): it counts neither way."
        for item in found.jumps
        if item.jump.number in numbers and item.jump.apex_height_m is None
    ]


def _unless_none(value: float | None, form: str, factor: float = 1.0) -> str:
    return "" if value is None else form.format(factor * value)


def jump_lines(found: RunReview) -> tuple[tuple[str, ...], list[tuple[str, ...]], list[str]]:
    """Return head and rows of the list of jumps, and lines: what the flags in it mean, and each verdict that waits."""
    head = ("jump", "touchdown", "apex", "height", "+-", "flight time", "counts", "reviewed", "flags")
    rows: list[tuple[str, ...]] = [
        (
            str(item.jump.number),
            _unless_none(item.jump.touchdown_s, "{:.3f} s"),
            _unless_none(item.jump.apex_s, "{:.3f} s"),
            _unless_none(item.jump.apex_height_m, "{:.2f} mm", 1e3),
            _unless_none(item.jump.apex_height_se_m, "{:.2f} mm", 1e3),
            _unless_none(item.jump.flight_time_s, "{:.0f} ms", 1e3),
            "yes" if item.excluded is None else f"no: {item.excluded}",
            "" if item.decision is None else _verdict_text(item.decision),
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


_PAST = {
    Verdict.ACCEPT: "accepted",
    Verdict.REJECT: "rejected",
    Verdict.MOVE: "moved",
    Verdict.ADD: "added",
    Verdict.CLEAR: "taken back",
}


def _verdict_text(verdict: DecisionRow | Reviewed) -> str:
    return f"{_PAST[verdict.verdict]} by {verdict.person}{', blind' if verdict.blind else ''}"


def review_lines(found: Sequence[Reviewed], others: Sequence[int]) -> list[str]:
    """Say which jumps of a run were reviewed, by whom, and how many were not; nothing where there are none."""
    lines = []
    for item in found:
        jumps = f"jump{'s' if len(item.jumps) > 1 else ''} {listed([*map(str, item.jumps)])}"
        lines.append(f"{jumps} {_verdict_text(item)} ({item.reason_code})")
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
    allowed = ", ".join(map(str, planned.settings.exclusions)) or "no reason"
    cure = f" {remedy}" if remedy and planned.settings.exclusions else ""
    return [f"[analysis] allows {allowed}, so the report calls {concerned} exploratory ({reason}): {AS_A_WHOLE}.{cure}"]


@dataclass(frozen=True, slots=True)
class DoubtReason:
    """Why a jump is doubtful: a detector's flag or a check by name, in words, and how much it adds to the score."""

    name: str
    words: str
    weight: float


@dataclass(frozen=True, slots=True)
class QueuedJump:
    """A jump to look at: jump `number` of a run, in a signal; verdicts are tied to `anchor_s`, where it was found.

    `apex_s` is where its apex is, also where a person put it.
    `doubt` is the sum of the weights of its reasons, heaviest first. `excluded` says why the jump does not count, None
    where it does. `decision` is the verdict that stands, `verdicts` are the last ones of each person.
    """

    run_uid: str
    run: str
    signal_sha256: str
    number: int
    anchor_s: float
    apex_s: float | None
    apex_height_m: float | None
    apex_height_se_m: float | None
    doubt: float
    reasons: tuple[DoubtReason, ...]
    excluded: str | None
    decision: DecisionRow | None
    verdicts: tuple[DecisionRow, ...]

    @property
    def at(self) -> str:
        """When it is, in words."""
        return f"{self.anchor_s if self.apex_s is None else self.apex_s:.3f} s"


@dataclass(frozen=True, slots=True)
class ReviewQueue:
    """Jumps in their order; `seed` is that of a shuffled one. `left_out` says why runs of jumps have none, by name."""

    order: ReviewOrder
    seed: int | None
    jumps: tuple[QueuedJump, ...]
    left_out: Mapping[str, str]


def review_queue(
    detections: Detections,
    configuration: Configuration,
    order: ReviewOrder = ReviewOrder.DOUBT,
    seed: int | None = None,
    where: str | None = None,
    *,
    unreviewed: bool = False,
) -> ReviewQueue:
    """Return the jumps of the runs that fulfil `where`, void ones left out; `unreviewed`: without a standing verdict.

    Stored jumps are read at once and no signal is; those of a detector that the protocol names since the ingest are
    found first. Raises `UsageError` for a shuffled order without a seed, a seed for another order, and a `where` that
    no run fulfils.
    """
    if (seed is None) is (order is ReviewOrder.SHUFFLED):
        raise UsageError(
            "a shuffled order needs a seed: add for example --seed 7, the same seed gives the same order."
            if seed is None
            else f"--seed {seed} has no use with --order {order}: leave it out, or give --order shuffled."
        )
    every, left_out = _jumps_by_run(detections, configuration, where)
    if order is ReviewOrder.DOUBT:
        every.sort(key=lambda item: -item.doubt)  # stable: as doubtful ones by run
    elif seed is not None:
        every = SeededChance(seed).shuffled(every)
    return ReviewQueue(order, seed, tuple(item for item in every if not unreviewed or item.decision is None), left_out)


def _jumps_by_run(
    detections: Detections, configuration: Configuration, where: str | None
) -> tuple[list[QueuedJump], dict[str, str]]:
    """Return the jumps of the selected runs by day, position and number, and why the other runs of jumps have none."""
    connection = detections.connection
    refuse_empty_selection(connection, where)
    selected = list_runs(connection, compile_where(where, where_columns(connection)) if where else None)
    runs = [run for run in selected if run.kind is RunKind.JUMPS and run.state is not RunState.VOID]
    logs, without = logs_of(connection, runs)
    left_out = {run.name: without[run.uid].reason for run in runs if run.uid in without}
    hashes = sorted({log.sha256 for several in logs.values() for log in several})
    judged = judge_runs(detections, runs, logs, jump_decisions(connection, hashes), by_protocol(configuration.protocol))
    return [
        item for run in runs if run.uid in judged for item in queued_jumps(run, judged[run.uid].judgement)
    ], left_out


def queued_jumps(run: RunRow, judgement: Judgement) -> Iterable[QueuedJump]:
    """Give the jumps of a run with what is doubtful about each, seen beside the others."""
    heights = {item.jump.number: item.jump.apex_height_m for item in judgement.jumps}
    errors_m = [item.jump.apex_height_se_m for item in judgement.jumps if item.jump.apex_height_se_m is not None]
    usual_se_m = statistics.median(errors_m) if len(errors_m) >= LEAST_JUMPS else None
    known = {number: height_m for number, height_m in heights.items() if height_m is not None}
    far = dict(zip(known, robust_z([*known.values()], least=usual_se_m or 0.0), strict=True))
    last = {item.signal_sha256: item.jump.number for item in judgement.jumps}
    for item in to_review(judgement.jumps):
        z = far.get(item.jump.number, 0.0) if len(known) >= LEAST_JUMPS else 0.0
        landing = item.jump.number == last[item.signal_sha256]
        reasons = sorted(_reasons(item, z, usual_se_m, landing), key=lambda reason: -reason.weight)
        yield QueuedJump(
            run_uid=run.uid,
            run=run.name,
            signal_sha256=item.signal_sha256,
            number=item.jump.number,
            anchor_s=anchor_of(item.before),
            apex_s=item.jump.apex_s,
            apex_height_m=item.jump.apex_height_m,
            apex_height_se_m=item.jump.apex_height_se_m,
            doubt=round(sum(reason.weight for reason in reasons), 3),
            reasons=tuple(reasons),
            excluded=item.excluded,
            decision=item.decision,
            verdicts=item.verdicts,
        )


LEAST_JUMPS = 5
"""With fewer jumps in a run, none lies far from the others."""
FAR_Z = 3.5
"""Robust z from which on a value counts as an outlier (Iglewicz and Hoaglin 1993)."""
WIDE_RATIO = 3.0
"""Standard errors so many times the usual one of the run are wide."""
MOST = 3.0
"""What one reason adds at most."""
WEIGHTS = {"no_apex": 2.0, "curvature_off": 2.0, "landing_extrapolated": 0.0, "moved": 0.0, "added": 0.0}
"""What flags and checks add that do not add 1. A height far off, or a wide error, adds 1 where it begins to count, and
more in proportion. A landing that was not seen bears on the flight time alone, and is no doubt."""


def _reasons(item: JudgedJump, z: float, usual_se_m: float | None, landing: bool) -> Iterable[DoubtReason]:
    """Give the reasons to doubt a jump; `landing`: it is the last stance of a log, which no flight follows."""
    jump = item.jump
    flags = {flag: FLAGS[flag] for flag in jump.flags}
    if jump.undefined_reason is not None and not landing:
        flags["no_apex"] = jump.undefined_reason
    if jump.gap_touched:
        flags["gap_touched"] = "samples are missing in the flight"
    for name, words in flags.items():
        if weight := WEIGHTS.get(name, 1.0):
            yield DoubtReason(name, words, weight)
    if abs(z) >= FAR_Z:
        side = "higher" if z > 0 else "lower"
        words = f"{side} than the other jumps of the run (robust z {z:.1f})"
        yield DoubtReason("height_far", words, min(abs(z) / FAR_Z, MOST))
    if usual_se_m and jump.apex_height_se_m is not None and jump.apex_height_se_m >= WIDE_RATIO * usual_se_m:
        ratio = jump.apex_height_se_m / usual_se_m
        words = f"the standard error of its height is {ratio:.1f} times the usual one of the run"
        yield DoubtReason("wide_error", words, min(ratio / WIDE_RATIO, MOST))


def queue_lines(queue: ReviewQueue) -> list[str]:
    """Return the queue for people, and a line of runs without jumps by reason."""
    head = ("run", "jump", "at", "height", "doubt", "verdict", "why doubtful")
    rows = [
        (
            item.run,
            item.number,
            item.at,
            _unless_none(item.apex_height_m, "{:.2f} mm", 1e3),
            f"{item.doubt:.2f}",
            item.decision and f"{item.decision.verdict} by {item.decision.person}",
            "; ".join(reason.words for reason in item.reasons),
        )
        for item in queue.jumps
    ]
    by_reason = grouped(queue.left_out, queue.left_out.values())
    without = [f"no jumps of {', '.join(names)}: {why}." for why, names in by_reason.items()]
    return [*columns(head, rows, "no jumps."), *without]


@dataclass(frozen=True, slots=True)
class Agreement:
    """Two people's verdicts on the same jumps: Cohen's kappa with the counts, and the jumps on which they differ.

    Each person's last verdict is meant. Of the jumps, `both_blind` had both verdicts given blind. `differ` is by run,
    day and number.
    """

    first: str
    second: str
    kappa: Kappa
    both_blind: int
    differ: tuple[QueuedJump, ...]

    @property
    def sentences(self) -> list[str]:
        """How far they agree."""
        names, kappa = (self.first, self.second), self.kappa
        counts = [
            f"{count} {one}" if one == other else f"{count} {one} by {names[0]}, {other} by {names[1]}"
            for one, row in zip(kappa.answers, kappa.counts, strict=True)
            for other, count in zip(kappa.answers, row, strict=True)
            if count
        ]
        counted = [f"{'; '.join(counts)}. Both blind: {self.both_blind}."] if counts else []
        return [kappa.sentence(names, "jump"), *counted]


def agreement(
    detections: Detections,
    configuration: Configuration,
    people: tuple[str, str] | None = None,
    where: str | None = None,
) -> tuple[Agreement, ...]:
    """Return how two people agree, or without these all pairs who gave verdicts on the same jumps, by name.

    Of the runs that fulfil `where`, void ones left out. A verdict that was taken back is none.
    """
    jumps, _left_out = _jumps_by_run(detections, configuration, where)
    said = [(item, {verdict.person: verdict for verdict in item.verdicts}) for item in jumps if item.verdicts]
    if people is not None:
        return (_agreement(*people, said),)
    everyone = sorted({person for _item, verdicts in said for person in verdicts})
    found = (_agreement(first, second, said) for first, second in itertools.combinations(everyone, 2))
    return tuple(one for one in found if one.kappa.n)


def _agreement(first: str, second: str, said: Sequence[tuple[QueuedJump, Mapping[str, DecisionRow]]]) -> Agreement:
    both = [(item, verdicts[first], verdicts[second]) for item, verdicts in said if {first, second} <= verdicts.keys()]
    return Agreement(
        first,
        second,
        cohen_kappa([_answer(one) for _item, one, _ in both], [_answer(other) for *_, other in both]),
        sum(one.blind and other.blind for _item, one, other in both),
        tuple(item for item, one, other in both if _answer(one) != _answer(other)),
    )


def _answer(said: DecisionRow) -> str:
    """Return what a person answers to the question whether this is a jump: who adds or moves one says yes."""
    return str(Verdict.ACCEPT if said.verdict in (Verdict.ADD, Verdict.MOVE) else said.verdict)


def agreement_lines(found: Agreement) -> list[str]:
    """Return the agreement in sentences, and the jumps on which they differ."""
    rows = []
    for item in found.differ:
        said = {one.person: f"{one.verdict} ({one.reason_code})" for one in item.verdicts}
        rows.append((item.run, item.number, item.at, said[found.first], said[found.second]))
    head = ("run", "jump", "at", found.first, found.second)
    return [*found.sentences, *(columns(head, rows) if rows else ())]
