"""Intervals and tests of runs that were all corrected with one line through idle runs (thesis 5.1.4).

The last group of a design is the idle runs (`idle_line`).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import product

import numpy as np
from scipy import special

from benchmarks.stats_evidence.sizes import arrays
from benchmarks.stats_evidence.sizes.design import EVERY_N, Design, Floats, Groups
from benchmarks.stats_evidence.sizes.idle_line import LONGEST, OF_CONTROL, corrected, half_width, line_of, ways
from benchmarks.stats_evidence.sizes.method import (
    Kind,
    Method,
    of_interval,
    of_one_interval,
    of_one_p,
    of_p,
)
from benchmarks.stats_evidence.sizes.ratios import CONTROL, FIELDS, SAVINGS_PERCENT, VARIATION
from benchmarks.stats_evidence.sizes.two_groups import OVER_ARRAYS
from stats.compare.savings import percent_savings
from stats.compare.shared_error import SharedTest, describe_shared, difference_with_shared
from stats.compare.two_sample import ROUTES, Route, compare_two
from stats.exact.numbers import as_interval

IDLE_RUNS = (3, 5, 6, 12)
"""Of which the line is made: the fewest that there may be, the most and the fewest on either side of where one
quantile does for all, and many."""
SIZES = (*((n, n) for n in EVERY_N), (5, 20), (10, 40), (3, 10))
MEANS = tuple(Design((n, idle), ratio) for n, idle, ratio in product(EVERY_N, IDLE_RUNS, (0.5, 1.0, 2.0)))
PAIRS = tuple(Design((*n, idle), ratio) for n, idle, ratio in product(SIZES, IDLE_RUNS, (0.5, 1.0, 1.5, 2.0, 3.0)))


def _own_sds(groups: Groups, design: Design) -> list[Floats]:
    """Return the groups with the SDs that are theirs: the ratio is that of both; idle runs scatter as treated ones."""
    control, treated, idle = groups
    return [control, np.asarray(treated / design.sds[1]), idle]


def _mean(groups: Groups, _design: Design) -> Floats:
    values, idle = groups
    line = line_of(idle)
    df = np.full(len(values), values.shape[1] - 1.0)
    variance = arrays.variance(values) / values.shape[1]
    half = half_width(variance, df, (line.terms(OF_CONTROL) ** 2).sum(axis=0), line.df)
    middle = values.mean(axis=1) - line.at(OF_CONTROL)
    return of_interval(middle - half, middle + half, 0.0)


def _corrected_difference(
    groups: Groups, design: Design, route: Route
) -> tuple[Floats, tuple[Floats, Floats, Floats, int]]:
    """Return the difference, and its variance, their degrees of freedom, the line's variance in it, and its own ones.

    All but the last have the shape (runs,).
    """
    control, treated, idle = _own_sds(groups, design)
    line, found = line_of(idle), OVER_ARRAYS[route](treated, control)
    shared = ((line.terms(LONGEST) - line.terms(OF_CONTROL)) ** 2).sum(axis=0)
    return found.difference - line.at(LONGEST) + line.at(OF_CONTROL), (found.se**2, found.df, shared, line.df)


def _difference(groups: Groups, design: Design, route: Route) -> Floats:
    middle, errors = _corrected_difference(groups, design, route)
    half = half_width(*errors)
    return of_interval(middle - half, middle + half, 0.0)


def _test(groups: Groups, design: Design, route: Route) -> Floats:
    difference, errors = _corrected_difference(groups, design, route)
    variance, _df, shared, _own_df = errors
    p = np.zeros_like(difference)
    widest = np.zeros_like(difference)
    for way in ways(*errors):
        se = np.sqrt(variance + way.more * shared)
        wider = way.quantile * se >= widest
        p = np.where(wider, 2.0 * special.stdtr(way.df, -np.abs(difference) / se), p)
        widest = np.maximum(widest, way.quantile * se)
    return of_p(p)


def _scaled(groups: Groups, design: Design) -> tuple[Floats, Floats, Floats]:
    """Return groups and idle runs in the unit of the savings: the largest SD is a share of the control's mean."""
    control, treated, idle = (CONTROL * VARIATION / max(design.sds) * group for group in _own_sds(groups, design))
    return CONTROL + control, np.asarray(CONTROL * (1.0 - SAVINGS_PERCENT / 100.0) + treated), idle


def _savings(groups: Groups, design: Design, name: str) -> Floats:
    control, treated, idle = _scaled(groups, design)
    line = line_of(idle)
    c, t = control.mean(axis=1) - line.at(OF_CONTROL), treated.mean(axis=1) - line.at(LONGEST)
    rho, in_c, in_t = t / c, line.terms(OF_CONTROL), line.terms(LONGEST)
    of_c, of_t = arrays.variance(control) / control.shape[1], arrays.variance(treated) / treated.shape[1]
    scatter = of_t + rho * rho * of_c
    df = scatter**2 / (of_t**2 / (treated.shape[1] - 1) + (rho * rho * of_c) ** 2 / (control.shape[1] - 1))
    shared = ((in_t - rho * in_c) ** 2).sum(axis=0)
    half = half_width(scatter, df, shared, line.df) / c
    low, high, known = 1.0 - rho - half, 1.0 - rho + half, c > 0.0
    with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
        if name == "log_ratio":
            low, high = 1.0 - rho * np.exp(half / rho), 1.0 - rho * np.exp(-half / rho)
            known = known & (rho > 0.0) & (half / rho <= 700.0)
        if name == "fieller":
            ends = [
                _fieller(
                    (c - t, c),
                    way.quantile,
                    (
                        of_t + of_c + way.more * ((in_t - in_c) ** 2).sum(axis=0),
                        of_c + way.more * (in_c * (in_c - in_t)).sum(axis=0),
                        of_c + way.more * (in_c**2).sum(axis=0),
                    ),
                )
                for way in ways(scatter, df, shared, line.df)
            ]
            low, high = np.min([end[0] for end in ends], axis=0), np.max([end[1] for end in ends], axis=0)
            known = known & np.all([end[2] > 0.0 for end in ends], axis=0)
    low, high = np.where(known, low, -np.inf), np.where(known, high, np.inf)
    return of_interval(100.0 * low, 100.0 * high, SAVINGS_PERCENT)


def _fieller(
    means: tuple[Floats, Floats], quantile: Floats, covariance: tuple[Floats, Floats, Floats]
) -> tuple[Floats, Floats, Floats]:
    """Return the ends of Fieller's interval of the first mean over the second, and what is above 0 where it is one."""
    (top, bottom), (of_top, of_both, of_bottom) = means, covariance
    quadratic = bottom**2 - quantile**2 * of_bottom
    middle = bottom * top - quantile**2 * of_both
    root = np.sqrt(np.maximum(middle**2 - quadratic * (top**2 - quantile**2 * of_top), 0.0))
    return (middle - root) / quadratic, (middle + root) / quadratic, quadratic


def _mean_one(groups: Groups, _design: Design) -> tuple[float, float, bool]:
    (values,), (error,) = corrected(groups[1], (groups[0], OF_CONTROL))
    found = describe_shared(values, error)
    return of_one_interval(as_interval(found.ci_low, found.ci_high), 0.0)


def _tested(groups: Groups, design: Design, route: Route) -> SharedTest:
    control, treated, idle = _own_sds(groups, design)
    (control, treated), errors = corrected(idle, (control, OF_CONTROL), (treated, LONGEST))
    test = compare_two(treated, control, route)
    return difference_with_shared(test.t, test.df, test.p, test.difference_ci, errors[1].minus(errors[0]))


def _difference_one(groups: Groups, design: Design, route: Route) -> tuple[float, float, bool]:
    found = _tested(groups, design, route)
    return of_one_interval(as_interval(found.ci_low, found.ci_high), 0.0)


def _test_one(groups: Groups, design: Design, route: Route) -> tuple[float, bool]:
    return of_one_p(_tested(groups, design, route).p)


def _savings_one(groups: Groups, design: Design, name: str) -> tuple[float, float, bool]:
    control, treated, idle = _scaled(groups, design)
    (control, treated), errors = corrected(idle, (control, OF_CONTROL), (treated, LONGEST))
    found = percent_savings(control, treated, shared_in_control=errors[0], shared_in_treated=errors[1])
    return of_one_interval(getattr(found, FIELDS[name]), SAVINGS_PERCENT)


def _of_two(name: str, kind: Kind, one: Callable[..., Sequence[float]], many: Callable[..., Floats], of: str) -> Method:
    return Method(name, kind, PAIRS, lambda g, design: one(g, design, of), lambda g, design: many(g, design, of))


METHODS = (
    Method("mean_ci_shared", "coverage", MEANS, _mean_one, _mean),
    *(_of_two(f"difference_ci_{route}_shared", "coverage", _difference_one, _difference, route) for route in ROUTES),
    *(_of_two(f"{name}_shared", "coverage", _savings_one, _savings, name) for name in FIELDS),
    *(_of_two(f"{route}_shared", "size", _test_one, _test, route) for route in ROUTES),
)
