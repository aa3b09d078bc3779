"""The emulator's platform between stances: held, or led back up along a minimum-jerk path (thesis 4.2.3)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from simulator.compiled import inner
from simulator.effects.effect import Function
from simulator.kernel.composition import Composition, made_once
from simulator.kernel.layout import (
    DEEPEST,
    EMULATOR_SINCE,
    IMPACT,
    NOW,
    RESET_FROM,
    SLIDES,
)

Row = NDArray[np.float64]


@made_once
def make_platform(composition: Composition) -> Function:
    """Height, velocity and acceleration of the platform: `(work, t)`, moving only while it is being reset.

    Where nothing resets, the height is the lowest the foot has been at.
    """
    if not composition.has("travel_m"):
        return inner(lambda work, t: (work[DEEPEST], 0.0, 0.0))
    duration = composition.position["reset_time"]

    @inner
    def platform(work: Row, t: float) -> tuple[float, float, float]:
        start = work[RESET_FROM]
        if start >= 0.0:
            return work[DEEPEST], 0.0, 0.0
        length = work[duration]
        s = min(max((t - work[EMULATOR_SINCE]) / length, 0.0), 1.0)
        left = 1.0 - s
        height = start * (1.0 - s * s * s * (10.0 + s * (6.0 * s - 15.0)))
        velocity = -start * 30.0 * s * s * left * left / length
        acceleration = -start * 60.0 * s * left * (1.0 - 2.0 * s) / (length * length)
        return height, velocity, acceleration

    return platform


def make_slide(composition: Composition) -> Function:
    """Rates of a platform that slides on without the foot, and the power it loses: `(work, row, stage)`.

    m_p a_p = k z + alpha w + beta w^2, downwards at the speed w, its weight carried by its motors.
    """
    if composition.platform < 0:
        return inner(lambda work, row, stage: 0.0)
    place, mass_kg = composition.platform, composition.slots["platform_mass_kg"]
    resistance_n, linear = composition.slots["resistance_n"], composition.slots["linear_drag_kg_s"]
    quadratic = composition.slots["quadratic_drag_kg_m"]

    @inner
    def slide(work: Row, row: int, stage: int) -> float:
        if work[SLIDES] == 0:
            work[stage + place], work[stage + place + 1] = 0.0, 0.0
            return 0.0
        depth_m, sinking = -work[row + place], -work[row + place + 1]
        push_n = resistance_n(work, depth_m) + (linear(work) + quadratic(work, depth_m) * sinking) * sinking
        work[stage + place], work[stage + place + 1] = -sinking, push_n / mass_kg(work)
        return push_n * sinking

    return slide


def make_stop_platform(composition: Composition) -> Function:
    """Stop a sliding platform: `(work)`; what it moved with is lost and booked."""
    if composition.platform < 0:
        return inner(lambda work: None)
    place, mass_kg = composition.platform, composition.slots["platform_mass_kg"]

    @inner
    def stop_platform(work: Row) -> None:
        if work[SLIDES] == 1:
            speed_m_s = work[NOW + place + 1]
            lost_j = 0.5 * mass_kg(work) * speed_m_s * speed_m_s
            work[IMPACT] += lost_j
            work[DEEPEST], work[SLIDES] = work[NOW + place], 0

    return stop_platform
