"""What happens in a steady jump while the extending leg drives the emulated ground down."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from simulator.jump import simulate
from simulator.kernel.layout import INTRUDING
from simulator.scene import Scene

RECORDED_JUMPS = 20
"""So many are recorded to look at the last: jumps settle to well under a micrometre within ten."""
_ROUNDING = 1e-9
"""m and m/s: a step that ends at the switch meets its condition but for rounding."""


@dataclass(frozen=True, slots=True)
class Yielding:
    """How deep the foot stands when the leg switches to extension, m, and the motors' heat from then on while the
    ground yields, J: active damping acts there and nowhere else.
    """

    switch_depth_m: float
    heat_j: float


def yielding_of(scene: Scene, accuracy: float) -> Yielding:
    """Record the jumps of a scene with the latched controller, and measure the last."""
    motion = simulate(scene.changed(jumps=RECORDED_JUMPS), accuracy, trajectory=True).trajectory
    if motion is None:
        raise RuntimeError(f"{scene.name} has no recorded motion")
    last = motion["jump"].to_numpy() == RECORDED_JUMPS - 1
    foot_m, length_m, heat_j = (motion[name].to_numpy()[last] for name in ("foot_height", "leg_length", "heat"))
    rate_m_s = (motion["body_velocity"] - motion["foot_velocity"]).to_numpy()[last]
    compressed = length_m < scene["rest_length"] - scene["switch_compression"] + _ROUNDING
    slow = rate_m_s > -scene["switch_speed_tolerance"] - _ROUNDING
    switch = int(np.argmax((compressed & slow) | (length_m < scene["guard_length"] + _ROUNDING)))
    yields = motion["mode"].to_numpy()[last] == INTRUDING
    spent_j = np.diff(heat_j[switch:])[yields[switch:-1] & yields[switch + 1 :]]
    return Yielding(switch_depth_m=-float(foot_m[switch]), heat_j=float(spent_j.sum()))
