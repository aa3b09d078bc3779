"""A cap on the leg's force by the supply's voltage, through the leg's kinematics: torque falls with the motors' speed.

The motors brake with what their own voltage adds to the supply's. Beyond the speed at which it is as high as that the
driver opens its bridge, and they give nothing.
"""

from __future__ import annotations

from simulator.compiled import Function, Row, inner
from simulator.effects.effect import Effect, ParameterIndex
from simulator.effects.shared import MOTOR_RESISTANCE, TORQUE_CONSTANT, VELOCITY_CONSTANT
from simulator.parameter import Parameter


def _functions(at: ParameterIndex) -> dict[str, Function]:
    voltage, resistance = at("supply_voltage"), at("motor_resistance")
    torque, velocity = at("torque_constant"), at("velocity_constant")
    stall_at, slope_at = at("voltage_stall_torque"), at("voltage_torque_slope")

    @inner
    def prepare(p: Row) -> None:
        p[stall_at] = 2.0 * p[torque] * p[voltage] / p[resistance]
        p[slope_at] = 2.0 * p[torque] * p[velocity] / p[resistance]

    @inner
    def cap_n(p: Row, lever_m: float, driven_m_s: float) -> float:
        return (p[stall_at] - p[slope_at] * driven_m_s / lever_m) / lever_m

    return {"prepare": prepare, "cap_n": cap_n, "cap_bends": inner(lambda: True), "cap_slows": inner(lambda: True)}


EFFECT = Effect(
    name="voltage_cap",
    meaning="the leg's force is at most what the supply's voltage lets both motors give at their speed",
    source="torque = K_tau (V - K_v omega) / R, not below 0, for the speed omega in its direction",
    parameters=(
        Parameter(
            "supply_voltage",
            "drive",
            "V",
            "voltage of the motors' supply",
            0.1,
            1e4,
            15.4,
            "the voltage of the thesis's batteries (5.1.4), which nobody measured in a jump",
        ),
        TORQUE_CONSTANT,
        MOTOR_RESISTANCE,
        VELOCITY_CONSTANT,
    ),
    excludes={
        "constant_force_cap": "the leg's force has one cap: leave out constant_force_cap or voltage_cap",
        "torque_cap": "the leg's force has one cap: leave out torque_cap or voltage_cap",
    },
    publishes=("capped_time_s",),
    derived=("voltage_stall_torque", "voltage_torque_slope"),
    functions=_functions,
)
