"""What a design of conditions, days and runs can tell: degrees of freedom by stratum, and tests that are exact.

Conditions that share a day are compared within it; conditions that share none, only by how much days differ. Which is
which are the connected parts of the graph that joins each condition to its days (or runs).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stats.days.cells import Cells, Codes, Floats, blocks_of, parts_of


@dataclass(frozen=True, slots=True)
class Strata:
    """Degrees of freedom of the scatter between days, between runs within days, and within runs."""

    by_day: Codes
    """Part of each condition by shared days, shape (k,)."""
    by_run: Codes
    """Part of each condition by shared runs, shape (k,)."""
    day: int
    run: int
    residual: int
    n_days: int
    n_runs: int
    day_is_run: bool
    """Every day holds one run, so that the two cannot be told apart."""
    run_is_value: bool
    """Every run holds one value, so that scatter between runs and within them cannot be told apart."""
    day_is_value: bool
    """Every day holds one value."""


def strata_of(cells: Cells) -> Strata:
    """Return what the cells' design can tell; without runs, give each day as its own run."""
    by_day, by_run = parts_of(cells.condition, cells.day), parts_of(cells.condition, cells.run)
    days, runs, k = int(cells.day.max()) + 1, int(cells.run.max()) + 1, cells.n_conditions
    day = days - (int(by_day.max()) + 1)
    through_run = runs - (int(by_run.max()) + 1)
    return Strata(
        by_day=by_day,
        by_run=by_run,
        day=day,
        run=through_run - day,
        residual=cells.n - k - (through_run if days < cells.n else 0),
        n_days=days,
        n_runs=runs,
        day_is_run=days == runs,
        run_is_value=runs == cells.n,
        day_is_value=days == cells.n,
    )


@dataclass(frozen=True, slots=True)
class FixedBlocks:
    """Least squares of units of equal variance on condition, with blocks as fixed effects."""

    differences: Floats
    """Condition minus the first condition, shape (k - 1,), scaled."""
    covariance: Floats
    """Their covariance in units of `mean_square`, shape (k - 1, k - 1)."""
    mean_square: float
    df: int
    f: float | None
    """None where the units do not scatter at all."""


def fixed_blocks(cells: Cells, block: Codes) -> FixedBlocks | None:
    """Fit cell means of equal variance per value within blocks; None where no degree of freedom is left."""
    k = cells.n_conditions
    _between, within = cells.rows(np.eye(k)[:, 1:], block)
    df = cells.n - k - int(block.max())
    if df < 1 or within.shape[0] < k - 1 or k < 2:
        return None
    q, r = np.linalg.qr(within[:, :-1])
    y = within[:, -1]
    along = q.T @ y
    residual = y - q @ along
    squares = cells.sum_squares + float(residual @ residual)
    inverse = np.linalg.solve(r, np.eye(k - 1))
    differences = inverse @ along
    if cells.plain(block):
        first = cells.condition_means[0]
        differences = np.array([float(mean - first) for mean in cells.condition_means[1:]])
        along = r @ differences
    nothing = squares <= negligible(cells)
    mean_square = 0.0 if nothing else squares / df
    f = None if nothing else float(along @ along) / (k - 1) / mean_square
    return FixedBlocks(differences, inverse @ inverse.T, mean_square, df, f)


def negligible(cells: Cells) -> float:
    """Return the sum of squares up to which scatter is rounding: some last digits of values of size 1."""
    return float(cells.n) * (16.0 * float(np.finfo(np.float64).eps)) ** 2


def units_of(cells: Cells, group: Codes, size: Floats) -> Cells | None:
    """Return one value for each group (run or day), its mean; None unless groups are alike: one condition, one size."""
    blocks = blocks_of(group)
    condition = cells.condition[blocks.first]
    totals = blocks.sums(size)
    if (cells.condition != condition[group]).any() or (totals != totals[0]).any():
        return None
    means = blocks.sums(size * cells.mean) / totals
    return Cells(
        condition=condition,
        day=cells.day[blocks.first],
        run=cells.run[blocks.first],
        size=np.ones(means.size),
        mean=means,
        base=np.zeros(means.size),
        offset=means,
        sum_squares=0.0,
        unit=cells.unit,
        condition_means=cells.condition_means,
    )
