"""Equivalence where the truth lies on a bound: claimed in at most one of twenty studies."""

from __future__ import annotations

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
from stats.equivalence import EquivalenceRoute, equivalence

CONTROL_MEAN, LOSS_PERCENT = 10.0, -10.0
"""The control's mean in SDs of the second group, and the true difference of the percent bounds."""


def _raw(route: EquivalenceRoute) -> Method:
    over_arrays = {"welch": arrays.welch, "student": arrays.student}[route]
    return Method(
        "equivalence" if route == "welch" else f"equivalence_{route}",
        "size",
        (*pairs(), *by_layout(2)),
        # One bound alone, or the other one far away: nearer bounds only make the tests err less.
        lambda groups, _: of_one_p(equivalence(groups[0].ravel(), groups[1].ravel(), None, 0.0, route=route).p),
        lambda groups, _: of_p(over_arrays(*map(arrays.flat, groups)).p_below_zero),
        alike if route == "student" else never,
    )


def _in_percent(groups: Groups) -> tuple[Floats, Floats]:
    treated, control = groups
    return np.asarray((1.0 + LOSS_PERCENT / 100.0) * CONTROL_MEAN + treated), np.asarray(CONTROL_MEAN + control)


def _percent_one(groups: Groups, _design: Design) -> tuple[float, bool]:
    treated, control = _in_percent(groups)
    return of_one_p(equivalence(treated.ravel(), control.ravel(), None, LOSS_PERCENT, bounds="percent").p)


def _percent_many(groups: Groups, _design: Design) -> Floats:
    treated, control = map(arrays.flat, _in_percent(groups))
    return of_p(arrays.welch(treated, control, weight=1.0 + LOSS_PERCENT / 100.0).p_below_zero)


def _percent_interval_one(groups: Groups, _design: Design) -> tuple[float, bool]:
    treated, control = map(np.ravel, _in_percent(groups))
    found = equivalence(treated, control, None, LOSS_PERCENT, bounds="percent", alpha=(1.0 - LEVEL) / 2.0)
    return number(found.welch.t_high), of_one_interval(found.estimate_ci, LOSS_PERCENT)[-1]


def _percent_interval_many(groups: Groups, _design: Design) -> Floats:
    """Miss where the two-sided test at the truth rejects: the interval is all that such tests do not reject."""
    treated, control = map(arrays.flat, _in_percent(groups))
    found = arrays.welch(treated, control, weight=1.0 + LOSS_PERCENT / 100.0)
    return columns(found.difference / found.se, found.p < 1.0 - LEVEL)


METHODS = (
    _raw("welch"),
    _raw("student"),
    Method("equivalence_percent", "size", (*pairs(), *by_layout(2)), _percent_one, _percent_many),
    Method(
        "equivalence_percent_ci",
        "coverage",
        (*pairs(), *by_layout(2)),
        _percent_interval_one,
        _percent_interval_many,
    ),
)
