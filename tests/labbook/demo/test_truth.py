"""What the demonstration takes for true, and its jumps: simulated, stretched to the drop and apex that were drawn."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from labbook.demo.truth import CHAPTER_5, GROUND, Condition, simulated_jump
from simulator.jump import simulate
from simulator.scene_file import load_scene


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


@given(st.sampled_from(CHAPTER_5.conditions), st.floats(0.40, 0.425), st.floats(-0.015, 0.015))
def test_a_hop_begins_where_it_is_dropped_and_has_its_apex(
    condition: Condition, start_m: float, higher_m: float
) -> None:
    jump = simulated_jump(condition.foot, condition.k_gain, condition.b_ad_gain)
    hop = jump.hop(start_m, jump.apex_height_m + higher_m)
    time_s = np.sort(np.append(np.linspace(0.0, hop.landing_s, 2001), hop.apex_s))
    height_m = hop.motion(time_s)[0]
    assert height_m[0] == pytest.approx(start_m, abs=1e-12)
    risen = time_s > hop.switch_s
    assert height_m[risen].max() == pytest.approx(hop.apex_height_m, abs=1e-6)
    assert time_s[risen][np.argmax(height_m[risen])] == pytest.approx(hop.apex_s, abs=0.002)
