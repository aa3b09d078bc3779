"""The plane of stiffness and damping through force over position and velocity (thesis 4.2.6)."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from scipy import special

from benchmarks.stats_evidence.sizes.design import CORRELATED, Design, Floats, Groups
from benchmarks.stats_evidence.sizes.method import LEVEL, Method, alike, of_interval, of_one_interval
from stats.lines.stiffness import MINIMUM_POINTS, fit_stiffness

POINTS = (MINIMUM_POINTS, 1000)
DESIGNS = (
    *(Design((n,), ratio) for n in POINTS for ratio in (1.0, 3.0)),
    *(Design((n,), distribution=name) for name in CORRELATED for n in POINTS),
)
STIFFNESS_N_M, DAMPING_KG_S, WEIGHT_N, FORCE_SD_N = 600.0, 20.0, -15.0, 5.0
AMPLITUDE_M, FREQUENCY_RAD_S, PERIODS = 0.05, 20.0, 2.25
TRUTH = {"stiffness": STIFFNESS_N_M, "damping": DAMPING_KG_S}


@lru_cache
def _trajectory(n: int) -> Floats:
    """Return displacement, velocity and 1 of so many points, shape (n, 3)."""
    angle = np.linspace(0.0, 2.0 * np.pi * PERIODS, n)
    velocity = AMPLITUDE_M * FREQUENCY_RAD_S * np.cos(angle)
    return np.column_stack([AMPLITUDE_M * np.sin(angle), velocity, np.ones(n)])


def _forces(groups: Groups, design: Design) -> Floats:
    """Return the force at each point; its SD goes along the trajectory from 1 to `sd_ratio` times `FORCE_SD_N`."""
    (noise,) = groups
    n = design.n[0]
    scatter = noise * design.sd_ratio ** np.linspace(0.0, 1.0, n) / design.sds[0]
    return np.asarray(_trajectory(n) @ [STIFFNESS_N_M, DAMPING_KG_S, WEIGHT_N] + FORCE_SD_N * scatter)


def _one(groups: Groups, design: Design, name: str) -> tuple[float, float, bool]:
    displacement, velocity, _ones = _trajectory(design.n[0]).T
    found = fit_stiffness(displacement, velocity, _forces(groups, design))
    return of_one_interval(found.stiffness_ci if name == "stiffness" else found.damping_ci, TRUTH[name])


def _many(groups: Groups, design: Design, name: str) -> Floats:
    columns, forces = _trajectory(design.n[0]), _forces(groups, design)
    base, upper = np.linalg.qr(columns)
    inverse = np.linalg.inv(upper)
    weights = forces @ base
    left = forces - weights @ base.T
    df = len(columns) - columns.shape[1]
    row = inverse[list(TRUTH).index(name)]
    se = np.sqrt((left**2).sum(axis=1) / df * (row @ row))
    half = -special.stdtrit(df, (1.0 - LEVEL) / 2.0) * se
    return of_interval(weights @ row - half, weights @ row + half, TRUTH[name])


METHODS = tuple(
    Method(
        f"{name}_ci",
        "coverage",
        DESIGNS,
        lambda groups, design, name=name: _one(groups, design, name),  # type: ignore[misc]
        lambda groups, design, name=name: _many(groups, design, name),  # type: ignore[misc]
        alike,
        runs=10_000,
    )
    for name in TRUTH
)
