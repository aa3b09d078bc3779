"""What a plan promises, over random sets of factors, and chance that never changes."""

from __future__ import annotations

import itertools
from collections import Counter
from typing import Any

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from data_schema.errors import UsageError
from data_schema.vocabulary import PlanMethod, RunKind
from labbook.plan.drawing import Plan, PlanFactor, PlannedRun, SeededChance, draw_plan
from tests.helpers.wording import refuses

CHAPTER_5 = (
    PlanFactor("foot", ("small", "large")),
    PlanFactor("k_gain", ("300", "400")),
    PlanFactor("b_ad_gain", ("0", "50", "100", "150", "200", "250"), control="0"),
)


@st.composite
def factor_sets(draw: st.DrawFn, treated: bool | None = None) -> tuple[PlanFactor, ...]:
    factors = [
        PlanFactor(f"factor_{n}", tuple(f"level {level}" for level in range(draw(st.integers(1, 3)))))
        for n in range(draw(st.integers(0, 3)))
    ]
    if treated or (treated is None and draw(st.booleans())):
        levels = tuple(str(level) for level in range(draw(st.integers(1, 6))))
        treatment = PlanFactor("treatment", levels, draw(st.sampled_from(levels)))
        factors.insert(draw(st.integers(0, len(factors))), treatment)
    return tuple(factors)


@st.composite
def requests(draw: st.DrawFn, treated: bool | None = None) -> dict[str, Any]:
    factors = draw(factor_sets(treated))
    has_treatment = any(factor.control is not None for factor in factors)
    return {
        "factors": factors,
        "runs_per_condition": draw(st.integers(1, 5)),
        "runs_per_day": draw(st.integers(2 if has_treatment else 1, 14)),
        "method": draw(st.sampled_from(PlanMethod)),
        "seed": draw(st.integers(0, 2**63 - 1)),
        "idle_minutes": draw(st.lists(st.sampled_from([20, 24, 30, 40, 50, 60]), max_size=7)),
        "run_duration_s": draw(st.sampled_from([None, 720.0])),
    }


def control_of(plan: Plan) -> PlanFactor | None:
    return next((factor for factor in plan.factors if factor.control is not None), None)


def group_of(run: PlannedRun, plan: Plan) -> tuple[tuple[str, str], ...]:
    treatment = control_of(plan)
    assert run.condition is not None
    return tuple((name, level) for name, level in run.condition if treatment is None or name != treatment.name)


def is_control(run: PlannedRun, plan: Plan) -> bool:
    treatment = control_of(plan)
    return treatment is not None and dict(run.condition or ()).get(treatment.name) == treatment.control


@given(requests())
def test_every_condition_reaches_its_number_and_only_controls_exceed_it(request: dict[str, Any]) -> None:
    plan = draw_plan(**request)
    n = request["runs_per_condition"]
    counts = Counter(run.condition for run in plan.runs if run.condition is not None)
    names = [factor.name for factor in plan.factors]
    every = [
        tuple(zip(names, levels, strict=True))
        for levels in itertools.product(*(factor.levels for factor in plan.factors))
    ]
    assert set(counts) == set(every)
    controls = {run.condition for run in plan.runs if is_control(run, plan)}
    assert all(count >= n if condition in controls else count == n for condition, count in counts.items())
    assert sum(counts.values()) - n * len(counts) <= len(plan.days) - 1
    idle = Counter(run.duration_s for run in plan.runs if run.kind is RunKind.IDLE)
    assert idle == Counter(60.0 * minutes for minutes in request["idle_minutes"])


@given(requests(treated=True))
def test_every_day_has_a_control_of_each_group_in_it(request: dict[str, Any]) -> None:
    plan = draw_plan(**request)
    for day in plan.days:
        jumps = [run for run in day if run.kind is RunKind.JUMPS]
        assert {group_of(run, plan) for run in jumps} == {group_of(run, plan) for run in jumps if is_control(run, plan)}


MORE_IDLE_THAN_RUNS: dict[str, Any] = {
    "factors": (),
    "runs_per_condition": 1,
    "runs_per_day": 6,
    "method": PlanMethod.RANDOMISED,
    "seed": 0,
    "idle_minutes": [20] * 7,
    "run_duration_s": None,
}


@example(request=MORE_IDLE_THAN_RUNS)
@given(requests())
def test_days_are_full_but_never_too_full(request: dict[str, Any]) -> None:
    lengths = [len(day) for day in draw_plan(**request).days]
    assert max(lengths) <= request["runs_per_day"]
    assert all(length >= request["runs_per_day"] - 1 for length in lengths[:-1])
    assert lengths[-1] >= 1


@given(requests())
def test_blocked_keeps_each_group_together_in_the_day_and_in_the_plan(request: dict[str, Any]) -> None:
    plan = draw_plan(**{**request, "method": PlanMethod.BLOCKED})
    for day in plan.days:
        blocks = [block for block, _ in itertools.groupby(run.block for run in day)]
        assert len([block for block in blocks if block != "idle"]) == len(set(blocks) - {"idle"})
    groups = [group_of(run, plan) for run in plan.runs if run.condition is not None]
    assert len([group for group, _ in itertools.groupby(groups)]) == len(set(groups))
    untreated = [factor for factor in plan.factors if factor.control is None]
    if untreated:  # the factor declared first changes least often
        firsts = [dict(group)[untreated[0].name] for group in groups]
        assert len([level for level, _ in itertools.groupby(firsts)]) == len(set(firsts))


def test_blocked_is_randomised_within_a_block() -> None:
    orders = {
        tuple(
            dict(run.condition or ())["b_ad_gain"]
            for run in draw_plan(CHAPTER_5, 1, 6, PlanMethod.BLOCKED, seed).days[0]
        )
        for seed in range(40)
    }
    assert len(orders) > 30
    assert {order.index("0") for order in orders} == {2, 3}  # the one control is in the middle, on either side


def sums_off(plan: Plan) -> dict[tuple[int, Any], tuple[float, list[int], list[int]]]:
    """By day and group: how far the sum of the controls' places is off that expected at random, and both sides."""
    found = {}
    for day in plan.days:
        jumps = [run for run in day if run.condition is not None]
        for group in {group_of(run, plan) for run in jumps}:
            own = [run for run in jumps if group_of(run, plan) == group]
            sides = [[run.position_in_day for run in own if is_control(run, plan) == side] for side in (True, False)]
            expected = len(sides[0]) * sum(map(sum, sides)) / len(own)
            found[day[0].day, group] = (sum(sides[0]) - expected, *sides)
    return found


@given(requests(treated=True))
def test_no_exchange_of_a_control_brings_the_mean_places_of_a_day_nearer(request: dict[str, Any]) -> None:
    plan = draw_plan(**request)
    for off, controls, treated in sums_off(plan).values():
        if treated:
            assert all(abs(off - one + other) >= abs(off) - 1e-6 for one in controls for other in treated)
        if treated and request["method"] is PlanMethod.BLOCKED:
            assert abs(off) <= 0.5


def test_controls_stand_at_many_places_and_pairs_take_turns() -> None:
    factor = PlanFactor("b_ad_gain", ("0", "50", "100"), control="0")
    plans = [draw_plan([factor], 20, 12, PlanMethod.RANDOMISED, seed) for seed in range(100)]
    places = [tuple(controls) for plan in plans for _off, controls, _treated in sums_off(plan).values()]
    assert {sum(each) for each in places} == {26}  # a mean of 6.5
    assert len(set(places)) > 30
    of_two = draw_plan([PlanFactor("b_ad_gain", ("0", "50"), control="0")], 8, 2, PlanMethod.RANDOMISED, 3)
    first = [is_control(day[0], of_two) for day in of_two.days]
    assert sum(first) == 4
    assert all(one != other for one, other in zip(first[::2], first[1::2], strict=True))


def test_randomised_mixes_groups_within_a_day_and_spreads_them_over_the_plan() -> None:
    plan = draw_plan(CHAPTER_5, 10, 12, PlanMethod.RANDOMISED, seed=5)
    changes = [len(list(itertools.groupby(group_of(run, plan) for run in day))) for day in plan.days]
    assert min(changes) > 2
    half = len(plan.runs) // 2
    for group, count in Counter(group_of(run, plan) for run in plan.runs[:half]).items():
        assert 24 <= count <= 36, group


@pytest.mark.parametrize("method", PlanMethod)
def test_days_of_whole_replicates_spend_no_control_in_excess(method: PlanMethod) -> None:
    plan = draw_plan(CHAPTER_5, 10, 12, method, seed=3, idle_minutes=(20, 24, 30, 40, 50, 60))
    assert len(plan.runs) == 246
    assert len(plan.days) == 21
    for day in plan.days:  # every treatment as often as every other: none is tied to a day
        assert len(set(Counter(dict(run.condition)["b_ad_gain"] for run in day if run.condition).values())) <= 1


@pytest.mark.parametrize("method", PlanMethod)
@pytest.mark.parametrize("levels", [(1, 8), (2, 4), (4, 2)])
def test_idle_runs_take_the_places_that_whole_replicates_leave(levels: tuple[int, int], method: PlanMethod) -> None:
    groups, treatments = (tuple(map(str, range(count))) for count in levels)
    factors = (PlanFactor("foot", groups), PlanFactor("b_ad_gain", treatments, control="0"))
    plan = draw_plan(factors, 4, 9, method, seed=7, idle_minutes=(20, 30, 40, 60))
    assert [sum(run.kind is RunKind.IDLE for run in day) for day in plan.days] == [1, 1, 1, 1]
    for day in plan.days:
        conditions = Counter(run.condition for run in day if run.condition)
        assert conditions.total() == 8
        by_group = Counter(condition[0] for condition in conditions.elements())
        assert {count % levels[1] for count in by_group.values()} == {0}  # whole replicates


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"runs_per_condition": 0}, "0 runs per condition"),
        ({"runs_per_day": 0}, "0 runs a day"),
        ({"runs_per_day": 1}, "cannot hold a run and its control"),
        ({"seed": -1}, "the seed -1"),
        ({"seed": 2**63}, "cannot be kept"),
        ({"runs_per_condition": 10**9}, "at most 100000"),
    ],
)
def test_impossible_plans_are_refused_in_a_sentence(change: dict[str, Any], words: str) -> None:
    request: dict[str, Any] = {"runs_per_condition": 10, "runs_per_day": 12, "seed": 1, **change}
    with refuses(UsageError, words):
        draw_plan(CHAPTER_5, method=PlanMethod.BLOCKED, **request)


def test_every_order_is_equally_likely() -> None:
    chance = SeededChance(0)
    n = 6000
    counts = Counter(tuple(chance.shuffled("abc")) for _ in range(n))
    assert set(counts) == set(itertools.permutations("abc"))
    # Chi-squared with 5 degrees of freedom stays below 20.5 with probability 0.999; the seed is fixed.
    assert sum((count - n / 6) ** 2 / (n / 6) for count in counts.values()) < 20.5
