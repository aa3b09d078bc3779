"""Scenes whose energy book did not close, each for a reason of its own: found among 1e5 drawn at random."""

from __future__ import annotations

import functools
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pytest

from simulator.effects.registry import BOOKED
from simulator.jump import limits_for, parameter_row, simulate
from simulator.kernel.build import kernel_for
from simulator.kernel.limits import REPEATS
from simulator.kernel.rows import COLUMN, COLUMNS
from simulator.result import JumpResult
from simulator.scene_file import load_scene
from tests.helpers.kernels import interpreted

ACCURACIES = (1e-4, 1e-5, 1e-6, 1e-7, 1e-8)
BOOK = ("leg_work_J", *(energy.column for energy in BOOKED))


@dataclass(frozen=True, slots=True)
class Case:
    """A shipped scene with other values, and what goes wrong where its reason is not looked after."""

    base: str
    values: dict[str, float]
    on: tuple[str, ...] = ()
    off: tuple[str, ...] = ()
    jumps: int = field(default=1, kw_only=True)

    def simulate(self, accuracy: float) -> tuple[JumpResult, ...]:
        scene = load_scene(self.base).changed(self.values, self.on, self.off, jumps=self.jumps)
        return simulate(scene, accuracy).jumps


CASES = {
    "a foot that follows the platform, and changes its speed too fast for that": Case(
        "emulator",
        {"body_mass": 12.56, "initial_velocity": -0.4835, "initial_height": 0.2376, "platform_stiffness": 350.8}
        | {"k_compression": 280.0, "platform_damping": 3005.0, "platform_travel": 0.04162, "release_time": 0.3695}
        | {"engage_time": 0.4627, "release_tolerance": 0.008113, "b_extension": 52.3, "b_ad": 5850.0}
        | {"switch_speed_tolerance": 0.1037, "stall_torque": 12.6, "motor_resistance": 0.04183},
    ),
    "ground that stops a foot in less time than can be told": Case(
        "sim1",
        {"body_mass": 0.01935, "foot_mass": 0.0001351, "sigma": 6.238e12, "kg_scale": 2.732e8}
        | {"velocity_constant": 0.002429},
    ),
    "the same for a foot that falls, then pulled and pressed by a stiff leg": Case(
        "sim1",
        {"foot_mass": 1.097e-05, "rest_length": 1.006, "upper_link": 0.517, "lower_link": 1.391, "phi": 0.1399}
        | {"k_compression": 2.333e5, "k_extension": 1e6, "initial_velocity": -2.66, "initial_height": 0.8697}
        | {"foot_radius": 0.1349, "cone_angle": 1.377, "sigma": 2.246e12, "kg_scale": 5.53e6, "rho": 11.89}
        | {"added_mass_constant": 4.648, "b_g": 14.39, "c_g": 781.6, "bg_scale": 1529.0, "b_compression": 3.03}
        | {"b_extension": 544.9, "b_ad": 7387.0, "guard_length": 0.2069, "torque_constant": 0.9527}
        | {"motor_resistance": 1.717, "velocity_constant": 0.05966, "stall_torque": 168.8},
    ),
    "two thousand steps that all err by what is allowed, and to one side": Case(
        "sim2",
        {"body_mass": 0.3718, "foot_mass": 0.0002893, "rest_length": 0.4858, "upper_link": 0.201, "mu": 0.6234}
        | {"lower_link": 0.3833, "k_compression": 37630.0, "initial_velocity": -1.494, "initial_height": 2.0}
        | {"foot_radius": 0.01146, "cone_angle": 0.6708, "k_sh": 3.902e7, "sigma": 1.447e9, "phi": 0.5869}
        | {"rho": 677.5, "added_mass_constant": 2.134, "b_g": 1e4, "c_g": 0.0, "bg_scale": 61.15, "b_ad": 19.15}
        | {"b_compression": 1343.0, "b_extension": 1.227, "control_rate": 363.9, "guard_length": 0.003226}
        | {"force_cap": 1506.0, "torque_constant": 4.386, "motor_resistance": 0.2322},
    ),
    "a cap that is touched for less than a quarter of a step": Case(
        "emulator",
        {"foot_mass": 0.1182, "initial_height": 1.484, "platform_stiffness": 18670.0, "platform_drag": 25.89}
        | {"platform_travel": 0.1234, "release_time": 0.07161, "reset_time": 0.839, "switch_compression": 0.01262}
        | {"rest_tolerance": 0.008686, "stall_torque": 0.4775},
        ("cost_torque_cap", "held_gains_in_flight", "rail_friction"),
        ("active_damping", "cost_of_whole_jump", "leg_damping", "motor_heat"),
    ),
    "an event seen too early, and another passed on the way to it": Case(
        "emulator",
        {"body_mass": 0.01576, "foot_mass": 0.08943, "rest_length": 0.1588, "k_compression": 12640.0}
        | {"initial_height": 0.3664, "platform_drag": 24.38, "platform_travel": 0.0627, "reset_time": 0.278}
        | {"engage_time": 0.1927, "release_tolerance": 0.08851, "shortest_hold": 0.0, "switch_compression": 0.1198}
        | {"switch_speed_tolerance": 0.3311, "rest_tolerance": 0.01931},
        ("cost_torque_cap", "held_gains_in_flight", "rail_friction"),
        ("active_damping", "cost_of_whole_jump", "leg_damping", "motor_heat"),
    ),
}


def first_run(case: Case, accuracy: float) -> tuple[float, float]:
    """What the book of the first jump lacks where it is not simulated again, and the energy at play."""
    scene = load_scene(case.base).changed(case.values, case.on, case.off, jumps=1)
    kernel = kernel_for(scene.effects)
    limits, rows, counts = limits_for(accuracy), np.zeros((1, 1, len(COLUMNS))), np.zeros(1, np.int64)
    limits[REPEATS] = 0
    table = parameter_row(kernel, scene)[np.newaxis]
    kernel.batch(table, limits, rows, counts, np.zeros((0, 4)), np.zeros((0, 0)))
    return float(rows[0, 0, COLUMN["energy_residual_J"]]), float(rows[0, 0, COLUMN["energy_at_play_J"]])


def turned_over_j(jump: JumpResult) -> float:
    return sum(abs(getattr(jump, name)) for name in BOOK)


Run = tuple[tuple[float, float], tuple[JumpResult, ...]]


def run(name: str, accuracy: float) -> Run:
    """The first run and the jumps of a case."""
    case = CASES[name]
    return first_run(case, accuracy), case.simulate(accuracy)


@functools.cache
def run_once(name: str, accuracy: float) -> Run:
    """A set of effects that no shipped scene has is not worth a kernel: what is not compiled gives the same jumps."""
    return interpreted(run, name, accuracy) if CASES[name].on else run(name, accuracy)


LONG = "an event seen too early, and another passed on the way to it"
"""Interpreted, it takes seconds at each accuracy: in a soak."""


def each(*names: str) -> list[Any]:
    """Cases at every accuracy."""
    return [
        pytest.param(name, accuracy, marks=pytest.mark.soak if name == LONG else ())
        for name in names
        for accuracy in ACCURACIES
    ]


@pytest.mark.soak
@pytest.mark.parametrize("name", [name for name, case in CASES.items() if case.on])
def test_it_closes_in_a_kernel_of_its_own(name: str) -> None:
    for accuracy in ACCURACIES:
        (residual_j, at_play_j), _ = run(name, accuracy)
        assert abs(residual_j) < accuracy * at_play_j


@pytest.mark.parametrize(("name", "accuracy"), each(*(name for name in CASES if not name.startswith("two thousand"))))
def test_it_closes_at_the_first_run(name: str, accuracy: float) -> None:
    """Not only because the scene is simulated again where it does not."""
    (residual_j, at_play_j), _ = run_once(name, accuracy)
    assert abs(residual_j) < accuracy * at_play_j


@pytest.mark.parametrize(("name", "accuracy"), each(*CASES))
def test_the_energy_book_closes(name: str, accuracy: float) -> None:
    _, jumps = run_once(name, accuracy)
    for jump in jumps:
        assert jump.outcome != "step_limit"
        assert abs(jump.energy_residual_J) < accuracy * turned_over_j(jump)


def test_an_apex_within_the_landing_is_one() -> None:
    """The body has left the ground and turned, and is met by it again, all within what a landing is allowed."""
    values = {"body_mass": 2.348, "foot_mass": 3.142e-05, "rest_length": 0.2314, "upper_link": 0.1217}
    values |= {"lower_link": 0.1454, "k_compression": 82340.0, "k_extension": 4.093}
    values |= {"initial_velocity": -3.564, "initial_height": 0.4298, "foot_radius": 0.08174}
    values |= {"cone_angle": 0.502, "mu": 0.1383, "k_sh": 6462000.0, "sigma": 612900.0}
    values |= {"kg_scale": 473500.0, "phi": 0.5836, "rho": 20.13, "added_mass_constant": 1.192}
    values |= {"b_g": 71.13, "c_g": 740.0, "bg_scale": 2.572, "b_compression": 6900.0}
    values |= {"b_extension": 7147.0, "b_ad": 1624.0, "control_rate": 27210.0, "guard_length": 0.004366}
    values |= {"force_cap": 58140.0, "torque_constant": 8.232, "motor_resistance": 0.001179}
    jump = simulate(load_scene("sim2").changed(values), 1e-6).jump
    assert jump.outcome == "touchdown"
    assert jump.liftoff_body_velocity_m_s is not None
    assert jump.liftoff_body_velocity_m_s > 0.0
    assert jump.apex_height_m == pytest.approx(jump.liftoff_body_height_m, rel=1e-7)
    assert jump.apex_time_s == jump.next_touchdown_time_s


@pytest.mark.soak
@pytest.mark.parametrize("accuracy", [1e-5, 1e-7, 1e-9])
def test_heat_in_flight_is_as_accurate_as_all_else_where_the_leg_passes_straight(accuracy: float) -> None:
    """An undamped leg rings in flight; where it passes straight the lever is 0, and the heating turns sharply."""
    uncapped = ("leg_damping", "constant_force_cap", "cost_of_commanded_force")
    scene = load_scene("sim2").changed({"k_extension": 900.0}, effects_off=uncapped)
    found, finest = (simulate(scene, goal).jump for goal in (accuracy, 1e-12))
    assert found.max_leg_length_m > 0.3
    assert found.jump_heat_J == pytest.approx(finest.jump_heat_J, rel=accuracy)


@pytest.mark.soak
@pytest.mark.parametrize("k_compression", [2500.0, 1e4, 1e5])
def test_a_body_held_between_two_gains_never_lifts_off(k_compression: float) -> None:
    """Without a clock an unlatched controller whose extension is too weak switches without end, and the body stands."""
    scene = load_scene("sim2").changed({"k_compression": k_compression, "k_extension": 100.0}, (), ("sampled_control",))
    jump = simulate(scene, 1e-6).jump
    assert jump.outcome == "no_liftoff"
    assert jump.steps < 1000
