import json

import pytest

from data_schema.errors import UnknownName
from labbook.demo.truth import CHAPTER_5, Condition, Group
from tests.helpers.wording import refuses


def test_passive_charge_is_the_thesiss_at_twelve_minutes() -> None:
    assert CHAPTER_5.passive_charge_mah(720) == pytest.approx(86.183, abs=1e-12)
    written = json.loads(json.dumps(CHAPTER_5.as_json()))
    assert written["passive"]["charge_at_run_duration_mah"] == pytest.approx(86.183)


def test_there_are_24_conditions_4_of_them_controls() -> None:
    assert len(set(CHAPTER_5.conditions)) == 24
    assert sum(condition.is_control for condition in CHAPTER_5.conditions) == 4


def test_savings_are_highest_for_the_small_foot_and_stiff_gain_and_lowest_for_large_and_soft() -> None:
    savings = {(group.foot, group.k_gain): group.saving for group in CHAPTER_5.groups}
    assert max(savings, key=savings.__getitem__) == ("small", 400)
    assert savings["small", 400] == 0.15
    assert min(savings, key=savings.__getitem__) == ("large", 300)


@pytest.mark.parametrize("group", CHAPTER_5.groups)
def test_savings_are_those_of_the_conditions_whatever_the_gain(group: Group) -> None:
    control = CHAPTER_5.joules_per_jump(Condition(group.foot, group.k_gain, 0))
    for gain in CHAPTER_5.ad_gains:
        treated = CHAPTER_5.joules_per_jump(Condition(group.foot, group.k_gain, gain))
        assert (control - treated) / control == pytest.approx(CHAPTER_5.saving(group.foot, group.k_gain))


def test_active_damping_raises_the_apex_by_at_most_3_mm() -> None:
    for group in CHAPTER_5.groups:
        control = CHAPTER_5.apex_height_m(Condition(group.foot, group.k_gain, 0))
        treated = CHAPTER_5.apex_height_m(Condition(group.foot, group.k_gain, 50))
        assert 0 <= treated - control <= 0.003 + 1e-12


def test_a_charge_carries_its_joules() -> None:
    assert CHAPTER_5.jump_charge_mah(3.6 * 15.4) == pytest.approx(1.0)


def test_a_foot_that_does_not_exist_is_named_with_the_nearest() -> None:
    with refuses(UnknownName, "'small 400'"):
        CHAPTER_5.group("smal", 400)
