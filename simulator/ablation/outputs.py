"""What a scene gives in cost, apex and depth, and how far another result of it is from that."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from data_schema.reasons import Reason
from data_schema.vocabulary import Undefined
from simulator.kernel.layout import OUTCOMES
from simulator.kernel.limits import MOST_STEPS
from simulator.scene import Scene
from simulator.sweep.chunks import recipe_for, simulate_rows
from simulator.sweep.design import Design
from simulator.sweep.outputs import PLACE


@dataclass(frozen=True, slots=True)
class Outputs:
    """What a scene's last jump gives, how it ended, and how many jumps there were until then.

    `most_steps` is the number of steps of the jump that took the most.
    """

    outcome: str
    jumps: int
    cost_J: float  # noqa: N815
    apex_height_m: float | None
    max_depth_m: float
    rhs_evaluations: int
    ill_conditioned: bool
    most_steps: int


@dataclass(frozen=True, slots=True)
class Difference:
    """Relative changes from the full scene's outputs, signed; undefined where the jump ended otherwise."""

    cost: float | Undefined
    apex: float | Undefined
    depth: float | Undefined

    @property
    def changes(self) -> tuple[float | Undefined, float | Undefined, float | Undefined]:
        """Those of cost, apex and depth."""
        return self.cost, self.apex, self.depth

    @property
    def largest(self) -> float:
        """The largest change, without its sign; infinite where one is undefined."""
        return max(math.inf if isinstance(change, Undefined) else abs(change) for change in self.changes)

    def within(self, tolerance: float) -> bool:
        """Whether cost, apex and depth all change by at most this share."""
        return self.largest <= tolerance


def outputs_of(scene: Scene, accuracy: float, most_steps: int | None = None) -> Outputs:
    """Simulate a scene and return the outputs of its last jump.

    A jump of more than `most_steps` ends in `step_limit` or `too_stiff`; None leaves the simulator's own limit.
    """
    recipe = recipe_for(scene, Design(()), accuracy)
    if most_steps is not None:
        recipe.limits[MOST_STEPS] = most_steps
    ((*jumps,),) = simulate_rows(recipe, np.zeros((1, 0)))
    made = [dict(zip(PLACE, jump.tolist(), strict=True)) for jump in jumps if jump[PLACE["outcome"]] >= 0.0]
    last = made[-1]
    return Outputs(
        outcome=OUTCOMES[int(last["outcome"])],
        jumps=len(made),
        cost_J=last["cost_J"],
        apex_height_m=None if math.isnan(last["apex_height_m"]) else last["apex_height_m"],
        max_depth_m=last["max_depth_m"],
        rhs_evaluations=int(last["rhs_evaluations"]),
        ill_conditioned=any(jump["ill_conditioned"] for jump in made),
        most_steps=int(max(jump["steps"] for jump in made)),
    )


def difference(found: Outputs, full: Outputs) -> Difference:
    """Return how far results are from the full scene's: 0 for what neither has, undefined for what only one has."""
    if found.outcome != full.outcome or found.jumps != full.jumps:
        where = "" if found.jumps == full.jumps else f" in jump {found.jumps}"
        ended = Undefined(Reason.SIMULATED_ENDED, ended=f"{found.outcome}{where}")
        return Difference(ended, ended, ended)
    return Difference(
        cost=_relative("cost", found.cost_J, full.cost_J),
        apex=_relative("apex", found.apex_height_m, full.apex_height_m),
        depth=_relative("depth", found.max_depth_m, full.max_depth_m),
    )


def _relative(name: str, found: float | None, full: float | None) -> float | Undefined:
    if found == full:
        return 0.0
    if found is None or full is None:
        return Undefined(Reason.NO_OUTPUT_WITHOUT if found is None else Reason.NO_OUTPUT_WITH, output=name)
    return (found - full) / abs(full) if full else Undefined(Reason.FULL_SCENE_ZERO, output=name)
