import json

import pytest

from data_schema.errors import UnknownName
from labbook.demo.truth import CHAPTER_5, GROUND, Condition
from simulator.jump import simulate
from simulator.scene_file import load_scene
from tests.helpers.wording import refuses


def test_passive_charge_is_the_thesiss_at_twelve_minutes() -> None:
    assert CHAPTER_5.drain.charge_mah(720) == pytest.approx(86.183, abs=1e-12)
    written = json.loads(json.dumps(CHAPTER_5.as_json()))
    assert written["passive"]["charge_at_run_duration_mah"] == pytest.approx(86.183)
    assert written["ground"] == GROUND


def test_there_are_24_conditions_4_of_them_controls() -> None:
    assert len(set(CHAPTER_5.conditions)) == 24
    assert sum(condition.is_control for condition in CHAPTER_5.conditions) == 4


def test_a_condition_is_a_jump_of_the_scene_on_the_campaigns_ground() -> None:
    scene = load_scene("bed").changed({"foot_radius": 0.051, "k_extension": 835.36, "b_ad": 351.67, **GROUND})
    jump = simulate(scene, 1e-9).jump
    condition = Condition("large", 300, 100)
    assert CHAPTER_5.joules_per_jump(condition) == pytest.approx(jump.cost_J, rel=1e-5)
    assert CHAPTER_5.apex_height_m(condition) == pytest.approx(jump.apex_height_m, rel=1e-5)


def test_savings_are_those_of_the_conditions_and_highest_for_the_small_foot_and_stiff_gain() -> None:
    for group in CHAPTER_5.groups:
        control, *treated = (
            CHAPTER_5.joules_per_jump(Condition(group.foot, group.k_gain, gain)) for gain in (0, *CHAPTER_5.ad_gains)
        )
        savings = [(control - joules) / control for joules in treated]
        each = [CHAPTER_5.saving(group.foot, group.k_gain, gain) for gain in CHAPTER_5.ad_gains]
        assert each == pytest.approx(savings)
        assert CHAPTER_5.saving(group.foot, group.k_gain) == pytest.approx(sum(savings) / len(savings))
    pooled = {(group.foot, group.k_gain): CHAPTER_5.saving(group.foot, group.k_gain) for group in CHAPTER_5.groups}
    assert max(pooled, key=pooled.__getitem__) == ("small", 400)
    assert CHAPTER_5.as_json()["saving_overall"] == pytest.approx(sum(pooled.values()) / len(pooled))


def test_a_charge_carries_its_joules() -> None:
    assert CHAPTER_5.jump_charge_mah(3.6 * 15.4) == pytest.approx(1.0)


def test_a_foot_that_does_not_exist_is_named_with_the_nearest() -> None:
    with refuses(UnknownName, "'small 400'"):
        CHAPTER_5.group("smal", 400)
