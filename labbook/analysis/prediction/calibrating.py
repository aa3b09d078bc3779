"""Parameters of a scene fitted to what a book measured: nonlinear least squares over the means of its conditions.

A residual is the predicted mean less the measured one, over the measured one's standard error from the scatter of runs,
pooled over the conditions of an outcome. Intervals come from runs drawn anew within each condition (bootstrap), and
from the profile likelihood, which says, too, which parameters cannot be identified. Held out, each group of conditions
is predicted from a fit to the others.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from data_schema.errors import InputRefused, UsageError, unknown_name
from data_schema.outcomes import Outcome
from data_schema.vocabulary import Undefined
from labbook.analysis.comparison import pairing
from labbook.analysis.outcomes.conditions import ConditionValues
from labbook.analysis.prediction.predicting import SIMULATED
from simulator.declared import all_parameters
from simulator.jump import parameter_row
from simulator.kernel.build import kernel_for
from simulator.scene import Scene
from simulator.sweep.chunks import Recipe, recipe_of_rows
from simulator.sweep.compute import simulate_on_all_cores
from simulator.sweep.outputs import PLACE
from stats.exact.tails import t_quantile
from stats.lines.nonlinear import NonlinearFit, fit_nonlinear, profile_interval, sensitivities

Floats = NDArray[np.float64]

FITTED = ("kg_scale", "bg_scale")
"""What is fitted where nobody says more: how stiff the ground is, and how it drags."""
ACCURACY = 1e-8
"""Relative error asked of the simulator: its differences are derivatives."""
BOOTSTRAP = 200
_OUTPUT = {Outcome.JOULES: "cost_J", Outcome.APEX: "apex_height_m"}
_FEWEST_RUNS = 2


@dataclass(frozen=True, slots=True)
class Measured:
    """The runs of one condition in one outcome: their values, and its place among the conditions that are simulated."""

    outcome: Outcome
    place: int
    group: str
    values: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class Calibrated:
    """A fitted parameter with its standard error and both intervals; an end is None where there is none."""

    name: str
    unit: str
    started_at: float
    value: float
    se: float | Undefined
    bootstrap: tuple[float, float] | None
    profile: tuple[float | None, float | None]

    @property
    def identified(self) -> bool:
        """Whether the profile has both ends within what a scene can have."""
        return None not in self.profile


@dataclass(frozen=True, slots=True)
class HeldOut:
    """Means predicted from a fit to the other groups: how many lie within their intervals, of how many, their error."""

    outcome: Outcome
    within: int
    of: int
    rms: float


@dataclass(frozen=True, slots=True)
class Calibration:
    """What came of a fit; `rms` is by outcome, in its unit, `n_runs` counts the values that went in."""

    parameters: tuple[Calibrated, ...]
    chi_squared: float
    df: int
    condition: float
    rms: Mapping[Outcome, float]
    held_out: tuple[HeldOut, ...]
    n_means: int
    n_runs: Mapping[Outcome, int]
    level: float
    failed: int


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
        )
        for outcome in SIMULATED
        for one in conditions.get(outcome, ())
    ]


@dataclass(frozen=True, slots=True, eq=False)
class Problem:
    """Conditions as scenes, and what was measured of them."""

    recipe: Recipe
    table: Floats
    places: tuple[int, ...]
    measured: tuple[Measured, ...]

    def residuals(self, means: Floats, errors: Floats, which: NDArray[np.bool_]) -> Callable[[Floats], Floats]:
        """Return the function of residuals of the chosen means, shape (m, n) for parameters of shape (m, k)."""

        def of(tried: Floats) -> Floats:
            return (self.predicted(tried)[:, which] - means[which]) / errors[which]

        return of

    def predicted(self, tried: Floats) -> Floats:
        """Return every mean, shape (m, n), for parameters of shape (m, k); NaN where the robot does not jump."""
        rows, n = len(self.table), len(tried)
        table = np.tile(self.table, (n, 1))
        table[:, self.places] = np.repeat(tried, rows, axis=0)
        block = simulate_on_all_cores(self.recipe, table).reshape(n, rows, self.recipe.jumps, -1)
        by_outcome = {outcome: block[..., PLACE[name]].mean(axis=2) for outcome, name in _OUTPUT.items()}
        return np.stack([by_outcome[each.outcome][:, each.place] for each in self.measured], axis=1)


def calibrate(
    scenes: Sequence[Scene],
    measured: Sequence[Measured],
    names: Sequence[str],
    *,
    resamples: int = BOOTSTRAP,
    seed: int = 1,
    level: float = 0.95,
    progress: Callable[[str], None] = lambda _what: None,
) -> Calibration:
    """Fit parameters of the scenes to what was measured.

    Parameters
    ----------
    scenes : of the conditions, each as it was run; they have the same effects
    measured : runs by condition and outcome; `place` says which scene
    names : parameters to fit, one value for all scenes
    resamples : how often runs are drawn anew

    Raises
    ------
    UsageError for a parameter that no effect reads, that differs between conditions, or that is 0; InputRefused where
    runs do not scatter or means do not suffice.
    """
    start = [_starting(scenes, name) for name in names]
    problem = _problem(scenes, measured, names)
    means, errors = _means(measured), _errors(measured)
    low, high = (np.array([getattr(all_parameters()[name], end) for name in names]) for end in ("low", "high"))
    low = np.maximum(low, 1e-6 * np.array(start))
    every = np.ones(len(measured), np.bool_)
    progress("compiling the simulator, up to 30 s")
    kernel_for(scenes[0].effects)
    progress("fitting")
    fit = fit_nonlinear(problem.residuals(means, errors, every), start, low, high)
    drawn, failed = _bootstrap(problem, fit, errors, (low, high), resamples, seed, progress)
    progress("profile likelihood")
    parameters = tuple(
        Calibrated(
            name,
            all_parameters()[name].unit,
            start[place],
            float(fit.values[place]),
            fit.ses if isinstance(fit.ses, Undefined) else float(fit.ses[place]),
            _quantiles(drawn[:, place], level),
            profile_interval(problem.residuals(means, errors, every), fit, place, low, high, level),
        )
        for place, name in enumerate(names)
    )
    progress("predicting what is held out")
    return Calibration(
        parameters,
        fit.chi_squared,
        fit.df,
        fit.condition,
        {
            outcome: _rms(fit.residuals[_of(measured, outcome)] * errors[_of(measured, outcome)])
            for outcome in _outcomes(measured)
        },
        _held_out(problem, means, errors, fit, (low, high), level),
        len(measured),
        {
            outcome: sum(len(each.values) for each in measured if each.outcome is outcome)
            for outcome in _outcomes(measured)
        },
        level,
        failed,
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


def _problem(scenes: Sequence[Scene], measured: Sequence[Measured], names: Sequence[str]) -> Problem:
    recipe, kernel = recipe_of_rows(scenes[0], ACCURACY), kernel_for(scenes[0].effects)
    columns = [parameter.name for parameter in kernel.composition.parameters]
    return Problem(
        recipe,
        np.array([parameter_row(kernel, scene) for scene in scenes]),
        tuple(columns.index(name) for name in names),
        tuple(measured),
    )


def _outcomes(measured: Sequence[Measured]) -> list[Outcome]:
    return list(dict.fromkeys(each.outcome for each in measured))


def _of(measured: Sequence[Measured], outcome: Outcome) -> NDArray[np.bool_]:
    return np.array([each.outcome is outcome for each in measured])


def _means(measured: Sequence[Measured]) -> Floats:
    return np.array([math.fsum(each.values) / len(each.values) for each in measured])


def _errors(measured: Sequence[Measured]) -> Floats:
    """Return the standard error of each mean, from the scatter of runs pooled over the conditions of an outcome."""
    errors = np.empty(len(measured))
    for outcome in _outcomes(measured):
        own = [each for each in measured if each.outcome is outcome]
        squares = sum(float(np.var(each.values) * len(each.values)) for each in own)
        df = sum(len(each.values) - 1 for each in own)
        if df < _FEWEST_RUNS or squares == 0.0:
            raise InputRefused(
                f"the {outcome.plural} of runs under one condition do not scatter: two runs of a condition at least "
                "tell how well its mean is known."
            )
        sd = math.sqrt(squares / df)
        errors[_of(measured, outcome)] = [sd / math.sqrt(len(each.values)) for each in own]
    return errors


def _bootstrap(
    problem: Problem,
    fit: NonlinearFit,
    errors: Floats,
    bounds: tuple[Floats, Floats],
    resamples: int,
    seed: int,
    progress: Callable[[str], None],
) -> tuple[Floats, int]:
    """Return the parameters of fits to runs drawn anew within each condition, and how many fits came to nothing."""
    rng, every = np.random.default_rng(seed), np.ones(len(problem.measured), np.bool_)
    drawn, failed = [], 0
    for number in range(resamples):
        progress(f"drawing runs anew, {number + 1} of {resamples}")
        means = np.array([float(np.mean(rng.choice(each.values, len(each.values)))) for each in problem.measured])
        try:
            drawn.append(fit_nonlinear(problem.residuals(means, errors, every), fit.values, *bounds).values)
        except InputRefused:
            failed += 1
    return np.array(drawn).reshape(len(drawn), fit.values.size), failed


def _quantiles(drawn: Floats, level: float) -> tuple[float, float] | None:
    if drawn.size < 1.0 / (1.0 - level):
        return None
    low, high = np.quantile(drawn, [0.5 - 0.5 * level, 0.5 + 0.5 * level])
    return float(low), float(high)


def _held_out(
    problem: Problem, means: Floats, errors: Floats, fit: NonlinearFit, bounds: tuple[Floats, Floats], level: float
) -> tuple[HeldOut, ...]:
    """Predict each group of conditions from a fit to the others; nothing where there is one group only."""
    groups = list(dict.fromkeys(each.group for each in problem.measured))
    if len(groups) < 2:
        return ()
    ratios, differences = np.full(len(means), np.nan), np.full(len(means), np.nan)
    for group in groups:
        out = np.array([each.group == group for each in problem.measured])
        other = fit_nonlinear(problem.residuals(means, errors, ~out), fit.values, *bounds)
        of_group = problem.residuals(means, errors, out)
        left, slopes = of_group(other.values[np.newaxis, :])[0], sensitivities(of_group, other.values, *bounds)
        of_fit = (
            np.zeros(len(left))
            if isinstance(other.covariance, Undefined)
            else np.einsum("ij,jk,ik->i", slopes, other.covariance, slopes)
        )
        quantile = t_quantile(level, other.df)
        ratios[out] = left / (quantile * np.sqrt(other.spread + of_fit))
        differences[out] = left * errors[out]
    return tuple(
        HeldOut(
            outcome,
            int(np.count_nonzero(np.abs(ratios[own]) <= 1.0)),
            int(np.count_nonzero(own)),
            _rms(differences[own]),
        )
        for outcome in _outcomes(problem.measured)
        for own in [_of(problem.measured, outcome)]
    )


def _rms(values: Floats) -> float:
    return float(np.sqrt(np.mean(values**2)))
