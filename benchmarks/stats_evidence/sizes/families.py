"""Families of comparisons: how often any of them errs where none has an effect."""

from __future__ import annotations

import math
from functools import lru_cache
from itertools import combinations

import numpy as np
from numpy.polynomial import Chebyshev

from benchmarks.stats_evidence.sizes import arrays
from benchmarks.stats_evidence.sizes.design import Design, Floats, Groups, by_layout, several
from benchmarks.stats_evidence.sizes.method import ALPHA, Method, alike, columns, number
from benchmarks.stats_evidence.sizes.several_groups import named
from stats.compare.two_sample import compare_two
from stats.groups.dunnett import dunnett, largest_critical
from stats.groups.multiple import holm
from stats.groups.tukey import Variances, compare_all_pairs, range_critical

FEWEST_DF, NODES = 2.0, 24


@lru_cache
def _criticals(k: int) -> Chebyshev:
    """Return the critical studentized range over 1 / df, by interpolation to some 13 digits."""
    return Chebyshev.interpolate(
        lambda inverse: np.array([range_critical(ALPHA, k, 1.0 / one) for one in inverse]),
        NODES,
        domain=[1e-3, 1.0 / FEWEST_DF],
    )


def _within(groups: Groups) -> tuple[Floats, int]:
    df = sum(group.shape[1] - 1 for group in groups)
    return np.asarray(sum((group.shape[1] - 1) * arrays.variance(group) for group in groups) / df), df


def _of_ratio(ratio: Floats) -> Floats:
    return columns(ratio, ratio >= 1.0)


def _tukey(groups: Groups, _design: Design) -> Floats:
    groups = list(map(arrays.flat, groups))
    scatter, df = _within(groups)
    critical = range_critical(ALPHA, len(groups), df)
    found = [
        np.abs(a.mean(axis=1) - b.mean(axis=1)) / np.sqrt(scatter / 2.0 * (1.0 / a.shape[1] + 1.0 / b.shape[1]))
        for a, b in combinations(groups, 2)
    ]
    return _of_ratio(np.max(found, axis=0) / critical)


def _games_howell(groups: Groups, _design: Design) -> Floats:
    found = []
    for a, b in combinations(map(arrays.flat, groups), 2):
        pair = arrays.welch(a, b)
        critical = _criticals(len(groups))(1.0 / pair.df)
        found.append(np.abs(pair.difference) / (pair.se / math.sqrt(2.0)) / critical)
    return _of_ratio(np.max(found, axis=0))


def _dunnett(groups: Groups, design: Design, *, two_sided: bool) -> Floats:
    groups = list(map(arrays.flat, groups))
    (scatter, df), (control, *treated) = _within(groups), groups
    critical = largest_critical(ALPHA, design.n[0], design.n[1:], df, two_sided=two_sided)
    distance = np.abs if two_sided else np.asarray
    found = [
        distance(group.mean(axis=1) - control.mean(axis=1))
        / np.sqrt(scatter * (1.0 / group.shape[1] + 1.0 / control.shape[1]))
        for group in treated
    ]
    return _of_ratio(np.max(found, axis=0) / critical)


def _holm(groups: Groups, _design: Design) -> Floats:
    control, *treated = map(arrays.flat, groups)
    least = np.min([arrays.welch(group, control).p for group in treated], axis=0)
    adjusted = np.minimum(1.0, len(treated) * least)
    return columns(adjusted, adjusted <= ALPHA)


def _all_pairs_one(groups: Groups, variances: Variances) -> tuple[float, bool]:
    """Return the largest difference over half its simultaneous interval, and whether any p rejects."""
    ratios, rejected = [], False
    for pair in compare_all_pairs(named(groups), variances=variances).pairs:
        low, high = pair.difference_ci if isinstance(pair.difference_ci, tuple) else (-math.inf, math.inf)
        ratios.append(2.0 * abs(number(pair.difference)) / (high - low))
        rejected |= number(pair.p) <= ALPHA
    return max(ratios), rejected


def _dunnett_one(groups: Groups, *, two_sided: bool) -> tuple[float, bool]:
    control, *treated = groups
    found = dunnett(control.ravel(), named(treated), alternative="two_sided" if two_sided else "greater")
    values = [number(one.t) for one in found.comparisons]
    ratio = max(map(abs, values) if two_sided else values) / number(found.critical)
    return ratio, min(number(one.p) for one in found.comparisons) <= ALPHA


def _holm_one(groups: Groups, _design: Design) -> tuple[float, bool]:
    control, *treated = groups
    p = {name: compare_two(group, control.ravel(), route="welch").p for name, group in named(treated).items()}
    found = holm(p, "treatments against one control", alpha=ALPHA)
    return min(map(number, found.adjusted_p)), any(rejected is True for rejected in found.rejected)


OF_THREE, OF_FOUR = ((*several(k), *by_layout(k)) for k in (3, 4))
METHODS = (
    Method(
        "tukey",
        "size",
        OF_THREE,
        lambda groups, _: _all_pairs_one(groups, "equal"),
        _tukey,
        lambda design: alike(design) and len(set(design.n)) == 1,
    ),
    Method("games_howell", "size", OF_THREE, lambda groups, _: _all_pairs_one(groups, "unequal"), _games_howell),
    *(
        Method(
            "dunnett" if two_sided else "dunnett_greater",
            "size",
            OF_FOUR,
            lambda groups, _, two_sided=two_sided: _dunnett_one(groups, two_sided=two_sided),  # type: ignore[misc]
            lambda groups, design, two_sided=two_sided: _dunnett(groups, design, two_sided=two_sided),  # type: ignore[misc]
            alike,
        )
        for two_sided in (True, False)
    ),
    Method("holm", "size", OF_FOUR, _holm_one, _holm),
)
