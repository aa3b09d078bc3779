"""The energy book: mechanical energy of body and foot, and what the integrals say it should be (physics of the notes
in `docs/decisions.md`). The leg's spring is virtual: its work is the motors'."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from simulator.basics import GRAVITY_M_S2
from simulator.compiled import inner
from simulator.effects.effect import Function
from simulator.kernel.composition import Composition, made_once
from simulator.kernel.layout import (
    BOOK,
    INTRUDING,
    LEG_WORK,
    NOW,
    SLIDES,
    V_BODY,
    V_FOOT,
    X_BODY,
    X_FOOT,
)

Row = NDArray[np.float64]


@made_once
def make_energy(composition: Composition) -> Function:
    """Kinetic and potential energy, J: `(mode, work)`; grains and a platform with mass count while they
    move."""
    body, foot = composition.position["body_mass"], composition.position["foot_mass"]
    has_mass, mass = composition.has("added_mass_kg"), composition.slot("added_mass_kg")
    slides, platform, platform_kg = (
        composition.platform >= 0,
        composition.platform,
        composition.slot("platform_mass_kg"),
    )

    @inner
    def energy(mode: int, work: Row) -> float:
        moved_kg, sliding_j = work[foot], 0.0
        if slides and work[SLIDES] == 1:
            sliding_j = 0.5 * platform_kg(work) * work[NOW + platform + 1] * work[NOW + platform + 1]
        elif slides and mode == INTRUDING:
            moved_kg += platform_kg(work)
        if has_mass and mode == INTRUDING:
            moved_kg += mass(work, -work[NOW + X_FOOT])
        return (
            work[body] * (0.5 * work[NOW + V_BODY] * work[NOW + V_BODY] + GRAVITY_M_S2 * work[NOW + X_BODY])
            + 0.5 * moved_kg * work[NOW + V_FOOT] * work[NOW + V_FOOT]
            + work[foot] * GRAVITY_M_S2 * work[NOW + X_FOOT]
            + sliding_j
        )

    return energy


def make_booked(composition: Composition) -> Function:
    """Energy gained since touchdown according to the integrals, J: `(work)`."""
    places = composition.integrals
    loss, grain = places.get("ground_loss", -1), places.get("grain_energy", -1)
    friction, reset = places.get("friction_loss", -1), places.get("reset_work", -1)

    @inner
    def booked(work: Row) -> float:
        gained = work[NOW + LEG_WORK] - work[BOOK]
        if loss >= 0:
            gained -= work[NOW + loss]
        if grain >= 0:
            gained += work[NOW + grain]
        if friction >= 0:
            gained -= work[NOW + friction]
        if reset >= 0:
            gained += work[NOW + reset]
        return gained

    return booked
