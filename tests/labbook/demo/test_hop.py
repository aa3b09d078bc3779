"""The jumps of the demonstration: simulated, stretched to the height of the drop and the apex that were drawn."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from labbook.demo.truth import CHAPTER_5, REST_LENGTH_M, Condition, Hop, simulated_hop, simulated_jump


@st.composite
def hops(draw: st.DrawFn) -> tuple[Condition, float, Hop]:
    condition = draw(st.sampled_from(CHAPTER_5.conditions))
    jump = simulated_jump(condition.foot, condition.k_gain, condition.b_ad_gain)
    start_m = draw(st.floats(0.40, 0.425))
    return (
        condition,
        start_m,
        simulated_hop(jump, REST_LENGTH_M, start_m, jump.apex_height_m + draw(st.floats(-0.015, 0.015))),
    )


@given(hops())
def test_a_hop_begins_where_it_is_dropped_and_has_its_apex(drawn: tuple[Condition, float, Hop]) -> None:
    _, start_m, hop = drawn
    time_s = np.sort(np.append(np.linspace(0.0, hop.landing_s, 2001), hop.apex_s))
    height_m = hop.motion(time_s).body_height_m
    assert height_m[0] == pytest.approx(start_m, abs=1e-12)
    risen = time_s > hop.switch_s
    assert height_m[risen].max() == pytest.approx(hop.apex_height_m, abs=1e-6)
    assert time_s[risen][np.argmax(height_m[risen])] == pytest.approx(hop.apex_s, abs=0.002)


@given(hops())
def test_the_leg_extends_from_where_it_is_shortest_to_lift_off(drawn: tuple[Condition, float, Hop]) -> None:
    _, _, hop = drawn
    time_s = np.linspace(0.0, hop.landing_s, 4001)
    motion = hop.motion(time_s)
    shortest = int(np.argmin(motion.leg_length_m))
    assert time_s[shortest] == pytest.approx(hop.switch_s, abs=0.001)
    assert motion.leg_length_m[shortest] == pytest.approx(hop.switch_leg_m, abs=1e-4)
    assert motion.body_height_m[shortest] == pytest.approx(hop.switch_height_m, abs=1e-3)
    (extending,) = np.nonzero(motion.extending)
    assert np.all(np.diff(extending) == 1)
    assert abs(int(extending[0]) - shortest) <= 1
    assert motion.body_height_m[extending[-1]] == pytest.approx(hop.lift_off_height_m, abs=0.003)
    assert time_s[extending[-1]] < hop.apex_s


def test_a_jump_as_drawn_from_the_mean_is_the_simulated_one() -> None:
    jump = simulated_jump("small", 400, 100)
    hop = simulated_hop(jump, REST_LENGTH_M, float(jump.height_m[0]), jump.apex_height_m)
    (kept,) = np.nonzero(np.diff(jump.time_s, prepend=-1.0) > 1e-9)
    np.testing.assert_allclose(hop.motion(jump.time_s[kept]).body_height_m, jump.height_m[kept], atol=1e-12)
