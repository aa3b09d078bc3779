"""Meeting the ground: an impact where it does not yield, intrusion where it does."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from simulator.compiled import inner
from simulator.effects.effect import Function
from simulator.kernel.composition import Composition
from simulator.kernel.control.decisions import make_hold
from simulator.kernel.events.foot_events import note_near
from simulator.kernel.layout import (
    BOTTOMED,
    CARRIED,
    DEEPEST,
    EMULATOR,
    EMULATOR_SINCE,
    ENGAGE,
    HOLD,
    IMPACT,
    INTRUDING,
    JAMMED,
    LENGTH_UNIT,
    MODE,
    NOW,
    OFFSET,
    RESET,
    SLIDES,
    TIME,
    TOUCHED_BEFORE_HOLD,
    TOUCHED_DURING_RESET,
    V_FOOT,
    X_FOOT,
)
from simulator.kernel.mechanics.platform import make_platform

Row = NDArray[np.float64]


def make_meet_ground(composition: Composition) -> Function:
    """Put the foot on the ground at t: `(work)`; the energy lost in an impact is booked."""
    platform = make_platform(composition)
    foot = composition.position["foot_mass"]
    emulated = composition.has("travel_m")
    yields, travel = composition.has("resistance_n"), composition.position.get("platform_travel", -1)
    has_mass, mass = composition.has("added_mass_kg"), composition.slot("added_mass_kg")
    grain, reset = composition.integrals.get("grain_energy", -1), composition.integrals.get("reset_work", -1)

    holds_force, hold = composition.on("held_force"), make_hold(composition)
    engage = composition.position.get("engage_time", -1)
    slides, place, platform_kg = composition.platform >= 0, composition.platform, composition.slot("platform_mass_kg")

    @inner
    def share_speed(work: Row) -> None:
        own_kg, other_kg, other_m_s = work[foot], platform_kg(work), 0.0
        if work[SLIDES] == 1:
            other_m_s, work[DEEPEST], work[SLIDES] = work[NOW + place + 1], work[NOW + place], 0
        own_m_s = work[NOW + V_FOOT]
        lost_j = 0.5 * own_kg * other_kg / (own_kg + other_kg) * (own_m_s - other_m_s) ** 2
        work[NOW + V_FOOT] = (own_kg * own_m_s + other_kg * other_m_s) / (own_kg + other_kg)
        work[IMPACT] += lost_j

    @inner
    def note_hold(work: Row) -> None:
        """Note how near touchdown is to the instant from which the platform yields, but for the scene's start."""
        since_s = work[TIME] - work[EMULATOR_SINCE]
        if work[EMULATOR] == ENGAGE:
            since_s -= work[engage]
        if work[EMULATOR] == ENGAGE or (work[EMULATOR] == HOLD and work[EMULATOR_SINCE] + work[OFFSET] > 0.0):
            note_near(since_s * work[NOW + V_FOOT], work[LENGTH_UNIT], work)

    @inner
    def meet_ground(work: Row) -> None:
        if emulated:
            note_hold(work)
        gives = yields and (not emulated or (work[EMULATOR] == HOLD and work[DEEPEST] > -work[travel]))
        if slides and gives:
            share_speed(work)
        height_m, velocity_m_s, _ = platform(work, work[TIME])
        if gives and work[NOW + V_FOOT] < 0.0:
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
            elif work[EMULATOR] == HOLD and work[DEEPEST] <= -work[travel]:
                work[BOTTOMED] += 1
        own_m_s, ground_m_s = work[NOW + V_FOOT], velocity_m_s if work[MODE] == CARRIED else 0.0
        lost_j = 0.5 * work[foot] * (own_m_s - ground_m_s) * (own_m_s - ground_m_s)
        work[NOW + V_FOOT] = ground_m_s
        work[IMPACT] += lost_j
        if holds_force:
            hold(work)
        if emulated:  # what the platform's drive gives to bring the foot to its own speed
            work[NOW + reset] += work[foot] * ground_m_s * (ground_m_s - own_m_s)

    return meet_ground
