"""The ground emulator's state machine (thesis 4.2.3): hold, release, reset, engage, by its own timer and the leg.

It has no contact sensor. The platform yields in *hold* only; in *reset* it is led back up and carries what stands on
it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from simulator.compiled import inner
from simulator.effects.effect import Function
from simulator.kernel.composition import Composition, made_once
from simulator.kernel.layout import (
    CARRIED,
    DEEPEST,
    EMULATOR,
    EMULATOR_SINCE,
    ENGAGE,
    EXTENSION,
    HOLD,
    HOLD_SINCE,
    JAMMED,
    MODE,
    NOW,
    PHASE,
    RELEASE,
    RELEASED,
    RESET,
    RESET_FROM,
    TIME,
    V_FOOT,
    X_FOOT,
)

Row = NDArray[np.float64]


@made_once
def make_timer(composition: Composition) -> Function:
    """When the emulator's state ends by itself, or may release at first, s since touchdown: `(work)`."""
    if not composition.has("travel_m"):
        return inner(lambda work: np.inf)
    at = composition.position
    release, reset, engage = at["release_time"], at["reset_time"], at["engage_time"]
    shortest = at["shortest_hold"]

    @inner
    def timer(work: Row) -> float:
        state = work[EMULATOR]
        if state == HOLD:
            ready_s = work[HOLD_SINCE] + work[shortest]
            waits = work[PHASE] == EXTENSION and work[RELEASED] == 0 and work[TIME] < ready_s
            return ready_s if waits else np.inf
        if state == RELEASE:
            return work[EMULATOR_SINCE] + work[release]
        if state == RESET:
            return work[EMULATOR_SINCE] + work[reset]
        return work[EMULATOR_SINCE] + work[engage]

    return timer


def make_advance(composition: Composition) -> Function:
    """Go to the emulator's next state at t: `(work)`."""
    if not composition.has("travel_m"):
        return inner(lambda work: None)

    @inner
    def advance(work: Row) -> None:
        if work[EMULATOR] == HOLD:
            return
        work[EMULATOR_SINCE] = work[TIME]
        if work[EMULATOR] == RELEASE:
            work[EMULATOR] = RESET
            work[RESET_FROM] = work[DEEPEST]
            if work[MODE] == JAMMED and work[DEEPEST] < 0.0:
                work[MODE] = CARRIED
        elif work[EMULATOR] == RESET:
            work[EMULATOR] = ENGAGE
            work[RESET_FROM], work[DEEPEST] = 0.0, 0.0
            if work[MODE] == CARRIED:
                work[MODE] = JAMMED
                work[NOW + X_FOOT], work[NOW + V_FOOT] = 0.0, 0.0
        elif work[EMULATOR] == ENGAGE:
            work[EMULATOR], work[RELEASED] = HOLD, 0
            work[HOLD_SINCE] = work[TIME]

    return advance
