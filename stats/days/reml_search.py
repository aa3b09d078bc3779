"""The search for the lowest deviance of a mixed model over days and runs."""

from __future__ import annotations

import math
from itertools import product

import numpy as np

from stats.days.blocks import Floats
from stats.days.reml import RemlModel

STEPS = 100
SMALL_STEP = 1e-13
"""Change of log(1 + gamma * group size) at which the search ends; Newton's last step squares the one before."""

NOTHING = 1e-8
"""Below it a variance is 0, as lme4 has it (a standard deviation of 1e-4): where the deviance is flat at the boundary,
rounding would decide whether the variance counts among the unknowns."""


def minimise(model: RemlModel, free: tuple[bool, bool], largest: float) -> Floats:
    """Return the gamma, shape (2,), of the lowest deviance; what is not `free` stays 0, as lme4 leaves out a term.

    The search runs in eta = log(1 + gamma * group size), smooth at the boundary gamma = 0 and logarithmic far from it:
    from every local minimum of a grid up to `largest`, by Newton steps, held at 0 where the deviance rises from there.
    """
    allowed = np.array(free)
    top = math.log1p(largest)
    count = 10 if allowed.sum() == 1 else 7
    axis = top * np.linspace(0.0, 1.0, count) ** 1.5
    axes = [axis if each else np.zeros(1) for each in free]
    grid = np.array([[model.deviance(_gamma(model, np.array([a, b]))) for b in axes[1]] for a in axes[0]])
    ends = [
        _descend(model, np.array([axes[0][i], axes[1][j]]), allowed, 2.0 * top + 10.0)
        for i, j in product(range(grid.shape[0]), range(grid.shape[1]))
        if grid[i, j] <= grid[max(i - 1, 0) : i + 2, max(j - 1, 0) : j + 2].min()
    ]
    end = min(ends, key=lambda end: model.deviance(_gamma(model, end))) if len(ends) > 1 else ends[0]
    return _gamma(model, np.where(end < NOTHING, 0.0, end))


def _gamma(model: RemlModel, eta: Floats) -> Floats:
    return np.asarray(np.expm1(eta) / model.group_size)


def _descend(model: RemlModel, eta: Floats, allowed: np.typing.NDArray[np.bool_], top: float) -> Floats:
    here = model.at(_gamma(model, eta))
    for _ in range(STEPS):
        stretch = np.exp(eta) / model.group_size
        gradient = here.gradient * stretch
        hessian = here.hessian * np.outer(stretch, stretch) + np.diag(gradient)
        moving = allowed & ~((eta == 0.0) & (gradient >= 0.0))
        if not moving.any():
            break
        step = _newton_step(gradient[moving], hessian[np.ix_(moving, moving)])
        slack = 1e-12 * model.degrees * (1.0 + abs(here.deviance) / model.degrees)
        factor = 1.0
        while True:
            trial = eta.copy()
            trial[moving] = np.clip(eta[moving] + factor * step, 0.0, top)
            there = model.at(_gamma(model, trial))
            if there.deviance <= here.deviance + slack or factor < 1e-6:
                break
            factor /= 2.0
        change = float(np.max(np.abs(trial - eta)))
        eta, here = trial, there
        if change <= SMALL_STEP * (1.0 + float(np.max(eta))):
            break
    return eta


def _newton_step(gradient: Floats, hessian: Floats) -> Floats:
    """Return Newton's step with curvatures made positive, no longer than 2 (a factor of 7 in gamma)."""
    curves, directions = np.linalg.eigh(hessian)
    floor = 1e-8 * max(float(np.max(np.abs(curves))), float(np.max(np.abs(gradient))), 1e-300)
    step = -directions @ ((directions.T @ gradient) / np.maximum(np.abs(curves), floor))
    return np.asarray(step * min(1.0, 2.0 / max(float(np.max(np.abs(step))), 1e-300)))
