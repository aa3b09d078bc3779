"""The jumps of a whole book, or of some of its runs, in the order in which a person looks at them.

The doubtful first: doubt adds up what the detector flagged, what the checks say, and how far a jump lies from the other
ones of its run. It orders jumps and is no probability. Drawn at random, the order depends on the jumps and the seed
alone, not on what was said of them, so that a review can go on another day.
"""

from __future__ import annotations

import statistics
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from data_schema.errors import UsageError
from data_schema.queries.detections import DecisionRow, jump_decisions
from data_schema.queries.runs import RunRow, list_runs, refuse_empty_selection, where_columns
from data_schema.vocabulary import ReviewOrder, RunKind, RunState
from data_schema.where import compile_where
from labbook.actions.runs.jump_review import logs_of
from labbook.analysis.outcomes.detection import Detections
from labbook.analysis.outcomes.run_apexes import (
    JudgedJump,
    Judgement,
    anchor_of,
    by_protocol,
    judge_runs,
    to_review,
)
from labbook.config.parsing import Configuration
from labbook.plan.drawing import SeededChance
from stats.apexes.jumps import FLAGS
from stats.compare.summary import robust_z


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
    every, left_out = jumps_by_run(detections, configuration, where)
    if order is ReviewOrder.DOUBT:
        every.sort(key=lambda item: -item.doubt)  # stable: as doubtful ones by run
    elif seed is not None:
        every = SeededChance(seed).shuffled(every)
    return ReviewQueue(order, seed, tuple(item for item in every if not unreviewed or item.decision is None), left_out)


def jumps_by_run(
    detections: Detections, configuration: Configuration, where: str | None = None
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
    return [item for run in runs if run.uid in judged for item in _queued(run, judged[run.uid].judgement)], left_out


def _queued(run: RunRow, judgement: Judgement) -> Iterable[QueuedJump]:
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


def queue_lines(queue: ReviewQueue) -> tuple[tuple[str, ...], list[tuple[str, ...]], list[str]]:
    """Return head and rows of the queue, and a line of runs without jumps by reason."""
    head = ("run", "jump", "at", "height", "doubt", "verdict", "why doubtful")
    rows: list[tuple[str, ...]] = [
        (
            item.run,
            str(item.number),
            f"{item.anchor_s if item.apex_s is None else item.apex_s:.3f} s",
            "" if item.apex_height_m is None else f"{item.apex_height_m * 1e3:.2f} mm",
            f"{item.doubt:.2f}",
            "" if item.decision is None else f"{item.decision.verdict} by {item.decision.person}",
            "; ".join(reason.words for reason in item.reasons),
        )
        for item in queue.jumps
    ]
    by_reason: dict[str, list[str]] = {}
    for name, why in queue.left_out.items():
        by_reason.setdefault(why, []).append(name)
    return head, rows, [f"no jumps of {', '.join(names)}: {why}." for why, names in by_reason.items()]
