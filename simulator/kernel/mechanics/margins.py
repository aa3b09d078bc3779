"""Forces of the leg, and the margins by which they lift a resting foot or make the ground yield."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from simulator.basics import GRAVITY_M_S2
from simulator.compiled import inner
from simulator.effects.effect import Function
from simulator.kernel.composition import Composition, made_once
from simulator.kernel.layout import EMULATOR, HOLD, V_BODY, V_FOOT, X_BODY, X_FOOT
from simulator.kernel.mechanics.leg import make_apply, make_command, make_lever

Row = NDArray[np.float64]
AT_REST = 1e-12
"""Share of the forces on a foot that counts as rounding: less neither lifts it nor makes the ground yield."""


@made_once
def make_forces(composition: Composition) -> Function:
    """Commanded and applied force of the leg, and its cap, N: `(work, row)`."""
    lever, command, apply = make_lever(composition), make_command(composition), make_apply(composition)
    capped, cap_n = composition.has("cap_n"), composition.slot("cap_n")

    @inner
    def forces(work: Row, row: int) -> tuple[float, float, float]:
        length_m = work[row + X_BODY] - work[row + X_FOOT]
        arm_m = lever(work, length_m)
        commanded_n = command(work, length_m, work[row + V_BODY] - work[row + V_FOOT], work[row + V_FOOT])
        most_n = cap_n(work, arm_m) if capped else np.inf
        return commanded_n, apply(work, arm_m, commanded_n), most_n

    return forces


@made_once
def make_foot_margins(composition: Composition) -> Function:
    """What lifts a resting foot and what makes the ground yield, N: `(work, row, applied_n)`.

    Both are positive only beyond rounding. Rigid ground, a ratchet outside *hold* and a platform at its stop do not
    yield.
    """
    foot = composition.position["foot_mass"]
    resistance_n = composition.slot("resistance_n")
    yields = composition.has("resistance_n")
    has_mass, mass = composition.has("added_mass_kg"), composition.slot("added_mass_kg")
    emulated, travel_m = composition.has("travel_m"), composition.slot("travel_m")

    @inner
    def margins(work: Row, row: int, applied_n: float) -> tuple[float, float]:
        weight_n = work[foot] * GRAVITY_M_S2
        lifting_n = applied_n - weight_n - AT_REST * (abs(applied_n) + weight_n)
        if not yields:
            return lifting_n, -1.0
        depth_m = -work[row + X_FOOT]
        if emulated and (work[EMULATOR] != HOLD or depth_m >= travel_m(work)):
            return lifting_n, -1.0
        if has_mass:
            weight_n += mass(work, depth_m) * GRAVITY_M_S2
        hold_n = resistance_n(work, depth_m)
        yielding_n = weight_n - applied_n - hold_n - AT_REST * (abs(applied_n) + weight_n + hold_n)
        return lifting_n, yielding_n

    return margins
