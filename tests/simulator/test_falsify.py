"""Grounds on which active damping does not save: found where they are, joined by equal heights, told with bars."""

from __future__ import annotations

import numpy as np
import pytest

from data_schema.errors import UnknownName, UsageError
from simulator.compiled import Row
from simulator.falsify import (
    FAILS,
    GAINS,
    NEVER_ROSE,
    NO_JUMP,
    SAVES,
    UNEQUAL,
    Judged,
    Searched,
    counterexamples,
    falsify,
    interval,
    judge_scenes,
    question_by_words,
    region_of,
    search,
)
from simulator.jump import simulate
from simulator.scene_file import load_scene
from simulator.sweep.design import sobol_shares
from tests.helpers.wording import refuses


def judged(saving: Row, apart: Row | None = None) -> Judged:
    """What a world would be judged to be that saves so much, and is apart somewhere."""
    verdict = np.where(saving < 0.0, FAILS, SAVES)
    if apart is not None:
        verdict = np.where(apart, UNEQUAL, verdict)
    nowhere = np.zeros(len(saving), np.bool_)
    return Judged(verdict, saving, saving, nowhere, np.ones((2, len(saving))), np.zeros(len(saving)), nowhere)


def test_a_planted_failure_is_found_in_99_of_100_seeds() -> None:
    """It fills a ten-thousandth of the box, beside a hollow in which the claim nearly fails, and grounds apart."""
    found = 0
    for seed in range(100):
        place = np.random.default_rng(seed).uniform(0.1, 0.9, 2)
        decoy = np.array([1.0, 1.0]) - place

        def world(shares: Row, place: Row = place, decoy: Row = decoy) -> Judged:
            near, far = (np.linalg.norm(shares - at, axis=1) for at in (place, decoy))
            saving = 0.3 - 0.31 * np.exp(-((near / 0.05) ** 2)) - 0.25 * np.exp(-((far / 0.2) ** 2))
            return judged(saving, (shares[:, 0] < 0.05) & (shares[:, 1] < 0.05))

        found += bool(len(search(world, sobol_shares(2, 512, seed), seed).failing))
    assert found >= 99


@pytest.mark.soak
def test_a_corner_of_the_bed_is_found_with_every_seed() -> None:
    """It is a sixth of a percent of the box; a sample of 512 meets it with two seeds of three."""
    questions = (
        question_by_words("bed", ["kg_scale=0.1:100", "bg_scale=0.03:10"], grounds=512, seed=seed) for seed in range(20)
    )
    assert sum(bool(len(falsify(question).failing)) for question in questions) >= 19


def test_a_box_without_failure_has_none() -> None:
    searched = search(lambda shares: judged(0.1 + shares.sum(axis=1)), sobol_shares(3, 64, 0), 0)
    assert not len(searched.failing)
    assert region_of(searched) is None
    assert (searched.says, searched.counts[SAVES]) == (64, 64)


def test_the_region_of_failures_is_held_against_the_other_half_of_the_sample() -> None:
    shares = sobol_shares(2, 1024, 3)
    fails = (shares[:, 0] < 0.25) & (shares[:, 1] > 0.5)
    searched = Searched(shares, judged(np.where(fails, -0.1, 0.1)), 1024)
    region = region_of(searched)
    assert region is not None
    assert np.allclose((*region.low, *region.high), (0.0, 0.5, 0.25, 1.0), atol=0.05)
    assert region.inside[0] == region.inside[1] > 40
    assert region.outside[0] <= 6
    low, high = interval(int(fails.sum()), 1024)
    assert low < 0.125 < high


def test_at_equal_height_both_controllers_reach_the_same_apex() -> None:
    question = question_by_words("bed", ["kg_scale=0.2:50"], grounds=8, seed=1)
    found = falsify(question)
    assert len(found.shares) > found.sample == 8
    told = np.flatnonzero(found.judged.verdict[:8] < NO_JUMP)
    assert told.size > 4
    scales = question.sweep.design.axes[0].coordinates
    for place in told[:2]:
        apexes, costs = [], []
        for controller, b_ad in enumerate((0.0, question.scene["b_ad"])):
            values = {"kg_scale": scales[place], "b_ad": b_ad, "k_extension": found.judged.stiffness[controller, place]}
            jump = simulate(question.scene.changed(values), 1e-6).jump
            assert jump.apex_height_m is not None
            apexes.append(jump.apex_height_m)
            costs.append(jump.cost_J)
        assert apexes[0] == pytest.approx(apexes[1], abs=1e-4)
        assert found.judged.saving[place] == pytest.approx((costs[0] - costs[1]) / costs[0], abs=1e-3)


def test_a_counterexample_is_confirmed_with_error_bars_and_by_another_solver() -> None:
    """Soft ground with little drag: at equal gains active damping costs more there, and jumps higher."""
    question = question_by_words(
        "bed", ["kg_scale=0.3:0.6", "bg_scale=0.03:0.06"], equal=GAINS, grounds=16, sets=["b_ad=517.67"]
    )
    found = falsify(question)
    examples = counterexamples(question, found, 1)
    assert [one.confirmed for one in examples] == [True]
    (one,) = examples
    assert one.more_j > 0.1 > 100.0 * (one.bar_j + (one.solver_j or 1.0))
    assert one.jumps[1].apex_height_m > one.jumps[0].apex_height_m  # type: ignore[operator]


def test_where_a_cost_is_not_positive_joules_are_compared() -> None:
    """Motors without resistance, dropped from high up: what braking gives back is more than the jump takes."""
    sets = ["motor_resistance=0.001", "initial_height=0.35", "b_ad=517.67"]
    question = question_by_words("bed", ["kg_scale=0.5:5", "bg_scale=0.3:3"], sets, grounds=16)
    found = falsify(question)
    says = np.flatnonzero(found.judged.verdict[:16] < NO_JUMP)
    rows = question.sweep.design.rows(0, 16)
    for place in says[:4]:
        cost_j = []
        for controller, b_ad in enumerate((0.0, 517.67)):
            ground = dict(zip(question.names, rows[place].tolist(), strict=True))
            values = {**ground, "b_ad": b_ad, "k_extension": found.judged.stiffness[controller, place]}
            cost_j.append(simulate(question.scene.changed(values), 1e-6).jump.cost_J)
        ce_j, ad_j = cost_j
        assert found.judged.verdict[place] == (SAVES if ad_j < ce_j else FAILS)
        assert found.judged.saved_j[place] == pytest.approx(ce_j - ad_j, abs=1e-2)
        assert found.judged.not_positive[place] == (min(cost_j) <= 0.0)
        assert np.isnan(found.judged.saving[place]) == (ce_j <= 0.0)
    free = np.isnan(found.judged.saving[says])
    assert 2 < free.sum() < len(says) == found.not_positive
    assert not len(found.failing)


def test_a_foot_that_never_rises_is_no_jump_and_says_nothing() -> None:
    """Strong active damping: on softer grounds the gains of flight press the lifted foot down until the body falls."""
    question = question_by_words("bed", ["kg_scale=0.5:50"], ["b_ad=3000"], equal=GAINS, grounds=16)
    found = falsify(question)
    scales = question.sweep.design.axes[0].coordinates
    never = np.flatnonzero(found.judged.verdict[:16] == NEVER_ROSE)
    assert 2 < len(never) == found.counts[NEVER_ROSE] < 14
    assert np.isnan(found.judged.saved_j[never]).all()
    for place in never[:2]:
        jump = simulate(question.scene.changed({"kg_scale": scales[place]}), 1e-6).jump
        assert jump.never_rose
        assert jump.outcome == "touchdown"
    by_height = falsify(question_by_words("bed", ["kg_scale=0.5:50"], ["b_ad=3000"], grounds=16))
    told = by_height.judged.verdict[never] < NO_JUMP  # with a stiffer extension it may jump
    assert (by_height.judged.stiffness[1, never[told]] > question.scene["k_extension"]).all()


def test_conditions_of_a_ground_are_judged() -> None:
    bed = load_scene("bed")
    found = judge_scenes([bed.changed({"b_ad": b_ad}) for b_ad in (185.67, 517.67)])
    assert found.verdict.tolist() == [SAVES, SAVES]
    assert 0.02 < found.saving[0] < found.saving[1] < 0.2
    assert not found.stiffer.any()


def test_the_saving_jumps_where_equal_height_begins_to_ask_for_a_stiffer_leg() -> None:
    """Of two grounds that differ by half a percent active damping jumps on one alone with the scene's stiffness."""
    bed = load_scene("bed").changed({"b_ad": 517.67, "bg_scale": 2.0})
    found = judge_scenes([bed.changed({"kg_scale": kg_scale}) for kg_scale in (0.2841, 0.2853)])
    assert found.stiffer.tolist() == [True, False]
    assert found.stiffness[1, 0] > 2.0 * bed["k_extension"] == 2.0 * found.stiffness[1, 1]
    assert found.saving == pytest.approx([0.1476, 0.0832], abs=1e-4)


def test_refused() -> None:
    with refuses(UnknownName, "hops", "saves"):
        question_by_words("bed", ["kg_scale=0.1:10"], claim="hops")
    with refuses(UnknownName, "cost", "height", "gains"):
        question_by_words("bed", ["kg_scale=0.1:10"], equal="cost")
    with refuses(UsageError, "active damping", "--effects"):
        question_by_words("bed", ["kg_scale=0.1:10"], effects="-active_damping")
    with refuses(UsageError, "b_ad", "--set", "--over"):
        question_by_words("bed", ["b_ad=100:200"], ["b_ad=50"])
