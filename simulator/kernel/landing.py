"""Meeting the ground: an impact where it does not yield, intrusion where it does."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from simulator.compiled import inner
from simulator.effects.effect import Function
from simulator.kernel.composition import Composition
from simulator.kernel.layout import (
    BOOK,
    CARRIED,
    EMULATOR,
    ENGAGE,
    HOLD,
    IMPACT,
    INTRUDING,
    JAMMED,
    MODE,
    NOW,
    RESET,
    TIME,
    TOUCHED_BEFORE_HOLD,
    TOUCHED_DURING_RESET,
    V_FOOT,
    X_FOOT,
)
from simulator.kernel.platform import make_platform

Row = NDArray[np.float64]
Flags = NDArray[np.int64]


def make_meet_ground(composition: Composition) -> Function:
    """Put the foot on the ground at t: `(work)`; the energy lost in an impact is booked."""
    platform = make_platform(composition)
    foot = composition.position["foot_mass"]
    emulated = composition.has("travel_m")
    yields = composition.has("resistance_n")
    has_mass, mass = composition.has("added_mass_kg"), composition.slot("added_mass_kg")
    grain = composition.integrals.get("grain_energy", -1)

    @inner
    def meet_ground(work: Row) -> None:
        height_m, velocity_m_s, _ = platform(work, work[TIME])
        if yields and (not emulated or work[EMULATOR] == HOLD) and work[NOW + V_FOOT] < 0.0:
            work[MODE] = INTRUDING
            work[NOW + X_FOOT] = height_m  # where it was found to be, but for what the landing is allowed
            if has_mass:  # the grains under an old print move with the foot at once
                work[NOW + grain] += 0.5 * mass(work, -work[NOW + X_FOOT]) * work[NOW + V_FOOT] * work[NOW + V_FOOT]
            return
        work[MODE] = JAMMED
        if not yields or emulated:
            work[NOW + X_FOOT] = height_m
        if emulated:
            if work[EMULATOR] == RESET:
                work[MODE] = CARRIED
                work[TOUCHED_DURING_RESET] += 1
            elif work[EMULATOR] == ENGAGE:
                work[TOUCHED_BEFORE_HOLD] += 1
        before_j = 0.5 * work[foot] * work[NOW + V_FOOT] * work[NOW + V_FOOT]
        work[NOW + V_FOOT] = velocity_m_s if work[MODE] == CARRIED else 0.0
        lost_j = before_j - 0.5 * work[foot] * work[NOW + V_FOOT] * work[NOW + V_FOOT]
        work[BOOK] += lost_j
        work[IMPACT] += lost_j

    return meet_ground
