"""What several events come to: a foot stopped at once, a body that is held, two phases that hold it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from simulator.compiled import inner
from simulator.effects.effect import Function
from simulator.kernel.composition import Composition, made_once
from simulator.kernel.layout import (
    ALLOWED,
    DEEPEST,
    EXTENSION,
    IMPACT,
    JAMMED,
    MODE,
    NOW,
    PHASE,
    V_BODY,
    V_FOOT,
    X_FOOT,
)
from simulator.kernel.mechanics.body import make_drive
from simulator.kernel.mechanics.margins import make_forces
from simulator.kernel.mechanics.moved_mass import make_moved_mass

Row = NDArray[np.float64]
GOES_ON = -1


@made_once
def make_stop_foot(composition: Composition) -> Function:
    """Stop the foot at once: `(work)`; what it moved with is lost and booked."""
    moved_mass_kg = make_moved_mass(composition)

    @inner
    def stop_foot(work: Row) -> None:
        lost_j = 0.5 * moved_mass_kg(work, -work[NOW + X_FOOT]) * work[NOW + V_FOOT] * work[NOW + V_FOOT]
        work[IMPACT] += lost_j
        work[NOW + V_FOOT] = 0.0
        work[DEEPEST] = min(work[DEEPEST], work[NOW + X_FOOT])
        work[MODE] = JAMMED

    return stop_foot


def make_turn_hold(composition: Composition) -> Function:
    """The body has stopped where an effect may hold it, or is pushed on: `(work)`."""
    if not composition.has("body_held"):
        return inner(lambda work: None)
    forces, drive_n, body_stops = make_forces(composition), make_drive(composition), composition.slots["body_stops"]

    @inner
    def turn_hold(work: Row) -> None:
        work[NOW + V_BODY] = 0.0
        body_stops(work, drive_n(work[MODE], work, NOW, forces(work, NOW)[1]))

    return turn_hold


def make_held_still(composition: Composition) -> Function:
    """Whether the two phases hold the body where it is, each driving it back over the threshold of the other: `(work)`,
    after a switch. Without a clock the controller then switches without end, and the foot never leaves the ground.
    """
    if composition.on("sampled_control") or composition.on("latched_switching"):
        return inner(lambda work: False)
    forces, drive = make_forces(composition), make_drive(composition)

    @inner
    def held_still(work: Row) -> bool:
        if work[MODE] != JAMMED or abs(work[NOW + V_BODY]) > work[ALLOWED]:
            return False
        drive_n = drive(work[MODE], work, NOW, forces(work, NOW)[1])
        return drive_n < 0.0 if work[PHASE] == EXTENSION else drive_n > 0.0

    return held_still
