"""Guard of the published controller: a leg shorter than this extends, whatever else holds."""

from __future__ import annotations

from simulator.compiled import Function, inner
from simulator.effects.effect import Effect, ParameterIndex
from simulator.parameter import Parameter


def _functions(at: ParameterIndex) -> dict[str, Function]:
    length = at("guard_length")
    return {"guard_length_m": inner(lambda p: p[length])}


EFFECT = Effect(
    name="short_leg_guard",
    meaning="a leg shorter than the guard length extends, before it folds",
    source="published with the simulations of ch. 3",
    parameters=(Parameter("guard_length", "controller", "m", "leg length below which it extends", 1e-3, 1.0),),
    functions=_functions,
)
