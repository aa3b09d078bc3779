"""Sampled control: the controller looks and sets gains at ticks of its clock, from touchdown on (thesis 3.1.3)."""

from __future__ import annotations

from simulator.compiled import Function, inner
from simulator.effects.effect import Effect, ParameterIndex
from simulator.parameter import Parameter


def _functions(at: ParameterIndex) -> dict[str, Function]:
    rate = at("control_rate")
    return {"control_period_s": inner(lambda p: 1.0 / p[rate])}


EFFECT = Effect(
    name="sampled_control",
    meaning="control at the ticks of a clock; off, control is continuous",
    source="thesis 3.1.3: an update loop of 1 kHz",
    parameters=(Parameter("control_rate", "controller", "Hz", "rate of the controller's clock", 1.0, 1e5),),
    functions=_functions,
)
