from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from data_schema.errors import UsageError
from simulator.parameter import GRAVITY_M_S2
from simulator.scene_file import load_scene
from simulator.scene_rules import DEEPEST_M, least_bearing_ratio
from tests.helpers.wording import refuses

SIM2 = load_scene("sim2")
EMULATOR = load_scene("emulator")
NOMINAL = {name: SIM2[name] for name in SIM2.read}


def ratios(p: dict[str, float], n_depths: int = 4000) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """K / (m_a g) at many depths, as the functions stand in the thesis's code."""
    radius, q = p["foot_radius"], p["mu"] / math.tan(p["cone_angle"])
    z = np.concatenate(
        [np.geomspace(1e-9, DEEPEST_M, n_depths), np.linspace(1e-6, min(radius / q, DEEPEST_M), n_depths)]
    )
    s = np.minimum(z, radius / q)
    volume = math.pi * (radius**2 * s - q * radius * s**2 + q**2 * s**3 / 3)
    area = math.pi * radius**2
    k = p["kg_scale"] * (p["k_sh"] * volume / area + p["sigma"] * z * (area + volume) / math.cos(p["cone_angle"]))
    added = p["phi"] * p["rho"] * p["mu"] * volume + p["added_mass_constant"] * z
    found: np.ndarray[tuple[int], np.dtype[np.float64]] = k / (added * GRAVITY_M_S2)
    return found


@given(
    st.floats(0.001, 0.2),
    st.floats(0.2, 1.4),
    st.floats(0.05, 20.0),
    st.floats(0.0, 1e5),
    st.floats(1.0, 1e7),
    st.floats(10.0, 2e4),
    st.floats(0.0, 20.0),
)
def test_the_least_bearing_ratio_is_that_of_all_depths(
    radius: float, angle: float, mu: float, k_sh: float, sigma: float, rho: float, constant: float
) -> None:
    p = NOMINAL | {"foot_radius": radius, "cone_angle": angle, "mu": mu, "k_sh": k_sh, "sigma": sigma, "rho": rho}
    p["added_mass_constant"] = constant
    assert least_bearing_ratio(p) <= ratios(p).min() * (1 + 1e-9)
    assert least_bearing_ratio(p) == pytest.approx(ratios(p).min(), rel=1e-3)


def test_a_ground_that_cannot_carry_its_grains_is_refused_and_the_sentence_gives_the_scale_that_can() -> None:
    limit = 1.0 / least_bearing_ratio(NOMINAL)
    assert limit == pytest.approx(0.0182, abs=1e-4)  # "below about 0.018"
    SIM2.changed({"kg_scale": 1.0001 * limit})
    with refuses(UsageError, "m_a") as refusal:
        SIM2.changed({"kg_scale": 0.5 * limit})
    scale = float(str(refusal.value).split("kg_scale = ")[2].split(",")[0])
    SIM2.changed({"kg_scale": scale})
    SIM2.changed({"kg_scale": 0.5 * limit}, effects_off=("added_mass",))


def test_a_soft_surface_over_firm_depth_is_judged_by_its_surface() -> None:
    p = NOMINAL | {"k_sh": 0.0, "kg_scale": 0.05}
    assert least_bearing_ratio(p) == pytest.approx(ratios(p).min(), rel=1e-6)
    with refuses(UsageError, "m_a"):
        SIM2.changed({"k_sh": 0.0, "kg_scale": 0.05})


def test_the_platform_is_released_before_the_leg_turns_soft() -> None:
    with refuses(UsageError, "rest_tolerance"):
        EMULATOR.changed({"release_tolerance": 0.004})
    equal = EMULATOR.changed({"release_tolerance": EMULATOR["rest_tolerance"]})  # the release goes first
    assert equal["release_tolerance"] == equal["rest_tolerance"]


def test_a_latched_leg_does_not_turn_stiff_and_soft_at_once() -> None:
    with refuses(UsageError, "rest_tolerance"):
        EMULATOR.changed({"switch_compression": 0.004})
