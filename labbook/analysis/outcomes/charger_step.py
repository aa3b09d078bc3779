"""The step in which a charger shows mAh, and what rounding to it does to joules a jump.

A rounded charge errs by up to half a step, uniformly: standard deviation step / sqrt(12). Where charges scatter by half
a step or more, that error differs from run to run, and their scatter holds it: rounding shifts the mean of normal
values of standard deviation s by at most step / pi * exp(-2 (pi s / step)^2), .002 of a step. Where they scatter by
less, repeats are rounded alike: their error is one, however many they are, and their scatter says nothing of it.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from data_schema.queries.charges import ChargeOfRun
from data_schema.vocabulary import ChargeMode
from stats.compare.shared_error import SharedError
from stats.days.decision import LEAST_DAYS
from stats.scatter import Floats

ROUNDING = "rounding"
"""What errors of rounding are called in a `SharedError`, where drain lines have names of their own."""
ENOUGH_SCATTER = 0.5
"""Steps of scatter from which on rounding errs independently from run to run."""
_NO_ERROR = SharedError()
_CHANCE = 0.01
"""Of a coarser step, where a finer one would make all charges its multiples so rarely."""


def with_display_step(
    charges: Mapping[str, list[ChargeOfRun]], stated_mah: float | None
) -> dict[str, list[ChargeOfRun]]:
    """Return charges by run with the charger's step: the stated one, else the one that all charges of the book show.

    A charge that was typed or declared in coarser steps than that keeps its own.
    """
    charged = [one for of_run in charges.values() for one in of_run if one.mode == ChargeMode.CHARGE]
    step_mah = stated_mah
    if step_mah is None and charged:
        typed_mah = min(one.resolution_mah for one in charged)
        step_mah = display_step_mah([one.charge_mah for one in charged], typed_mah)
    if step_mah is None:
        return dict(charges)

    def has_step(one: ChargeOfRun) -> bool:
        return one.resolution_mah == step_mah or (stated_mah is None and one.resolution_mah > step_mah)

    return {
        run_uid: [one if has_step(one) else replace(one, resolution_mah=step_mah) for one in of_run]
        for run_uid, of_run in charges.items()
    }


def display_step_mah(charges_mah: Iterable[float], typed_mah: float) -> float:
    """Return the step in mAh that charges were shown in, `typed_mah` being that of the last digit written down.

    It is a coarser one, 2, 4, 5, 10, 20, 25 times and so on, where all charges are multiples of it and there are so
    many different ones that chance alone would make them so in 1 % of books: two for 10 times, three for 5, seven for
    2.
    """
    different = np.unique(np.abs(np.fromiter(charges_mah, float)))
    different = different[different > 0.0]
    step_mah = typed_mah
    while times := next((each for each in (10.0, 5.0, 2.0) if _all_multiples(different, step_mah, each)), None):
        step_mah *= times
    return step_mah


def _all_multiples(different_mah: Floats, step_mah: float, times: float) -> bool:
    """Tell whether all charges are multiples of so many steps, and too many are for chance."""
    steps = different_mah / (step_mah * times)
    return times**-steps.size <= _CHANCE and bool(np.all(np.abs(steps - np.round(steps)) < 1e-6))


def scatter_in_steps(
    joules: Sequence[float], step_j: Sequence[float], conditions: Sequence[str], days: Sequence[str]
) -> float | None:
    """Return the pooled standard deviation of joules a jump within conditions, each run's in its own steps.

    All of shape (n,), `step_j` what a step is worth in the run's joules a jump. A condition of fewer days than decide
    by days is taken within days, as its test is. None where no two runs can be compared.
    """
    of_condition: dict[str, set[str]] = {}
    for condition, day in zip(conditions, days, strict=True):
        of_condition.setdefault(condition, set()).add(day)
    blocks: dict[tuple[str, str], list[int]] = {}
    for place, (condition, day) in enumerate(zip(conditions, days, strict=True)):
        block = day if len(of_condition[condition]) < LEAST_DAYS else ""
        blocks.setdefault((condition, block), []).append(place)
    df = len(joules) - len(blocks)
    if df < 1:
        return None
    squares = 0.0
    for places in blocks.values():
        mean = math.fsum(joules[place] for place in places) / len(places)
        steps = [(joules[place] - mean) / step_j[place] for place in places]
        squares += math.fsum(away * away for away in steps)
    return math.sqrt(squares / df)


def with_rounding(error: SharedError, step_j: float, reading: str) -> SharedError:
    """Add the error that all runs of one reading of one condition have in common, in joules a jump."""
    return _joined(error, SharedError({(ROUNDING, reading): step_j / math.sqrt(12.0)}, {ROUNDING: math.inf}))


def with_rounding_of(error: SharedError, other: SharedError) -> SharedError:
    """Add the rounding that another error holds."""
    return _joined(error, rounding_in(other))


def rounding_in(error: SharedError, *, without: bool = False) -> SharedError:
    """Return what of an error in common is rounding, or what is not."""
    if ROUNDING not in error.df:
        return error if without else _NO_ERROR
    return SharedError(
        {term: size for term, size in error.terms.items() if (term[0] == ROUNDING) is not without},
        {fit: df for fit, df in error.df.items() if (fit == ROUNDING) is not without},
    )


def _joined(one: SharedError, other: SharedError) -> SharedError:
    return one if other is _NO_ERROR else SharedError({**one.terms, **other.terms}, {**one.df, **other.df})
