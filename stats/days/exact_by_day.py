"""Tests beside the mixed model of conditions over several days: exact ones, and paired ones on day means.

The exact tests take units of equal variance, and hold days or runs fixed:

- Conditions joined by shared days, no runs: values, day fixed. In a complete balanced design this is the F of the mixed
  model; elsewhere it leaves out the information between days, and stays exact.
- Conditions joined by shared runs: values, run fixed.
- One condition a run and runs of one size: run means, day fixed.
- One condition a day and days of one size: day means.

The paired test of two conditions takes the difference of their means on each day that holds both for one observation.
It needs no model of days and no equal scatter: with three runs of a condition against ten on each of five days, and the
few scattering twice as much, its interval covers .95 where that of the exact test covers .85.

Conditions that share a day are compared within it; conditions that share none, only by how much days differ. Which is
which are the connected parts of the graph that joins each condition to its days (or runs).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from data_schema.reasons import Reason
from data_schema.vocabulary import Undefined
from stats.checks import Sample
from stats.compare.summary import t_test
from stats.days.blocked_result import Contrast, ExactTest
from stats.days.cells import Cells, Codes, Floats, blocks_of, parts_of
from stats.exact.numbers import exact_sum, finite
from stats.exact.tails import f_upper, t_quantile, t_two_sided


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
    """Every day holds one run, so that days and runs are confounded."""
    run_is_value: bool
    """Every run holds one value, so that scatter between runs and within them is confounded."""
    day_is_value: bool
    """Every day holds one value."""


def strata_of(cells: Cells) -> Strata:
    """Return which effects the cells' design can estimate; without runs, give each day as its own run."""
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


def exact_test(
    cells: Cells, strata: Strata, with_runs: bool, names: tuple[str, ...], level: float
) -> ExactTest | Undefined:
    """Return the exact test that the design allows, or why it allows none."""
    chosen = _layout(cells, strata, with_runs)
    if isinstance(chosen, Undefined):
        return chosen
    units, block, unit_name, block_name = chosen
    found = fixed_blocks(units, block)
    if found is None:
        return Undefined(Reason.MEANS_LEAVE_NO_DF, of=unit_name)
    if found.f is None:
        return Undefined(Reason.MEANS_WITHOUT_SCATTER, of=unit_name)
    between = units.n_conditions - 1
    contrasts = []
    for place, name in enumerate(names[1:]):
        se = math.sqrt(found.mean_square * float(found.covariance[place, place]))
        difference = float(found.differences[place])
        half = t_quantile(level, found.df) * se
        t = difference / se
        tail = t_two_sided(t, found.df)
        contrasts.append(
            Contrast(
                condition=name,
                control=names[0],
                difference=units.unit.difference(difference, "the difference"),
                se=units.unit.spread(se, "the standard error"),
                df=float(found.df),
                t=t,
                p=tail.p,
                log10_p=tail.log10_p,
                interval=units.unit.differences(difference - half, difference + half),
            )
        )
    overall = f_upper(found.f, between, found.df)
    return ExactTest(
        unit=unit_name,
        block=block_name,
        balanced=_balanced(units, block),
        f=found.f,
        df_between=between,
        df_within=found.df,
        p=overall.p,
        log10_p=overall.log10_p,
        contrasts=tuple(contrasts),
    )


def _balanced(units: Cells, block: Codes) -> bool:
    if not block.any():  # nothing is held fixed
        return True
    pairs = block * units.n_conditions + units.condition
    counts = np.bincount(pairs, weights=units.size, minlength=(int(block.max()) + 1) * units.n_conditions)
    return bool((counts == counts[0]).all())


def _layout(cells: Cells, strata: Strata, with_runs: bool) -> tuple[Cells, Codes, str, str] | Undefined:
    nothing = np.zeros(cells.size.size, dtype=np.intp)
    if cells.n_conditions < 2:
        return Undefined(Reason.ONE_CONDITION)
    if strata.day_is_value:
        return cells, nothing, "value", "nothing"
    if with_runs and not strata.by_run.any():
        return cells, cells.run, "value", "run"
    if not with_runs and not strata.by_day.any():
        return cells, cells.day, "value", "day"
    units = units_of(cells, cells.run, cells.size) if with_runs else cells
    if units is None:
        return Undefined(Reason.RUNS_DIFFER_IN_SIZE)
    if with_runs and not strata.by_day.any():
        return units, units.day, "run mean", "day"
    means = units_of(units, units.day, units.size)
    if means is None:
        return Undefined(Reason.DAYS_DIFFER_IN_SIZE)
    return means, np.zeros(means.size.size, dtype=np.intp), "day mean", "nothing"


def paired_tests(
    sample: Sample, condition: Codes, day: Codes, names: tuple[str, ...], level: float
) -> tuple[Contrast, ...]:
    """Return every other condition minus the first by Student's test of the differences of their means on shared days.

    `condition` and `day` number those of the sample's values, shape (n,). One shared day gives a difference, no test.
    """
    means = [_day_means(sample, condition == place, day) for place in range(len(names))]
    return tuple(_paired(means[0], means[place], names[0], names[place], level) for place in range(1, len(names)))


def _day_means(sample: Sample, chosen: NDArray[np.bool_], day: Codes) -> dict[int, Fraction]:
    """Return the exact means of the chosen values by the number of their day."""
    values, days = sample.values[chosen], day[chosen]
    rest = None if sample.rest is None else sample.rest[chosen]
    order = np.argsort(days, kind="stable")
    numbers, first = np.unique(days[order], return_index=True)
    means = {}
    for number, places in zip(numbers.tolist(), np.split(order, first[1:]), strict=True):
        means[number] = exact_sum(values[places], None if rest is None else rest[places]) / places.size
    return means


def _paired(
    control: dict[int, Fraction], treated: dict[int, Fraction], control_name: str, name: str, level: float
) -> Contrast:
    differences = [treated[number] - control[number] for number in sorted(control.keys() & treated.keys())]
    n = len(differences)
    if n == 0:
        return Contrast(name, control_name, *(Undefined(Reason.NO_DAY_HOLDS_BOTH, a=name, b=control_name),) * 7)
    mean = sum(differences, Fraction(0)) / n
    difference = finite(mean, "the difference")
    if n == 1:
        none = Undefined(Reason.ONE_DAY_HOLDS_BOTH, a=name, b=control_name)
        return Contrast(name, control_name, difference, *(none,) * 6)
    squares = sum(((each - mean) ** 2 for each in differences), Fraction(0))
    if squares == 0:
        none = Undefined(Reason.SAME_ON_EVERY_DAY, a=name, b=control_name)
        return Contrast(name, control_name, difference, *(none,) * 6)
    test = t_test(mean, squares / (n - 1) / n, Fraction(n - 1), level)
    return Contrast(name, control_name, difference, test.se, test.df, test.t, test.p, test.log10_p, test.ci)
