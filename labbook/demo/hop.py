"""One jump from a height as the simulator has it: drop, stance, flight.

What jumps of a condition differ by, the height of the drop and the apex, stretches drop and flight as gravity would
have it, their times by the root of their heights; the stance is the simulated one.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class HopMotion:
    """A hop sampled in time: arrays of one shape, SI units, up positive."""

    body_height_m: FloatArray
    leg_length_m: FloatArray
    leg_velocity_m_s: FloatArray
    extending: NDArray[np.bool_]


@dataclass(frozen=True, slots=True, eq=False)
class Hop:
    """A hop from its drop to its second touchdown: heights of the body above the undisturbed ground, times since the
    drop. The switch is where the leg is shortest. `motion` samples the hop at times, rising, to its end at most.
    """

    rest_length_m: float
    lift_off_height_m: float
    apex_height_m: float
    switch_height_m: float
    switch_leg_m: float
    switch_s: float
    apex_s: float
    landing_s: float
    motion: Callable[[FloatArray], HopMotion]


@dataclass(frozen=True, slots=True, eq=False)
class SimulatedJump:
    """A jump of the simulator: arrays of shape (samples,) from its drop to its second touchdown."""

    joules: float
    time_s: FloatArray
    height_m: FloatArray
    leg_m: FloatArray
    touchdown_s: float
    lift_off_s: float
    lift_off_height_m: float
    apex_s: float
    apex_height_m: float


def simulated_hop(jump: SimulatedJump, rest_length_m: float, start_m: float, apex_height_m: float) -> Hop:
    """Return the simulated jump, begun at `start_m` and reaching `apex_height_m`."""
    low_m, end_s = jump.lift_off_height_m, float(jump.time_s[-1])
    drop_share = (start_m - rest_length_m) / (float(jump.height_m[0]) - rest_length_m)
    rise_share = (apex_height_m - low_m) / (jump.apex_height_m - low_m)
    touchdown_s = math.sqrt(drop_share) * jump.touchdown_s
    lift_off_s = touchdown_s + jump.lift_off_s - jump.touchdown_s
    apex_s, landing_s = (
        lift_off_s + math.sqrt(rise_share) * (simulated_s - jump.lift_off_s) for simulated_s in (jump.apex_s, end_s)
    )
    shortest = int(np.argmin(jump.leg_m))
    switch_s = touchdown_s + float(jump.time_s[shortest]) - jump.touchdown_s

    def motion(time_s: FloatArray) -> HopMotion:
        times_s = [0.0, touchdown_s, lift_off_s, landing_s]
        simulated_s = np.interp(time_s, times_s, [0.0, jump.touchdown_s, jump.lift_off_s, end_s])
        height_m, leg_m = (np.interp(simulated_s, jump.time_s, values) for values in (jump.height_m, jump.leg_m))
        dropping, flying = time_s < touchdown_s, time_s > lift_off_s
        height_m[dropping] = rest_length_m + drop_share * (height_m[dropping] - rest_length_m)
        height_m[flying] = low_m + rise_share * (height_m[flying] - low_m)
        return HopMotion(height_m, leg_m, np.gradient(leg_m, time_s), (time_s > switch_s) & ~flying)

    return Hop(
        rest_length_m=rest_length_m,
        lift_off_height_m=low_m,
        apex_height_m=apex_height_m,
        switch_height_m=float(jump.height_m[shortest]),
        switch_leg_m=float(jump.leg_m[shortest]),
        switch_s=switch_s,
        apex_s=apex_s,
        landing_s=landing_s,
        motion=motion,
    )
