"""The body's acceleration under the leg's force, its weight and the friction of its rail."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from simulator.basics import GRAVITY_M_S2
from simulator.compiled import inner
from simulator.effects.effect import Function
from simulator.kernel.composition import Composition, made_once
from simulator.kernel.layout import RAIL

Row = NDArray[np.float64]


@made_once
def make_body_acceleration(composition: Composition) -> Function:
    """Compose `(work, applied_n)`: the acceleration upward, m/s²; 0 while the rail holds the body."""
    per_body = composition.position["inverse_body_mass"]
    has_friction, friction_n = composition.has("rail_friction_n"), composition.slot("rail_friction_n")

    @inner
    def acceleration_m_s2(work: Row, applied_n: float) -> float:
        a_b = -applied_n * work[per_body] - GRAVITY_M_S2
        if has_friction:
            sign = work[RAIL]
            a_b = 0.0 if sign == 0.0 else a_b - sign * friction_n(work) * work[per_body]
        return a_b

    return acceleration_m_s2
