"""What a scene gives without each of its effects, and which of them are enough for a tolerance."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass

from data_schema.errors import UsageError
from data_schema.reasons import Reason
from data_schema.vocabulary import Undefined
from simulator.effects.registry import EFFECTS
from simulator.jump import limits_for, simulate
from simulator.result import SceneResult
from simulator.scene import Scene

MEASURED_JUMPS = 10
"""Of a scene with more jumps, so many are simulated for each set of effects, and the last of them is looked at."""
STEPS_MORE = 30
"""Times the steps of a jump with all effects after which one without some of them is given up. What chatters without
the controller's clock takes thousands of times as many; shipped scenes without one effect at most twice as many."""
ACCURACIES_A_TOLERANCE = 10.0
"""A tolerance is at least so many times the accuracy: differences of results have the errors of both."""


@dataclass(frozen=True, slots=True)
class Without:
    """What a scene gives without some effects, and the relative changes of cost, apex and depth, signed.

    They are those of the last jump, and undefined where that ended otherwise.
    """

    effects: tuple[str, ...]
    result: SceneResult
    changes: Mapping[str, float | Undefined]

    @property
    def largest(self) -> float:
        """The largest change, without its sign; infinite where one is undefined."""
        return max(math.inf if isinstance(change, Undefined) else abs(change) for change in self.changes.values())


@dataclass(frozen=True, slots=True)
class Ablation:
    """What leaving out the effects of a scene changes, against a tolerance.

    `scene` is as it was measured, with few jumps. `alone`: without each effect; `needed`: effects that cannot be left
    out, each with the sentence that says why; `left_out`: the effects that are not needed for the tolerance.
    """

    scene: Scene
    accuracy: float
    tolerance: float
    full: SceneResult
    alone: Mapping[str, Without]
    needed: Mapping[str, str]
    left_out: Without

    @property
    def enough(self) -> tuple[str, ...]:
        """The effects that are enough."""
        return _in_order(self.scene.effects - set(self.left_out.effects))


def ablation_of_effects(
    scene: Scene, tolerance: float, accuracy: float = 1e-6, step: Callable[[str], None] = lambda _done: None
) -> Ablation:
    """Leave out each effect alone; then one after the other, always the one that changes least, within the tolerance.

    `step` is called before each set of effects is simulated. Raises `UsageError` for a scene that does not come to an
    apex.
    """
    scene = scene.changed(jumps=min(scene.jumps, MEASURED_JUMPS))
    full = simulate(scene, accuracy)
    if full.jump.apex_height_m is None:
        raise UsageError(
            f"jump {len(full.jumps)} of {scene.name} ends in {full.jump.outcome}, before an apex, so that there is no "
            "jump for an effect to change: set other values until the robot jumps."
        )

    def without(effects: Collection[str]) -> Without:
        names = _in_order(effects)
        step(f"without {' and '.join(names)}")
        found = simulate(scene.changed(effects_off=names), accuracy, most_steps=STEPS_MORE * most_steps(full))
        return Without(names, found, _changes(found, full))

    needed = {name: why for name in _in_order(scene.effects) if (why := _why_needed(scene, {name}))}
    alone = {name: without({name}) for name in _in_order(scene.effects) if name not in needed}
    left_out = Without((), full, _changes(full, full))
    candidates = list(alone.values())
    while candidates:
        best = min(candidates, key=lambda item: item.largest)
        if best.largest > tolerance:
            break
        left_out = best
        gone = set(best.effects)
        further = [gone | {name} for name in _in_order(scene.effects - gone)]
        candidates = [without(effects) for effects in further if not _why_needed(scene, effects)]
    return Ablation(scene, accuracy, tolerance, full, alone, needed, left_out)


def tolerance_of(words: str, accuracy: float) -> float:
    """Return the share that `1%` or `0.01` names: above 0, at most 1.

    Raises `UsageError` for what is no share, could mean two, or is finer than results of this accuracy resolve.
    """
    limits_for(accuracy)
    text = words.strip()
    percent = text.endswith("%")
    try:
        number = float(text.removesuffix("%"))
    except ValueError:
        number = math.nan
    share = number / 100.0 if percent else number
    if not 0.0 < share <= 1.0 or (share == 1.0 and not percent):
        raise UsageError(f"--within {words} is no share above 0, to 100%: write for example --within 1% or 0.01.")
    if share < ACCURACIES_A_TOLERANCE * accuracy:
        raise UsageError(
            f"--within {words} is too fine to tell with results of accuracy {accuracy:g}: give at least "
            f"{100.0 * ACCURACIES_A_TOLERANCE * accuracy:g}%, or --accuracy {share / ACCURACIES_A_TOLERANCE:g}."
        )
    return share


def most_steps(result: SceneResult) -> int:
    """Return the number of steps of the jump that took the most."""
    return max(jump.steps for jump in result.jumps)


COMPARED = {"cost": "cost_J", "apex": "apex_height_m", "depth": "max_depth_m"}
"""What is compared, and which number of a jump that is."""


def _changes(found: SceneResult, full: SceneResult) -> dict[str, float | Undefined]:
    """Return how far results are from the full scene's: 0 for what neither has, undefined for what only one has."""
    one, other, jumps = found.jump, full.jump, len(found.jumps)
    if (one.outcome, jumps) != (other.outcome, len(full.jumps)):
        where = "" if jumps == len(full.jumps) else f" in jump {jumps}"
        return dict.fromkeys(COMPARED, Undefined(Reason.SIMULATED_ENDED, ended=f"{one.outcome}{where}"))
    return {name: _relative(name, getattr(one, key), getattr(other, key)) for name, key in COMPARED.items()}


def _relative(name: str, found: float | None, full: float | None) -> float | Undefined:
    if found == full:
        return 0.0
    if found is None or full is None:
        return Undefined(Reason.NO_OUTPUT_WITHOUT if found is None else Reason.NO_OUTPUT_WITH, output=name)
    return (found - full) / abs(full) if full else Undefined(Reason.FULL_SCENE_ZERO, output=name)


def _in_order(effects: Collection[str]) -> tuple[str, ...]:
    return tuple(name for name in EFFECTS if name in effects)


def _why_needed(scene: Scene, effects: Collection[str]) -> str:
    """Return the sentence that says why a scene cannot be without these effects, empty where it can."""
    try:
        scene.changed(effects_off=effects)
    except UsageError as refused:
        return str(refused)
    return ""
