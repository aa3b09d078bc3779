"""What a wanted accuracy takes: for each method the coarsest setting that keeps it, and what that costs in time."""

from __future__ import annotations

from dataclasses import dataclass

from simulator.accuracy.study import AccuracyStudy, Point, Series

COST = "cost_J"
GOALS = (1e-2, 1e-6)
"""Relative errors that users want: a number to compare with a battery, and one to compare simulations with."""


@dataclass(frozen=True, slots=True)
class Need:
    """What a method needs for `goal`: the coarsest point from which on every finer one keeps it; None: it never does.

    `within_reach` is False where the goal lies under the reference's floor, so that nobody can tell.
    """

    series: Series
    output: str
    goal: float
    point: Point | None
    within_reach: bool


def needs(study: AccuracyStudy, goal: float, output: str = COST) -> tuple[Need, ...]:
    """Return what each method that covers the scene needs for a relative error in one output."""
    floor = study.reference.floor[output]
    reach = floor is not None and floor <= goal
    return tuple(
        Need(series, output, goal, _point(series, goal, output), reach) for series in study.series if not series.why_not
    )


def _point(series: Series, goal: float, output: str) -> Point | None:
    """A setting counts only if no finer one misses: an error that passes through zero once is luck. One that gave up
    has no error, and shows nothing.
    """
    kept = None
    for point in reversed(series.points):
        if point.failure:
            continue
        error = (point.errors or {}).get(output)
        if error is None or error > goal:
            break
        kept = point
    return kept
