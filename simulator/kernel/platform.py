"""The emulator's platform between stances: held, or led back up along a minimum-jerk path (thesis 4.2.3)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from simulator.compiled import inner
from simulator.effects.effect import Function
from simulator.kernel.composition import Composition
from simulator.kernel.layout import (
    DEEPEST,
    EMULATOR_SINCE,
    RESET_FROM,
)

Row = NDArray[np.float64]


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
