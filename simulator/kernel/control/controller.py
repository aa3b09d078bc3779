"""The leg's controller: when it changes its phase (thesis 4.2.5, 5.1.1, and the published rule of ch. 3).

A clock asks the whole rule at its ticks. Without one each condition of the rule is an event of its own, so that no
moment in which all of them hold is passed over.
"""

from __future__ import annotations

import math

import numpy as np

from simulator.compiled import Function, Row, inner
from simulator.kernel.combined import nothing
from simulator.kernel.composition import Composition, made_once
from simulator.kernel.layout import (
    ACTIVE_DAMPING,
    ASLEEP,
    CARRIED,
    COMPRESSION,
    CONDITIONS,
    CREEPING,
    DAMPING,
    DECIDED,
    DEEPEST,
    EMULATOR,
    EMULATOR_SINCE,
    ENGAGE,
    EXTENSION,
    FLIGHT,
    GROWTH,
    GUARD_SWITCHES,
    HELD_FORCE,
    HOLD,
    HOLD_SINCE,
    HOLDS,
    INTRUDING,
    JAMMED,
    LENGTH_UNIT,
    MARGIN,
    MARGIN_TICK,
    MODE,
    NOW,
    PHASE,
    RELEASE,
    RELEASE_MISSED,
    RELEASED,
    RESET,
    RESET_FROM,
    SAMPLED_SPEED,
    SPEED_UNIT,
    STIFFNESS,
    TICK,
    TIME,
    V_BODY,
    V_FOOT,
    WORST_GROWTH,
    X_BODY,
    X_FOOT,
)
from simulator.kernel.limits import NEAR_PEAK
from simulator.kernel.mechanics.leg import make_set_gains
from simulator.kernel.mechanics.motion import make_moved_mass
from simulator.kernel.working_row import choose, lanes_in


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
        return nothing

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


SHORT = CONDITIONS - 1
"""Number of the condition that holds by itself: the leg is short."""


@made_once
def make_conditions(composition: Composition) -> Function:
    """Compose `(work, phase, row)`: what the rule asks for in a phase, each positive where it holds.

    Three conditions that must hold together, in m and m/s, and last that the leg is short, or 1 and -1 for none.
    """
    guarded, guard_m = composition.optional("guard_length_m")
    rest, latched = composition.position["rest_length"], composition.on("latched_switching")
    compression_m, tolerance_m = composition.slot("switch_compression_m"), composition.slot("rest_tolerance_m")
    tolerance_m_s = composition.slot("switch_speed_tolerance_m_s")

    @inner
    def conditions(work: Row, phase: int, row: int) -> tuple[float, float, float, float]:
        length_m = work[row + X_BODY] - work[row + X_FOOT]
        if latched and phase != COMPRESSION:
            return length_m - work[rest] + tolerance_m(work), 1.0, 1.0, -1.0
        short_m = guard_m(work) - length_m if guarded else -1.0
        lengthening_m_s = work[row + V_BODY] - work[row + V_FOOT]
        if latched:
            return work[rest] - compression_m(work) - length_m, lengthening_m_s + tolerance_m_s(work), 1.0, short_m
        return lengthening_m_s, work[row + V_BODY], -work[row + X_FOOT], short_m

    return conditions


def make_wants_switch(composition: Composition) -> Function:
    """Compose `(work, phase, row, length_unit_m, speed_unit_m_s)`, positive where the phase should change.

    Its value is the distance to the decision in units of the given errors: its sign decides, its size is the margin.
    """
    conditions, guarded = make_conditions(composition), composition.has("guard_length_m")
    if composition.on("latched_switching"):

        @inner
        def latched(work: Row, phase: int, row: int, length_unit_m: float, speed_unit_m_s: float) -> float:
            first_m, still_m_s, _, short_m = conditions(work, phase, row)
            if phase != COMPRESSION:
                return first_m / length_unit_m
            wish = min(first_m / length_unit_m, still_m_s / speed_unit_m_s)
            return max(wish, short_m / length_unit_m) if guarded else wish

        return latched

    @inner
    def unlatched(work: Row, phase: int, row: int, length_unit_m: float, speed_unit_m_s: float) -> float:
        lengthening_m_s, rising_m_s, depth_m, short_m = conditions(work, phase, row)
        # a foot in the ground is known to be there: its depth is known to a share of itself
        below = choose(depth_m > 0.0, np.inf, depth_m / length_unit_m)
        wish = min(lengthening_m_s / speed_unit_m_s, rising_m_s / speed_unit_m_s, below)
        if guarded:
            wish = max(wish, short_m / length_unit_m)
        return choose(phase == COMPRESSION, wish, -wish)

    return unlatched


@made_once
def make_rule(composition: Composition) -> Function:
    """Compose `(work)`: whether the phase should change, by which conditions are noted to hold."""
    latched = composition.on("latched_switching")

    @inner
    def rule(work: Row) -> bool:
        every = work[HOLDS] == 1.0 and work[HOLDS + 1] == 1.0 and work[HOLDS + 2] == 1.0
        extends = every or work[HOLDS + SHORT] == 1.0
        return extends if latched or work[PHASE] == COMPRESSION else not extends

    return rule


def make_note_conditions(conditions: Function) -> Function:
    """Compose `(work, turned)`: note which conditions hold; number `turned` (-1: none) has just changed."""

    @inner
    def note_conditions(work: Row, turned: int) -> None:
        values = conditions(work, work[PHASE], NOW)
        for one in range(CONDITIONS):
            held = work[HOLDS + one]
            work[HOLDS + one] = 1.0 - held if one == turned else 1.0 if values[one] > 0.0 else 0.0

    return note_conditions


LARGEST_GROWTH = 700.0
"""Largest growth of an error that is counted, as a logarithm: a number can hold no more."""


def make_switch(composition: Composition) -> Function:
    """Change the phase and its gains: `(work)`."""
    set_gains = make_set_gains(composition)
    guarded, guard_m = composition.optional("guard_length_m")
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
        grow(((work[ACTIVE_DAMPING] != 0.0) | holds_force) & (work[MODE] == INTRUDING), work)
        wish = wants_switch(work, work[PHASE], NOW, work[LENGTH_UNIT], work[SPEED_UNIT])
        if abs(wish) < min(work[MARGIN], NEAR_PEAK) and work[TICK] > 0:  # at touchdown the state has no error yet
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
    """Follow how much a small error of an intruding foot's speed has grown, as a logarithm: `(which, work)`, at a tick.

    A foot damped by its sampled speed carries an error from tick to tick with the factor
    exp(-c T / m) - (g / c) (1 - exp(-c T / m)): T the period, m the moving mass, c the damping that acts at once, g
    that by the sample, which is all of the leg's where its force is held. Beyond -1 the leg chatters: errors grow each
    tick, and a goal is met only by steps that are as much finer. In lanes `which` says whose foot is damped.
    """
    samples = composition.has("active_damping_kg_m") and composition.samples_speed
    if not composition.on("sampled_control") or not (samples or composition.on("held_force")):
        return nothing
    growth_factor = make_growth_factor(composition)

    @inner
    def grow(which: bool, work: Row) -> None:
        if lanes_in(which) == 0:
            return
        factor = growth_factor(work)
        if lanes_in(which & ((factor > 1.0) | (work[GROWTH] > 0.0))) == 0:  # nothing has grown, and nothing does
            return
        grown = max(0.0, work[GROWTH] + math.log(max(factor, 1e-3)))
        work[GROWTH] = choose(which, grown, work[GROWTH])
        work[WORST_GROWTH] = choose(which, max(work[WORST_GROWTH], min(grown, LARGEST_GROWTH)), work[WORST_GROWTH])

    return grow


def make_growth_factor(composition: Composition) -> Function:
    """Compose `(work)`: the size of that factor for an intruding foot."""
    moved_mass_kg, rate = make_moved_mass(composition), composition.position["control_rate"]
    linear, held = composition.on("linear_active_damping"), composition.on("held_force")
    has_quadratic, quadratic = composition.optional("quadratic_drag_kg_m")
    has_linear, drag_kg_s = composition.optional("linear_drag_kg_s")

    @inner
    def growth_factor(work: Row) -> float:
        depth_m, sinking = -work[NOW + X_FOOT], -work[NOW + V_FOOT]
        sampled_kg_s, at_once_kg_s = work[ACTIVE_DAMPING], work[DAMPING]
        if has_quadratic:
            at_once_kg_s = 2.0 * quadratic(work, depth_m) * sinking + work[DAMPING]
        at_once_kg_s = at_once_kg_s + 1e-9
        if has_linear:
            at_once_kg_s = at_once_kg_s + drag_kg_s(work)
        if not linear:
            sampled_kg_s = sampled_kg_s * (work[NOW + V_BODY] + sinking)
            at_once_kg_s = at_once_kg_s + work[ACTIVE_DAMPING] * sinking
        if held:
            of_leg_kg_s = work[DAMPING] + (0.0 if linear else work[ACTIVE_DAMPING] * sinking)
            sampled_kg_s, at_once_kg_s = sampled_kg_s + of_leg_kg_s, at_once_kg_s - of_leg_kg_s
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
