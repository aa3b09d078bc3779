"""How many values a planned test needs, by any of the powers of this package."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

from data_schema.errors import InputRefused
from data_schema.rounding import level_text
from data_schema.vocabulary import Undefined
from stats.checks import as_count, as_level
from stats.planning.power import Power
from stats.results import Result

LARGEST_N = 1_000_000


@dataclass(frozen=True, slots=True)
class SampleSize(Result):
    """The smallest plan that reaches a power."""

    target: float
    """The chance of rejecting that was asked for, 0 to 1."""
    plan: Power | Undefined
    """The plan, with its power; undefined where no n reaches the target."""

    @property
    def n(self) -> int | Undefined:
        """Number of values of the plan's first group."""
        return self.plan if isinstance(self.plan, Undefined) else self.plan.group_ns[0]

    def sentence(self) -> str:
        """Return the plan in words, or why there is none."""
        if isinstance(self.plan, Undefined):
            chance = f"{level_text(self.target)} to reject"
            return f"No n was found with a chance of {chance}: {self.plan.reason}."
        return self.plan.sentence()


def sample_size(plan: Callable[[int], Power], power: float = 0.8, largest: int = LARGEST_N) -> SampleSize:
    """Return the plan with the smallest n, up to `largest`, whose power is at least `power`.

    `plan` makes a plan of n values a group, as `lambda n: power_t(0.5, 1.0, n, n)`; its power must not fall with n.
    Raises `InputRefused` for a plan that is no such function, and for a largest n below 2.
    """
    if not callable(plan):
        raise InputRefused(f"plan is {plan!r}: give a function of n, as lambda n: power_t(0.5, 1.0, n, n).")
    target, largest = as_level("power", power), as_count("largest", largest, least=2)

    @cache  # each n is asked about several times
    def plan_of(n: int) -> Power:
        made = plan(n)
        if not isinstance(made, Power):
            raise InputRefused(f"plan returns {made!r}: return a power, as lambda n: power_t(0.5, 1.0, n, n).")
        return made

    def enough(n: int) -> bool:
        found = plan_of(n).power
        return not isinstance(found, Undefined) and found >= target

    n = 2
    while not enough(n):
        tried = plan_of(n)
        if tried.never is not None and target > tried.alpha:
            return SampleSize(target, Undefined(tried.never))
        if n >= largest:
            return SampleSize(target, Undefined(f"the search ended at n = {largest}"))
        n = min(2 * n, largest)
    below = 1 if n == 2 else n // 2
    while n - below > 1:
        middle = (n + below) // 2
        below, n = (below, middle) if enough(middle) else (middle, n)
    return SampleSize(target, plan_of(n))
