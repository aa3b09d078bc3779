"""Fill the days of a plan with replicates, and order the runs of each day.

RANDOMISED takes the groups in rounds, one replicate of each in random order, so that no group is tied to one part of
the campaign, and shuffles each day as a whole. BLOCKED finishes one group before the next, in nested random order
(the factor declared first changes least often: declare the one that is hardest to change first), and shuffles the
runs of a group within each day; idle runs stand between groups.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from data_schema.vocabulary import PlanMethod
from labbook.plan.chance import SeededChance

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


def _rounds(groups: list[list[Replicate]], chance: SeededChance) -> list[Replicate]:
    return [replicate for together in zip(*groups, strict=True) for replicate in chance.shuffled(together)]


def _one_after_another(groups: list[list[Replicate]], chance: SeededChance) -> list[Replicate]:
    return [replicate for replicates in groups for replicate in chance.shuffled(replicates)]


def fill_days(queue: list[Replicate], runs_per_day: int) -> Iterator[list[Slot]]:
    """Fill one day after another from the queue; a day starts a group with its control, or leaves it for the next."""
    today: list[Slot] = []
    controlled: set[Slot] = set()
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
            free = runs_per_day - len(today)
            if free < needed:
                yield today
                today, controlled = [], set()
            else:
                today += pending[:free]
                controlled.update(pending[:1])
                pending = pending[free:]
    yield today


def _whole_day(slots: list[Slot], chance: SeededChance) -> list[tuple[str, Slot]]:
    return [("day", slot) for slot in chance.shuffled(slots)]


def _group_by_group(slots: list[Slot], chance: SeededChance) -> list[tuple[str, Slot]]:
    stretches: dict[Condition, list[Slot]] = {}
    idle: list[Slot] = []
    for slot in slots:
        (idle if slot.group is None else stretches.setdefault(slot.group, [])).append(slot)
    blocks = [(_block_name(group), chance.shuffled(runs)) for group, runs in stretches.items()]
    for slot in idle:
        blocks.insert(chance.below(len(blocks) + 1), ("idle", [slot]))
    return [(name, slot) for name, runs in blocks for slot in runs]


def _block_name(group: Condition) -> str:
    return ", ".join(f"{factor}={level}" for factor, level in group) or "day"


QUEUES: dict[PlanMethod, Callable[[list[list[Replicate]], SeededChance], list[Replicate]]] = {
    PlanMethod.RANDOMISED: _rounds,
    PlanMethod.BLOCKED: _one_after_another,
}
"""How the replicates of all groups are put one behind another."""

ORDERS: dict[PlanMethod, Callable[[list[Slot], SeededChance], list[tuple[str, Slot]]]] = {
    PlanMethod.RANDOMISED: _whole_day,
    PlanMethod.BLOCKED: _group_by_group,
}
"""How the runs of one day are ordered; the name of the block of each comes with it."""
