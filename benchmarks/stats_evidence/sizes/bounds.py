"""Equivalence where the truth lies on a bound: claimed in at most one of twenty studies."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from benchmarks.stats_evidence.sizes import arrays
from benchmarks.stats_evidence.sizes.design import Design, Floats, Groups, by_layout, pairs
from benchmarks.stats_evidence.sizes.method import (
    LEVEL,
    Method,
    alike,
    columns,
    never,
    number,
    of_one_interval,
    of_one_p,
    of_p,
)
from stats.compare.equivalence import EquivalenceRoute, equivalence

CONTROL_MEAN, LOSS_PERCENT = 10.0, -10.0
"""The control's mean in SDs of the second group, and the true difference of the percent bounds."""
OVER_ARRAYS: Mapping[EquivalenceRoute, Callable[..., arrays.Estimate]] = {
    "welch": arrays.welch,
    "student": arrays.student,
}


def _raw(route: EquivalenceRoute) -> Method:
    over_arrays = OVER_ARRAYS[route]
    return Method(
        "equivalence" if route == "welch" else f"equivalence_{route}",
        "size",
        (*pairs(), *by_layout(2)),
        # One bound alone, or the other one far away: nearer bounds only make the tests err less.
        lambda groups, _: of_one_p(equivalence(groups[0].ravel(), groups[1].ravel(), high=0.0, route=route).p),
        lambda groups, _: of_p(over_arrays(*map(arrays.flat, groups)).p_below_zero),
        alike if route == "student" else never,
    )


def _in_percent(groups: Groups) -> tuple[Floats, Floats]:
    treated, control = groups
    return np.asarray((1.0 + LOSS_PERCENT / 100.0) * CONTROL_MEAN + treated), np.asarray(CONTROL_MEAN + control)


def _percent(route: EquivalenceRoute) -> tuple[Method, Method]:
    """Return the test at the truth, and the interval of level 1 - 2 alpha: all that two such tests do not reject."""
    over_arrays = OVER_ARRAYS[route]
    factor, alpha = 1.0 + LOSS_PERCENT / 100.0, (1.0 - LEVEL) / 2.0

    def one(groups: Groups, _design: Design) -> tuple[float, bool]:
        treated, control = map(np.ravel, _in_percent(groups))
        return of_one_p(equivalence(treated, control, low=None, high=LOSS_PERCENT, bounds="percent", route=route).p)

    def many(groups: Groups, _design: Design) -> Floats:
        treated, control = map(arrays.flat, _in_percent(groups))
        return of_p(over_arrays(treated, control, factor).p_below_zero)

    def interval_one(groups: Groups, _design: Design) -> tuple[float, bool]:
        treated, control = map(np.ravel, _in_percent(groups))
        found = equivalence(treated, control, low=None, high=LOSS_PERCENT, bounds="percent", route=route, alpha=alpha)
        at_truth = found.welch if route == "welch" else found.student
        return number(at_truth.t_high), of_one_interval(found.estimate_ci, LOSS_PERCENT)[-1]

    def interval_many(groups: Groups, _design: Design) -> Floats:
        treated, control = map(arrays.flat, _in_percent(groups))
        found = over_arrays(treated, control, factor)
        return columns(found.difference / found.se, found.p < 1.0 - LEVEL)

    name, designs = "equivalence_percent" + ("" if route == "welch" else f"_{route}"), (*pairs(), *by_layout(2))
    return (
        Method(name, "size", designs, one, many),
        Method(f"{name}_ci", "coverage", designs, interval_one, interval_many),
    )


METHODS = (_raw("welch"), _raw("student"), *_percent("welch"), *_percent("student"))
