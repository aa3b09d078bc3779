"""One scene by every method at every setting: errors, evaluations, time.

What a wanted accuracy takes: for each method the coarsest setting that keeps it, and what that costs in time.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from simulator.accuracy.methods import METHODS, Attempt, Method, relative_errors, stops_after
from simulator.accuracy.peers import PeerGaveUp
from simulator.accuracy.reference_of import Reference, reference_of
from simulator.kernel.build import kernel_for
from simulator.scene import Scene

MOST_JUMPS = 4
"""Of scenes in which jumps follow each other this many are made; the last one is compared."""

RUNS = 12
LONGEST_TIMING_S = 0.6
"""Runs of one setting, and the time after which it is not run again."""


@dataclass(frozen=True, slots=True)
class Point:
    """One method at one setting.

    Relative errors are at least the reference's floor; infinite where an output was not reached, None where there is
    no relative error. `seconds` is the least of several runs after one that does not count. Where
    `failure` says why there is no result, the rest is empty.
    """

    setting: float
    outcome: str = ""
    errors: Mapping[str, float | None] | None = None
    evaluations: int = 0
    seconds: float = 0.0
    failure: str = ""


@dataclass(frozen=True, slots=True)
class Series:
    """A method's points, from coarse to fine; none where `why_not` says why the method does not cover the scene."""

    method: str
    setting: str
    unit: str
    points: tuple[Point, ...]
    why_not: str = ""


@dataclass(frozen=True, slots=True)
class AccuracyStudy:
    """A scene, cut to few jumps, what is true of it, and what each method gave."""

    scene: Scene
    reference: Reference
    series: tuple[Series, ...]


def accuracy_study(
    scene: Scene, quick: bool = False, done: Callable[[str], object] = lambda _what: None
) -> AccuracyStudy:
    """Compute a scene by every method; `done` is called after each point. `quick` takes few settings of each."""
    scene = scene.changed(jumps=min(scene.jumps, MOST_JUMPS))
    stop_after = stops_after(scene)
    kernel_for(scene.effects)
    reference = reference_of(scene, stop_after)
    done("reference")
    series = tuple(_series(method, scene, stop_after, reference, quick, done) for method in METHODS.values())
    return AccuracyStudy(scene, reference, series)


def n_points(quick: bool) -> int:
    """Return how often `accuracy_study` calls `done`, at most."""
    return 1 + sum(len(_settings(method, quick)) for method in METHODS.values())


def _settings(method: Method, quick: bool) -> tuple[float, ...]:
    return method.settings[1:-1:3] if quick else method.settings


def _series(
    method: Method,
    scene: Scene,
    stop_after: int,
    reference: Reference,
    quick: bool,
    done: Callable[[str], object],
) -> Series:
    reason = method.why_not(scene)
    if reason is not None:
        return Series(method.name, method.setting, method.unit, (), reason)
    points = []
    for setting in _settings(method, quick):
        points.append(_point(method.prepare(scene, setting, stop_after), setting, reference, quick))
        done(f"{method.name} {setting:g}")
    return Series(method.name, method.setting, method.unit, tuple(points))


def _point(attempt: Attempt, setting: float, reference: Reference, quick: bool) -> Point:
    try:
        attempt.run()
        seconds = _least_seconds(attempt, 2 if quick else RUNS)
    except PeerGaveUp as reason:
        return Point(setting, failure=str(reason))
    found, floor = attempt.found(), reference.floor
    errors = {
        name: None if error is None or floor[name] is None else max(error, floor[name] or 0.0)
        for name, error in relative_errors(found, reference.values).items()
    }
    failure = "" if found.outcome == reference.outcome else f"ended in {found.outcome}, not {reference.outcome}"
    return Point(setting, found.outcome, errors, found.evaluations, seconds, failure)


def _least_seconds(attempt: Attempt, runs: int) -> float:
    least, spent = math.inf, 0.0
    for _ in range(runs):
        start = time.perf_counter()
        attempt.run()
        taken = time.perf_counter() - start
        least, spent = min(least, taken), spent + taken
        if spent > LONGEST_TIMING_S:
            break
    return least


COST = "cost_J"
GOALS = (1e-2, 1e-6)
"""Relative errors that users want: a number to compare with a battery, and one to compare simulations with."""


@dataclass(frozen=True, slots=True)
class Need:
    """What a method needs for `goal`: the coarsest point from which on every finer one keeps it; None: it never does.

    `within_reach` is False where the goal lies below the reference's floor, so that this cannot be decided.
    """

    series: Series
    goal: float
    point: Point | None
    within_reach: bool


def needs(study: AccuracyStudy, goal: float) -> tuple[Need, ...]:
    """Return what each method that covers the scene needs for a relative error in the cost."""
    floor = study.reference.floor[COST]
    reach = floor is not None and floor <= goal
    return tuple(
        Need(series, goal, _point_needed(series, goal), reach) for series in study.series if not series.why_not
    )


def _point_needed(series: Series, goal: float) -> Point | None:
    """A setting counts only if no finer one misses: an error that passes through zero once is luck. One that gave up
    has no error, and shows nothing.
    """
    within = None
    for point in reversed(series.points):
        if point.failure:
            continue
        error = (point.errors or {}).get(COST)
        if error is None or error > goal:
            break
        within = point
    return within
