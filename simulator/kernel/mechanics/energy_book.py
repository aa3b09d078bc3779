"""The energy book: mechanical energy of body and foot, and what the integrals say it should be (physics of the notes
in `docs/decisions.md`). The leg's spring is virtual: its work is the motors'."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from simulator.basics import GRAVITY_M_S2
from simulator.compiled import inner
from simulator.effects.effect import Function
from simulator.effects.registry import BOOKED
from simulator.kernel.composition import Composition, made_once
from simulator.kernel.layout import (
    IMPACT,
    INTRUDING,
    LEG_WORK,
    NOW,
    SLIDES,
    V_BODY,
    V_FOOT,
    X_BODY,
    X_FOOT,
)
from simulator.kernel.rows import COLUMN

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
    """Energy gained since touchdown according to what events and integrals say, J: `(work)`."""
    booked = inner(lambda work: work[NOW + LEG_WORK] - work[IMPACT])
    for energy in BOOKED:
        if energy.name in composition.integrals:
            booked = _with_entry(booked, composition.integrals[energy.name], float(energy.sign))
    return booked


def _with_entry(before: Function, integral: int, sign: float) -> Function:
    return inner(lambda work: before(work) + sign * work[NOW + integral])


def make_note_energies(composition: Composition) -> Function:
    """Write the energies of the book, 0 for those of effects that are off: `(work, row)`.

    Returns the sum of their sizes and of that of the leg's work, J.
    """
    note = inner(lambda work, row: abs(work[NOW + LEG_WORK]))
    for energy in BOOKED:
        if energy.sudden:
            place = int(IMPACT)
        elif energy.name in composition.integrals:
            place = int(NOW) + composition.integrals[energy.name]
        else:
            place = -1
        note = _with_column(note, COLUMN[energy.column], place)
    return note


def _with_column(before: Function, column: int, place: int) -> Function:
    @inner
    def note(work: Row, row: Row) -> float:
        turned_over_j = before(work, row)
        row[column] = work[place] if place >= 0 else 0.0
        return turned_over_j + abs(row[column])

    return note
