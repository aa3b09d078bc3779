"""Designs that are simulated: groups of values, or conditions over days, without any effect."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import signal

Floats = NDArray[np.float64]
RUNS_A_DAY = 2
COMMON: Mapping[str, Callable[[int], int]] = {
    "own": lambda _days: 0,
    "partly": lambda _days: 1,
    "mostly": lambda days: days - 1,
}
"""Of layouts of days that groups do not share, or not all: how many of each group's days are days of all."""
Groups = Sequence[Floats]
"""One array a group, shape (runs, n_i); over days (runs, days, values a day)."""

DISTRIBUTIONS: Mapping[str, Callable[[np.random.Generator, tuple[int, ...]], Floats]] = {
    "normal": lambda rng, shape: rng.standard_normal(shape),
    "t5": lambda rng, shape: rng.standard_t(5.0, shape),
    "t3": lambda rng, shape: rng.standard_t(3.0, shape),
    "exponential": lambda rng, shape: rng.standard_exponential(shape) - 1.0,
    "uniform": lambda rng, shape: rng.uniform(-1.0, 1.0, shape),
}
"""Scatter by name, each about a mean of 0."""
LAG1 = 0.5


def _going_together(rng: np.random.Generator, shape: tuple[int, ...]) -> Floats:
    """Return normal values of SD 1, each of which takes `LAG1` of the one before along the last axis."""
    steps = math.sqrt(1.0 - LAG1 * LAG1) * rng.standard_normal(shape)
    first = LAG1 * rng.standard_normal((*shape[:-1], 1))
    return np.asarray(signal.lfilter([1.0], [1.0, -LAG1], steps, axis=-1, zi=first)[0])


CORRELATED: Mapping[str, Callable[[np.random.Generator, tuple[int, ...]], Floats]] = {f"lag1 {LAG1:g}": _going_together}
"""Scatter of values that follow each other in time, by their correlation with the one before."""


@dataclass(frozen=True, slots=True)
class Design:
    """Groups of values without an effect; what is not given is that of equal scatter and no days."""

    n: tuple[int, ...]
    """Number of values of each group, over all days."""
    sd_ratio: float = 1.0
    """SD of the first group over that of the last; those between lie on equal ratios."""
    days: int | None = None
    """Days that each group was measured on."""
    day_sd: float | None = None
    """SD between days, in SDs of the values of the last group."""
    layout: str = ""
    """"shared" where all groups share their days, "own" where each has days of its own, "partly" where they share the
    first and each has others of its own, "mostly" where they share all but the last; of shared days "holes" where two
    of five values are missing, "runs" where each group has two runs a day that differ with an SD of 1; empty without
    days."""
    distribution: str = "normal"

    @property
    def common_days(self) -> int:
        """Days that all groups have in common, the first ones of each."""
        days = self.days or 0
        return COMMON[self.layout](days) if self.layout in COMMON else days

    @property
    def sds(self) -> tuple[float, ...]:
        """SD of each group."""
        last = max(len(self.n) - 1, 1)
        return tuple(self.sd_ratio ** (1.0 - place / last) for place in range(len(self.n)))

    @property
    def times(self) -> tuple[int, ...]:
        """Values of each group a day."""
        return tuple(n // (self.days or 1) for n in self.n)

    @property
    def normal_and_alike(self) -> bool:
        """Whether all values are normal with one SD."""
        return self.distribution == "normal" and self.sd_ratio == 1.0

    @property
    def no_day_moves(self) -> bool:
        """Whether differences of groups are free of days: there are none, or they do not differ, or all share one."""
        return not self.day_sd or (self.days == 1 and self.layout == "shared")


def draw(design: Design, runs: int, rng: np.random.Generator) -> list[Floats]:
    """Return `runs` studies of a design: one array a group."""
    scatter = {**DISTRIBUTIONS, **CORRELATED}[design.distribution]
    if design.days is None:
        return [sd * scatter(rng, (runs, n)) for n, sd in zip(design.n, design.sds, strict=True)]
    of_day = (runs, design.days, 1)
    together = rng.standard_normal(of_day)
    found = []
    for sd, times in zip(design.sds, design.times, strict=True):
        level = rng.standard_normal(of_day) if design.layout in COMMON else together
        level[:, : design.common_days] = together[:, : design.common_days]
        values = sd * scatter(rng, (runs, design.days, times)) + (design.day_sd or 0.0) * level
        if design.layout == "runs":
            of_runs = rng.standard_normal((runs, design.days, RUNS_A_DAY))
            values += np.repeat(of_runs, times // RUNS_A_DAY, axis=2)
        found.append(values)
    return found


EVERY_N = (3, 5, 10, 25)
SOME_N = (3, 5, 10)
DAYS = (1, 2, 3, 4, 5, 6)
UNEQUAL_N = ((5, 20), (10, 40), (3, 10), (5, 8), (10, 16))
RATIOS = (1.0, 1.5, 2.0, 3.0)
FURTHER_PAIRS = (
    *((2, 2), (4, 4), (2, 3), (2, 4), (2, 8), (2, 25), (3, 4), (3, 5), (3, 25), (4, 6), (4, 16)),
    *((5, 10), (7, 9), (10, 12), (10, 20), (15, 30), (15, 50), (25, 35), (25, 50), (25, 100)),
)
"""Two values, four, and groups that are a little or very unequal."""
FURTHER_TRIPLES = (
    *((4, 4, 4), (3, 3, 6), (3, 4, 5), (4, 6, 8), (3, 6, 12), (5, 5, 10)),
    *((10, 10, 20), (10, 15, 20), (25, 25, 50)),
)
UNEQUAL_TIMES: Mapping[int, tuple[tuple[int, ...], ...]] = {
    2: ((3, 10), (10, 33)),
    3: ((3, 6, 12), (10, 20, 40)),
    4: ((3, 6, 12, 24),),
}
"""Values a day of groups that were measured unequally often, by the number of groups."""
UNEQUAL_RATIOS = (0.5, 1.0, 2.0, 3.0)


def equal_groups(groups: int, ratios: Sequence[float] = RATIOS) -> tuple[Design, ...]:
    """Return designs of groups of one size."""
    return tuple(Design((n,) * groups, ratio) for n in EVERY_N for ratio in ratios)


def several(groups: int) -> tuple[Design, ...]:
    """Return designs of three groups or more: of one size, of sizes that double, and of three groups more of both."""
    sizes = (tuple(5 * 2**place for place in range(groups)), *(FURTHER_TRIPLES if groups == 3 else ()))
    return *equal_groups(groups), *(Design(n, ratio) for n in sizes for ratio in UNEQUAL_RATIOS)


def pairs() -> tuple[Design, ...]:
    """Return designs of two groups; where sizes differ the smaller group scatters less, as much or more."""
    sizes = (*UNEQUAL_N, *FURTHER_PAIRS)
    return *equal_groups(2), *(Design(n, ratio) for n in sizes for ratio in (0.5, *RATIOS))


def designs_over_days(
    groups: int,
    layout: str,
    day_sds: Sequence[float] = (1.0,),
    times_a_day: Sequence[int] = EVERY_N,
    fewest_days: int = 1,
) -> tuple[Design, ...]:
    """Return designs of groups that were each measured so often on each of at most six days."""
    return tuple(
        Design((times * days,) * groups, 1.0, days, day_sd, layout)
        for times in times_a_day
        for days in DAYS[fewest_days - 1 :]
        for day_sd in day_sds
    )


def partly(groups: int, times_a_day: Sequence[int] = SOME_N) -> tuple[Design, ...]:
    """Return designs of groups that share the first of their days."""
    return designs_over_days(groups, "partly", times_a_day=times_a_day, fewest_days=2)


def mostly(groups: int, times_a_day: Sequence[int] = SOME_N) -> tuple[Design, ...]:
    """Return designs of groups that share all of their days but the last; of two days that is the first."""
    return designs_over_days(groups, "mostly", times_a_day=times_a_day, fewest_days=3)


def apart(groups: int, times_a_day: Sequence[int]) -> tuple[Design, ...]:
    """Return designs of groups on days of their own, and on days of which they share the first, or all but the last."""
    return (
        *designs_over_days(groups, "own", times_a_day=times_a_day),
        *partly(groups, times_a_day),
        *mostly(groups, times_a_day),
    )


def by_layout(groups: int, times_a_day: Sequence[int] = SOME_N) -> tuple[Design, ...]:
    """Return designs of groups over one to six days in every layout that does not call for a model of its own."""
    return *apart(groups, times_a_day), *designs_over_days(groups, "shared", times_a_day=times_a_day)


def by_layout_unlike(groups: int) -> tuple[Design, ...]:
    """Return the same with 1, 2 and 25 values a day; with 5 where SDs differ; and with few values against many."""
    of_one = by_layout(groups, (1,))
    return (
        *(one for one in of_one if one.n[0] > 2),
        *(one for one in by_layout(groups, (2,)) if one.n[0] > 2),
        *by_layout(groups, (25,)),
        *(replace(one, sd_ratio=2.0) for one in by_layout(groups, (5,))),
        *(
            replace(one, n=tuple(times * (one.days or 1) for times in a_day), sd_ratio=ratio)
            for a_day in UNEQUAL_TIMES[groups]
            for ratio in (0.5, 1.0, 2.0)
            for one in of_one
        ),
    )
