"""Effects left out of a scene, and the smallest set that stays within a tolerance of what all effects give.

The change of a result that a user lets pass, in words: `1%` or `0.01`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from itertools import combinations

from data_schema.errors import UsageError
from simulator.ablation.outputs import Difference, Outputs, difference
from simulator.effects.registry import EFFECTS
from simulator.jump import limits_for
from simulator.scene import Scene

ACCURACIES_A_TOLERANCE = 10.0
"""A tolerance is at least so many times the accuracy: differences of results have the errors of both."""


def tolerance_of(words: str, accuracy: float) -> float:
    """Return the share that the words name: above 0, at most 1.

    Raises `UsageError` for what is no share, could mean two, or is finer than results of this accuracy resolve, and
    for an accuracy that cannot be had.
    """
    limits_for(accuracy)
    text = words.strip()
    percent = text.endswith("%")
    try:
        number = float(text.removesuffix("%"))
    except ValueError:
        number = math.nan
    share = number / 100.0 if percent else number
    if not 0.0 < share < math.inf:
        raise UsageError(f"--within {words} is not a share above 0: write for example --within 1% or --within 0.01.")
    if not percent and share >= 1.0:
        raise UsageError(f"--within {words} does not say of what: write --within {number:g}%, or a number below 1.")
    if share > 1.0:
        raise UsageError(f"--within {words} lets everything pass: give at most 100%.")
    if share < ACCURACIES_A_TOLERANCE * accuracy:
        raise UsageError(
            f"--within {words} is too fine to tell with results of accuracy {accuracy:g}: give at least "
            f"{100.0 * ACCURACIES_A_TOLERANCE * accuracy:g}%, or --accuracy {share / ACCURACIES_A_TOLERANCE:g}."
        )
    return share


MOST_CANDIDATES = 8
"""With so many effects that may go, all their subsets are simulated: at most 256."""

Sets = tuple[frozenset[str], ...]
OutputsWithout = Callable[[frozenset[str]], Outputs]
"""What a scene gives without these effects."""


@dataclass(frozen=True, slots=True)
class LeftOut:
    """Effects that are left out, in the registry's order, what the scene gives without them, and the difference."""

    effects: tuple[str, ...]
    outputs: Outputs
    difference: Difference


@dataclass(frozen=True, slots=True)
class LeavingOut:
    """A scene, the function that simulates it without some of its effects, and those that stay whatever they change."""

    scene: Scene
    outputs: OutputsWithout
    retained: frozenset[str] = frozenset()

    @property
    def full(self) -> Outputs:
        """What the scene gives with all its effects."""
        return self.outputs(frozenset())

    def measure(self, effects: frozenset[str]) -> LeftOut:
        """Simulate the scene without these effects; they must leave one that can be simulated."""
        found = self.outputs(effects)
        return LeftOut(in_order(effects), found, difference(found, self.full))


def in_order(effects: frozenset[str]) -> tuple[str, ...]:
    """Return effects in the registry's order."""
    return tuple(name for name in EFFECTS if name in effects)


def refusal(scene: Scene, effects: frozenset[str]) -> str | None:
    """Return the sentence that says why a scene cannot be without these effects, None where it can."""
    try:
        scene.changed(effects_off=effects)
    except UsageError as refused:
        return str(refused)
    return None


@dataclass(frozen=True, slots=True)
class Smallest:
    """The effects that are enough, and what is left out. No single further effect can go.

    `candidates`: effects that can go alone or together with one other. `exhaustive`: whether all subsets of the
    candidates were looked at; otherwise effects were left out one by one, always the one that changes least.
    """

    effects: tuple[str, ...]
    left_out: LeftOut
    candidates: tuple[str, ...]
    exhaustive: bool


def smallest_set(leaving_out: LeavingOut, singles_and_pairs: Iterable[LeftOut], tolerance: float) -> Smallest:
    """Search the smallest set; of several, the one with the smallest change.

    `singles_and_pairs`: what leaving out one effect or two does, for all that may be left out so. Effects that go
    only in a company of three or more, whose changes cancel, are not looked for. What is found was simulated, and
    is within the tolerance.
    """
    gone = [item for item in singles_and_pairs if item.difference.within(tolerance)]
    candidates = in_order(frozenset(name for item in gone for name in item.effects))
    exhaustive = len(candidates) <= MOST_CANDIDATES
    found = _largest_subset(leaving_out, candidates, tolerance) if exhaustive else frozenset[str]()
    further = _one_by_one(leaving_out, found, tolerance)
    return Smallest(
        effects=in_order(leaving_out.scene.effects - further),
        left_out=leaving_out.measure(further),
        candidates=candidates,
        exhaustive=exhaustive and further == found,
    )


def smallest_is_full(leaving_out: LeavingOut) -> Smallest:
    """Return the full scene as the smallest set: no effect can go."""
    return Smallest(in_order(leaving_out.scene.effects), leaving_out.measure(frozenset()), (), True)


def _largest_subset(leaving_out: LeavingOut, candidates: tuple[str, ...], tolerance: float) -> frozenset[str]:
    for size in range(len(candidates), 0, -1):
        found = _best(leaving_out, tuple(map(frozenset, combinations(candidates, size))), tolerance)
        if found is not None:
            return found
    return frozenset()


def _one_by_one(leaving_out: LeavingOut, left_out: frozenset[str], tolerance: float) -> frozenset[str]:
    """Leave out further effects, each time the one with the smallest change, until none can go."""
    remaining = in_order(leaving_out.scene.effects - leaving_out.retained - left_out)
    found = _best(leaving_out, tuple(left_out | {name} for name in remaining), tolerance)
    return left_out if found is None else _one_by_one(leaving_out, found, tolerance)


def _best(leaving_out: LeavingOut, sets: Sets, tolerance: float) -> frozenset[str] | None:
    """Return the set whose absence changes least, None where none stays within the tolerance."""
    possible = [leaving_out.measure(item) for item in sets if refusal(leaving_out.scene, item) is None]
    within = [item for item in possible if item.difference.within(tolerance)]
    return frozenset(min(within, key=lambda item: item.difference.largest).effects) if within else None
