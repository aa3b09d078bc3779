"""Runs of a control and a treatment by day, and by level of another factor where levels are pooled (strata).

The difference of means within days is weighted as least squares with day effects weights it, n m / (n + m) for each
day of n control and m treated runs. Runs carry errors in common with others.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from data_schema.errors import InputRefused
from data_schema.reasons import Reason
from data_schema.vocabulary import Undefined
from stats.checks import Labels, as_labels, as_values
from stats.compare.shared_error import SharedError, shared_of_mean, weighted_sum
from stats.results import plural
from stats.scatter import Scale, group_of, scale_of, times_power

Block = tuple[str, str]
"""A day and a stratum."""


@dataclass(frozen=True, slots=True)
class Runs:
    """The values of the runs of one condition on one day, and the error that their mean has in common with others."""

    values: tuple[float, ...]
    shared: SharedError

    @property
    def n(self) -> int:
        """Their number."""
        return len(self.values)


RunsOfCondition = Mapping[Block, Runs]
"""The runs of a condition by day, as `blocks_of_runs` gathers them."""


@dataclass(frozen=True, slots=True)
class Means:
    """The mean of runs and the squares about it, in a `stats.scatter.Scale`."""

    n: int
    mean: float
    squares: float
    shared: SharedError


def scale_of_runs(conditions: Iterable[RunsOfCondition]) -> Scale:
    """Return the one scale of the runs of conditions that are compared."""
    return scale_of(*(np.array(each.values) for condition in conditions for each in condition.values()))


def means_of(runs: Runs, scale: Scale) -> Means:
    """Return the mean of runs and the squares about it, and their error in common, in a scale."""
    found, shared = group_of("", scale.scaled(np.array(runs.values))), runs.shared
    if shared.terms:
        shared = shared.times(times_power(1.0, -scale.exponent))
    return Means(found.n, found.mean, found.squares, shared)


@dataclass(frozen=True, slots=True)
class Counts:
    """Runs on shared days, and runs on other days, which enter nothing."""

    control: int
    treated: int
    other_control: int
    other_treated: int


@dataclass(frozen=True, slots=True)
class SharedDay:
    """A day with runs of both conditions; within days, of one stratum."""

    day: str
    control: Means
    treated: Means

    @property
    def weight(self) -> float:
        """The inverse variance of the contrast, in units of that of a run."""
        return self.control.n * self.treated.n / (self.control.n + self.treated.n)


@dataclass(frozen=True, slots=True)
class RunsByDay:
    """The runs of a control and of a treatment, by day and stratum."""

    control: RunsOfCondition
    treated: RunsOfCondition

    def without(self, day: str) -> RunsByDay:
        """Return the runs of the other days."""
        control, treated = (
            {block: runs for block, runs in side.items() if block[0] != day} for side in (self.control, self.treated)
        )
        return RunsByDay(control, treated)

    def shared_days(self, scale: Scale) -> tuple[SharedDay, ...]:
        """Return the days that hold runs of both, stratum by stratum."""
        both = sorted(self.control.keys() & self.treated.keys())
        return tuple(
            SharedDay(block[0], means_of(self.control[block], scale), means_of(self.treated[block], scale))
            for block in both
        )

    def why_no_day_is_shared(self, control: str, treated: str) -> Undefined:
        """Return that no day holds both, or that none does within one stratum."""
        days = [{day for day, _stratum in side} for side in (self.control, self.treated)]
        code = Reason.NO_DAY_HOLDS_BOTH_ALIKE if days[0] & days[1] else Reason.NO_DAY_HOLDS_BOTH
        return Undefined(code, a=control, b=treated)

    def counts(self) -> Counts:
        """Count the runs."""
        both = self.control.keys() & self.treated.keys()
        total = [sum(runs.n for runs in side.values()) for side in (self.control, self.treated)]
        shared = [sum(side[block].n for block in both) for side in (self.control, self.treated)]
        return Counts(shared[0], shared[1], total[0] - shared[0], total[1] - shared[1])


def one_day(strata: Sequence[SharedDay]) -> SharedDay:
    """Return the strata of a day as one day."""
    if len(strata) == 1:
        return strata[0]
    weights = weights_of(strata)

    def side(runs: Sequence[Means]) -> Means:
        mean = math.fsum(weight * one.mean for weight, one in zip(weights, runs, strict=True))
        squares, shared = math.fsum(one.squares for one in runs), weighted_sum([one.shared for one in runs], weights)
        return Means(sum(one.n for one in runs), mean, squares, shared)

    return SharedDay(strata[0].day, side([each.control for each in strata]), side([each.treated for each in strata]))


def weights_of(days: Sequence[SharedDay]) -> list[float]:
    """Return n m / (n + m) of days or strata, in shares of 1."""
    total = math.fsum(day.weight for day in days)
    return [day.weight / total for day in days]


def blocks_of_runs(
    name: str,
    values: ArrayLike,
    labels: Labels | None,
    strata: Labels | None,
    errors: Sequence[SharedError] | None,
) -> dict[Block, Runs]:
    """Gather values by the labels of their day and stratum; raises `InputRefused` as `contrast_by_day` says."""
    found = as_values(name, values)
    n = int(found.size)
    days, levels = (
        [""] * n if given is None else [str(each) for each in as_labels(f"{what}_{name}", given, "refuse")]
        for what, given in (("days", labels), ("strata", strata))
    )
    own = [SharedError()] * n if errors is None else list(errors)
    for what, given in (("label of day", days), ("label of stratum", levels), ("shared error", own)):
        if len(given) != n:
            raise InputRefused(
                f"{name} has {plural(n, 'value')} and {plural(len(given), what)}: give one for each value."
            )
    blocks: dict[Block, list[int]] = {}
    for at, block in enumerate(zip(days, levels, strict=True)):
        blocks.setdefault(block, []).append(at)
    return {
        block: Runs(tuple(found[places].tolist()), shared_of_mean([own[at] for at in places]))
        for block, places in blocks.items()
    }
