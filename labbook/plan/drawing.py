"""Draw the order of a study's runs: randomised or blocked, and the same for the same seed.

What is promised (thesis 4.3.1 and 5.1.3, without the "almost always"):

- every condition reaches its number of runs; only controls may exceed it;
- a day on which a group is measured (one combination of all factors but the treatment: one foot at one gain) has at
  least one control of that group;
- no day has more runs than it can hold.

The unit that is drawn is the *replicate*: for one group, one control and one run of every other level of the
treatment. Where a day holds whole replicates, treatments are orthogonal to days (a randomised complete block design)
and no control is spent in excess. A replicate that does not fit is continued on the next day, with a control of its
own there if the rest has none: at most one in excess for each new day.

Idle runs stand on days drawn at random, as many a day as make the fewest days and continue the fewest replicates: one
a day where whole replicates leave a place free, else in the places of a whole replicate.

RANDOMISED takes the groups in rounds, one replicate of each in random order, so that no group is tied to one part of
the campaign, and shuffles each day as a whole. BLOCKED finishes one group before the next, in nested random order
(the factor declared first changes least often: declare the one that is hardest to change first), and shuffles the
runs of a group within each day; idle runs stand between groups.

Of either order, controls then change places with treated runs of their group and day for as long as that brings the
mean positions of both nearer: a drift over the day favours neither. Where a group's runs follow one another, the sum of
its controls' places ends within half a place of that expected at random.

Chance that is the same for the same seed in every version of every library.

Word `i` (from 0) of a seed is the first 8 bytes, big endian, of the SHA-256 of the ASCII text `labbook {seed} {i}`. A
number below `n` is the first word below the largest multiple of `n`, modulo `n`, so that no number is favoured. Lists
are shuffled from the last place down (Fisher and Yates 1938; Durstenfeld, Communications of the ACM 7, 1964).
"""

from __future__ import annotations

import bisect
import hashlib
import itertools
import math
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeVar

from data_schema.errors import UsageError
from data_schema.grouping import grouped
from data_schema.vocabulary import PlanMethod, RunKind

_Item = TypeVar("_Item")
_WORDS = 2**64


class SeededChance:
    """A source of chance; what it gives depends on the seed and on what was asked before, and on nothing else."""

    def __init__(self, seed: int) -> None:
        self._seed = seed
        self._drawn = 0

    def below(self, limit: int) -> int:
        """Draw a whole number from 0 up to, not including, `limit` (1 to 2**64), all equally likely."""
        fair = _WORDS - _WORDS % limit
        while True:
            digest = hashlib.sha256(f"labbook {self._seed} {self._drawn}".encode("ascii")).digest()
            self._drawn += 1
            word = int.from_bytes(digest[:8], "big")
            if word < fair:
                return word % limit

    def shuffled(self, items: Iterable[_Item]) -> list[_Item]:
        """Return the items in random order, every order equally likely."""
        order = list(items)
        for last in range(len(order) - 1, 0, -1):
            other = self.below(last + 1)
            order[last], order[other] = order[other], order[last]
        return order


Condition = tuple[tuple[str, str], ...]
"""Factor and level, in the order of the factors."""


@dataclass(frozen=True, slots=True)
class Slot:
    """What takes one place of a day; an idle run has neither group nor condition."""

    group: Condition | None
    condition: Condition | None
    duration_s: float | None


@dataclass(frozen=True, slots=True)
class Replicate:
    """Runs that belong together, and the control that a day with any of them must have."""

    slots: tuple[Slot, ...]
    control: Slot | None


def fill_days(queue: list[Replicate], idle: list[Slot], runs_per_day: int, chance: SeededChance) -> list[list[Slot]]:
    """Return the slots of each day: of all numbers of idle runs a day, that which takes the fewest days counts.

    Of equal ones that which continues the fewest replicates on another day, then the smallest number.
    """
    if not idle:
        return _filled_days(queue, {}, runs_per_day)[0]
    full = (sum(len(replicate.slots) for replicate in queue) + len(idle)) // runs_per_day
    order = chance.shuffled(range(max(full, math.ceil(len(idle) / runs_per_day))))
    fewest = math.ceil(len(idle) / len(order))
    found = []
    for together in range(fewest, max(fewest, min(len(idle), runs_per_day)) + 1):
        lots = [idle[start : start + together] for start in range(0, len(idle), together)]
        found.append(_filled_days(queue, dict(zip(order, lots, strict=False)), runs_per_day))
    return min(found, key=lambda days: (len(days[0]), days[1]))[0]


def _filled_days(
    queue: list[Replicate], idle: Mapping[int, list[Slot]], runs_per_day: int
) -> tuple[list[list[Slot]], int]:
    """Fill one day after another from the queue, `idle` being what days have already, counted from 0.

    A day starts a group with its control, or leaves it for the next. Returns the days, and how often a replicate is
    continued on another day.
    """
    days = [list(idle.get(0, ()))]
    controlled: set[Slot] = set()
    continued = 0
    for replicate in queue:
        pending, control = list(replicate.slots), replicate.control
        while pending:
            needed = 1
            if control in controlled:
                # The replicate's own control comes last: it serves the next day if the rest goes there.
                pending.sort(key=lambda slot: slot == control)
            elif control is not None:
                own = pending.count(control)
                # A lone control at the end of a day would cost another one on the next.
                needed = 2 if own < 2 and len(pending) > own else 1
                if own:
                    pending.remove(control)
                pending.insert(0, control)
            free = runs_per_day - len(days[-1])
            if free < needed:
                days.append(list(idle.get(len(days), ())))
                controlled = set()
            else:
                days[-1] += pending[:free]
                controlled.update(pending[:1])
                pending = pending[free:]
                continued += bool(pending)
    left = [slot for day in sorted(idle) if day >= len(days) for slot in idle[day]]
    for slots in days:  # what is left over fills earlier days before it takes days of its own
        free = runs_per_day - len(slots)
        slots += left[:free]
        left = left[free:]
    return days + [left[start : start + runs_per_day] for start in range(0, len(left), runs_per_day)], continued


def _group_by_group(slots: list[Slot], chance: SeededChance) -> list[tuple[str, Slot]]:
    stretches = grouped(slots, [slot.group for slot in slots])
    idle = stretches.pop(None, [])
    blocks = [
        (", ".join(f"{factor}={level}" for factor, level in group or ()) or "day", chance.shuffled(runs))
        for group, runs in stretches.items()
    ]
    for slot in idle:
        blocks.insert(chance.below(len(blocks) + 1), ("idle", [slot]))
    return [(name, slot) for name, runs in blocks for slot in runs]


def _balanced(
    order: list[tuple[str, Slot]], controls: Collection[Slot | None], ahead: dict[Condition, float]
) -> list[tuple[str, Slot]]:
    """Exchange controls with treated runs of their group until the mean positions of both are as near as that brings.

    `ahead` has by group the sum of its controls' places over the days before, about what is expected of a random order:
    where two orders are equally good, the one that takes less of it is chosen. It is brought up to date.
    """
    places: dict[Condition, tuple[list[int], list[int]]] = {}
    for place, (_block, slot) in enumerate(order):
        if slot.group is not None:
            places.setdefault(slot.group, ([], []))[slot not in controls].append(place)
    found = list(order)
    for group, (of_controls, of_treated) in places.items():
        both, before = [*of_controls, *of_treated], ahead.get(group, 0.0)
        off = sum(of_controls) - len(of_controls) * sum(both) / len(both)
        while of_controls and of_treated:
            off_by = {
                (one, other): off + of_treated[other] - of_controls[one]
                for one, place in enumerate(of_controls)
                for other in _nearest(of_treated, place - off)
            }
            one, other = min(off_by, key=lambda pair: _cost(off_by[pair], before))
            if _cost(off_by[one, other], before) >= _cost(off, before):
                break
            off = off_by[one, other]
            here, there = of_controls[one], of_treated[other]
            of_controls[one], of_treated[other] = there, here
            found[here], found[there] = found[there], found[here]
            of_treated.sort()
        ahead[group] = before + off
    return found


def _cost(off: float, before: float) -> tuple[float, float]:
    """Return what a sum of places off its expectation costs: rounded, so that equal ones are equal."""
    return round(abs(off), 6), round(abs(before + off), 6)


def _nearest(places: Sequence[int], wanted: float) -> range:
    """Return where in a sorted list the places next to the one wanted stand, on either side and on it."""
    at = bisect.bisect_left(places, wanted)
    return range(max(0, at - 1), min(len(places), at + 2))


QUEUES: dict[PlanMethod, Callable[[list[list[Replicate]], SeededChance], list[Replicate]]] = {
    PlanMethod.RANDOMISED: lambda groups, chance: [
        replicate for together in zip(*groups, strict=True) for replicate in chance.shuffled(together)
    ],
    PlanMethod.BLOCKED: lambda groups, chance: [
        replicate for replicates in groups for replicate in chance.shuffled(replicates)
    ],
}
"""How the replicates of all groups are put one behind another."""

ORDERS: dict[PlanMethod, Callable[[list[Slot], SeededChance], list[tuple[str, Slot]]]] = {
    PlanMethod.RANDOMISED: lambda slots, chance: [("day", slot) for slot in chance.shuffled(slots)],
    PlanMethod.BLOCKED: _group_by_group,
}
"""How the runs of one day are ordered; the name of the block of each comes with it."""


LARGEST_PLAN = 100_000
"""Runs that a plan may have."""


@dataclass(frozen=True, slots=True)
class PlanFactor:
    """A factor and its levels; the one with a `control` level is the treatment, the others form the groups."""

    name: str
    levels: tuple[str, ...]
    control: str | None = None


@dataclass(frozen=True, slots=True)
class PlannedRun:
    """One run to be made: `condition` is None for an idle run, `duration_s` where the protocol fixes none.

    `position` counts through the plan, `day` the days, `position_in_day` through the day, all from 1. `block` names
    the runs of a day among which the order was drawn.
    """

    position: int
    day: int
    position_in_day: int
    block: str
    condition: Condition | None
    kind: RunKind
    duration_s: float | None


@dataclass(frozen=True, slots=True)
class Plan:
    """The runs of a study in the order in which to make them."""

    factors: tuple[PlanFactor, ...]
    method: PlanMethod
    seed: int
    runs: tuple[PlannedRun, ...]

    @property
    def days(self) -> tuple[tuple[PlannedRun, ...], ...]:
        """The runs of each day."""
        return tuple(tuple(runs) for _, runs in itertools.groupby(self.runs, key=lambda run: run.day))


def draw_plan(
    factors: Sequence[PlanFactor],
    runs_per_condition: int,
    runs_per_day: int,
    method: PlanMethod,
    seed: int,
    *,
    idle_minutes: Sequence[float] = (),
    run_duration_s: float | None = None,
) -> Plan:
    """Draw a plan: `runs_per_condition` runs of each combination of levels, at most `runs_per_day` a day.

    Each of `idle_minutes` is one idle run of that length (thesis 5.1.4); it takes a place of its day like any other
    run. Raises `UsageError` for a plan that cannot be made.
    """
    _check(factors, runs_per_condition, runs_per_day, seed, len(idle_minutes))
    chance = SeededChance(seed)
    groups = [
        [_replicate(factors, group, run_duration_s, chance) for _number in range(runs_per_condition)]
        for group in _nested([factor for factor in factors if factor.control is None], chance)
    ]
    queue = QUEUES[method](groups, chance)
    idle = chance.shuffled(Slot(None, None, 60.0 * minutes) for minutes in idle_minutes)
    runs: list[PlannedRun] = []
    controls = {replicates[0].control for replicates in groups}
    ahead: dict[Condition, float] = {}
    for day, slots in enumerate(fill_days(queue, idle, runs_per_day, chance), start=1):
        order = _balanced(ORDERS[method](slots, chance), controls, ahead)
        for place, (block, slot) in enumerate(order, start=1):
            kind = RunKind.IDLE if slot.condition is None else RunKind.JUMPS
            runs.append(PlannedRun(len(runs) + 1, day, place, block, slot.condition, kind, slot.duration_s))
    return Plan(tuple(factors), method, seed, tuple(runs))


def _nested(factors: Sequence[PlanFactor], chance: SeededChance) -> list[Condition]:
    """Every combination of levels in random order, the first factor's levels each in one stretch."""
    if not factors:
        return [()]
    return [
        ((factors[0].name, level), *rest)
        for level in chance.shuffled(factors[0].levels)
        for rest in _nested(factors[1:], chance)
    ]


def _replicate(
    factors: Sequence[PlanFactor], group: Condition, duration_s: float | None, chance: SeededChance
) -> Replicate:
    treatment = next((factor for factor in factors if factor.control is not None), None)
    if treatment is None:
        return Replicate((Slot(group, group, duration_s),), None)

    def slot(level: str) -> Slot:
        levels = {**dict(group), treatment.name: level}
        return Slot(group, tuple((factor.name, levels[factor.name]) for factor in factors), duration_s)

    control = slot(str(treatment.control))
    others = [slot(level) for level in treatment.levels if level != treatment.control]
    return Replicate((control, *chance.shuffled(others)), control)


def _check(
    factors: Sequence[PlanFactor],
    runs_per_condition: int,
    runs_per_day: int,
    seed: int,
    idle: int,
) -> None:
    for what, number in (("runs per condition", runs_per_condition), ("runs a day", runs_per_day)):
        if number < 1:
            raise UsageError(f"{number} {what} is too few: give 1 or more.")
    if runs_per_day == 1 and any(factor.control is not None and len(factor.levels) > 1 for factor in factors):
        raise UsageError(
            "a day of 1 run cannot hold a run and its control: give 2 or more runs a day, or no control level."
        )
    if not 0 <= seed < 2**63:
        raise UsageError(f"the seed {seed} cannot be kept: give a whole number from 0 to {2**63 - 1}.")
    conditions = math.prod(len(factor.levels) for factor in factors)
    size = conditions * runs_per_condition + idle
    if size > LARGEST_PLAN:
        raise UsageError(f"the plan would have {size} runs, at most {LARGEST_PLAN} are drawn: plan fewer at a time.")
