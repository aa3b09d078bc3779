"""The interval of one mean, those of a line's and a parabola's coefficients, and those of both at their end."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy import special

from benchmarks.stats_evidence.sizes import arrays
from benchmarks.stats_evidence.sizes.design import (
    DISTRIBUTIONS,
    EVERY_N,
    RATIOS,
    Design,
    Floats,
    Groups,
    designs_over_days,
)
from benchmarks.stats_evidence.sizes.method import LEVEL, Method, alike, of_interval, of_one_interval, there
from data_schema.reasons import Reason
from data_schema.vocabulary import Undefined
from stats.compare.summary import describe
from stats.lines.regression import fit_linear, fit_polynomial

INTERCEPT, SLOPE, BEND = 2.0, 3.0, -1.0
END = 1.0
"""Where on x, which goes from 0 to 1, the fitted response is looked at: scatter tells most there."""
LINES = tuple(Design((n,), ratio) for n in EVERY_N for ratio in RATIOS)
PARABOLAS = tuple(design for design in LINES if design.n[0] > 3)
"""Three values lie on a parabola and leave no scatter."""


def _mean(groups: Groups, _design: Design) -> Floats:
    (values,) = map(arrays.flat, groups)
    n = values.shape[1]
    half = -special.stdtrit(n - 1, (1.0 - LEVEL) / 2.0) * np.sqrt(arrays.variance(values) / n)
    middle = values.mean(axis=1)
    return of_interval(middle - half, middle + half, 0.0)


def _mean_one(groups: Groups, _design: Design) -> tuple[float, float, bool]:
    found = describe(groups[0].ravel())
    low, high = found.ci_low, found.ci_high
    if isinstance(low, Undefined) or isinstance(high, Undefined):
        return of_one_interval(Undefined(Reason.AS_SAID, said="the sample has no interval"), 0.0)
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


def _of_curve(groups: Groups, design: Design, degree: int, form: Callable[[Floats], Floats], truth: float) -> Floats:
    """Return the interval of what `form` makes of the columns' coefficients, the highest power first."""
    x, y = _curve(groups, design, degree)
    base, upper = np.linalg.qr(np.vander(x, degree + 1))
    weights = y @ base
    left = y - weights @ base.T
    df = x.size - degree - 1
    here = np.linalg.solve(upper.T, form(np.arange(degree, -1.0, -1.0)))
    middle = weights @ here
    half = -special.stdtrit(df, (1.0 - LEVEL) / 2.0) * np.sqrt((left**2).sum(axis=1) / df * (here @ here))
    return of_interval(middle - half, middle + half, truth)


def _at_end(groups: Groups, design: Design, degree: int) -> Floats:
    return _of_curve(groups, design, degree, lambda powers: END**powers, _truth_at_end(degree))


def _intercept(groups: Groups, design: Design) -> Floats:
    return _of_curve(groups, design, 1, lambda powers: np.equal(powers, 0.0).astype(np.float64), INTERCEPT)


def _bend(groups: Groups, design: Design) -> Floats:
    return _of_curve(groups, design, 2, lambda powers: np.equal(powers, 2.0).astype(np.float64), BEND)


def _intercept_one(groups: Groups, design: Design) -> tuple[float, float, bool]:
    x, y = _line(groups, design)
    return of_one_interval(there(fit_linear(y, {"x": x}).ci)[0], INTERCEPT)


def _bend_one(groups: Groups, design: Design) -> tuple[float, float, bool]:
    return of_one_interval(there(fit_polynomial(*_curve(groups, design, 2), 2).ci)[2], BEND)


def _curve(groups: Groups, design: Design, degree: int) -> tuple[Floats, Floats]:
    x, y = _line(groups, design)
    return x, y if degree == 1 else np.asarray(y + BEND * x * x)


def _truth_at_end(degree: int) -> float:
    return INTERCEPT + SLOPE * END + (0.0 if degree == 1 else BEND * END * END)


def _line_at_end(groups: Groups, design: Design) -> tuple[float, float, bool]:
    x, y = _curve(groups, design, 1)
    return of_one_interval(fit_linear(y, {"x": x}).at({"x": END}).ci, _truth_at_end(1))


def _parabola_at_end(groups: Groups, design: Design) -> tuple[float, float, bool]:
    x, y = _curve(groups, design, 2)
    return of_one_interval(fit_polynomial(x, y, 2).at(END).ci, _truth_at_end(2))


METHODS = (
    Method(
        "mean_ci",
        "coverage",
        (
            *(Design((n,), distribution=name) for name in DISTRIBUTIONS for n in EVERY_N),
            *designs_over_days(1, "own"),
        ),
        _mean_one,
        _mean,
        alike,
    ),
    Method(
        "fit_linear_ci",
        "coverage",
        LINES,
        _slope_one,
        _slope,
        alike,
    ),
    Method("fit_linear_intercept_ci", "coverage", LINES, _intercept_one, _intercept, alike),
    Method("fit_linear_at_ci", "coverage", LINES, _line_at_end, lambda g, design: _at_end(g, design, 1), alike),
    Method(
        "fit_polynomial_at_ci", "coverage", PARABOLAS, _parabola_at_end, lambda g, design: _at_end(g, design, 2), alike
    ),
    Method("fit_polynomial_ci", "coverage", PARABOLAS, _bend_one, _bend, alike),
)
