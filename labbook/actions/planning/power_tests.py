"""The tests that a study is planned for: what they compare, at which level, with how many values.

Tests by shared days are planned with the days that a drawn plan gives each group.
"""

from __future__ import annotations

import functools
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

from data_schema.reasons import Reason
from data_schema.vocabulary import Undefined
from labbook.analysis.outcomes.conditions import Spread
from labbook.config.model import AnalysisSettings, Family
from labbook.plan.drawing import Plan
from stats.days.decision import LEAST_DAYS
from stats.planning.power import Power, power_anova, power_by_day, power_equivalence_by_day


@dataclass(frozen=True, slots=True)
class Assumed:
    """A standard deviation and a control mean, in J or m; `spread` is what the former was estimated from, if it was.

    The reason of an undefined mean tells how to get one.
    """

    sd: float
    mean: float | Undefined
    spread: Spread | None = None


@dataclass(frozen=True, slots=True)
class Design:
    """What is compared: in each of so many groups, so many treated levels of the swept factor with one control."""

    settings: AnalysisSettings
    swept: str
    treated: int
    groups: int

    @property
    def comparisons(self) -> int:
        """How many comparisons the family has."""
        return self.groups * (1 if self.settings.family is Family.POOLED else self.treated)

    def sizes(self, n: int) -> tuple[int, int]:
        """Return how many runs of the control and of the treatment a comparison has, with n of each condition."""
        return n, n * self.treated if self.settings.family is Family.POOLED else n


@dataclass(frozen=True, slots=True)
class PlannedTest:
    """A test at a level; `plan` goes from a standard deviation and the n of each condition to the power.

    `note` adds what the name leaves open.
    """

    name: str
    alpha: float
    assumed: Assumed | Undefined
    plan: Callable[[float, int], Power]
    note: str = ""


Layout: TypeAlias = list[tuple[int, int]]
"""Runs of the control and of the treatment on each day."""

DrawPlan: TypeAlias = Callable[[int], Plan | Undefined]
"""Draws a plan with so many runs of each condition; undefined where it is too large."""

LayoutsOf: TypeAlias = Callable[[int], "list[Layout] | Undefined"]
"""The layouts of a plan with so many runs of each condition."""

OfSize: TypeAlias = Callable[[float, int], Power]
"""The power at a standard deviation with so many values of each condition."""


def tests_of(
    design: Design, difference: float, primary: Assumed, apex: Assumed | Undefined, layouts: LayoutsOf
) -> list[PlannedTest]:
    """Return the tests for a difference of the primary outcome in the order in which they are shown.

    The first is the comparison with the control, by the shared days of the layouts.
    """
    alpha, comparisons = design.settings.alpha, design.comparisons
    one_sided = design.settings.one_sided and design.settings.primary_outcome.has_savings
    sides = 2.0 if one_sided else 1.0  # a one-sided test at alpha rejects where the two-sided one at 2 alpha does

    def with_control(level: float) -> OfSize:
        both = sides * level
        return _by_layout(design, both, layouts, lambda sd, layout: power_by_day(difference, sd, layout, both))

    name = f"by shared days{', one-sided' if one_sided else ''}"
    found = [PlannedTest(name, alpha, primary, with_control(alpha))]
    if comparisons > 1:
        level, note = alpha / comparisons, "rejects at this alpha whatever the other comparisons of the family give"
        found.append(PlannedTest(f"{name}, Holm over {comparisons}", level, primary, with_control(level), note))
    further = _anova_test(design, difference, primary), _equivalence_test(design, apex, layouts)
    return [*found, *(test for test in further if test is not None)]


def _anova_test(design: Design, difference: float, primary: Assumed) -> PlannedTest | None:
    """Two levels apart by the difference and the others half way: of all such means those hardest to find.

    Over two levels with as many values as the comparison with the control has, F is Student's t squared: no other test.
    """
    if design.treated < 2 or (design.treated == 2 and design.sizes(1) == (1, 1)):
        return None
    means = (-difference / 2.0, difference / 2.0, *[0.0] * (design.treated - 2))
    alpha = design.settings.alpha
    return PlannedTest(
        f"ANOVA over {design.treated} levels",
        alpha,
        primary,
        lambda sd, n: power_anova(means, sd, n, alpha),
        "two treated levels are that far apart and the others half way, the hardest case to find",
    )


def _equivalence_test(design: Design, apex: Assumed | Undefined, layouts: LayoutsOf) -> PlannedTest | None:
    """Apex heights that do not differ at all, against the bounds; None without bounds."""
    bounds, alpha = design.settings.apex_bounds, design.settings.alpha
    if bounds is None:
        return None
    low, high = bounds.low, bounds.high
    mean = apex.mean if bounds.percent and isinstance(apex, Assumed) else None
    if isinstance(mean, Undefined):
        apex, mean = Undefined(Reason.BOUNDS_IN_PERCENT, reason=mean.reason), None
    note = "by the shared days; apexes do not differ at all"
    if bounds.percent:
        note += "; the mean that the percent are of is estimated in the study, as in the test"
    plan = _by_layout(
        design,
        alpha,
        layouts,
        lambda sd, layout: power_equivalence_by_day(sd, low, high, layout, alpha, control_mean=mean),
    )
    return PlannedTest("no loss of apex height (TOST)", alpha, apex, plan, note)


def _by_layout(design: Design, alpha: float, layouts: LayoutsOf, power: Callable[[float, Layout], Power]) -> OfSize:
    def plan(sd: float, n: int) -> Power:
        """Return the power in the group whose days find least."""
        found = layouts(n)
        if isinstance(found, Undefined):
            return Power("the test by shared days", design.sizes(n), alpha, found)
        return least_of([power(sd, layout) for layout in found])

    return plan


def drawn_layouts(swept: str, family: Family, draw: DrawPlan) -> LayoutsOf:
    """Return what gives the layout of each comparison of a drawn plan."""

    @functools.cache
    def layouts(n: int) -> list[Layout] | Undefined:
        plan = draw(n)
        return plan if isinstance(plan, Undefined) else _layouts_of(plan, swept, family)

    return layouts


def _layouts_of(plan: Plan, swept: str, family: Family) -> list[Layout]:
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


def largest_n_within_days(layouts: LayoutsOf) -> int:
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
    within = largest_n_within_days(layouts)
    if within < 2 or within >= largest:
        return None
    before, after = plan(within).power, plan(within + 1).power
    if isinstance(before, float) and isinstance(after, float) and after < before:
        return Crossing(within, before, within + 1, after)
    return None
