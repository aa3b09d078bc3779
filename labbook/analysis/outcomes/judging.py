"""Which jumps count: what people decided, matched to the jumps at hand, and what the protocol excludes.

A verdict is tied to a signal and a time, not to a row, so it outlives the detector it was given under. It is matched
to the jump whose apex lies within half a flight time of its anchor, whichever detector found it. If the detector has a
new version that moves the apex by more than three standard errors, or no jump or several match, the verdict waits for
a person again, until a later verdict about the same moment settles it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from data_schema.queries.detections import DecisionRow, DetectionRow, JumpRow
from data_schema.vocabulary import Verdict

UNKNOWN_FLIGHT_S = 0.25
"""Flight time assumed for matching where a jump has none: that of a 7.7 cm hop."""
MOVED_STANDARD_ERRORS = 3.0


@dataclass(frozen=True, slots=True)
class JudgedJump:
    """A jump, numbered through the run, the signal it was found in, and why it does not count (None where it does)."""

    jump: JumpRow
    signal_sha256: str
    excluded: str | None
    decision: DecisionRow | None


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
    def in_force(self) -> tuple[DecisionRow, ...]:
        """The verdicts that stand: taken back or overruled ones say nothing any more."""
        return (*(item.decision for item in self.jumps if item.decision is not None), *self.waiting)


@dataclass(frozen=True, slots=True)
class Rules:
    """What the protocol excludes without asking."""

    exclude_first_jumps: int
    exclude_gap_jumps: bool


def judge(
    detections: Sequence[DetectionRow], decisions: Mapping[str, Sequence[DecisionRow]], rules: Rules
) -> Judgement:
    """Decide for every jump of a run whether it counts: a person's word first, then the protocol.

    `detections` are those of the run's logs one after the other; `decisions` are by signal.
    """
    parts: list[Judgement] = []
    for detection in detections:
        before = sum(len(part.jumps) for part in parts)
        jumps = tuple(replace(jump, number=before + jump.number) for jump in detection.jumps)
        said = decisions.get(detection.signal_sha256, [])
        parts.append(_judge_log(replace(detection, jumps=jumps), said, rules))
    return Judgement(
        tuple(jump for part in parts for jump in part.jumps), tuple(item for part in parts for item in part.waiting)
    )


def _judge_log(detection: DetectionRow, decisions: Sequence[DecisionRow], rules: Rules) -> Judgement:
    verdicts: dict[int, DecisionRow] = {}
    waiting: dict[float, DecisionRow] = {}
    for decision in decisions:
        jump = match(detection, decision)
        half_flight_s = UNKNOWN_FLIGHT_S / 2.0 if jump is None else _half_flight(jump)
        for anchor_s in [at_s for at_s in waiting if abs(at_s - decision.anchor_s) <= half_flight_s]:
            del waiting[anchor_s]
        if jump is None:
            waiting[decision.anchor_s] = decision
        elif decision.verdict is Verdict.CLEAR:
            verdicts.pop(jump.number, None)
        else:
            verdicts[jump.number] = decision
    judged = tuple(
        JudgedJump(
            jump, detection.signal_sha256, _excluded(jump, verdicts.get(jump.number), rules), verdicts.get(jump.number)
        )
        for jump in detection.jumps
    )
    return Judgement(judged, tuple(item for item in waiting.values() if item.verdict is not Verdict.CLEAR))


def match(detection: DetectionRow, decision: DecisionRow) -> JumpRow | None:
    """Return the one jump that a verdict is about, or None when it must be asked again.

    Another detector's apex differs by its nature, so only a new version of the same detector calls for a new review.
    """
    near = [jump for jump in detection.jumps if abs(anchor_of(jump) - decision.anchor_s) <= _half_flight(jump)]
    if len(near) != 1:
        return None
    jump = near[0]
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
