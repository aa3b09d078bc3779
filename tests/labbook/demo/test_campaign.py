"""The campaign of the demonstration: its calendar, and the runs that it draws."""

from collections import Counter

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from data_schema.vocabulary import RunKind
from labbook.demo.campaign import BATTERIES, Campaign, Day, draw_calendar, make_campaign
from labbook.demo.truth import CHAPTER_5, Condition


@pytest.fixture(scope="module")
def campaign() -> Campaign:
    return make_campaign(1)


def test_default_campaign_is_chapter_5s(campaign: Campaign) -> None:
    assert len(campaign.of_kind(RunKind.JUMPS)) == 264
    assert len(campaign.of_kind(RunKind.IDLE)) == 6
    assert len(campaign.of_kind(RunKind.CHARACTERISATION)) == 1
    assert [run.name for run in campaign.runs] == [f"r{n:03d}" for n in range(1, 272)]
    assert {run.battery for run in campaign.runs} == set(BATTERIES)


def test_faults_of_real_work_occur() -> None:
    runs = [run for seed in range(3) for run in make_campaign(seed).of_kind(RunKind.JUMPS)]
    assert {run.starts for run in runs} == {1, 2, 3}
    assert any(run.jumps_made < 25 for run in runs)
    assert all(run.jumps_made == 25 or f"stopped after {run.jumps_made} jumps" in run.note for run in runs)
    misfired = [run for run in runs if run.misfired.any()]
    assert misfired
    assert all("not leave the" in run.note for run in misfired)
    assert all(run.reached_apexes_m.size == run.jumps_made - run.misfired.sum() for run in runs)


def test_charges_are_whole_milliamperehours_about_the_model() -> None:
    residuals, apexes = [], []
    for seed in range(8):
        for run in make_campaign(seed).of_kind(RunKind.JUMPS):
            assert run.condition is not None
            joules = CHAPTER_5.joules_per_jump(run.condition)
            expected = CHAPTER_5.drain.charge_mah(run.duration_s)
            expected += run.jumps_made * CHAPTER_5.jump_charge_mah(joules)
            residuals.append(run.charge_mah - expected)
            apexes.append(run.reached_apexes_m.mean() - CHAPTER_5.apex_height_m(run.condition))
            assert isinstance(run.charge_mah, int)
    scatter = CHAPTER_5.scatter
    day_mah = 25 * CHAPTER_5.jump_charge_mah(scatter.day_joules_per_jump)
    expected_sd = (scatter.recharge_mah**2 + scatter.run_mah**2 + day_mah**2 + 1 / 12) ** 0.5
    assert np.std(residuals) == pytest.approx(expected_sd, rel=0.05)
    assert abs(np.mean(residuals)) < 4 * expected_sd / len(residuals) ** 0.5
    assert abs(np.mean(apexes)) < 0.0002


def conditions(day: Day) -> list[Condition]:
    return [slot.condition for slot in day.slots if slot.kind is RunKind.JUMPS and slot.condition is not None]


@given(st.integers(0, 2**32), st.integers(2, 12))
def test_every_day_has_its_controls_and_every_condition_its_runs(seed: int, runs: int) -> None:
    days = draw_calendar(np.random.default_rng(seed), CHAPTER_5, runs, 30)
    for day in days:
        groups = {(condition.foot, condition.k_gain) for condition in conditions(day)}
        controls = {(c.foot, c.k_gain) for c in conditions(day) if c.is_control}
        assert controls == groups
    counts = Counter(condition for day in days for condition in conditions(day))
    assert all(counts[c] == runs for c in CHAPTER_5.conditions if not c.is_control)
    assert all(counts[c] >= runs for c in CHAPTER_5.conditions)
    assert counts.total() == 24 * runs + 30
