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
    return DetectionRow("d", "key", algorithm, version, "hash", "{}", jumps)


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


def placed(verdict: Verdict, anchor_s: float, at_s: float, person: str = "ada", height_m: float = 0.2) -> DecisionRow:
    return replace(said(verdict, anchor_s, height_m), uid=f"{verdict}{at_s}", at_s=at_s, person=person)


def judged_with(decisions: list[DecisionRow], *jumps: JumpRow, exclude_first: int = 0, version: int = 1) -> Judgement:
    """The judgement where an apex of 0.3 m is found at each time that a person named."""
    times = {one.at_s for one in decisions if one.at_s is not None}
    seen = {("hash", at_s): replace(jump(1, at_s, 0.3), uid=f"seen{at_s}") for at_s in times}
    found = detection(*(jumps or (jump(1, 1.0), jump(2, 2.0), jump(3, 3.0))), version=version)
    return judge_run([found], {"hash": decisions}, Rules(exclude_first, exclude_gap_jumps=False), seen)


def heights(judgement: Judgement) -> list[float | None]:
    return [item.apex_height_m for item in judgement.counted]


MOVE, ADD = placed(Verdict.MOVE, 2.0, 2.05), placed(Verdict.ADD, 1.5, 1.5, height_m=0.3)


def test_a_moved_apex_counts_as_others_do_and_stays_moved_when_it_is_accepted() -> None:
    found = judged_with([MOVE])
    assert heights(found) == [0.2, 0.3, 0.2]
    assert (found.jumps[1].jump.apex_s, found.jumps[1].jump.number) == (2.05, 2)
    assert "moved" in found.jumps[1].jump.flags
    assert found.in_force == (MOVE,)
    assert heights(judged_with([MOVE], exclude_first=2)) == [0.2]
    accept = replace(said(Verdict.ACCEPT, 2.0), uid="later", person="ben")
    found = judged_with([MOVE, accept], exclude_first=2)
    assert heights(found) == [0.3, 0.2]
    assert set(found.in_force) == {MOVE, accept}
    assert [one.person for one in found.jumps[1].verdicts] == ["ada", "ben"]
    assert heights(judged_with([MOVE, replace(accept, verdict=Verdict.REJECT)])) == [0.2, 0.2]
    assert heights(judged_with([replace(accept, verdict=Verdict.REJECT), MOVE])) == [0.2, 0.3, 0.2]
    found = judged_with([MOVE, accept, replace(accept, verdict=Verdict.CLEAR)])
    assert (heights(found), found.in_force) == ([0.2, 0.2, 0.2], ())


def test_a_later_place_replaces_an_earlier_one() -> None:
    other = placed(Verdict.MOVE, 2.0, 1.98, "ben")
    found = judged_with([MOVE, other])
    assert (found.jumps[1].jump.apex_s, found.jumps[1].placed, found.in_force) == (1.98, other, (other,))


def test_a_misfire_can_be_given_an_apex_and_a_jump_lose_it() -> None:
    lost = replace(jump(2, 2.0, None), apex_s=None)
    at_touchdown = placed(Verdict.MOVE, 1.8, 2.05)
    assert heights(judged_with([at_touchdown], jump(1, 1.0), lost)) == [0.2, 0.3]
    nothing = {("hash", 2.05): replace(jump(1, 2.05, None), undefined_reason="no flight")}
    found = judge_run([detection(jump(1, 1.0), jump(2, 2.0))], {"hash": [MOVE]}, RULES, nothing)
    assert [item.excluded for item in found.jumps] == [None, "no flight"]


def test_an_added_jump_stands_in_its_place_and_the_others_keep_their_verdicts() -> None:
    reject = replace(said(Verdict.REJECT, 2.0), uid="r")
    found = judged_with([reject, ADD])
    assert [(item.jump.number, item.jump.apex_s) for item in found.jumps] == [(1, 1.0), (2, 1.5), (3, 2.0), (4, 3.0)]
    assert "added" in found.jumps[1].jump.flags
    assert states(found) == [True, True, False, True]
    assert heights(judged_with([ADD], exclude_first=2)) == [0.2, 0.2]
    rejected = replace(said(Verdict.REJECT, 1.5), uid="no", person="ben")
    assert states(judged_with([ADD, rejected])) == [True, False, True, True]
    moved = placed(Verdict.MOVE, 1.5, 1.52, "ben")
    found = judged_with([ADD, moved])
    assert [item.jump.apex_s for item in found.jumps] == [1.0, 1.52, 2.0, 3.0]
    cleared = judged_with([ADD, moved, replace(rejected, verdict=Verdict.CLEAR)])
    assert len(cleared.jumps) == 3
    assert cleared.in_force == ()
    again = judged_with([ADD, replace(rejected, verdict=Verdict.CLEAR), replace(ADD, uid="again")])
    assert [one.uid for one in again.jumps[1].verdicts] == ["again"]


def test_a_jump_that_a_new_version_finds_where_it_was_added_is_not_there_twice() -> None:
    """As other verdicts, the statement holds where the height is the one that was seen, and else waits."""
    jumps = (jump(1, 1.0), jump(2, 1.52, 0.3), jump(3, 2.0))
    found = judged_with([ADD], *jumps, version=2)
    assert [item.jump.apex_s for item in found.jumps] == [1.0, 1.5, 2.0]
    assert found.jumps[1].placed == ADD
    found = judged_with([ADD], jump(1, 1.0), jump(2, 1.52, 0.35), version=2)
    assert [item.jump.apex_s for item in found.jumps] == [1.0, 1.52]
    assert found.waiting == (ADD,)
    nowhere = placed(Verdict.MOVE, 9.0, 9.1)
    assert judged_with([nowhere]).waiting == (nowhere,)


def test_an_added_jump_of_a_second_log_is_numbered_through() -> None:
    first, second = detection(jump(1, 1.0)), replace(detection(jump(1, 1.0), jump(2, 2.0)), signal_sha256="other")
    seen = {("other", 1.5): replace(jump(1, 1.5, 0.3), uid="seen")}
    found = judge_run([first, second], {"other": [replace(ADD, signal_sha256="other")]}, RULES, seen)
    assert [(item.jump.number, item.jump.apex_s) for item in found.jumps] == [(1, 1.0), (2, 1.0), (3, 1.5), (4, 2.0)]
