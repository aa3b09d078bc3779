"""Braking gives nothing back: where the leg's power is negative the mechanical part of the cost counts none."""

from __future__ import annotations

from simulator.compiled import Function, Row, inner
from simulator.effects.effect import MODES, Effect, Guard, ParameterIndex


def _functions(at: ParameterIndex) -> dict[str, Function]:
    @inner
    def power_turns_guard(p: Row, lever_m: float, v_r: float, force_n: float) -> float:
        return -force_n * v_r

    @inner
    def mechanical_w(p: Row, lever_m: float, v_r: float, force_n: float) -> float:
        return max(-force_n * v_r, 0.0)

    return {"power_turns_guard": power_turns_guard, "mechanical_w": mechanical_w}


EFFECT = Effect(
    name="no_regeneration",
    meaning="braking gives nothing back: negative power of the leg counts as 0; off, it is given back in full",
    source="a drive that cannot charge its battery, or burns what comes back in a resistor",
    guards=(Guard("power_turns", "F r', or - F r'", "the leg drives, or brakes", MODES, of_force=True),),
    functions=_functions,
)
