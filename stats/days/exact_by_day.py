"""Exact tests of conditions measured over several days: units of equal variance, days or runs held fixed.

- Conditions joined by shared days, no runs: values, day fixed. In a complete balanced design this is the F of the mixed
  model; elsewhere it leaves out what days tell between them, and stays exact.
- Conditions joined by shared runs: values, run fixed.
- One condition a run and runs of one size: run means, day fixed.
- One condition a day and days of one size: day means.
"""

from __future__ import annotations

import math

import numpy as np

from data_schema.vocabulary import Undefined
from stats.days.blocked_result import Contrast, ExactTest
from stats.days.blocks import Codes
from stats.days.cells import Cells
from stats.days.strata import Strata, fixed_blocks, units_of
from stats.exact.distributions import t_quantile
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
