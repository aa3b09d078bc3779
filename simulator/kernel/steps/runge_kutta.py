"""One step of the embedded Runge-Kutta pair of Dormand and Prince (1980), order 5 with an error of order 4.

The step is taken by the fifth-order solution; the seventh stage is the rate at its end. Integrals do not act back on
the motion: between the stages only the motion is advanced.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from simulator.compiled import inner
from simulator.effects.effect import Function
from simulator.kernel.composition import Composition
from simulator.kernel.layout import (
    ERROR,
    K1,
    K2,
    K3,
    K4,
    K5,
    K6,
    K7,
    LEG_WORK,
    NOW,
    TRIAL,
)

Row = NDArray[np.float64]
ORDER = 5


def make_runge_kutta(composition: Composition, rates_of: Function) -> Function:
    """Compose the step `(mode, t, h, work)`.

    The place `K1` holds the rates at the start; `TRIAL`, `K7` and `ERROR` receive the state at the end, the rates
    there and its estimated error.
    """
    size = composition.state_size
    acting_later = composition.platform >= 0 or composition.effect_states  # they follow the integrals
    moving = size if acting_later else LEG_WORK

    @inner
    def step(mode: int, t: float, h: float, work: Row) -> None:
        for i in range(moving):
            work[TRIAL + i] = work[NOW + i] + h * 0.2 * work[K1 + i]
        rates_of(mode, t + 0.2 * h, work, TRIAL, K2)
        for i in range(moving):
            work[TRIAL + i] = work[NOW + i] + h * (3.0 / 40.0 * work[K1 + i] + 9.0 / 40.0 * work[K2 + i])
        rates_of(mode, t + 0.3 * h, work, TRIAL, K3)
        for i in range(moving):
            work[TRIAL + i] = work[NOW + i] + h * (
                44.0 / 45.0 * work[K1 + i] - 56.0 / 15.0 * work[K2 + i] + 32.0 / 9.0 * work[K3 + i]
            )
        rates_of(mode, t + 0.8 * h, work, TRIAL, K4)
        for i in range(moving):
            work[TRIAL + i] = work[NOW + i] + h * (
                19372.0 / 6561.0 * work[K1 + i]
                - 25360.0 / 2187.0 * work[K2 + i]
                + 64448.0 / 6561.0 * work[K3 + i]
                - 212.0 / 729.0 * work[K4 + i]
            )
        rates_of(mode, t + h * (8.0 / 9.0), work, TRIAL, K5)
        for i in range(moving):
            work[TRIAL + i] = work[NOW + i] + h * (
                9017.0 / 3168.0 * work[K1 + i]
                - 355.0 / 33.0 * work[K2 + i]
                + 46732.0 / 5247.0 * work[K3 + i]
                + 49.0 / 176.0 * work[K4 + i]
                - 5103.0 / 18656.0 * work[K5 + i]
            )
        rates_of(mode, t + h, work, TRIAL, K6)
        for i in range(size):
            work[TRIAL + i] = work[NOW + i] + h * (
                35.0 / 384.0 * work[K1 + i]
                + 500.0 / 1113.0 * work[K3 + i]
                + 125.0 / 192.0 * work[K4 + i]
                - 2187.0 / 6784.0 * work[K5 + i]
                + 11.0 / 84.0 * work[K6 + i]
            )
        rates_of(mode, t + h, work, TRIAL, K7)
        for i in range(size):
            work[ERROR + i] = h * (
                71.0 / 57600.0 * work[K1 + i]
                - 71.0 / 16695.0 * work[K3 + i]
                + 71.0 / 1920.0 * work[K4 + i]
                - 17253.0 / 339200.0 * work[K5 + i]
                + 22.0 / 525.0 * work[K6 + i]
                - 1.0 / 40.0 * work[K7 + i]
            )

    return step
