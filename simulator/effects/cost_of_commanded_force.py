"""The cost counts the force the controller commands, though a cap keeps the robot from it (set 2, thesis 3.3)."""

from __future__ import annotations

from simulator.compiled import Function, inner
from simulator.effects.effect import Effect, ParameterIndex


def _functions(at: ParameterIndex) -> dict[str, Function]:
    return {"cost_force_n": inner(lambda p, lever_m, commanded_n, applied_n: commanded_n)}


EFFECT = Effect(
    name="cost_of_commanded_force",
    meaning="the cost is that of the commanded force; off, of the applied force",
    source="published with the second set of simulations, thesis 3.3",
    excludes={"cost_torque_cap": "the cost counts one force: leave out cost_of_commanded_force or cost_torque_cap"},
    functions=_functions,
)
