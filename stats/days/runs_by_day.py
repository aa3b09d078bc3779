"""Runs gathered by day, and by the levels (strata) that a comparison pools within a day."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from numpy.typing import ArrayLike

from data_schema.errors import InputRefused
from stats.checks import Labels, as_labels, as_sample
from stats.compare.shared_error import SharedError, degrees_of_fits, shared_of_mean
from stats.results import counted

Block = tuple[str, str]
"""A day and a stratum."""


@dataclass(frozen=True, slots=True)
class Runs:
    """The runs of one condition on one day: their number and mean, the squares about it, their error in common."""

    n: int
    mean: float
    squares: float
    shared: SharedError


@dataclass(frozen=True, slots=True)
class RunsByDay:
    """The runs of a control and of a treatment, by day and stratum."""

    control: Mapping[Block, Runs]
    treated: Mapping[Block, Runs]

    def without(self, day: str) -> RunsByDay:
        """Return the runs of the other days."""
        control, treated = (
            {block: runs for block, runs in side.items() if block[0] != day} for side in (self.control, self.treated)
        )
        return RunsByDay(control, treated)


@dataclass(frozen=True, slots=True)
class SharedDay:
    """A day with runs of both conditions; within days, of one stratum."""

    day: str
    control: Runs
    treated: Runs

    @property
    def weight(self) -> float:
        """The inverse variance of the contrast, in units of that of a run."""
        return self.control.n * self.treated.n / (self.control.n + self.treated.n)


def joined(strata: Sequence[SharedDay]) -> SharedDay:
    """Return the strata of a day as one day."""
    if len(strata) == 1:
        return strata[0]
    weights = weights_of(strata)

    def side(runs: Sequence[Runs]) -> Runs:
        mean = math.fsum(weight * one.mean for weight, one in zip(weights, runs, strict=True))
        squares, shared = math.fsum(one.squares for one in runs), weighed([one.shared for one in runs], weights)
        return Runs(sum(one.n for one in runs), mean, squares, shared)

    return SharedDay(strata[0].day, side([each.control for each in strata]), side([each.treated for each in strata]))


def weights_of(days: Sequence[SharedDay]) -> list[float]:
    """Return n m / (n + m) of days or strata, in shares of 1."""
    total = math.fsum(day.weight for day in days)
    return [day.weight / total for day in days]


def weighed(errors: Sequence[SharedError], weights: Sequence[float]) -> SharedError:
    """Return the error of a weighted sum; the weights sum to 1."""
    n = len(errors)
    terms: dict[tuple[str, str], list[float]] = {}
    for error, weight in zip(errors, weights, strict=True):
        for term, value in error.terms.items():
            terms.setdefault(term, []).append(weight * n * value)
    return SharedError({term: math.fsum(values) / n for term, values in terms.items()}, degrees_of_fits(errors))


def blocks_of_runs(
    name: str,
    values: ArrayLike,
    labels: Labels | None,
    strata: Labels | None,
    errors: Sequence[SharedError] | None,
) -> dict[Block, Runs]:
    """Gather values by the labels of their day and stratum; raises `InputRefused` as `contrast_by_day` says."""
    found = as_sample(name, values).values
    n = int(found.size)
    days, levels = (
        [""] * n if given is None else [str(each) for each in as_labels(f"{what}_{name}", given, "refuse")]
        for what, given in (("days", labels), ("strata", strata))
    )
    own = [SharedError()] * n if errors is None else list(errors)
    for what, given in (("label of day", days), ("label of stratum", levels), ("shared error", own)):
        if len(given) != n:
            raise InputRefused(
                f"{name} has {counted(n, 'value')} and {counted(len(given), what)}: give one for each value."
            )
    blocks: dict[Block, list[int]] = {}
    for at, block in enumerate(zip(days, levels, strict=True)):
        blocks.setdefault(block, []).append(at)
    return {block: _runs(found[places].tolist(), [own[at] for at in places]) for block, places in blocks.items()}


def _runs(values: Sequence[float], errors: Sequence[SharedError]) -> Runs:
    mean = math.fsum(values) / len(values)
    # The mean of equal values, rounded, may be another number; they do not scatter about it.
    squares = 0.0 if min(values) == max(values) else math.fsum((value - mean) ** 2 for value in values)
    return Runs(len(values), mean, squares, shared_of_mean(errors))
