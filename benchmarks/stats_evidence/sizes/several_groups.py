"""Several means at once: analysis of variance, Welch's, and the interval of the share of variance."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from scipy import optimize, special

from benchmarks.stats_evidence.sizes import arrays
from benchmarks.stats_evidence.sizes.design import (
    UNEQUAL_RATIOS,
    Design,
    Floats,
    Groups,
    by_layout,
    equal_groups,
    several,
)
from benchmarks.stats_evidence.sizes.method import (
    LEVEL,
    Method,
    alike,
    columns,
    number,
    of_one_interval,
    of_one_p,
    of_p,
)
from benchmarks.stats_evidence.sizes.two_groups import pooled_sd
from stats.exact.tails import f_tails
from stats.groups.anova import one_way_anova, welch_anova

STEP = 0.5
"""True distance from group to group in pooled SDs, of the interval of the share."""


def named(groups: Groups) -> dict[str, Floats]:
    """Return the groups by name, as the library takes them."""
    return {f"group {place}": group.ravel() for place, group in enumerate(groups)}


def _anova(groups: Groups, _design: Design) -> Floats:
    f, between, within = arrays.anova_f(list(map(arrays.flat, groups)))
    return of_p(special.fdtrc(between, within, f))


def _welch_f(groups: Groups) -> tuple[Floats, int, Floats]:
    """Return Welch's F and its degrees of freedom, each of shape (runs,) but the number between groups."""
    groups = list(map(arrays.flat, groups))
    k = len(groups)
    weights = np.stack([group.shape[1] / arrays.variance(group) for group in groups])
    shares = weights / weights.sum(axis=0)
    means = np.stack([group.mean(axis=1) for group in groups])
    distances = (weights * (means - (shares * means).sum(axis=0)) ** 2).sum(axis=0)
    dfs = np.array([group.shape[1] - 1 for group in groups])[:, None]
    doubt = ((1.0 - shares) ** 2 / dfs).sum(axis=0)
    f = distances / (k - 1) / (1.0 + 2.0 * (k - 2) * doubt / (k * k - 1))
    return f, k - 1, (k * k - 1) / (3.0 * doubt)


def _welch_anova(groups: Groups, _design: Design) -> Floats:
    f, between, within = _welch_f(groups)
    return of_p(special.fdtrc(between, within, f))


def _shifted(groups: Groups, design: Design) -> list[Floats]:
    return [group + STEP * place * pooled_sd(design) for place, group in enumerate(groups)]


def _noncentrality(design: Design) -> float:
    places, sizes = STEP * np.arange(len(design.n)), np.array(design.n)
    return float(sizes @ (places - sizes @ places / sizes.sum()) ** 2)


@lru_cache
def _bounds_of_f(between: int, within: int, noncentrality: float) -> tuple[float, float]:
    """Return the F between which the interval of the noncentrality holds the true one."""
    tail = (1.0 - LEVEL) / 2.0
    low = optimize.brentq(lambda f: f_tails(f, between, within, noncentrality)[0] - tail, 1e-9, 1e4, xtol=1e-13)
    return low, optimize.brentq(lambda f: f_tails(f, between, within, noncentrality)[1] - tail, 1e-9, 1e4, xtol=1e-13)


def _share_many(groups: Groups, design: Design) -> Floats:
    f, between, within = arrays.anova_f(list(map(arrays.flat, _shifted(groups, design))))
    low, high = _bounds_of_f(between, within, _noncentrality(design))
    return columns(f, (f < low) | (f > high))


def _share_one(groups: Groups, design: Design) -> tuple[float, bool]:
    found = one_way_anova(named(_shifted(groups, design)))
    noncentrality = _noncentrality(design)
    truth = noncentrality / (noncentrality + sum(design.n))
    return number(found.f), of_one_interval(found.eta_squared_ci, truth)[-1]


def _own_noncentrality(design: Design) -> float:
    """Return what Welch's F is noncentral by: distances in the SDs that each group's values have together."""
    places, sizes = STEP * pooled_sd(design) * np.arange(len(design.n)), np.array(design.n)
    of_days = (sizes - np.array(design.times)) / (sizes - 1.0) * (design.day_sd or 0.0) ** 2
    weights = sizes / (np.square(design.sds) + of_days)
    return float(weights @ (places - weights @ places / weights.sum()) ** 2)


def _own_share_many(groups: Groups, design: Design) -> Floats:
    f, between, within = _welch_f(_shifted(groups, design))
    below = special.ncfdtr(between, within, _own_noncentrality(design), f)
    tail = (1.0 - LEVEL) / 2.0
    return columns(f, (below < tail) | (below > 1.0 - tail))


def _own_share_one(groups: Groups, design: Design) -> tuple[float, bool]:
    found = welch_anova(named(_shifted(groups, design)))
    noncentrality = _own_noncentrality(design)
    truth = noncentrality / (noncentrality + sum(design.n))
    return number(found.f), of_one_interval(found.eta_squared_ci, truth)[-1]


DESIGNS = (*several(3), *by_layout(3))
FURTHER = (
    *equal_groups(5),
    *(Design(n, ratio) for n in ((2, 2, 2), (2, 4, 8)) for ratio in UNEQUAL_RATIOS),
)
METHODS = (
    Method(
        "one_way_anova",
        "size",
        (*DESIGNS, *FURTHER),
        lambda groups, _: of_one_p(one_way_anova(named(groups)).p),
        _anova,
        alike,
    ),
    Method("welch_anova", "size", (*DESIGNS, *FURTHER), lambda g, _: of_one_p(welch_anova(named(g)).p), _welch_anova),
    Method("eta_squared_ci", "coverage", DESIGNS, _share_one, _share_many, alike),
    Method("welch_eta_squared_ci", "coverage", DESIGNS, _own_share_one, _own_share_many),
)
