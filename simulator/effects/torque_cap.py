"""A cap on the leg's force by the motors' stall torque, through the leg's kinematics (thesis 3.2.1)."""

from __future__ import annotations

from simulator.compiled import Function, inner
from simulator.effects.effect import Effect, ParameterIndex
from simulator.effects.shared import STALL_TORQUE


def _functions(at: ParameterIndex) -> dict[str, Function]:
    torque = at("stall_torque")
    return {"cap_n": inner(lambda p, lever_m, driven_m_s: 2.0 * p[torque] / lever_m), "cap_bends": inner(lambda: True)}


EFFECT = Effect(
    name="torque_cap",
    meaning="the leg's force is at most what both motors hold at stall, at each leg length",
    source="thesis 3.2.1",
    parameters=(STALL_TORQUE,),
    excludes={
        "constant_force_cap": "the leg's force has one cap: leave out constant_force_cap or torque_cap",
        "voltage_cap": "the leg's force has one cap: leave out torque_cap or voltage_cap",
    },
    publishes=("capped_time_s",),
    functions=_functions,
)
