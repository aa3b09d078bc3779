"""Control: decisions at ticks of the clock, or at the instant itself where control is continuous."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from simulator.compiled import inner
from simulator.effects.effect import Function
from simulator.kernel.composition import Composition, made_once
from simulator.kernel.layout import (
    ACTIVE_DAMPING,
    ASLEEP,
    COMPRESSION,
    CREEPING,
    DAMPING,
    DECIDED,
    EMULATOR,
    EXTENSION,
    FLIGHT,
    GROWTH,
    GUARD_SWITCHES,
    HELD_FORCE,
    HOLD,
    INTRUDING,
    LENGTH_UNIT,
    MARGIN,
    MARGIN_TICK,
    MODE,
    NOW,
    PHASE,
    RELEASE_MISSED,
    RELEASED,
    SAMPLED_SPEED,
    SPEED_UNIT,
    STIFFNESS,
    TICK,
    V_BODY,
    V_FOOT,
    WORST_GROWTH,
    X_BODY,
    X_FOOT,
)
from simulator.kernel.mechanics.leg import make_set_gains
from simulator.kernel.mechanics.moved_mass import make_moved_mass

Row = NDArray[np.float64]
LARGEST_GROWTH = 700.0
"""Largest growth of an error that is counted, as a logarithm: a number can hold no more."""


def make_switch(composition: Composition) -> Function:
    """Change the phase and its gains: `(work)`."""
    set_gains = make_set_gains(composition)
    guarded, guard_m = composition.has("guard_length_m"), composition.slot("guard_length_m")
    emulated = composition.has("travel_m")

    @inner
    def switch(work: Row) -> None:
        if guarded and work[PHASE] == COMPRESSION and work[NOW + X_BODY] - work[NOW + X_FOOT] < guard_m(work):
            work[GUARD_SWITCHES] += 1
        work[PHASE] = EXTENSION if work[PHASE] == COMPRESSION else COMPRESSION
        if emulated and work[EMULATOR] == HOLD and work[PHASE] == COMPRESSION and work[RELEASED] == 0:
            work[RELEASE_MISSED] += 1
        set_gains(work, work[PHASE] == EXTENSION, work[NOW + V_FOOT])

    return switch


@made_once
def make_hold(composition: Composition) -> Function:
    """Hold the force that is commanded now until the next tick: `(work)`."""
    rest, linear = composition.position["rest_length"], composition.on("linear_active_damping")

    @inner
    def hold(work: Row) -> None:
        speed_m_s = work[NOW + V_BODY] - work[NOW + V_FOOT]
        force_n = work[STIFFNESS] * (work[NOW + X_BODY] - work[NOW + X_FOOT] - work[rest]) + work[DAMPING] * speed_m_s
        force_n += work[ACTIVE_DAMPING] * work[SAMPLED_SPEED] * (1.0 if linear else speed_m_s)
        work[HELD_FORCE] = force_n

    return hold


def make_tick(composition: Composition, wants_switch: Function, switch: Function) -> Function:
    """Decide at the tick that is due: `(work, flip)`.

    Returns whether a gain (or a held force) has changed. `flip` turns the decision round. A step that was cut here
    because of a decision has it carried out: so near a threshold the state at its end may say otherwise.
    """
    set_gains = make_set_gains(composition)
    active = composition.has("active_damping_kg_m") and not composition.on("continuous_foot_speed")
    holds_force = composition.on("held_force")
    grow, hold = make_growth(composition), make_hold(composition)

    @inner
    def tick(work: Row, flip: bool) -> bool:
        grow(work)
        wish = wants_switch(work, work[PHASE], NOW, work[LENGTH_UNIT], work[SPEED_UNIT])
        if abs(wish) < work[MARGIN] and work[TICK] > 0:  # the state at touchdown carries no error of this jump
            work[MARGIN], work[MARGIN_TICK] = abs(wish), work[TICK]
        changed = work[TICK] + 1.0 == work[DECIDED] or (wish > 0.0) != flip
        if changed:
            switch(work)
        elif active and work[ACTIVE_DAMPING] > 0.0:  # a sample that no gain multiplies changes nothing
            set_gains(work, work[PHASE] == EXTENSION, work[NOW + V_FOOT])
            changed = True
        if holds_force:
            hold(work)
            changed = True
        work[TICK] += 1
        return changed

    return tick


def make_growth(composition: Composition) -> Function:
    """Follow how much a small error of the foot's speed has grown, as a logarithm: `(work)`, once a tick.

    A foot damped by its sampled speed carries an error from tick to tick with the factor
    exp(-c T / m) - (g / c) (1 - exp(-c T / m)): T the period, m the moving mass, c the damping that acts at once, g
    that by the sample. Beyond -1 the leg chatters: errors grow each tick, and a goal is met only by steps that are
    as much finer.
    """
    active = composition.has("active_damping_kg_m") and composition.on("sampled_control")
    if not active or composition.on("continuous_foot_speed") or not composition.has("quadratic_drag_kg_m"):
        return inner(lambda work: None)
    growth_factor = make_growth_factor(composition)

    @inner
    def grow(work: Row) -> None:
        if work[ACTIVE_DAMPING] == 0.0 or work[MODE] != INTRUDING:
            return
        work[GROWTH] = max(0.0, work[GROWTH] + math.log(max(growth_factor(work), 1e-3)))
        work[WORST_GROWTH] = max(work[WORST_GROWTH], min(work[GROWTH], LARGEST_GROWTH))

    return grow


def make_growth_factor(composition: Composition) -> Function:
    """Compose `(work)`: the size of that factor for an intruding foot."""
    moved_mass_kg, rate = make_moved_mass(composition), composition.position["control_rate"]
    quadratic, linear = composition.slots["quadratic_drag_kg_m"], composition.on("linear_active_damping")
    has_linear, drag_kg_s = composition.has("linear_drag_kg_s"), composition.slot("linear_drag_kg_s")

    @inner
    def growth_factor(work: Row) -> float:
        depth_m, sinking = -work[NOW + X_FOOT], -work[NOW + V_FOOT]
        sampled_kg_s = work[ACTIVE_DAMPING]
        at_once_kg_s = 2.0 * quadratic(work, depth_m) * sinking + work[DAMPING] + 1e-9
        if has_linear:
            at_once_kg_s = at_once_kg_s + drag_kg_s(work)
        if not linear:
            sampled_kg_s = sampled_kg_s * (work[NOW + V_BODY] + sinking)
            at_once_kg_s = at_once_kg_s + work[ACTIVE_DAMPING] * sinking
        decay = math.exp(-at_once_kg_s / (work[rate] * moved_mass_kg(work, depth_m)))
        return abs(decay - sampled_kg_s / at_once_kg_s * (1.0 - decay))

    return growth_factor


def make_must_land(composition: Composition) -> Function:
    """Whether the next tick changes something for sure, so that a step must end on it: `(work)`."""
    sampled, sleeps = composition.on("sampled_control"), composition.sleeps_in_flight
    active = composition.has("active_damping_kg_m") and not composition.on("continuous_foot_speed")
    holds_force = composition.on("held_force")

    @inner
    def must_land(work: Row) -> bool:
        if not sampled or (sleeps and (work[MODE] == FLIGHT or work[ASLEEP] == 1)):
            return False
        if holds_force and work[MODE] != FLIGHT:
            return True
        if active:
            moving = work[MODE] == INTRUDING or work[MODE] == CREEPING or work[MODE] == FLIGHT
            return work[ACTIVE_DAMPING] > 0.0 and (moving or work[SAMPLED_SPEED] > 0.0)
        return False

    return must_land
