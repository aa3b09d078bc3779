"""The values of one simulated scene, and of the same scene with a parameter raised or lowered."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from data_schema.errors import LabbookError
from data_schema.outcomes import Outcome

if TYPE_CHECKING:
    from simulator.result import JumpResult
    from simulator.scene import Scene

SIMULATED = (Outcome.JOULES, Outcome.APEX)
"""The outcomes that a simulation has."""


@dataclass(frozen=True, slots=True)
class Simulated:
    """One simulation of a scene: a value a quantity (None where a jump has no apex), and how the jump ended.

    `close_decision`: whether a decision hangs on a knife's edge; `branch` holds the values had it fallen otherwise,
    where that was simulated. `rounding`: what rounding has grown to, 0 where the accuracy has room for it.
    `under_surface`: whether the body gets under the grains; `open_book`: whether an energy book does not close.
    """

    values: Mapping[str, float | None]
    outcome: str
    close_decision: bool
    rounding: float
    under_surface: bool
    open_book: bool
    branch: Mapping[str, float | None] | None = None


def varied(scene: Scene, name: str, factor: float, accuracy: float) -> Mapping[str, float | None]:
    """Simulate with one parameter times a factor; nothing comes of what no scene can have."""
    try:
        changed = scene.changed({name: scene[name] * factor})
    except LabbookError:
        return dict.fromkeys(map(str, SIMULATED))
    return simulated(changed, accuracy).values


def simulated(scene: Scene, accuracy: float) -> Simulated:
    """Simulate a scene and take the mean over its jumps."""
    from simulator.jump import close_decision, grown_rounding, simulate

    jumps = simulate(scene, accuracy).jumps
    ended = next((jump.outcome for jump in jumps if jump.apex_height_m is None), jumps[-1].outcome)
    branch = None
    if any(jump.other_branch is not None for jump in jumps):
        branch = _means([jump.other_branch or jump for jump in jumps])
    rounding = max(grown_rounding(jump, accuracy) for jump in jumps)
    return Simulated(
        _means(jumps),
        ended,
        any(map(close_decision, jumps)),
        rounding,
        any(jump.under_surface for jump in jumps),
        any(jump.open_book for jump in jumps),
        branch,
    )


def _means(jumps: Sequence[JumpResult]) -> dict[str, float | None]:
    heights = [jump.apex_height_m for jump in jumps if jump.apex_height_m is not None]
    if len(heights) < len(jumps):
        return dict.fromkeys(map(str, SIMULATED))
    joules = math.fsum(jump.cost_J for jump in jumps)
    return {str(Outcome.JOULES): joules / len(jumps), str(Outcome.APEX): math.fsum(heights) / len(jumps)}
