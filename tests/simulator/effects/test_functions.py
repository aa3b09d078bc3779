"""The effects' functions against the formulas they stand for, written out once more."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import pytest
from numpy.typing import NDArray

from simulator.kernel.composition import compose
from simulator.kernel.mechanics.leg import make_lever
from simulator.scene import Scene
from simulator.scene_file import load_scene
from tests.helpers.kernels import interpreted

Row = NDArray[np.float64]
DEPTHS_M = np.concatenate([np.geomspace(1e-6, 0.2, 60), [0.02598, 0.026]])
LENGTHS_M = np.linspace(0.105, 0.295, 77)
Q = 2.0 / math.tan(1.0472)


@dataclass(frozen=True, slots=True)
class Request:
    """A slot's function in a scene, and the arguments to give it, each an array of the same length."""

    scene: Scene
    slot: str
    each: tuple[Row, ...] = ()


def evaluated(requests: dict[str, Request]) -> dict[str, Row]:
    """What the functions give, with their scenes' parameters; works where nothing is compiled."""
    found = {}
    for name, request in requests.items():
        composition = compose(request.scene.effects)
        row = np.zeros(composition.row_size)
        for parameter in composition.parameters:
            row[composition.position[parameter.name]] = request.scene[parameter.name]
        composition.prepare(row)
        function = make_lever(composition) if request.slot == "lever_m" else composition.slots[request.slot]
        calls = zip(*request.each, strict=True) if request.each else [()]
        found[name] = np.array([function(row, *arguments) for arguments in calls])
    return found


def formed_m(radius_m: float) -> Row:
    return np.asarray(np.minimum(DEPTHS_M, radius_m / Q))


def volume_m3(radius_m: float) -> Row:
    s = formed_m(radius_m)
    return np.asarray(np.pi * (radius_m**2 * s - Q * radius_m * s**2 + Q**2 * s**3 / 3.0))


def jacobian_1_m(lengths_m: Row) -> Row:
    """d beta / d r of the five-bar leg (thesis 3.2.1)."""
    first, second = 0.1, 0.2
    u = (first**2 - second**2 + lengths_m**2) / (2.0 * first * lengths_m)
    slope = (lengths_m**2 - first**2 + second**2) / (2.0 * first * lengths_m**2)
    return np.asarray(slope / np.sqrt(1.0 - u**2))


NUDGE_M = 1e-7
RADIUS_M = 0.03
LEVERS_M = 1.0 / jacobian_1_m(LENGTHS_M)
SPEEDS_M_S, FORCES_N = np.linspace(-2.0, 2.0, len(LENGTHS_M)), 90.0 * np.sin(np.arange(len(LENGTHS_M)))
COMMANDED_N = 2.0 * FORCES_N
GAINS = {100.0: 323.36, 400.0: 1091.36, 0.0: 67.36, -1.0: 20.0}
GRANULAR = load_scene("sim2").changed({"kg_scale": 1.4, "bg_scale": 0.7, "foot_radius": RADIUS_M})
SIM1, SIM2, EMULATOR = load_scene("sim1"), load_scene("sim2"), load_scene("emulator")

REQUESTS = {
    "resistance": Request(GRANULAR, "resistance_n", (DEPTHS_M,)),
    "resistance above": Request(GRANULAR, "resistance_n", (DEPTHS_M + NUDGE_M,)),
    "resistance below": Request(GRANULAR, "resistance_n", (DEPTHS_M - NUDGE_M,)),
    "resistance slope": Request(GRANULAR, "resistance_slope_n_m", (DEPTHS_M,)),
    "added mass": Request(GRANULAR, "added_mass_kg", (DEPTHS_M,)),
    "added mass slope": Request(GRANULAR, "added_mass_slope_kg_m", (DEPTHS_M,)),
    "grain drag": Request(GRANULAR, "quadratic_drag_kg_m", (DEPTHS_M,)),
    "lever": Request(SIM1, "lever_m", (LENGTHS_M,)),
    "torque cap": Request(load_scene("bed"), "cap_n", (LEVERS_M,)),
    "constant cap": Request(SIM2, "cap_n", (LEVERS_M,)),
    "heat": Request(SIM1, "heat_w", (LEVERS_M, SPEEDS_M_S, FORCES_N)),
    "drag": Request(SIM1, "drag_w", (LEVERS_M, SPEEDS_M_S, FORCES_N)),
    "commanded": Request(SIM2, "cost_force_n", (LEVERS_M, COMMANDED_N, FORCES_N)),
    "stalled": Request(SIM1, "cost_force_n", (LEVERS_M, COMMANDED_N, FORCES_N)),
    "platform": Request(EMULATOR, "resistance_n", (DEPTHS_M,)),
    "platform drag": Request(EMULATOR, "quadratic_drag_kg_m", (DEPTHS_M,)),
    **{
        f"gain {gain:g}": Request(
            EMULATOR.changed(
                {"k_extension": stiffness, "ad_share": 0.25}, ("scaled_active_damping",), ("active_damping",)
            ),
            "active_damping_kg_m",
        )
        for gain, stiffness in GAINS.items()
    },
}


@pytest.fixture(scope="module")
def values() -> dict[str, Row]:
    return interpreted(evaluated, REQUESTS)


def test_resistance_of_the_grains(values: dict[str, Row]) -> None:
    area_m2 = np.pi * RADIUS_M**2
    penetration_n = 1600.0 * volume_m3(RADIUS_M) / area_m2
    stress_n = 1.2e5 * DEPTHS_M * (area_m2 + volume_m3(RADIUS_M)) / math.cos(1.0472)
    np.testing.assert_allclose(values["resistance"], 1.4 * (penetration_n + stress_n), rtol=1e-13)
    slope = (values["resistance above"] - values["resistance below"]) / (2.0 * NUDGE_M)
    np.testing.assert_allclose(values["resistance slope"], slope, rtol=1e-5)


def test_added_mass_and_the_drag_that_is_its_slope(values: dict[str, Row]) -> None:
    """D = bg_scale b_g c_g m_a'."""
    wanted_kg = 0.57 * 1000.0 * 2.0 * volume_m3(RADIUS_M) + 1.0 * DEPTHS_M
    np.testing.assert_allclose(values["added mass"], wanted_kg, rtol=1e-13)
    area_m2 = np.pi * (RADIUS_M - Q * formed_m(RADIUS_M)) ** 2
    slope = 0.57 * 1000.0 * 2.0 * area_m2 + 1.0
    np.testing.assert_allclose(values["added mass slope"], slope, rtol=1e-12)
    np.testing.assert_allclose(values["grain drag"], 0.7 * 17.2 * 2.7 * slope, rtol=1e-12)


def test_the_lever_is_one_over_the_slope_of_the_joint_angle(values: dict[str, Row]) -> None:
    np.testing.assert_allclose(values["lever"], LEVERS_M, rtol=1e-12)


def test_caps_on_the_force(values: dict[str, Row]) -> None:
    """The torque cap is least, 62.3 N, at a length of 0.215 m; the constant one is 2 x 3.5 / 0.1 N."""
    np.testing.assert_allclose(values["torque cap"], 7.0 * jacobian_1_m(LENGTHS_M), rtol=1e-12)
    assert values["torque cap"].min() == pytest.approx(62.3, abs=0.05)
    assert LENGTHS_M[values["torque cap"].argmin()] == pytest.approx(0.215, abs=2e-3)
    assert set(values["constant cap"]) == {70.0}


def test_heat_and_drag_of_both_motors(values: dict[str, Row]) -> None:
    constant, ohm = 0.09549296586, 0.186
    current_a = -FORCES_N * LEVERS_M / constant
    np.testing.assert_allclose(values["heat"], 2.0 * ohm * (current_a / 2.0) ** 2, rtol=1e-12)
    np.testing.assert_allclose(values["drag"], constant**2 / ohm * (SPEEDS_M_S / LEVERS_M) ** 2, rtol=1e-12)


def test_the_force_that_the_cost_counts(values: dict[str, Row]) -> None:
    np.testing.assert_array_equal(values["commanded"], COMMANDED_N)
    most_n = 7.0 / LEVERS_M
    assert np.any(np.abs(FORCES_N) > most_n)
    np.testing.assert_allclose(values["stalled"], np.clip(FORCES_N, -most_n, most_n), rtol=1e-14)


@pytest.mark.parametrize("gain", GAINS)
def test_scaled_active_damping_is_a_share_of_the_gain(gain: float, values: dict[str, Row]) -> None:
    """A stiffness below that of gain 0 is none of the robot's, and has no damping."""
    assert values[f"gain {gain:g}"] == pytest.approx(3.32 * 0.25 * max(gain, 0.0), abs=1e-12)


def test_the_platform_pushes_with_its_spring_and_its_drag(values: dict[str, Row]) -> None:
    np.testing.assert_allclose(values["platform"], 1603.0 * DEPTHS_M, rtol=1e-15)
    assert set(values["platform drag"]) == {46.4}
