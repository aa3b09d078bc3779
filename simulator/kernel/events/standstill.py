"""What several events come to: a foot stopped at once, a body that turns on its rail, two phases that hold it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from simulator.basics import GRAVITY_M_S2
from simulator.compiled import inner
from simulator.effects.effect import Function
from simulator.kernel.composition import Composition, made_once
from simulator.kernel.layout import (
    ALLOWED,
    BOOK,
    DEEPEST,
    EXTENSION,
    IMPACT,
    JAMMED,
    MODE,
    NOW,
    PHASE,
    RAIL,
    V_BODY,
    V_FOOT,
    X_FOOT,
)
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
        work[BOOK] += lost_j
        work[IMPACT] += lost_j
        work[NOW + V_FOOT] = 0.0
        work[DEEPEST] = min(work[DEEPEST], work[NOW + X_FOOT])
        work[MODE] = JAMMED

    return stop_foot


def make_rail_turns(composition: Composition) -> Function:
    """The body has stopped on its rail, or is pushed off it: `(work)`."""
    if not composition.has("rail_friction_n"):
        return inner(lambda work: None)
    forces, friction_n = make_forces(composition), composition.slots["rail_friction_n"]
    body = composition.position["body_mass"]

    @inner
    def rail_turns(work: Row) -> None:
        work[NOW + V_BODY] = 0.0
        drive_n = -forces(work, NOW)[1] - work[body] * GRAVITY_M_S2
        if abs(drive_n) <= friction_n(work):
            work[RAIL] = 0.0
        else:
            work[RAIL] = 1.0 if drive_n > 0.0 else -1.0

    return rail_turns


def make_held_still(composition: Composition) -> Function:
    """Whether the two phases hold the body where it is, each driving it back over the threshold of the other: `(work)`,
    after a switch. Without a clock the controller then switches without end, and the foot never leaves the ground.
    """
    if composition.on("sampled_control") or composition.on("latched_switching"):
        return inner(lambda work: False)
    forces, body = make_forces(composition), composition.position["body_mass"]

    @inner
    def held_still(work: Row) -> bool:
        if work[MODE] != JAMMED or abs(work[NOW + V_BODY]) > work[ALLOWED]:
            return False
        drive_n = -forces(work, NOW)[1] - work[body] * GRAVITY_M_S2
        return drive_n < 0.0 if work[PHASE] == EXTENSION else drive_n > 0.0

    return held_still
