"""A constant cap on the leg's force, both ways (second set of simulations, thesis 3.3)."""

from __future__ import annotations

from simulator.compiled import Function, inner
from simulator.effects.effect import Effect, ParameterIndex
from simulator.parameter import Parameter


def _functions(at: ParameterIndex) -> dict[str, Function]:
    cap = at("force_cap")
    return {"cap_n": inner(lambda p, lever_m, driven_m_s: p[cap])}


EFFECT = Effect(
    name="constant_force_cap",
    meaning="the leg's force is at most a constant",
    source="thesis 3.3",
    parameters=(Parameter("force_cap", "drive", "N", "largest force of the leg", 1.0, 1e6),),
    excludes={
        "torque_cap": "the leg's force has one cap: leave out constant_force_cap or torque_cap",
        "voltage_cap": "the leg's force has one cap: leave out constant_force_cap or voltage_cap",
    },
    publishes=("capped_time_s",),
    functions=_functions,
)
