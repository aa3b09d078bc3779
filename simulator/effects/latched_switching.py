"""Latched switching, the robot's rule (thesis 5.1.1): compressed far enough and no longer shortening, the leg extends
until it is back at its rest length. Without it the published rule of ch. 3 decides anew each time."""

from __future__ import annotations

from simulator.compiled import Function, inner
from simulator.effects.effect import Effect, ParameterIndex
from simulator.parameter import Parameter


def _functions(at: ParameterIndex) -> dict[str, Function]:
    compression, speed, rest = at("switch_compression"), at("switch_speed_tolerance"), at("rest_tolerance")
    return {
        "switch_compression_m": inner(lambda p: p[compression]),
        "switch_speed_tolerance_m_s": inner(lambda p: p[speed]),
        "rest_tolerance_m": inner(lambda p: p[rest]),
    }


EFFECT = Effect(
    name="latched_switching",
    meaning="the leg's phase is kept until its own condition ends it",
    source="thesis 4.2.5, 5.1.1",
    parameters=(
        Parameter("switch_compression", "controller", "m", "compression from which the leg may extend", 0.0, 0.15),
        Parameter("switch_speed_tolerance", "controller", "m/s", "shortening speed taken as none", 0.0, 0.5),
        Parameter("rest_tolerance", "controller", "m", "distance from the rest length taken as reached", 0.0, 0.05),
    ),
    functions=_functions,
)
