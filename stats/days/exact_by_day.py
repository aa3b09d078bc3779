"""Tests beside the mixed model of conditions over several days: exact ones, and paired ones on day means.

The exact tests take units of equal variance, and hold days or runs fixed:

- Conditions joined by shared days, no runs: values, day fixed. In a complete balanced design this is the F of the mixed
  model; elsewhere it leaves out what days tell between them, and stays exact.
- Conditions joined by shared runs: values, run fixed.
- One condition a run and runs of one size: run means, day fixed.
- One condition a day and days of one size: day means.

The paired test of two conditions takes the difference of their means on each day that holds both for one observation.
It needs no model of days and no equal scatter: with three runs of a condition against ten on each of five days, and the
few scattering twice as much, its interval covers .95 where that of the exact test covers .85.
"""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from data_schema.vocabulary import Undefined
from stats.checks import Sample
from stats.compare.t_tests import t_test
from stats.days.blocked_result import Contrast, ExactTest
from stats.days.cells import Cells, Codes
from stats.days.strata import Strata, fixed_blocks, units_of
from stats.exact.distributions import t_quantile
from stats.exact.error_free import exact_sum
from stats.exact.finite import finite
from stats.exact.tails import f_upper, t_two_sided


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
        return Undefined(f"the {unit_name}s leave no degree of freedom to measure their scatter by")
    if found.f is None:
        return Undefined(f"the {unit_name}s do not scatter at all")
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
        return Undefined("there is one condition only")
    if strata.day_is_value:
        return cells, nothing, "value", "nothing"
    if with_runs and not strata.by_run.any():
        return cells, cells.run, "value", "run"
    if not with_runs and not strata.by_day.any():
        return cells, cells.day, "value", "day"
    units = units_of(cells, cells.run, cells.size) if with_runs else cells
    if units is None:
        return Undefined("runs differ in size, or conditions change within some runs only")
    if with_runs and not strata.by_day.any():
        return units, units.day, "run mean", "day"
    means = units_of(units, units.day, units.size)
    if means is None:
        return Undefined("days differ in size, or only some conditions share days")
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
        total = exact_sum(values[places]) + (0 if rest is None else exact_sum(rest[places]))
        means[number] = total / places.size
    return means


def _paired(
    control: dict[int, Fraction], treated: dict[int, Fraction], control_name: str, name: str, level: float
) -> Contrast:
    differences = [treated[number] - control[number] for number in sorted(control.keys() & treated.keys())]
    n = len(differences)
    if n == 0:
        return Contrast(name, control_name, *(Undefined(f"no day holds both {name} and {control_name}"),) * 7)
    mean = sum(differences, Fraction(0)) / n
    difference = finite(mean, "the difference")
    if n == 1:
        none = Undefined(f"one day only holds both {name} and {control_name}")
        return Contrast(name, control_name, difference, *(none,) * 6)
    squares = sum(((each - mean) ** 2 for each in differences), Fraction(0))
    if squares == 0:
        none = Undefined(f"{name} and {control_name} differ by as much on every day")
        return Contrast(name, control_name, difference, *(none,) * 6)
    test = t_test(mean, squares / (n - 1) / n, Fraction(n - 1), level)
    return Contrast(name, control_name, difference, test.se, test.df, test.t, test.p, test.log10_p, test.ci)
