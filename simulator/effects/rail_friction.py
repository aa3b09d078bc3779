"""Dry friction of the body on its vertical rail: a constant force against its motion, and a hold while it rests."""

from __future__ import annotations

from simulator.compiled import inner
from simulator.effects.effect import Effect, Function, ParameterIndex
from simulator.parameter import Parameter


def _functions(at: ParameterIndex) -> dict[str, Function]:
    force = at("rail_friction_force")
    return {"rail_friction_n": inner(lambda p: p[force])}


EFFECT = Effect(
    name="rail_friction",
    meaning="dry friction of the body on its rail",
    source="thesis 4.2.4: the robot is constrained to a vertical rail",
    parameters=(Parameter("rail_friction_force", "robot", "N", "friction of the rail", 0.0, 1e3),),
    publishes=("friction_loss_J",),
    functions=_functions,
)
