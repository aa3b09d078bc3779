"""The tests by shared days as a study is planned for them: the days that a drawn plan gives each group."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import TypeAlias

from data_schema.vocabulary import Undefined
from labbook.actions.planning.power_tests import Assumed, Design, PlannedTest, percent_of_mean
from labbook.config.model import Family
from labbook.plan.drawing import Plan
from stats.days.decision import LEAST_DAYS
from stats.planning.power import Power, power_by_day, power_equivalence_by_day

Layout: TypeAlias = list[tuple[int, int]]
"""Runs of the control and of the treatment on each day."""

DrawPlan: TypeAlias = Callable[[int], Plan | Undefined]
"""Draws a plan with so many runs of each condition; undefined where it is too large."""


LayoutsOf: TypeAlias = Callable[[int], "list[Layout] | Undefined"]
"""The layouts of a plan with so many runs of each condition."""


def drawn_layouts(swept: str, family: Family, draw: DrawPlan) -> LayoutsOf:
    """Return what gives the layout of each comparison of a drawn plan."""

    @cache
    def layouts(n: int) -> list[Layout] | Undefined:
        plan = draw(n)
        return plan if isinstance(plan, Undefined) else layouts_of(plan, swept, family)

    return layouts


def tests_by_layout(design: Design, difference: float, primary: Assumed, layouts: LayoutsOf) -> Iterator[PlannedTest]:
    """Give the test by shared days at alpha, and at the level at which Holm's procedure rejects in any case."""
    alpha, family = design.settings.alpha, design.comparisons
    levels = [("by shared days", alpha, "")]
    if family > 1:
        note = "rejects at this alpha whatever the other comparisons of the family give"
        levels.append((f"by shared days, Holm over {family}", alpha / family, note))

    def power(sd: float, layout: Layout, level: float) -> Power:
        return power_by_day(difference, sd, layout, level)

    for name, level, note in levels:
        yield PlannedTest(name, level, primary, _plan(design, level, layouts, power), note)


def equivalence_by_layout(design: Design, apex: Assumed | Undefined, layouts: LayoutsOf) -> PlannedTest | None:
    """Give both one-sided tests of apex heights by the same contrast; None without bounds."""
    bounds, alpha = design.settings.apex_bounds, design.settings.alpha
    if bounds is None:
        return None
    name, note = "no loss of apex height (TOST)", "by the shared days; apexes do not differ at all"
    mean = None
    if bounds.percent:
        note += "; the mean that the percent are of is estimated in the study, as in the test"
        apex = percent_of_mean(apex)
        mean = None if isinstance(apex, Undefined) else apex.mean

    def power(sd: float, layout: Layout, level: float) -> Power:
        control_mean = None if isinstance(mean, Undefined) else mean
        return power_equivalence_by_day(sd, bounds.low, bounds.high, layout, level, control_mean=control_mean)

    return PlannedTest(name, alpha, apex, _plan(design, alpha, layouts, power), note)


def _plan(
    design: Design, alpha: float, layouts: LayoutsOf, power: Callable[[float, Layout, float], Power]
) -> Callable[[float, int], Power]:
    def plan(sd: float, n: int) -> Power:
        """Return the power in the group whose days find least."""
        found = layouts(n)
        sizes = design.sizes(n)
        if isinstance(found, Undefined):
            return Power("the test by shared days", sizes, alpha, found)
        return replace(least_of([power(sd, layout, alpha) for layout in found]), group_ns=sizes)

    return plan


def least_of(powers: Sequence[Power]) -> Power:
    """Return the plan that finds least; one that claims nothing finds least of all."""
    return min(powers, key=lambda one: -1.0 if isinstance(one.power, Undefined) else one.power)


def shared_days(layouts: Sequence[Layout]) -> int:
    """Return the fewest days that hold both sides of a comparison."""
    return min(map(_shared, layouts), default=0)


def _shared(layout: Layout) -> int:
    return sum(1 for of_day in layout if all(of_day))


@dataclass(frozen=True, slots=True)
class Crossing:
    """Where more runs find less: the last n with all comparisons within days, the first with one paired on day means.

    Pairing on day means needs more to find as much, and what it finds holds for days like these.
    """

    n_within: int
    power_within: float
    n_paired: int
    power_paired: float

    @property
    def sentence(self) -> str:
        """Say both powers."""
        within, paired = (f"{100.0 * power:.1f} %" for power in (self.power_within, self.power_paired))
        return (
            f"From n = {self.n_paired} on, where {LEAST_DAYS} days are shared, the test is paired on day means: power "
            f"{paired}, and {within} at n = {self.n_within}, within days, valid for the days measured only."
        )


def last_within(layouts: LayoutsOf) -> int:
    """Return the largest n with all comparisons within days; the days that are shared grow with n."""

    def paired(n: int) -> bool:
        found = layouts(n)
        return isinstance(found, Undefined) or max(map(_shared, found), default=LEAST_DAYS) >= LEAST_DAYS

    low, high = 1, 2
    while not paired(high):
        low, high = high, 2 * high
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if paired(middle) else (middle, high)
    return low


def crossing_of(plan: Callable[[int], Power], layouts: LayoutsOf, largest: int) -> Crossing | None:
    """Return where the rule changes up to an n, if the power falls there."""
    within = last_within(layouts)
    if within < 2 or within >= largest:
        return None
    before, after = plan(within).power, plan(within + 1).power
    if isinstance(before, float) and isinstance(after, float) and after < before:
        return Crossing(within, before, within + 1, after)
    return None


def layouts_of(plan: Plan, swept: str, family: Family) -> list[Layout]:
    """Return the layout of each comparison of the family."""
    control = next(factor.control for factor in plan.factors if factor.name == swept)
    runs: dict[tuple[tuple[str, str], ...], Counter[tuple[int, str]]] = {}
    for run in plan.runs:
        if run.condition is not None:
            levels = dict(run.condition)
            level = levels.pop(swept)
            runs.setdefault(tuple(levels.items()), Counter())[run.day, level] += 1
    found = []
    for counts in runs.values():
        treated = dict.fromkeys(level for _day, level in counts if level != control)
        compared = [tuple(treated)] if family is Family.POOLED else [(level,) for level in treated]
        days = dict.fromkeys(day for day, _level in counts)
        found += [
            [(counts[day, str(control)], sum(counts[day, level] for level in levels)) for day in days]
            for levels in compared
        ]
    return found
