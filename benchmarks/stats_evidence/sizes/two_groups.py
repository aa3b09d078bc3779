"""Two means compared: Student, Welch, Welch after an F-test, and the intervals of difference and effect."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache

from scipy import optimize

from benchmarks.stats_evidence.sizes import arrays
from benchmarks.stats_evidence.sizes.design import Design, Floats, Groups, by_layout, pairs
from benchmarks.stats_evidence.sizes.method import (
    LEVEL,
    Method,
    alike,
    columns,
    never,
    number,
    of_interval,
    of_one_interval,
    of_one_p,
    of_p,
)
from stats.compare.effect_size import hedges_factor
from stats.compare.two_sample import ROUTES, Route, compare_two
from stats.exact.tails import t_tails

EFFECT = 0.8
"""True difference in pooled SDs, of the interval of Hedges's g."""
OVER_ARRAYS: dict[Route, Callable[[Floats, Floats], arrays.Estimate]] = {
    "student": arrays.student,
    "welch": arrays.welch,
    "f_then_t": arrays.f_then_t,
}


def test_of(route: Route, designs: tuple[Design, ...]) -> Method:
    """Return the test of one route."""
    return Method(
        route,
        "size",
        designs,
        lambda groups, _: of_one_p(compare_two(groups[0].ravel(), groups[1].ravel(), route).p),
        lambda groups, _: of_p(OVER_ARRAYS[route](*map(arrays.flat, groups)).p),
        alike if route == "student" else never,
    )


def _interval_of(route: Route) -> Method:
    return Method(
        f"difference_ci_{route}",
        "coverage",
        (*pairs(), *by_layout(2)),
        lambda groups, _: of_one_interval(compare_two(groups[0].ravel(), groups[1].ravel(), route).difference_ci, 0.0),
        lambda groups, _: of_interval(*OVER_ARRAYS[route](*map(arrays.flat, groups)).ends, 0.0),
        alike if route == "student" else never,
    )


def pooled_sd(design: Design) -> float:
    """Return the SD that the pooled variance estimates; of it is so much the days' as so few of them show."""
    dfs = [n - 1 for n in design.n]
    of_values = sum(df * sd * sd for df, sd in zip(dfs, design.sds, strict=True))
    of_days = sum(n - times for n, times in zip(design.n, design.times, strict=True)) * (design.day_sd or 0.0) ** 2
    return math.sqrt((of_values + of_days) / sum(dfs))


@lru_cache
def _bounds_of_t(df: float, delta: float) -> tuple[float, float]:
    """Return the t between which the interval of the noncentrality holds `delta`."""
    tail = (1.0 - LEVEL) / 2.0
    reach = abs(delta) + 200.0
    low = optimize.brentq(lambda t: t_tails(t, df, delta)[0] - tail, -reach, reach, xtol=1e-13)
    return low, optimize.brentq(lambda t: t_tails(t, df, delta)[1] - tail, -reach, reach, xtol=1e-13)


def _g_many(groups: Groups, design: Design) -> Floats:
    a, b = map(arrays.flat, groups)
    n_a, n_b = design.n
    found = arrays.student(a + EFFECT * pooled_sd(design), b)
    t = found.difference / found.se
    low, high = _bounds_of_t(n_a + n_b - 2.0, EFFECT / math.sqrt(1.0 / n_a + 1.0 / n_b))
    return columns(t, (t < low) | (t > high))


def _g_one(groups: Groups, design: Design) -> tuple[float, bool]:
    a, b = (group.ravel() for group in groups)
    found = compare_two(a + EFFECT * pooled_sd(design), b)
    missed = of_one_interval(found.hedges_g_ci, EFFECT * hedges_factor(sum(design.n) - 2.0))[-1]
    return number(found.pooled_t), missed


METHODS = (
    *(test_of(route, pairs()) for route in ROUTES),
    *(_interval_of(route) for route in ROUTES),
    Method("hedges_g_ci", "coverage", (*pairs(), *by_layout(2)), _g_one, _g_many, alike),
)
