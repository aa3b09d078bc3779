"""Nonlinear least squares with what the data say of each parameter: covariance, condition, profile likelihood.

Residuals are in units of their standard errors. Where chi squared is above its degrees of freedom, the model or the
errors are not right, and all errors are widened by the root of their ratio; never narrowed, where it is below.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from data_schema.errors import InputRefused
from data_schema.reasons import Reason
from data_schema.vocabulary import Undefined
from stats.scatter import Floats
from stats.tails import t_quantile

Residuals = Callable[[Floats], Floats]
"""Residuals, shape (m, n), of m vectors of parameters, shape (m, k); NaN where the model gives nothing."""

_BEYOND = 1e4
"""Stands for a residual where the model gives nothing: the fit turns back."""
_STEP = 1e-4
"""Of a parameter, for differences."""
_CLOSE = 1e-3
"""Relative error of the ends of a profile's interval."""


class NothingAtStart(InputRefused):
    """The model gives nothing at the starting values of a fit."""


@dataclass(frozen=True, slots=True, eq=False)
class NonlinearFit:
    """Parameters at the least sum of squares.

    Parameters
    ----------
    values : (k,) parameters
    covariance : (k, k), widened by the root of `spread`; Undefined where a parameter changes nothing
    residuals : (n,) in standard errors, at `values`
    sensitivities : (n, k) of the residuals, by parameter
    chi_squared, df : sum of the squared residuals, and n - k
    condition : condition number of the sensitivities by relative changes of the parameters
    """

    values: Floats
    covariance: Floats | Undefined
    residuals: Floats
    sensitivities: Floats
    chi_squared: float
    df: int
    condition: float

    @property
    def spread(self) -> float:
        """By what variances are widened: chi squared over its degrees of freedom, 1 at least."""
        return max(1.0, self.chi_squared / self.df)

    @property
    def ses(self) -> Floats | Undefined:
        """Standard errors of the parameters."""
        return self.covariance if isinstance(self.covariance, Undefined) else np.sqrt(np.diag(self.covariance))


def fit_nonlinear(residuals: Residuals, start: ArrayLike, low: ArrayLike, high: ArrayLike) -> NonlinearFit:
    """Fit parameters within bounds by a trust region (scipy), from positive starting values.

    Raises `InputRefused` where there are not more residuals than parameters, `NothingAtStart` where the model gives
    nothing at the start.
    """
    from scipy.optimize import least_squares

    begin, bounds = np.asarray(start, np.float64), (np.asarray(low, np.float64), np.asarray(high, np.float64))
    at_start = residuals(begin[np.newaxis, :])[0]
    if at_start.size <= begin.size:
        raise InputRefused(
            f"{at_start.size} numbers do not tell {begin.size} parameters: fit fewer, or measure more conditions."
        )
    if not np.isfinite(at_start).all():
        raise NothingAtStart("the model gives nothing at the starting values: begin from a scene whose robot jumps.")

    found = least_squares(
        lambda shares: _known(residuals((shares * begin)[np.newaxis, :]))[0],
        np.ones_like(begin),
        lambda shares: sensitivities(residuals, shares * begin, *bounds) * begin,
        bounds=(bounds[0] / begin, bounds[1] / begin),
        x_scale="jac",
        xtol=1e-6,
        ftol=1e-8,
        gtol=1e-10,
    )
    values, left, slopes = found.x * begin, found.fun, found.jac / begin
    scaled = slopes * values
    condition = float(np.linalg.cond(scaled)) if np.isfinite(scaled).all() else math.inf
    chi_squared, df = float(left @ left), left.size - begin.size
    covariance: Floats | Undefined = Undefined(Reason.NOT_IDENTIFIED)
    if condition < 1.0 / math.sqrt(np.finfo(np.float64).eps):
        covariance = max(1.0, chi_squared / df) * np.linalg.inv(scaled.T @ scaled) * np.outer(values, values)
    return NonlinearFit(values, covariance, left, slopes, chi_squared, df, condition)


def profile_interval(
    residuals: Residuals, fit: NonlinearFit, place: int, low: ArrayLike, high: ArrayLike, level: float
) -> tuple[float | None, float | None]:
    """Return the interval in which a parameter may lie, all others refitted: None for an end that is not found.

    Its ends are where the least chi squared has risen by the spread times the square of Student's quantile (profile
    likelihood, Venzon and Moolgavkar 1988). There is none where a bound comes first, its own or that of another
    parameter, which is then not identified.
    """
    minimum = {float(fit.values[place]): (0.0, np.delete(fit.values, place))}
    profile = _Profile(residuals, fit, place, np.asarray(low, np.float64), np.asarray(high, np.float64), minimum)
    rise = fit.spread * t_quantile(level, fit.df) ** 2
    se = fit.values[place] if isinstance(fit.ses, Undefined) else float(fit.ses[place])
    below, above = (_end(profile, rise, sign * se * t_quantile(level, fit.df)) for sign in (-1.0, 1.0))
    return below, above


@dataclass(slots=True)
class _Profile:
    """The least chi squared with one parameter held, and the other parameters there, by its value.

    Each fit of the others begins where the nearest one ended, or where the fit of all would have them move from there.
    """

    residuals: Residuals
    fit: NonlinearFit
    place: int
    low: Floats
    high: Floats
    known: dict[float, tuple[float, Floats]]

    @property
    def _free(self) -> NDArray[np.bool_]:
        return np.asarray(np.arange(self.fit.values.size) != self.place)

    def rise(self, value: float) -> float:
        """Return by how much chi squared is above its minimum."""
        if value not in self.known:
            self.known[value] = self._fitted(value)
        return self.known[value][0]

    def _fitted(self, value: float) -> tuple[float, Floats]:
        free = self._free

        def held(table: Floats) -> Floats:
            return self.residuals(np.insert(table, self.place, value, axis=1))

        nearest = min(self.known, key=lambda one: abs(one - value))
        others = self.known[nearest][1]
        if not free.any():
            left = _known(held(np.empty((1, 0))))[0]
            return float(left @ left) - self.fit.chi_squared, others
        starts = [others]
        if not isinstance(self.fit.covariance, Undefined):
            moved = self.fit.covariance[free, self.place] / self.fit.covariance[self.place, self.place]
            starts.append(np.clip(others + moved * (value - nearest), self.low[free], self.high[free]))
        squares = [
            float(np.sum(_known(left) ** 2)) if np.isfinite(left).all() else math.inf for left in held(np.array(starts))
        ]
        begin = starts[int(np.argmin(squares))]
        if not math.isfinite(min(squares)):
            return math.inf, others
        found = fit_nonlinear(held, begin, self.low[free], self.high[free])
        return found.chi_squared - self.fit.chi_squared, found.values

    def at_bounds(self, value: float) -> bool:
        """Whether another parameter stands at the end of its range: what ends the interval then is that, not data."""
        free, others = self._free, self.known[value][1]
        low, high = self.low[free], self.high[free]
        return bool(np.any((others <= low * (1.0 + _CLOSE)) | (others >= high * (1.0 - _CLOSE))))


def _end(profile: _Profile, wanted: float, step: float) -> float | None:
    """Return where the rise reaches what is wanted: bracketed by steps that double, then by Brent's method.

    A step is by a factor of two at most, so that the fit of the others begins near its end. The root of the rise is
    nearly a line, so that few evaluations do.
    """
    from scipy.optimize import brentq

    bound = float((profile.low if step < 0.0 else profile.high)[profile.place])
    inside = float(profile.fit.values[profile.place])

    def beyond(value: float) -> float:
        return math.sqrt(min(max(profile.rise(value), 0.0), 1e4 * wanted)) - math.sqrt(wanted)

    while True:
        outside = inside + step if step < 0.0 else min(inside + step, bound)
        outside = max(outside, 0.5 * inside, bound) if step < 0.0 else min(outside, 2.0 * inside)
        if profile.rise(outside) >= wanted:
            end = float(brentq(beyond, inside, outside, xtol=_CLOSE * abs(outside), rtol=_CLOSE))
            profile.rise(end)
            return None if profile.at_bounds(end) else end
        if outside == bound:
            return None
        inside, step = outside, 2.0 * step


def sensitivities(residuals: Residuals, values: Floats, low: Floats, high: Floats) -> Floats:
    """Return the residuals' derivatives by each parameter, shape (n, k), from central differences within bounds."""
    steps = _STEP * values
    table = np.concatenate([values + np.diag(steps), values - np.diag(steps)])
    table = np.clip(table, low, high)
    up, down = np.split(_known(residuals(table)), 2)
    widths = np.diag(table[: values.size] - table[values.size :])
    return np.asarray(((up - down) / widths[:, np.newaxis]).T)


def _known(found: Floats) -> Floats:
    return np.where(np.isfinite(found), found, _BEYOND)
