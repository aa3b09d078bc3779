"""The sampled motion: units on everything, a clock that never turns back, both sides of an event, and the result's
own numbers at its ends.
"""

from __future__ import annotations

import math

import numpy as np
import pint
import pytest
import xarray as xr

from simulator.jump import SAMPLE_EVERY_S, simulate
from simulator.kernel.layout import MODES
from simulator.parameter import GRAVITY_M_S2
from simulator.result import SceneResult
from simulator.scene_file import load_scene, shipped_scenes

UNITLESS = {"mode", "jump"}


@pytest.fixture(scope="module", params=shipped_scenes())
def result(request: pytest.FixtureRequest) -> SceneResult:
    scene = load_scene(request.param)
    values = {"b_ad": 40.0} if request.param in ("sim1", "bed") else {}
    return simulate(scene.changed(values, jumps=min(scene.jumps, 3)), 1e-8, trajectory=True)


@pytest.fixture
def motion(result: SceneResult) -> xr.Dataset:
    assert result.trajectory is not None
    return result.trajectory


def test_without_being_asked_for_there_is_none() -> None:
    assert simulate(load_scene("sim2")).trajectory is None


def test_every_variable_has_a_unit_and_a_meaning(motion: xr.Dataset) -> None:
    units: pint.UnitRegistry[float] = pint.UnitRegistry()
    for name, variable in motion.variables.items():
        assert variable.attrs["long_name"]
        assert variable.dims == ("time",)
        if name not in UNITLESS:
            assert units.Unit(variable.attrs["units"]).dimensionality is not None
            assert np.all(np.isfinite(variable.values))
    assert motion["mode"].attrs["flag_meanings"].split() == list(MODES)
    assert set(np.unique(motion["mode"])) <= set(motion["mode"].attrs["flag_values"])


def test_time_never_turns_back_nor_leaps(result: SceneResult, motion: xr.Dataset) -> None:
    """A jump's clock starts anew at touchdown: what is published adds it to the time before, to the last digit."""
    steps_s = np.diff(motion["time"].values)
    assert motion["time"].values[0] == 0.0
    assert np.all(steps_s >= -1e-14)
    assert np.all(steps_s < 1.001 * SAMPLE_EVERY_S)
    assert np.all(np.diff(motion["jump"].values) >= 0)
    assert motion["jump"].values[-1] == len(result.jumps) - 1


def test_both_ends_are_those_of_the_result(result: SceneResult, motion: xr.Dataset) -> None:
    scene, last = result.scene, result.jump
    first_sample, last_sample = motion.isel(time=0), motion.isel(time=-1)
    assert first_sample["foot_height"] == scene["initial_height"]
    assert first_sample["leg_length"] == pytest.approx(scene["rest_length"])
    assert first_sample["body_velocity"] == scene["initial_velocity"]
    for name, wanted in (
        ("time", last.touchdown_time_s + (last.next_touchdown_time_s or math.nan)),
        ("body_velocity", last.next_touchdown_body_velocity_m_s),
        ("leg_work", last.leg_work_J),
        ("mechanical_energy", last.jump_mechanical_J),
        ("heat", last.jump_heat_J),
    ):
        assert last_sample[name] == pytest.approx(wanted, rel=1e-12), name
    shortest_m = motion["leg_length"].values[motion["jump"].values == 0].min()
    assert shortest_m == pytest.approx(result.jumps[0].min_leg_length_m, rel=1e-5)


def test_an_event_has_a_sample_on_either_side(result: SceneResult, motion: xr.Dataset) -> None:
    time_s, mode, number = motion["time"].values, motion["mode"].values, motion["jump"].values
    for place, jump in enumerate(result.jumps):
        for change in jump.mode_changes[1:]:
            before = (number == place) & (np.abs(time_s - jump.touchdown_time_s - change.time_s) < 1e-12)
            sides = [MODES[one] for one in mode[before]]
            assert change.before in sides
            assert change.after in sides


def test_highest_and_lowest_point_and_lift_off_are_the_result_s(result: SceneResult, motion: xr.Dataset) -> None:
    time_s, number = motion["time"].values, motion["jump"].values
    for place, jump in enumerate(result.jumps):
        own = number == place
        after = own & (time_s >= jump.touchdown_time_s + (jump.liftoff_time_s or math.nan) - 1e-12)
        assert motion["body_height"].values[after].max() == pytest.approx(jump.apex_height_m, rel=1e-9)
        at_apex = np.abs(time_s - jump.touchdown_time_s - (jump.apex_time_s or math.nan)) < 1e-12
        there = np.flatnonzero(own & at_apex)
        assert there.size >= 2
        assert np.abs(motion["body_velocity"].values[there]).max() < 1e-7
        assert motion["foot_height"].values[there] == pytest.approx(jump.apex_foot_height_m, rel=1e-12)
        lowest_m = motion["body_height"].values[own].min()  # samples are 0.5 ms apart: at most v^2 / 2a above the turn
        assert lowest_m - 5e-6 < jump.min_body_height_m <= lowest_m
        lifted = np.flatnonzero(after)[0]
        assert motion["body_height"].values[lifted] == pytest.approx(jump.liftoff_body_height_m, rel=1e-12)
        assert motion["body_velocity"].values[lifted] == pytest.approx(jump.liftoff_body_velocity_m_s, rel=1e-12)


def test_velocities_are_the_derivatives_of_heights(motion: xr.Dataset) -> None:
    time_s = motion["time"].values
    inside = np.flatnonzero(np.diff(time_s) > 1e-5)
    steps_s = np.diff(time_s)[inside]
    for height, velocity in (("body_height", "body_velocity"), ("foot_height", "foot_velocity")):
        slope = np.diff(motion[height].values)[inside] / steps_s
        mean = 0.5 * (motion[velocity].values[inside] + motion[velocity].values[inside + 1])
        # within a step; from one jump to the next an impact stops the foot
        same = motion["jump"].values[inside] == motion["jump"].values[inside + 1]
        np.testing.assert_allclose(slope[same], mean[same], atol=5e-3)


def test_in_flight_the_force_is_that_of_spring_and_damper_between_the_steps_too() -> None:
    """Steps of flight are ten milliseconds long: what is drawn between their ends is no straight line."""
    scene = load_scene("sim2")
    motion = simulate(scene, 1e-6, trajectory=True).trajectory
    assert motion is not None
    flight = motion.isel(time=motion["mode"].values == MODES.index("flight"))
    force_n = scene["body_mass"] * (flight["body_acceleration"].values + GRAVITY_M_S2)
    stretch_m = scene["rest_length"] - flight["leg_length"].values
    speed_m_s = flight["foot_velocity"].values - flight["body_velocity"].values
    held_n = scene["k_extension"] * stretch_m + scene["b_extension"] * speed_m_s
    assert np.abs(force_n - held_n).max() < 1e-3 * np.abs(force_n).max()
