"""A drive that gives nothing back: its cost against the positive work of jumps integrated by scipy; kinks are met."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from simulator.accuracy.methods import outputs_of, stops_after
from simulator.accuracy.peers import peer_run, system_for
from simulator.effects.registry import EFFECTS
from simulator.error_bars import simulate_with_errors
from simulator.jump import simulate
from simulator.scene import Scene
from simulator.scene_file import load_scene
from tests.helpers.kernels import interpreted

Row = NDArray[np.float64]
G = 9.81
ON = frozenset({"rigid_ground", "touchdown_impact", "leg_damping", "latched_switching", "no_regeneration"})
PLATE = load_scene("force_plate").changed({"initial_height": 0.2}, ON, set(EFFECTS) - ON, jumps=1)
WITH = {name: load_scene(name).changed(effects_on=("no_regeneration",)) for name in ("sim2", "bed", "emulator")}
GEARED = WITH["bed"].changed({"gear_ratio": 6.0}, ("linear_leg",))
X_B, V_B, X_F, V_F, WORK = range(5)


def positive_work_j(scene: Scene) -> tuple[float, float]:
    """Work of the leg where that is positive, in the stance and up to the apex, by equations written out.

    Between two instants at which the power is zero the work is that of its whole integral, or counts as none.
    """
    rest_m, body_kg, foot_kg = scene["rest_length"], scene["body_mass"], scene["foot_mass"]
    state, parts = np.array([rest_m + scene["initial_height"], 0.0, scene["initial_height"], 0.0, 0.0]), list[Row]()

    def pull_n(y: Row, phase: str) -> float:
        spring_n = scene[f"k_{phase}"] * (y[X_B] - y[X_F] - rest_m)
        return float(spring_n + scene[f"b_{phase}"] * (y[V_B] - y[V_F]))

    def move(phase: str, flies: bool, until: Callable[[Row], float]) -> None:
        nonlocal state

        def rates(t: float, y: Row) -> list[float]:
            force_n = pull_n(y, phase)
            foot = [y[V_F], force_n / foot_kg - G] if flies else [0.0, 0.0]
            return [y[V_B], -force_n / body_kg - G, *foot, -force_n * (y[V_B] - y[V_F])]

        def event(t: float, y: Row) -> float:
            return until(y)

        event.terminal, event.direction = True, 1.0  # type: ignore[attr-defined]
        turns = [event, lambda t, y: pull_n(y, phase), lambda t, y: y[V_B] - y[V_F]]
        found = solve_ivp(rates, (0.0, 5.0), state, "DOP853", events=turns, rtol=1e-12, atol=1e-14, max_step=2e-3)
        assert found.status == 1
        at = [(0.0, state[WORK]), (found.t[-1], found.y[WORK, -1])]
        for times_s, states in zip(found.t_events, found.y_events, strict=True):
            at += [(t, y[WORK]) for t, y in zip(times_s, states, strict=True)]
        parts.append(np.diff([work for _, work in sorted(at)]))
        state = found.y[:, -1]

    move("compression", True, lambda y: -y[X_F])
    state[[V_F, WORK]], parts = 0.0, []
    short_m, slow_m_s = rest_m - scene["switch_compression"], scene["switch_speed_tolerance"]
    move("compression", False, lambda y: min(short_m - y[X_B] + y[X_F], y[V_B] + slow_m_s))
    move("extension", False, lambda y: pull_n(y, "extension") - foot_kg * G)
    stance = len(parts)
    move("extension", True, lambda y: y[X_B] - y[X_F] - rest_m + scene["rest_tolerance"])
    move("compression", True, lambda y: -y[X_F])
    gained = [float(np.maximum(part, 0.0).sum()) for part in parts]
    return sum(gained[:stance]), sum(gained)


def test_it_is_the_positive_work_of_a_jump_that_is_integrated_apart() -> None:
    jump, (stance_j, whole_j) = interpreted(simulate, PLATE, 1e-11).jump, positive_work_j(PLATE)
    assert jump.outcome == "touchdown"
    assert jump.stance_mechanical_J == pytest.approx(stance_j, rel=1e-9)
    assert jump.jump_mechanical_J == pytest.approx(whole_j, rel=1e-9)
    assert jump.jump_mechanical_J > jump.stance_mechanical_J > 1.1 * jump.leg_work_J


@pytest.mark.parametrize("scene", [*WITH.values(), GEARED], ids=lambda scene: scene.title)
def test_the_motion_is_the_same_and_braking_no_longer_pays(scene: Scene) -> None:
    braked = interpreted(simulate, scene, 1e-9).jumps
    without = interpreted(simulate, scene.changed(effects_off=("no_regeneration",)), 1e-9).jumps
    for one, other in zip(braked, without, strict=True):
        for name in ("liftoff_time_s", "apex_height_m", "max_depth_m", "stance_heat_J", "leg_work_J"):
            assert getattr(one, name) == pytest.approx(getattr(other, name), rel=1e-8, abs=1e-9), name
        for span in ("stance", "jump"):
            assert getattr(one, f"{span}_mechanical_J") > max(0.0, getattr(other, f"{span}_mechanical_J")) + 0.1
        assert abs(one.energy_residual_J) < 1e-9 * one.energy_at_play_J


@pytest.mark.parametrize("goal", [1e-4, 1e-6])
def test_a_power_that_dies_out_in_flight_hides_no_apex(goal: float) -> None:
    """It crosses zero so flatly there that a step may end behind the body's turn."""
    values = {
        "k_extension": 1237.507903571753,
        "b_extension": 25.95040305496497,
        "initial_velocity": -1.471615958628937,
        "motor_resistance": 1.0580163420833615,
        "b_ad": 0.0,
    }
    scene = load_scene("sim2").changed(values)
    without = interpreted(simulate, scene, goal).jump
    braked = interpreted(simulate, scene.changed(effects_on=("no_regeneration",)), goal).jump
    assert braked.apex_height_m == pytest.approx(without.apex_height_m, rel=goal)


@pytest.mark.parametrize("scene", [WITH["sim2"], WITH["emulator"], GEARED], ids=["sampled", "emulator", "geared"])
@pytest.mark.parametrize("goal", [1e-3, 1e-5, 1e-7])
def test_goals_are_kept_and_error_bars_hold(goal: float, scene: Scene) -> None:
    one = scene.changed(jumps=1)
    jump, finest = interpreted(simulate_with_errors, one, goal).jump, interpreted(simulate, one, 1e-13).jump
    assert not jump.ill_conditioned
    for name in ("cost_J", "stance_mechanical_J", "jump_mechanical_J", "apex_height_m"):
        off = abs(getattr(jump, name) - getattr(finest, name))
        assert off <= jump.errors[name], name  # type: ignore[index]
        assert off <= goal * abs(getattr(finest, name)), name
        coarse = getattr(interpreted(simulate, one, goal).jump, name)
        assert abs(coarse - getattr(finest, name)) <= goal * abs(getattr(finest, name)), name


def cost_by_another_solver_j(scene: Scene) -> float:
    system = system_for(scene.effects)
    parameters = np.array([scene[parameter.name] for parameter in system.composition.parameters])
    run = peer_run(system, parameters, "DOP853", 1e-11, scene.jumps, stops_after(scene))
    return float(outputs_of(scene, run.rows).values["cost_J"] or 0.0)


def test_another_solver_agrees() -> None:
    for scene in (WITH["sim2"], GEARED):
        found_j = interpreted(cost_by_another_solver_j, scene)
        assert found_j == pytest.approx(interpreted(simulate, scene, 1e-11).jump.cost_J, rel=1e-8)


def test_a_jump_that_charged_the_battery_costs_something() -> None:
    charging = GEARED.changed({"k_extension": 707.36}, effects_off=("no_regeneration",))
    assert interpreted(simulate, charging, 1e-6).jump.cost_J < 0.0
    assert interpreted(simulate, charging.changed(effects_on=("no_regeneration",)), 1e-6).jump.cost_J > 1.0
