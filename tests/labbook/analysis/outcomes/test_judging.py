"""Which jump a verdict is about, after another detector or a new version has looked at the log."""

from __future__ import annotations

from dataclasses import replace

import pytest

from data_schema.queries.detections import DecisionRow, DetectionRow, JumpRow
from data_schema.vocabulary import ReasonCode, Verdict
from labbook.analysis.outcomes.run_apexes import Judgement, Rules
from labbook.analysis.outcomes.run_apexes import judge as judge_run

RULES = Rules(exclude_first_jumps=0, exclude_gap_jumps=False)


def jump(number: int, apex_s: float, height_m: float | None = 0.2, se_m: float | None = 0.001) -> JumpRow:
    reason = None if height_m is not None else "too few samples"
    return JumpRow(
        f"j{number}", number, apex_s - 0.2, apex_s - 0.15, apex_s, height_m, se_m, reason, 0.3, 60, False, ()
    )


def detection(*jumps: JumpRow, algorithm: str = "robust", version: int = 1) -> DetectionRow:
    return DetectionRow("d", "key", algorithm, version, "s", "hash", "{}", jumps)


def said(verdict: Verdict, anchor_s: float = 1.0, height_m: float = 0.2, version: int = 1) -> DecisionRow:
    reason, at_utc = ReasonCode.OTHER, f"2026-01-0{version}T00:00:00Z"
    return DecisionRow(
        f"v{version}", "hash", anchor_s, verdict, reason, None, height_m, "robust", version, "ada", at_utc, blind=False
    )


def judge(found: DetectionRow, decisions: list[DecisionRow], rules: Rules) -> Judgement:
    """The judgement of a run with one log."""
    return judge_run([found], {found.signal_sha256: decisions}, rules)


def states(judgement: Judgement) -> list[bool]:
    return [item.excluded is None for item in judgement.jumps]


REJECT, ACCEPT, CLEAR = said(Verdict.REJECT), said(Verdict.ACCEPT), said(Verdict.CLEAR)


@pytest.mark.parametrize(("height_m", "se_m"), [(0.2, 0.001), (0.25, 0.001), (0.25, None)])
def test_a_verdict_stands_with_another_detector(height_m: float, se_m: float | None) -> None:
    other = detection(jump(1, 1.1, height_m, se_m), jump(2, 1.6), algorithm="published")
    assert states(judge(other, [REJECT], RULES)) == [False, True]
    excluding = Rules(exclude_first_jumps=1, exclude_gap_jumps=False)
    assert states(judge(other, [ACCEPT], excluding)) == [True, True]


def test_another_detector_with_no_jump_or_two_near_the_anchor_waits() -> None:
    for jumps in ([jump(1, 1.2)], [jump(1, 0.9), jump(2, 1.1)]):
        found = judge(detection(*jumps, algorithm="published"), [REJECT], RULES)
        assert all(states(found))
        assert found.waiting == (REJECT,)


@pytest.mark.parametrize(
    ("height_m", "se_m", "stands"),
    [(0.2029, 0.001, True), (0.2031, 0.001, False), (0.3, None, True), (None, None, False)],
)
def test_a_new_version_that_moves_the_apex_asks_again(height_m: float | None, se_m: float | None, stands: bool) -> None:
    found = judge(detection(jump(1, 1.0, height_m, se_m), version=2), [REJECT], RULES)
    assert (found.waiting == ()) is stands
    assert (found.jumps[0].decision == REJECT) is stands


def test_a_later_verdict_settles_a_waiting_one() -> None:
    new = detection(jump(1, 1.05, 0.3), version=2)
    later = said(Verdict.ACCEPT, 1.05, 0.3, version=2)
    found = judge(new, [REJECT, later], RULES)
    assert found.waiting == ()
    assert found.jumps[0].decision == later
    assert found.in_force == (later,)


def test_clear_removes_a_waiting_verdict_near_it_and_of_two_the_later_waits() -> None:
    nothing_near = detection(jump(1, 5.0))
    assert judge(nothing_near, [REJECT, said(Verdict.CLEAR, 1.05)], RULES).waiting == ()
    assert judge(nothing_near, [REJECT, said(Verdict.CLEAR, 2.0)], RULES).waiting == (REJECT,)
    accept = said(Verdict.ACCEPT, 1.05)
    assert judge(detection(), [REJECT, accept], RULES).waiting == (accept,)


def test_the_jumps_of_a_run_that_was_started_again_are_numbered_through() -> None:
    first = detection(jump(1, 1.0), jump(2, 2.0))
    second = replace(first, signal_sha256="other", jumps=(jump(1, 1.0), jump(2, 3.0)))
    again = replace(REJECT, signal_sha256="other")
    found = judge_run([first, second], {"other": [again]}, Rules(exclude_first_jumps=1, exclude_gap_jumps=False))
    assert [item.jump.number for item in found.jumps] == [1, 2, 3, 4]
    assert [item.signal_sha256 for item in found.jumps] == ["hash", "hash", "other", "other"]
    assert states(found) == [False, True, False, True]  # the first of the run, and the first of the second log
    assert found.jumps[2].decision == again
