import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from data_schema.errors import UsageError
from data_schema.units import STANDARD_GRAVITY_M_S2
from labbook.demo.hop import Hop, hop_motion

hops = st.builds(
    Hop,
    drop_height_m=st.floats(0.36, 0.45),
    apex_height_m=st.floats(0.285, 0.40),
    compression_m=st.floats(0.08, 0.13),
    jamming_time_s=st.floats(0.0, 0.035),
    extension_intrusion_m=st.floats(0.0, 0.03),
)


def phases(hop: Hop) -> dict[str, tuple[float, float]]:
    return {
        "drop": (0.0, hop.touchdown_s),
        "compression": (hop.touchdown_s, hop.switch_s),
        "extension": (hop.switch_s, hop.lift_off_s),
        "flight": (hop.lift_off_s, hop.landing_s),
    }


@given(hops)
def test_ballistic_phases_are_exact_parabolas(hop: Hop) -> None:
    g = STANDARD_GRAVITY_M_S2
    drop_s = np.linspace(0, hop.touchdown_s, 40)[:-1]
    np.testing.assert_allclose(
        hop_motion(hop, drop_s).body_height_m, hop.drop_height_m - g * drop_s**2 / 2, rtol=0, atol=1e-14
    )
    flight_s = np.linspace(hop.lift_off_s, hop.landing_s, 41)[1:]
    np.testing.assert_allclose(
        hop_motion(hop, flight_s).body_height_m,
        hop.apex_height_m - g * (flight_s - hop.apex_s) ** 2 / 2,
        rtol=0,
        atol=1e-14,
    )


@given(hops)
def test_apex_is_the_highest_point_after_lift_off(hop: Hop) -> None:
    time_s = np.sort(np.append(np.linspace(hop.switch_s, hop.landing_s, 500), hop.apex_s))
    motion = hop_motion(hop, time_s)
    top = int(np.argmax(motion.body_height_m))
    assert motion.body_height_m[top] == hop.apex_height_m
    assert time_s[top] == hop.apex_s
    assert motion.body_velocity_m_s[top] == 0.0


@given(hops)
def test_height_velocity_and_leg_are_continuous(hop: Hop) -> None:
    for edge_s in (hop.touchdown_s, hop.switch_s, hop.lift_off_s):
        around = hop_motion(hop, np.array([edge_s - 1e-9, edge_s + 1e-9]))
        assert abs(np.diff(around.body_height_m)[0]) < 1e-7
        assert abs(np.diff(around.body_velocity_m_s)[0]) < 1e-5
        assert abs(np.diff(around.leg_length_m)[0]) < 1e-7
        if hop.jamming_time_s > 1e-3:
            assert abs(np.diff(around.leg_velocity_m_s)[0]) < 1e-4


@given(hops)
def test_velocities_are_the_derivatives(hop: Hop) -> None:
    step_s = 1e-6
    for start_s, end_s in phases(hop).values():
        middle_s = np.linspace(start_s, end_s, 12)[1:-1]
        before, at, after = (hop_motion(hop, middle_s + shift) for shift in (-step_s, 0.0, step_s))
        for value, rate in (
            ("body_height_m", "body_velocity_m_s"),
            ("leg_length_m", "leg_velocity_m_s"),
            ("body_velocity_m_s", "body_acceleration_m_s2"),
        ):
            slope = (getattr(after, value) - getattr(before, value)) / (2 * step_s)
            np.testing.assert_allclose(slope, getattr(at, rate), atol=2e-3)


@given(hops)
def test_controller_switches_where_the_leg_stops_shortening(hop: Hop) -> None:
    compression_s = np.linspace(hop.touchdown_s, hop.switch_s, 60)[1:-1]
    extension_s = np.linspace(hop.switch_s, hop.lift_off_s, 60)[1:-1]
    compression, extension = hop_motion(hop, compression_s), hop_motion(hop, extension_s)
    assert np.all(compression.leg_velocity_m_s < 0)
    assert not compression.extending.any()
    assert np.all(extension.leg_velocity_m_s > 0)
    assert extension.extending.all()
    assert hop_motion(hop, np.array([hop.switch_s])).leg_length_m[0] == pytest.approx(0.27 - hop.compression_m)


def test_stance_of_the_thesis_is_short_and_within_the_leg() -> None:
    hop = Hop(0.42, 0.33)
    assert hop.lift_off_s - hop.touchdown_s < 0.5
    assert hop.touchdown_speed_m_s == pytest.approx(math.sqrt(2 * STANDARD_GRAVITY_M_S2 * 0.15))
    leg_m = hop_motion(hop, np.linspace(0, hop.landing_s, 1000)).leg_length_m
    assert leg_m.min() > 0.1
    assert leg_m.max() < 0.3


def test_rigid_ground_returns_the_impulse_of_the_weight() -> None:
    hop = Hop(0.34, 0.34, jamming_time_s=0.0, extension_intrusion_m=0.0)
    time_s = np.linspace(0, hop.apex_s, 200_001)
    force_over_mass = hop_motion(hop, time_s).body_acceleration_m_s2 + STANDARD_GRAVITY_M_S2
    assert np.trapezoid(force_over_mass, time_s) == pytest.approx(STANDARD_GRAVITY_M_S2 * hop.apex_s, rel=1e-4)


def test_leg_pushes_throughout_stance_and_harder_after_the_switch() -> None:
    hop = Hop(0.42, 0.33)
    time_s = np.linspace(hop.touchdown_s, hop.lift_off_s, 1000)[1:-1]
    motion = hop_motion(hop, time_s)
    force_over_mass = motion.body_acceleration_m_s2 + STANDARD_GRAVITY_M_S2
    assert np.all(force_over_mass > 0)
    assert np.argmax(force_over_mass) == np.argmax(motion.extending)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"drop_height_m": 0.26, "apex_height_m": 0.33}, "foot in the ground"),
        ({"drop_height_m": 0.42, "apex_height_m": 0.2}, "below lift-off"),
        ({"drop_height_m": 0.42, "apex_height_m": 0.33, "jamming_time_s": 0.4}, "shorter than the compression"),
    ],
)
def test_impossible_hops_are_refused(arguments: dict[str, float], words: str) -> None:
    with pytest.raises(UsageError, match=words):
        Hop(**arguments)
