"""What a scene does without each of its effects and each two, and which of them are enough for a tolerance."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import combinations

from data_schema.errors import UsageError
from data_schema.vocabulary import Undefined
from simulator.ablation.outputs import Outputs, outputs_of
from simulator.ablation.smallest import (
    LeavingOut,
    LeftOut,
    OutputsWithout,
    Smallest,
    in_order,
    refusal,
    smallest_is_full,
    smallest_set,
)
from simulator.scene import Scene

MEASURED_JUMPS = 10
"""Of a scene with more jumps, so many are simulated for each set of effects, and the last of them is looked at."""
CHECKED_JUMPS = 100
"""Of a scene with more jumps, so many are simulated to check the smallest set: jumps grow steady by then."""
_MOST_HALVINGS = 8
STEPS_MORE = 30
"""Times the steps of a jump with all effects after which one without some of them is given up. What chatters without
the controller's clock takes thousands of times as many; shipped scenes without one or two effects at most twice as
many."""
OUTPUTS = ("cost", "apex", "depth")
REPORTED_SURPRISE = 0.1
"""Part of the tolerance from which on a deviation from the expected change is reported."""


@dataclass(frozen=True, slots=True)
class Ablation:
    """What leaving out the effects of a scene changes, against a tolerance.

    `scene` is as it was measured, with few jumps. `alone`, by effect; `needed`: effects that cannot be left out alone,
    each with the sentence that says why; `pairs`, by both effects in either order, where both may go. `checked`: what
    the smallest set leaves out, after as many jumps as are checked; `searched_within`: the tolerance that the set was
    searched for, finer than `tolerance` where differences grow from jump to jump.
    """

    scene: Scene
    accuracy: float
    tolerance: float
    full: Outputs
    alone: Mapping[str, LeftOut]
    needed: Mapping[str, str]
    pairs: Mapping[tuple[str, str], LeftOut]
    smallest: Smallest
    checked: LeftOut
    searched_within: float


def measured_scene(scene: Scene) -> Scene:
    """Return the scene with as many jumps as are simulated to measure its effects."""
    return scene.changed(jumps=min(scene.jumps, MEASURED_JUMPS))


def sets_to_leave_out(scene: Scene, retained: frozenset[str] = frozenset()) -> tuple[frozenset[str], ...]:
    """Return the sets of one or two effects, none `retained`, without which the scene can still be simulated."""
    names = in_order(scene.effects - retained)
    sets = [frozenset(left_out) for size in (1, 2) for left_out in combinations(names, size)]
    return tuple(left_out for left_out in sets if refusal(scene, left_out) is None)


def ablation_of_effects(
    scene: Scene,
    tolerance: float,
    accuracy: float = 1e-6,
    step: Callable[[str], None] = lambda _done: None,
    retained: frozenset[str] = frozenset(),
) -> Ablation:
    """Leave out each effect, and each two, and search the smallest set within the tolerance; those `retained` stay.

    The set is within it in the last jump that is measured and in the last that is checked. `step` is called after
    each set of `sets_to_leave_out`, and then once when the search has ended. Raises `UsageError` for a scene that does
    not come to an apex.
    """
    measured = measured_scene(scene)
    leaving_out = _leaving_out(measured, accuracy, retained)
    full = leaving_out.full
    _check_jumps(scene, full)
    found: list[LeftOut] = []
    for left_out in sets_to_leave_out(measured, retained):
        found.append(leaving_out.measure(left_out))
        step(f"without {' and '.join(found[-1].effects)}")
    later = leaving_out
    if scene.jumps > measured.jumps:
        later = _leaving_out(scene.changed(jumps=min(scene.jumps, CHECKED_JUMPS)), accuracy, retained)
    smallest, checked, share = _smallest(leaving_out, later, found, tolerance)
    step("smallest set")
    alone = {item.effects[0]: item for item in found if len(item.effects) == 1}
    pairs = {(item.effects[0], item.effects[1]): item for item in found if len(item.effects) == 2}
    refusals = {name: refusal(measured, frozenset({name})) for name in in_order(measured.effects)}
    return Ablation(
        scene=measured,
        accuracy=accuracy,
        tolerance=tolerance,
        full=full,
        alone=alone,
        needed={name: sentence for name, sentence in refusals.items() if sentence is not None},
        pairs={**pairs, **{(second, first): item for (first, second), item in pairs.items()}},
        smallest=smallest,
        checked=checked,
        searched_within=share,
    )


def outputs_without(scene: Scene, accuracy: float, steps_more: int = STEPS_MORE) -> OutputsWithout:
    """Return the function that simulates a scene without some of its effects, each set once.

    A jump that takes `steps_more` times the steps of any with all effects is given up (`step_limit`, `too_stiff`).
    """

    @cache
    def outputs(left_out: frozenset[str]) -> Outputs:
        most_steps = steps_more * outputs(frozenset()).most_steps if left_out else None
        return outputs_of(scene.changed(effects_off=left_out), accuracy, most_steps)

    return outputs


def _leaving_out(scene: Scene, accuracy: float, retained: frozenset[str]) -> LeavingOut:
    return LeavingOut(scene, outputs_without(scene, accuracy), retained)


def _check_jumps(scene: Scene, full: Outputs) -> None:
    if full.apex_height_m is None:
        raise UsageError(
            f"jump {full.jumps} of {scene.name} ends in {full.outcome}, before an apex, so that there is no jump for "
            "an effect to change: set other values until the robot jumps."
        )


def _smallest(
    leaving_out: LeavingOut, later: LeavingOut, found: Sequence[LeftOut], tolerance: float
) -> tuple[Smallest, LeftOut, float]:
    """Search for ever finer tolerances until what is found is within the tolerance later, too."""
    for halvings in range(_MOST_HALVINGS):
        share = tolerance / 2**halvings
        smallest = smallest_set(leaving_out, found, share)
        checked = later.measure(frozenset(smallest.left_out.effects))
        if checked.difference.within(tolerance):
            return smallest, checked, share
    return smallest_is_full(leaving_out), later.measure(frozenset()), 0.0


@dataclass(frozen=True, slots=True)
class Together:
    """The relative change of an output without an effect and its partner, and that expected from each alone.

    Expected is that the two factors by which the output changes multiply.
    """

    partner: str
    output: str
    change: float | Undefined
    expected: float

    @property
    def surprise(self) -> float:
        """How far the change is from what is expected; infinite where the jump ends otherwise without both."""
        return math.inf if isinstance(self.change, Undefined) else abs(self.change - self.expected)


def least_additive_pair(ablation: Ablation, effect: str) -> Together | None:
    """Return the pair with this effect, and the output, whose change is farthest from the product of single changes.

    None where all pairs are as expected, to a tenth of the tolerance, and where the effect cannot be left out alone.
    """
    found = [
        Together(partner, output, both, (1.0 + mine) * (1.0 + others) - 1.0)
        for (name, partner), pair in ablation.pairs.items()
        if name == effect and effect in ablation.alone and partner in ablation.alone
        for output, both, mine, others in zip(
            OUTPUTS,
            pair.difference.changes,
            ablation.alone[effect].difference.changes,
            ablation.alone[partner].difference.changes,
            strict=True,
        )
        if not isinstance(mine, Undefined) and not isinstance(others, Undefined)
    ]
    worst = max(found, key=lambda item: item.surprise, default=None)
    return worst if worst is not None and worst.surprise > REPORTED_SURPRISE * ablation.tolerance else None
