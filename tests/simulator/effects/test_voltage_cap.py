"""The torque that a supply's voltage leaves: whole jumps against their equations written out, integrated by scipy."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from simulator.effects.registry import EFFECTS
from simulator.error_bars import simulate_with_errors
from simulator.jump import simulate
from simulator.scene import Scene
from simulator.scene_file import load_scene
from tests.helpers.kernels import interpreted

Row = NDArray[np.float64]
G = 9.81
ON = frozenset({"rigid_ground", "touchdown_impact", "leg_damping", "latched_switching", "voltage_cap"})
PLATE = load_scene("force_plate").changed({"initial_height": 0.2}, ON, set(EFFECTS) - ON, jumps=1)
FIVE_BAR = PLATE.changed({"supply_voltage": 6.0})
LINEAR = PLATE.changed({"supply_voltage": 16.0, "pinion_radius": 0.02, "gear_ratio": 2.0}, ("linear_leg",))
BED = load_scene("bed").changed({}, ("voltage_cap",), ("torque_cap",))
X_B, V_B, X_F, V_F, WORK, CAPPED = range(6)


@dataclass(slots=True)
class Robot:
    """The robot's state, the time since its touchdown, and what the motors did where the voltage was too low."""

    scene: Scene
    state: Row
    time_s: float = 0.0
    sides: set[str] = field(default_factory=set)

    def lever_m(self, length_m: float) -> float:
        """Torque of both motors over the leg's force, by the law of cosines for the angle at the motors."""
        if "linear_leg" in self.scene.effects:
            return self.scene["pinion_radius"] / self.scene["gear_ratio"]
        upper_m, lower_m = self.scene["upper_link"], self.scene["lower_link"]
        cosine = (upper_m**2 + length_m**2 - lower_m**2) / (2.0 * upper_m * length_m)
        return upper_m * length_m * math.sqrt(1.0 - cosine**2) / (length_m - upper_m * cosine)

    def leg_n(self, y: Row, phase: str) -> tuple[float, bool]:
        """Force of the leg, tension positive, and whether it is less than commanded."""
        length_m, speed_m_s = float(y[X_B] - y[X_F]), float(y[V_B] - y[V_F])
        stiffness, damping = self.scene[f"k_{phase}"], self.scene[f"b_{phase}"]
        commanded_n = stiffness * (length_m - self.scene["rest_length"]) + damping * speed_m_s
        lever_m = self.lever_m(length_m)
        turning_rad_s = -math.copysign(speed_m_s / lever_m, commanded_n * speed_m_s)
        driving_v = self.scene["supply_voltage"] - self.scene["velocity_constant"] * turning_rad_s
        torque_n_m = self.scene["torque_constant"] * driving_v / self.scene["motor_resistance"]
        most_n = 2.0 * max(torque_n_m, 0.0) / lever_m
        if abs(commanded_n) <= most_n:
            return commanded_n, False
        self.sides.add("brakes" if turning_rad_s < 0.0 else "drives" if torque_n_m > 0.0 else "gives nothing")
        return math.copysign(most_n, commanded_n), True

    def move(self, phase: str, flies: bool, until: Callable[[Row], float]) -> None:
        """Go on with the gains of a phase until a function of the state rises through zero."""
        body_kg, foot_kg = self.scene["body_mass"], self.scene["foot_mass"]

        def rates(t: float, y: Row) -> list[float]:
            pull_n, capped = self.leg_n(y, phase)
            foot = [y[V_F], pull_n / foot_kg - G] if flies else [0.0, 0.0]
            return [y[V_B], -pull_n / body_kg - G, *foot, -pull_n * (y[V_B] - y[V_F]), float(capped)]

        def event(t: float, y: Row) -> float:
            return until(y)

        event.terminal, event.direction = True, 1.0  # type: ignore[attr-defined]
        found = solve_ivp(rates, (0.0, 5.0), self.state, "DOP853", events=event, rtol=1e-12, atol=1e-14, max_step=2e-3)
        assert found.status == 1
        self.state, self.time_s = found.y[:, -1], self.time_s + found.t[-1]


def wanted(scene: Scene) -> tuple[dict[str, float], set[str]]:
    """What the jump comes to by its equations: a fall, a stance of two phases, a flight of three parts."""
    rest_m, height_m, foot_kg = scene["rest_length"], scene["initial_height"], scene["foot_mass"]
    robot = Robot(scene, np.array([rest_m + height_m, 0.0, height_m, 0.0, 0.0, 0.0]))
    robot.move("compression", True, lambda y: -y[X_F])
    touchdown_s, robot.time_s = robot.time_s, 0.0
    robot.state[[V_F, WORK, CAPPED]] = 0.0
    short_m, slow_m_s = rest_m - scene["switch_compression"], scene["switch_speed_tolerance"]
    robot.move("compression", False, lambda y: min(short_m - y[X_B] + y[X_F], y[V_B] + slow_m_s))
    robot.move("extension", False, lambda y: robot.leg_n(y, "extension")[0] - foot_kg * G)
    liftoff_s, speed_m_s = robot.time_s, robot.state[V_B]
    robot.move("extension", True, lambda y: y[X_B] - y[X_F] - rest_m + scene["rest_tolerance"])
    robot.move("compression", True, lambda y: -y[V_B])
    return {
        "touchdown_time_s": touchdown_s,
        "liftoff_time_s": liftoff_s,
        "liftoff_body_velocity_m_s": speed_m_s,
        "apex_time_s": robot.time_s,
        "apex_height_m": robot.state[X_B],
        "capped_time_s": robot.state[CAPPED],
    }, robot.sides


@pytest.mark.parametrize(
    ("scene", "sides"),
    [(FIVE_BAR, {"drives", "brakes"}), (LINEAR, {"drives", "gives nothing"})],
    ids=["five-bar", "linear leg"],
)
def test_a_jump_is_that_of_its_equations_and_the_book_closes(scene: Scene, sides: set[str]) -> None:
    jump, (values, found) = interpreted(simulate, scene, 1e-11).jump, wanted(scene)
    assert found == sides
    for name, value in values.items():
        assert getattr(jump, name) == pytest.approx(value, rel=1e-9, abs=0.0), name
    assert jump.outcome == "touchdown"
    assert abs(jump.energy_residual_J) < 1e-10 * jump.energy_at_play_J


@pytest.mark.parametrize("scene", [FIVE_BAR, LINEAR, BED], ids=["five-bar", "linear leg", "grains"])
def test_it_acts_where_the_voltage_is_too_low_and_nowhere_else(scene: Scene) -> None:
    """With all the voltage that there is, and with just more than enough, a jump is that without a cap."""
    low, enough, most = (
        interpreted(simulate, scene.changed({"supply_voltage": voltage}), 1e-8).jump for voltage in (6.0, 50.0, 1e4)
    )
    without = interpreted(simulate, scene.changed(effects_off=("voltage_cap",)), 1e-8).jump
    assert most.capped_time_s == without.capped_time_s == 0.0 < low.capped_time_s
    assert low.apex_height_m is None or low.apex_height_m < 0.99 * without.apex_height_m  # type: ignore[operator]
    for jump in (enough, most):
        for name in ("liftoff_time_s", "apex_height_m", "stance_mechanical_J", "next_touchdown_time_s"):
            assert getattr(jump, name) == pytest.approx(getattr(without, name), rel=1e-8), name


@pytest.mark.parametrize(
    "scene", [FIVE_BAR, LINEAR, BED.changed({"supply_voltage": 6.0})], ids=["five-bar", "linear", "grains"]
)
@pytest.mark.parametrize("goal", [1e-4, 1e-6, 1e-8])
def test_goals_are_kept_and_error_bars_hold(goal: float, scene: Scene) -> None:
    jump, finest = interpreted(simulate_with_errors, scene, goal).jump, interpreted(simulate, scene, 1e-13).jump
    assert not jump.ill_conditioned
    assert jump.capped_time_s > 0.0
    for name in ("liftoff_time_s", "apex_height_m", "stance_mechanical_J", "capped_time_s"):
        off = abs(getattr(jump, name) - getattr(finest, name))
        assert off <= jump.errors[name], name
        assert off <= goal * abs(getattr(finest, name)), name
    assert abs(jump.energy_residual_J) < goal * jump.energy_at_play_J
