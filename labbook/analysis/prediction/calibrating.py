"""Parameters of a scene fitted to what a book measured: nonlinear least squares over the means of its conditions.

Measured means of an outcome have the scatter of runs pooled over conditions, what runs of a day have in common, and the
errors that all have from one passive-drain line: their covariance weighs the residuals (generalised least squares).
Intervals come from the profile likelihood, which says, too, which parameters cannot be identified. Held out, each group
of conditions is predicted from a fit to the others.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from data_schema.errors import InputRefused, UsageError, unknown_name
from data_schema.outcomes import Outcome
from data_schema.vocabulary import Undefined
from labbook.analysis.comparison import pairing
from labbook.analysis.outcomes.conditions import ConditionValues
from labbook.analysis.prediction.simulating import ALWAYS, ManyScenes, many_scenes
from simulator.declared import all_parameters
from simulator.scene import Scene
from stats.compare.shared_error import SharedError
from stats.lines.nonlinear import NonlinearFit, fit_nonlinear, profile_interval, sensitivities
from stats.tails import t_quantile

Floats = NDArray[np.float64]

FITTED = ("kg_scale", "bg_scale")
"""What is fitted where nobody says more: how stiff the ground is, and how it drags."""
ACCURACY = 1e-8
"""Relative error asked of the simulator: its differences are derivatives."""
_FEWEST_DF, _FEWEST_DAYS = 2, 3


@dataclass(frozen=True, slots=True)
class Measured:
    """The runs of one condition in one outcome, and its place among the conditions that are simulated.

    `days` and `shared` are those of each value: its day, and its errors in common with other runs.
    """

    outcome: Outcome
    place: int
    group: str
    values: tuple[float, ...]
    days: tuple[str, ...]
    shared: tuple[SharedError, ...] = ()

    @property
    def mean(self) -> float:
        """Their mean."""
        return math.fsum(self.values) / len(self.values)


@dataclass(frozen=True, slots=True)
class Calibrated:
    """A fitted parameter with its standard error and its interval; an end is None where there is none."""

    name: str
    unit: str
    started_at: float
    value: float
    se: float | Undefined
    profile: tuple[float | None, float | None]

    @property
    def identified(self) -> bool:
        """Whether the profile has both ends within what a scene can have."""
        return None not in self.profile

    @property
    def at_bound(self) -> bool:
        """Whether the value is the least or the largest that a scene can have."""
        about = all_parameters()[self.name]
        return min(self.value - about.low, about.high - self.value) <= 1e-6 * abs(self.value)


@dataclass(frozen=True, slots=True)
class HeldOut:
    """Means predicted from a fit to the other groups: how many lie within their intervals, of how many, their error."""

    outcome: Outcome
    within: int
    of: int
    rms: float


@dataclass(frozen=True, slots=True)
class Calibration:
    """What came of a fit; `rms` is by outcome, in its unit, `n_runs` counts the values that went in.

    `df_of_errors` are the degrees of freedom of the scatter between runs.
    """

    parameters: tuple[Calibrated, ...]
    chi_squared: float
    df: int
    df_of_errors: int
    condition: float
    rms: Mapping[Outcome, float]
    held_out: tuple[HeldOut, ...]
    n_means: int
    n_runs: Mapping[Outcome, int]
    level: float


def measured_means(
    conditions: Mapping[Outcome, Sequence[ConditionValues]], keys: Sequence[str], swept: str | None
) -> list[Measured]:
    """Return the runs by condition and simulated outcome; `keys` has the conditions in the order of their scenes."""
    return [
        Measured(
            outcome,
            keys.index(one.key),
            pairing.group_label({name: label for name, label in one.levels.items() if name != swept}),
            tuple(one.values),
            tuple(item.run.day for item in one.runs),
            tuple(item.shared for item in one.runs),
        )
        for outcome in ALWAYS
        for one in conditions.get(outcome, ())
    ]


@dataclass(frozen=True, slots=True, eq=False)
class Problem:
    """Conditions as scenes, and what was measured of them."""

    scenes: ManyScenes
    measured: tuple[Measured, ...]
    _known: dict[bytes, Floats] = field(default_factory=dict)
    """What was simulated: each fit to means drawn anew starts where the first one ended."""

    def residuals(self, means: Floats, covariance: Floats, which: NDArray[np.bool_]) -> Callable[[Floats], Floats]:
        """Return whitened residuals of the chosen means, shape (m, n), as a function of parameters, shape (m, k)."""
        root = np.linalg.cholesky(covariance[np.ix_(which, which)])

        def of(tried: Floats) -> Floats:
            left = self.predicted(tried)[:, which] - means[which]
            known = np.isfinite(left).all(axis=1)
            found = np.full_like(left, np.nan)
            found[known] = np.linalg.solve(root, left[known].T).T
            return found

        return of

    def predicted(self, tried: Floats) -> Floats:
        """Return every mean, shape (m, n), for parameters of shape (m, k); NaN where the robot does not jump."""
        name = tried.tobytes()
        if name not in self._known:
            by_outcome = self.scenes.means(tried)
            self._known[name] = np.stack([by_outcome[each.outcome][:, each.place] for each in self.measured], axis=1)
        return self._known[name]


def calibrate(
    scenes: Sequence[Scene],
    measured: Sequence[Measured],
    names: Sequence[str],
    *,
    level: float = 0.95,
    progress: Callable[[str], None] = lambda _what: None,
) -> Calibration:
    """Fit parameters of the scenes to what was measured.

    Parameters
    ----------
    scenes : of the conditions, each as it was run; they have the same effects
    measured : runs by condition and outcome; `place` says which scene
    names : parameters to fit, one value for all scenes

    Raises
    ------
    UsageError for a parameter that is named twice, differs between conditions, or is 0; UnknownName for one that the
    scene does not read; InputRefused where runs do not scatter or means do not suffice.
    """
    twice = next((name for name in names if list(names).count(name) > 1), None)
    if twice is not None:
        raise UsageError(f"{twice} is to be fitted twice: name it once.")
    start = [_starting(scenes, name) for name in names]
    progress("compiling the simulator, up to 30 s")
    problem = Problem(many_scenes(scenes, names, ACCURACY), tuple(measured))
    means = np.array([each.mean for each in measured])
    covariance, df_of_errors = _covariance(measured)
    low, high = (np.array([getattr(all_parameters()[name], end) for name in names]) for end in ("low", "high"))
    low = np.maximum(low, 1e-6 * np.array(start))
    residuals = problem.residuals(means, covariance, np.ones(len(measured), np.bool_))
    progress("fitting")
    fit = fit_nonlinear(residuals, start, low, high)
    progress("profile likelihood")
    parameters = tuple(
        Calibrated(
            name,
            all_parameters()[name].unit,
            start[place],
            float(fit.values[place]),
            fit.ses if isinstance(fit.ses, Undefined) else float(fit.ses[place]),
            profile_interval(residuals, fit, place, low, high, level),
        )
        for place, name in enumerate(names)
    )
    progress("predicting what is held out")
    left = problem.predicted(fit.values[np.newaxis, :])[0] - means
    outcomes = _outcomes(measured)
    return Calibration(
        parameters,
        fit.chi_squared,
        fit.df,
        df_of_errors,
        fit.condition,
        {outcome: _rms(left[_of(measured, outcome)]) for outcome in outcomes},
        _held_out(problem, means, covariance, fit, (low, high), level),
        len(measured),
        {outcome: sum(len(each.values) for each in measured if each.outcome is outcome) for outcome in outcomes},
        level,
    )


def _starting(scenes: Sequence[Scene], name: str) -> float:
    if name not in scenes[0].read:
        raise unknown_name("parameter that this scene reads", name, scenes[0].read)
    values = {scene[name] for scene in scenes}
    if len(values) > 1:
        raise UsageError(
            f"{name} differs between the conditions ({min(values):g} to {max(values):g}): fit another one."
        )
    (value,) = values
    if value <= 0.0:
        raise UsageError(f"{name} is {value:g} in the scene, and a fit begins above 0: set it under [simulation].")
    return value


def _outcomes(measured: Sequence[Measured]) -> list[Outcome]:
    return list(dict.fromkeys(each.outcome for each in measured))


def _of(measured: Sequence[Measured], outcome: Outcome) -> NDArray[np.bool_]:
    return np.array([each.outcome is outcome for each in measured])


def _covariance(measured: Sequence[Measured]) -> tuple[Floats, int]:
    """Return the covariance of the means, and the degrees of freedom of the scatter between runs.

    Of one outcome, means share their days, whose variance is estimated from the runs' distances from the means of their
    conditions by day, and the errors of the drain lines; different outcomes share nothing.
    """
    covariance, total_df = np.zeros((len(measured), len(measured))), 0
    for outcome in _outcomes(measured):
        own = [each for each in measured if each.outcome is outcome]
        squares = sum(float(np.var(each.values) * len(each.values)) for each in own)
        df = sum(len(each.values) - 1 for each in own)
        if df < _FEWEST_DF or squares == 0.0:
            raise InputRefused(
                f"the {outcome.plural} of runs under one condition do not scatter: two runs of a condition at least "
                "tell how well its mean is known."
            )
        within, between = _variances(own, squares / df)
        days = sorted({day for each in own for day in each.days})
        shares = np.array([[each.days.count(day) / len(each.days) for day in days] for each in own])
        terms = sorted({term for each in own for error in each.shared for term in error.terms})
        common = np.array([_common(each, terms) for each in own]).reshape(len(own), len(terms))
        part = np.diag([within / len(each.values) for each in own]) + between * shares @ shares.T + common @ common.T
        places = np.flatnonzero(_of(measured, outcome))
        covariance[np.ix_(places, places)] = part
        total_df += df
    return covariance, total_df


def _common(each: Measured, terms: Sequence[tuple[str, str]]) -> list[float]:
    """Return what the mean of a condition takes from each error in common, in standard errors of it."""
    return [math.fsum(error.terms.get(term, 0.0) for error in each.shared) / len(each.values) for term in terms]


def _variances(own: Sequence[Measured], total: float) -> tuple[float, float]:
    """Split the variance of runs about the means of their conditions into that within days and that between days.

    By the method of moments: the mean distance of a day's m runs has the variance within / m + between, but for what
    the means of conditions take of it.
    """
    by_day: dict[str, list[float]] = {}
    for each in own:
        for day, value in zip(each.days, each.values, strict=True):
            lost = math.sqrt(len(each.values) / max(1, len(each.values) - 1))
            by_day.setdefault(day, []).append(lost * (value - each.mean))
    several = [distances for distances in by_day.values() if len(distances) > 1]
    within_df = sum(len(distances) - 1 for distances in several)
    if len(by_day) < _FEWEST_DAYS or within_df == 0:
        return total, 0.0
    within = sum(float(np.var(distances) * len(distances)) for distances in several) / within_df
    excess = [float(np.mean(distances)) ** 2 - within / len(distances) for distances in by_day.values()]
    between = max(0.0, float(np.mean(excess)) * len(by_day) / (len(by_day) - 1))
    return (within, between) if within > 0.0 and between > 0.0 else (total, 0.0)


def _held_out(
    problem: Problem, means: Floats, covariance: Floats, fit: NonlinearFit, bounds: tuple[Floats, Floats], level: float
) -> tuple[HeldOut, ...]:
    """Predict each group of conditions from a fit to the others; nothing of a group without which there is none."""
    groups = list(dict.fromkeys(each.group for each in problem.measured))
    ratios, differences = np.full(len(means), np.nan), np.full(len(means), np.nan)
    for group in groups if len(groups) > 1 else ():
        out = np.array([each.group == group for each in problem.measured])
        try:
            other = fit_nonlinear(problem.residuals(means, covariance, ~out), fit.values, *bounds)
        except InputRefused:  # too few means are left
            continue
        slopes = sensitivities(problem.predicted, other.values, *bounds)[out]
        of_fit = np.zeros_like(slopes.T @ slopes) if isinstance(other.covariance, Undefined) else other.covariance
        own = other.spread * np.diag(covariance)[out] + np.sum((slopes @ of_fit) * slopes, axis=1)
        # Days that the others share with what is held out moved the fit the same way.
        root, beside = np.linalg.cholesky(covariance[np.ix_(~out, ~out)]), covariance[np.ix_(~out, out)]
        followed = np.sum((other.sensitivities @ of_fit @ slopes.T) * np.linalg.solve(root, beside), axis=0)
        errors = np.sqrt(own - 2.0 * followed)
        differences[out] = problem.predicted(other.values[np.newaxis, :])[0][out] - means[out]
        ratios[out] = differences[out] / (t_quantile(level, other.df) * errors)
    finite = np.isfinite(ratios)
    return tuple(
        HeldOut(
            outcome,
            int(np.count_nonzero(np.abs(ratios[own]) <= 1.0)),
            int(np.count_nonzero(own)),
            _rms(differences[own]),
        )
        for outcome in _outcomes(problem.measured)
        for own in [_of(problem.measured, outcome) & finite]
        if own.any()
    )


def _rms(values: Floats) -> float:
    return float(np.sqrt(np.mean(values**2)))
