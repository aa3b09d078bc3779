"""The test by shared days as a study is planned for it: the days that a drawn plan gives each group."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cache
from typing import TypeAlias

from data_schema.vocabulary import Undefined
from labbook.actions.planning.power_tests import Assumed, Design, PlannedTest
from labbook.config.model import Family
from labbook.plan.drawing import Plan
from stats.planning.power import Power
from stats.planning.power_by_day import power_by_day

Layout: TypeAlias = list[tuple[int, int]]
"""Runs of the control and of the treatment on each day."""

DrawPlan: TypeAlias = Callable[[int], Plan | Undefined]
"""Draws a plan with so many runs of each condition; undefined where it is too large."""


def tests_by_layout(design: Design, difference: float, primary: Assumed, draw: DrawPlan) -> Iterator[PlannedTest]:
    """Give the test by shared days at alpha, and at the level at which Holm's procedure rejects in any case."""
    alpha, family = design.settings.alpha, design.comparisons
    levels = [("by shared days", alpha, "")]
    if family > 1:
        note = "rejects at this alpha whatever the other comparisons of the family give"
        levels.append((f"by shared days, Holm over {family}", alpha / family, note))
    layouts = cache(lambda n: _layouts(design, draw(n)))
    for name, level, note in levels:
        yield PlannedTest(name, level, primary, _plan(design, difference, level, layouts), note)


def _plan(
    design: Design, difference: float, alpha: float, layouts: Callable[[int], list[Layout] | Undefined]
) -> Callable[[float, int], Power]:
    def plan(sd: float, n: int) -> Power:
        """Return the power in the group whose days find least."""
        found = layouts(n)
        sizes = design.sizes(n)
        if isinstance(found, Undefined):
            return Power("the test by shared days", sizes, alpha, found)
        powers = [power_by_day(difference, sd, layout, alpha) for layout in found]
        least = min(powers, key=lambda one: -1.0 if isinstance(one.power, Undefined) else one.power)
        return replace(least, group_ns=sizes)

    return plan


def _layouts(design: Design, plan: Plan | Undefined) -> list[Layout] | Undefined:
    return plan if isinstance(plan, Undefined) else layouts_of(plan, design.swept, design.settings.family)


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
