"""The interval of one mean, and that of a line's slope."""

from __future__ import annotations

import numpy as np
from scipy import special

from benchmarks.stats_evidence.sizes import arrays
from benchmarks.stats_evidence.sizes.design import DISTRIBUTIONS, EVERY_N, RATIOS, Design, Floats, Groups
from benchmarks.stats_evidence.sizes.method import LEVEL, Method, alike, of_interval, of_one_interval
from data_schema.vocabulary import Undefined
from stats.regression import fit_linear
from stats.summary import describe

INTERCEPT, SLOPE = 2.0, 3.0


def _mean(groups: Groups, _design: Design) -> Floats:
    (values,) = groups
    n = values.shape[1]
    half = -special.stdtrit(n - 1, (1.0 - LEVEL) / 2.0) * np.sqrt(arrays.variance(values) / n)
    middle = values.mean(axis=1)
    return of_interval(middle - half, middle + half, 0.0)


def _mean_one(groups: Groups, _design: Design) -> tuple[float, float, bool]:
    found = describe(groups[0])
    low, high = found.ci_low, found.ci_high
    if isinstance(low, Undefined) or isinstance(high, Undefined):
        return of_one_interval(Undefined("the sample has no interval"), 0.0)
    return of_one_interval((low, high), 0.0)


def _line(groups: Groups, design: Design) -> tuple[Floats, Floats]:
    """Return equidistant x, shape (n,), and y of each study; the SD of y grows along x by `sd_ratio` in all."""
    (noise,) = groups
    x = np.linspace(0.0, 1.0, design.n[0])
    return x, np.asarray(INTERCEPT + SLOPE * x + noise * design.sd_ratio**x / design.sds[0])


def _slope(groups: Groups, design: Design) -> Floats:
    x, y = _line(groups, design)
    about = x - x.mean()
    slope = y @ about / (about @ about)
    left = y - y.mean(axis=1, keepdims=True) - slope[:, None] * about
    df = x.size - 2
    half = -special.stdtrit(df, (1.0 - LEVEL) / 2.0) * np.sqrt((left**2).sum(axis=1) / df / (about @ about))
    return of_interval(slope - half, slope + half, SLOPE)


def _slope_one(groups: Groups, design: Design) -> tuple[float, float, bool]:
    x, y = _line(groups, design)
    found = fit_linear(y, {"x": x}).ci
    return of_one_interval(found if isinstance(found, Undefined) else found[1], SLOPE)


METHODS = (
    Method(
        "mean_ci",
        "coverage",
        tuple(Design((n,), distribution=name) for name in DISTRIBUTIONS for n in EVERY_N),
        _mean_one,
        _mean,
        alike,
    ),
    Method(
        "fit_linear_ci",
        "coverage",
        tuple(Design((n,), ratio) for n in EVERY_N for ratio in RATIOS),
        _slope_one,
        _slope,
        alike,
    ),
)
