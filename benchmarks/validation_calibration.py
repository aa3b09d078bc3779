"""Calibrating a scene in a closed loop: runs drawn about what the scene gives with a known ground, fitted again."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache

import numpy as np

from data_schema.outcomes import Outcome
from data_schema.vocabulary import Undefined
from labbook.analysis.prediction.calibrating import Calibration, Measured, calibrate
from simulator.jump import simulate
from simulator.scene import Scene
from simulator.scene_file import load_scene

TRUE = {"kg_scale": 1.1, "bg_scale": 1.3}
RUN_SD = {Outcome.JOULES: 1.0, Outcome.APEX: 0.003}
LEVEL = 0.95


@cache
def conditions() -> tuple[tuple[str, Scene], ...]:
    """Two feet by two stiffnesses, with and without active damping; the group is foot and stiffness."""
    scene = load_scene("bed")
    return tuple(
        (f"{radius_m} {k_n_m}", scene.changed({"foot_radius": radius_m, "k_extension": k_n_m, "b_ad": b_ad}))
        for radius_m in (0.038, 0.051)
        for k_n_m in (835.0, 1091.0)
        for b_ad in (0.0, 350.0)
    )


@cache
def true_means() -> tuple[Mapping[Outcome, float], ...]:
    """Return joules and apex height of each condition on the true ground."""
    found = []
    for _group, scene in conditions():
        jump = simulate(scene.changed(TRUE)).jump
        assert jump.apex_height_m is not None
        found.append({Outcome.JOULES: jump.cost_J, Outcome.APEX: jump.apex_height_m})
    return tuple(found)


def measured(chance: np.random.Generator, n: int = 6, day_share: float = 0.0) -> list[Measured]:
    """Draw runs of each condition, one a day on `n` days of twelve, which scatter and have days in common.

    `day_share` is the standard deviation of days over that of runs.
    """
    found = []
    day_effects = {outcome: chance.normal(0.0, day_share * sd, 12) for outcome, sd in RUN_SD.items()}
    for place, (group, _scene) in enumerate(conditions()):
        for outcome, value in true_means()[place].items():
            values = chance.normal(value, RUN_SD[outcome], n) + day_effects[outcome][:n]
            days = tuple(f"day {run}" for run in range(n))
            found.append(Measured(outcome, place, group, tuple(values.tolist()), days))
    return found


def from_means(chance: np.random.Generator, day_share: float) -> tuple[Calibration, float]:
    """Draw a campaign and fit the ground to it; beside it a number between 0 and 1 that picks a mean held out."""
    drawn = measured(chance, day_share=day_share)
    found = calibrate([scene for _group, scene in conditions()], drawn, list(TRUE), level=LEVEL)
    return found, float(chance.uniform())


def intervals(drawn: tuple[Calibration, float]) -> Mapping[str, tuple[float, float] | Undefined]:
    """Return the profile's intervals, without end where a parameter is not identified, and those of means held out.

    Of the means of an outcome that are held out one is picked at random, as they have their campaign in common: its
    interval, about its own mean, holds 0 where the prediction holds the mean.
    """
    found, picked = drawn
    ends = {one.name: one.profile for one in found.parameters}
    return {
        **{
            f"{name}, profile": (-np.inf if low is None else low, np.inf if high is None else high)
            for name, (low, high) in ends.items()
        },
        **{f"{one.outcome}, held out": (-1.0, one.within / one.of - picked) for one in found.held_out},
    }


def truths() -> dict[str, float]:
    """Return what is true of the intervals."""
    held_out = {f"{outcome}, held out": 0.0 for outcome in RUN_SD}
    return {**{f"{name}, profile": value for name, value in TRUE.items()}, **held_out}
