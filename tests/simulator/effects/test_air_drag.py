"""Air drag: a whole jump against its equations written out once more, integrated by scipy."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from simulator.effects.registry import EFFECTS
from simulator.jump import simulate
from simulator.scene import Scene
from simulator.scene_file import load_scene
from tests.helpers.kernels import interpreted

Row = NDArray[np.float64]
G = 9.81
ON = frozenset({"rigid_ground", "touchdown_impact", "leg_damping", "latched_switching", "air_drag"})
SCENE = load_scene("force_plate").changed({"drag_area": 0.8, "initial_height": 0.2}, ON, set(EFFECTS) - ON, jumps=1)
"""A sail on a robot of 2 kg: it costs 2 cm of a jump of 40."""
X_B, V_B, X_F, V_F, LOSS = range(5)


@dataclass(slots=True)
class Robot:
    """The robot's state, and the time since its touchdown."""

    scene: Scene
    state: Row
    time_s: float = 0.0

    def leg_n(self, y: Row, phase: str) -> float:
        stiffness, damping = self.scene[f"k_{phase}"], self.scene[f"b_{phase}"]
        return float(stiffness * (y[X_B] - y[X_F] - self.scene["rest_length"]) + damping * (y[V_B] - y[V_F]))

    def move(self, phase: str, flies: bool, until: Callable[[Row], float]) -> None:
        """Go on with the gains of a phase until a function of the state rises through zero."""
        body_kg, foot_kg = self.scene["body_mass"], self.scene["foot_mass"]
        drag_kg_m = 0.5 * self.scene["air_density"] * self.scene["drag_area"]

        def rates(t: float, y: Row) -> list[float]:
            pull_n = self.leg_n(y, phase)
            a_b = (-pull_n - drag_kg_m * y[V_B] * abs(y[V_B])) / body_kg - G
            foot = [y[V_F], pull_n / foot_kg - G] if flies else [0.0, 0.0]
            return [y[V_B], a_b, *foot, drag_kg_m * abs(y[V_B]) ** 3]

        def event(t: float, y: Row) -> float:
            return until(y)

        event.terminal, event.direction = True, 1.0  # type: ignore[attr-defined]
        found = solve_ivp(rates, (0.0, 5.0), self.state, "DOP853", events=event, rtol=1e-13, atol=1e-15, max_step=5e-3)
        assert found.status == 1
        self.state, self.time_s = found.y[:, -1], self.time_s + found.t[-1]


def wanted() -> dict[str, float]:
    """What the jump comes to by its equations: a fall, a stance of two phases, a flight of three parts."""
    rest_m, height_m, foot_kg = SCENE["rest_length"], SCENE["initial_height"], SCENE["foot_mass"]
    robot = Robot(SCENE, np.array([rest_m + height_m, 0.0, height_m, 0.0, 0.0]))
    robot.move("compression", True, lambda y: -y[X_F])
    touchdown_s, robot.time_s = robot.time_s, 0.0
    robot.state[[V_F, LOSS]] = 0.0
    short_m, slow_m_s = rest_m - SCENE["switch_compression"], SCENE["switch_speed_tolerance"]
    robot.move("compression", False, lambda y: min(short_m - y[X_B] + y[X_F], y[V_B] + slow_m_s))
    robot.move("extension", False, lambda y: robot.leg_n(y, "extension") - foot_kg * G)
    liftoff_s, speed_m_s = robot.time_s, robot.state[V_B]
    robot.move("extension", True, lambda y: y[X_B] - y[X_F] - rest_m + SCENE["rest_tolerance"])
    robot.move("compression", True, lambda y: -y[V_B])
    apex_s, apex_m = robot.time_s, robot.state[X_B]
    robot.move("compression", True, lambda y: -y[X_F])
    return {
        "touchdown_time_s": touchdown_s,
        "liftoff_time_s": liftoff_s,
        "liftoff_body_velocity_m_s": speed_m_s,
        "apex_time_s": apex_s,
        "apex_height_m": apex_m,
        "next_touchdown_time_s": robot.time_s,
        "next_touchdown_body_velocity_m_s": robot.state[V_B],
        "air_drag_loss_J": robot.state[LOSS],
    }


def test_a_jump_is_that_of_its_equations_and_the_book_closes() -> None:
    still = SCENE.changed({"air_density": 0.0}), SCENE.changed(effects_off=("air_drag",))
    jump, airless, without = (interpreted(simulate, scene, 1e-12).jump for scene in (SCENE, *still))
    for name, value in wanted().items():
        assert getattr(jump, name) == pytest.approx(value, rel=1e-11, abs=0.0), name
    assert jump.outcome == "touchdown"
    assert abs(jump.energy_residual_J) < 1e-11 * jump.energy_at_play_J
    assert without.air_drag_loss_J == airless.air_drag_loss_J == 0.0  # type: ignore[attr-defined]
    assert airless.apex_height_m == pytest.approx(without.apex_height_m, rel=1e-11)
    assert jump.apex_height_m == pytest.approx(0.396, abs=1e-3)
    assert without.apex_height_m == pytest.approx(0.417, abs=1e-3)
