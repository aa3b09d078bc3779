"""Damping of the virtual leg spring: b (v_b - v_f), with one coefficient a phase (thesis Eq. 3.1)."""

from __future__ import annotations

from simulator.compiled import Function, inner
from simulator.effects.effect import Effect, ParameterIndex
from simulator.parameter import Parameter


def _functions(at: ParameterIndex) -> dict[str, Function]:
    compression, extension = at("b_compression"), at("b_extension")
    return {
        "compression_damping_kg_s": inner(lambda p: p[compression]),
        "extension_damping_kg_s": inner(lambda p: p[extension]),
    }


EFFECT = Effect(
    name="leg_damping",
    meaning="linear damping of the virtual leg spring",
    source="thesis Eq. 3.1, 4.2.5",
    parameters=(
        Parameter("b_compression", "leg", "kg/s", "leg damping in compression", 0.0, 1e4),
        Parameter("b_extension", "leg", "kg/s", "leg damping in extension", 0.0, 1e4),
    ),
    functions=_functions,
)
