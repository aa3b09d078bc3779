"""The mixed model of conditions over days, fitted and put into numbers of the values' own unit.

Degrees of freedom are Satterthwaite's, as lmerTest computes them, from exact derivatives of the deviance. A contrast
l'b has the variance v = l'Cl, which depends on the variance parameters (theta, sigma). These are known only to A, twice
the inverse Hessian of the REML deviance; then df = 2 v^2 / (g'Ag) with g the gradient of v. lmerTest takes both
derivatives numerically and keeps them to some 8 digits; its cut-off for small curvatures depends on the unit of the
data (it warns for values in the thousands and more). Here neither happens.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from data_schema.reasons import Reason
from data_schema.vocabulary import Undefined
from stats.days.blocked_result import ConditionMean, Contrast
from stats.days.cells import Cells, Floats, blocks_of
from stats.days.exact_by_day import Strata, negligible
from stats.days.reml import DAY, RUN, Estimates, Profile, RemlModel, minimise
from stats.exact.tails import Tail, f_upper, t_quantile, t_two_sided


class Satterthwaite:
    """The degrees of freedom of any contrast of one fit."""

    def __init__(self, profile: Profile, gamma: Floats, degrees: int) -> None:
        """Take the fit's profile at its gamma, shape (2,), with n - k `degrees`."""
        self._profile = profile
        # At theta = 0 v does not change with theta to first order, nor does it mix with sigma: the parameter drops out.
        inner = np.flatnonzero(gamma > 0.0)
        theta = np.sqrt(gamma[inner])
        squares = profile.residual_variance * degrees
        # Second derivatives of D(theta, log sigma) = log dets + S / sigma^2 + nu log sigma^2 at the minimum.
        force = np.array(profile.pulls)[inner]
        size = inner.size + 1
        hessian = np.zeros((size, size))
        # The profiled Hessian has the term of sigma's minimum in it, -nu (S'/S)^2: take it out again.
        plain = profile.hessian[np.ix_(inner, inner)] + degrees * np.outer(force, force) / squares**2
        hessian[:-1, :-1] = 4.0 * np.outer(theta, theta) * plain + np.diag(2.0 * profile.gradient[inner])
        hessian[:-1, -1] = hessian[-1, :-1] = 4.0 * theta * force * degrees / squares
        hessian[-1, -1] = 4.0 * degrees
        scale = 1.0 / np.sqrt(np.maximum(np.abs(np.diag(hessian)), np.finfo(np.float64).tiny))
        curves, directions = np.linalg.eigh(hessian * np.outer(scale, scale))
        positive = curves > 1e-12
        turned = scale[:, None] * directions[:, positive]
        self._doubt = 2.0 * (turned / curves[positive]) @ turned.T
        self._inner = list(zip(inner.tolist(), theta.tolist(), strict=True))

    def df(self, weights: Floats) -> float:
        """Return the degrees of freedom of the weighted sum of means with weights of shape (k,)."""
        variance = self._profile.estimates.variance(weights)
        by_theta = [2.0 * theta * self._profile.slope(place, weights) for place, theta in self._inner]
        gradient = np.array([*by_theta, 2.0 * variance])
        return 2.0 * variance**2 / float(gradient @ self._doubt @ gradient)

    def f_test(self, contrasts: Floats) -> tuple[float, float] | None:
        """Return F of all contrasts being 0 and its denominator's degrees of freedom.

        `contrasts` has shape (q, k), and its rows add up to 0.

        F is split into t-tests of uncorrelated contrasts whose degrees of freedom are joined through the expected
        values of their squares (Fai and Cornelius); where they differ, the result depends on the contrasts chosen,
        though not on how rows of unit length at right angles to each other are turned.
        None where the contrasts' standard errors are so far apart (1e10) that the smallest is lost.
        """
        estimates = self._profile.estimates
        turn, errors, _right = np.linalg.svd(estimates.root(contrasts), full_matrices=False)
        if errors[-1] <= 1e-10 * errors[0]:
            return None
        turned = turn.T @ contrasts
        q = errors.size
        found = turned[:, 1:] @ estimates.differences()
        f = float(np.sum((found / errors) ** 2)) / (q * self._profile.residual_variance)
        single = [self.df(row) for row in turned]
        if max(single) - min(single) < 1e-8:
            return f, float(np.mean(single))
        if min(single) <= 2.0:
            return f, 2.0
        expected = sum(df / (df - 2.0) for df in single)
        return f, 2.0 * expected / (expected - q)


FAR = 1e12
"""Variance of days over that of values that stands for infinite: only comparisons within days count."""


@dataclass(frozen=True, slots=True)
class Fitted:
    """A design to be fitted: its cells, what it can estimate, the names of its conditions, the level of intervals."""

    cells: Cells
    strata: Strata
    with_runs: bool
    names: tuple[str, ...]
    level: float


@dataclass(frozen=True, slots=True)
class Overall:
    """The F-test of all conditions being equal; fields as those of `BlockedByDay`."""

    f: float
    df_within: float
    lmertest_df_within: float
    tail: Tail


@dataclass(frozen=True, slots=True)
class Fit:
    """The parts of `BlockedByDay` that come from the mixed model."""

    conditions: tuple[ConditionMean, ...]
    contrasts: tuple[Contrast, ...]
    day_variance: float | Undefined
    run_variance: float | Undefined
    residual_variance: float | Undefined
    day_ratio: float
    singular: bool | Undefined
    reml_criterion: float | Undefined
    overall: Overall | Undefined
    """Of all conditions being equal."""


def fit_by_day(design: Fitted, days_of: list[int]) -> Fit:
    """Fit the design by REML; `days_of` holds the number of days of each condition."""
    cells, strata = design.cells, design.strata
    model = RemlModel(cells)
    free = (strata.day > 0 and not strata.day_is_value, design.with_runs and strata.run > 0)
    squares = _residual_squares(cells, free)
    untested = _untested(design, squares)
    if untested is not None:
        gamma = np.array([FAR if each else 0.0 for each in free])
        return _without(design, days_of, model.estimates(gamma), float(gamma[DAY]), untested)
    total = cells.sum_squares + float(cells.size @ cells.mean**2)
    gamma = minimise(model, free, 100.0 * (1.0 + total / (squares / strata.residual)))
    profile = model.at(gamma)
    doubt = Satterthwaite(profile, gamma, model.degrees)
    unknown = _unknown_variance(design, free)
    conditions = [_mean(design, profile, doubt, place, days_of[place], unknown) for place in range(len(design.names))]
    contrasts = [_contrast(design, profile, doubt, place) for place in range(1, len(design.names))]
    lacking = next((each.p for each in contrasts if isinstance(each.p, Undefined)), None)
    if len(design.names) < 2:
        lacking = Undefined(Reason.ONE_CONDITION)
    overall = _f_test(cells, doubt) if lacking is None else lacking
    variance = profile.residual_variance
    return Fit(
        conditions=tuple(conditions),
        contrasts=tuple(contrasts),
        day_variance=_variance(design, gamma[DAY] * variance) if free[DAY] else _no_day_variance(design),
        run_variance=_variance(design, gamma[RUN] * variance) if free[RUN] else _no_run_variance(),
        residual_variance=_variance(design, variance),
        day_ratio=float(gamma[DAY]),
        singular=any(each and value == 0.0 for each, value in zip(free, gamma, strict=True)),
        reml_criterion=profile.deviance + 2.0 * model.degrees * cells.unit.exponent * math.log(2.0),
        overall=overall,
    )


def _f_test(cells: Cells, doubt: Satterthwaite) -> Overall | Undefined:
    k = cells.n_conditions
    # Rows at right angles to the mean of all and to each other: another order of conditions only turns them.
    turned = blocks_of(np.zeros(k, dtype=np.intp)).reflected(np.ones(k), np.eye(k))
    found, by_type_one = doubt.f_test(turned[1:]), doubt.f_test(_type_one_contrasts(cells))
    if found is None or by_type_one is None:
        return Undefined(Reason.DAYS_TOO_DIFFERENT)
    return Overall(*found, by_type_one[1], f_upper(found[0], k - 1, found[1]))


def _variance(design: Fitted, scaled: float) -> float | Undefined:
    return design.cells.unit.spread(scaled, "the variance", power=2)


def _residual_squares(cells: Cells, free: tuple[bool, bool]) -> float:
    """Return the sum of squares that conditions and the terms of the model leave over."""
    block = cells.run if free[RUN] else cells.day if free[DAY] else np.zeros_like(cells.day)
    between, within = cells.rows(np.eye(cells.n_conditions), block)
    rows = within if any(free) else np.concatenate([between, within])
    solution = np.linalg.lstsq(rows[:, :-1], rows[:, -1], rcond=None)[0]
    left = rows[:, -1] - rows[:, :-1] @ solution
    return cells.sum_squares + float(left @ left)


def _untested(design: Fitted, squares: float) -> Undefined | None:
    if design.strata.residual < 1:
        return Undefined(Reason.NO_DF_LEFT)
    if squares <= negligible(design.cells):
        return Undefined(Reason.NO_SCATTER_WITHIN_DAYS)
    return None


def _unknown_variance(design: Fitted, free: tuple[bool, bool]) -> Undefined | None:
    """Return why a mean, unlike a difference, has no standard error for other days and runs."""
    if design.strata.day_is_value:
        return None
    if not free[DAY]:
        return _no_day_variance(design)
    return _no_run_variance() if design.with_runs and not free[RUN] else None


def _no_day_variance(design: Fitted) -> Undefined:
    if design.strata.day_is_value:
        return Undefined(Reason.ONE_VALUE_A_DAY)
    if design.strata.n_days == 1:
        return Undefined(Reason.ONE_DAY)
    return Undefined(Reason.EACH_ONE_DAY)


def _no_run_variance() -> Undefined:
    return Undefined(Reason.RUN_SCATTER_UNTOLD)


def _why_not_comparable(design: Fitted, place: int) -> Undefined | None:
    """Return why a condition cannot be compared with the control, or None."""
    strata, names = design.strata, design.names
    if strata.day_is_value:
        return None
    apart = strata.by_day[place] != strata.by_day[0]
    if apart and strata.day == 0:
        return Undefined(Reason.ONE_DAY_EACH, a=names[place], b=names[0])
    if design.with_runs and not apart and strata.by_run[place] != strata.by_run[0] and strata.run == 0:
        return Undefined(Reason.ONE_RUN_EACH, a=names[place], b=names[0])
    return None


def _mean(
    design: Fitted, profile: Profile, doubt: Satterthwaite, place: int, n_days: int, unknown: Undefined | None
) -> ConditionMean:
    cells = design.cells
    weights = np.eye(len(design.names))[place]
    estimate = profile.estimates.means()[place]
    n = int(cells.size[cells.condition == place].sum())
    middle = cells.unit.value(estimate, "the mean")
    if unknown is not None:
        return ConditionMean(design.names[place], n, n_days, middle, unknown, unknown, unknown)
    se = math.sqrt(profile.residual_variance * profile.estimates.variance(weights))
    df = doubt.df(weights)
    half = t_quantile(design.level, df) * se
    ends = cells.unit.values(float(estimate - half), float(estimate + half))
    return ConditionMean(design.names[place], n, n_days, middle, cells.unit.spread(se, "the standard error"), df, ends)


def _contrast(design: Fitted, profile: Profile, doubt: Satterthwaite, place: int) -> Contrast:
    unit, names = design.cells.unit, design.names
    weights = np.eye(len(names))[place] - np.eye(len(names))[0]
    difference = float(profile.estimates.differences()[place - 1])
    none = _why_not_comparable(design, place)
    if none is not None:
        return Contrast(names[place], names[0], unit.difference(difference, "the difference"), *(none,) * 6)
    se = math.sqrt(profile.residual_variance * profile.estimates.variance(weights))
    df = doubt.df(weights)
    half = t_quantile(design.level, df) * se
    t = difference / se
    tail = t_two_sided(t, df)
    return Contrast(
        condition=names[place],
        control=names[0],
        difference=unit.difference(difference, "the difference"),
        se=unit.spread(se, "the standard error"),
        df=df,
        t=t,
        p=tail.p,
        log10_p=tail.log10_p,
        interval=unit.differences(difference - half, difference + half),
    )


def _type_one_contrasts(cells: Cells) -> Floats:
    """Return lmerTest's contrasts of one factor, shape (k - 1, k): Doolittle's rows of the cross products."""
    k = cells.n_conditions
    counts = cells.counts
    cross = np.diag(counts[1:]) - np.outer(counts[1:], counts[1:]) / counts.sum()
    lower = np.linalg.cholesky(cross)
    upper = (lower / np.diag(lower)).T
    return np.asarray(upper @ np.column_stack([-np.ones(k - 1), np.eye(k - 1)]))


def _without(design: Fitted, days_of: list[int], estimates: Estimates, day_ratio: float, none: Undefined) -> Fit:
    """Return the means and differences of a design that allows no test."""
    cells, control = design.cells, design.names[0]
    return Fit(
        conditions=tuple(
            ConditionMean(name, int(n), days, cells.unit.value(mean, "the mean"), none, none, none)
            for name, n, days, mean in zip(design.names, cells.counts, days_of, estimates.means(), strict=True)
        ),
        contrasts=tuple(
            Contrast(name, control, cells.unit.difference(float(difference), "the difference"), *(none,) * 6)
            for name, difference in zip(design.names[1:], estimates.differences(), strict=True)
        ),
        day_variance=none,
        run_variance=none,
        residual_variance=none,
        day_ratio=day_ratio,
        singular=none,
        reml_criterion=none,
        overall=none,
    )
