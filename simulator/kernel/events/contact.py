"""Contact: what a resting foot does next, lift-off, and meeting the ground again."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from simulator.compiled import inner
from simulator.effects.effect import Function
from simulator.kernel.composition import Composition, made_once
from simulator.kernel.layout import (
    ABOVE_PRINT,
    ACTIVE_DAMPING,
    AIRBORNE,
    ASLEEP,
    BEYOND,
    CANCELLED,
    CARRIED,
    CLEAR,
    CLEARED,
    COMPRESSION,
    COST_CAPPED,
    CREEPING,
    DAMPING,
    DEEPEST,
    FLIGHT,
    IMPACT,
    IN_PRINT,
    INTRUDING,
    JAMMED,
    MODE,
    NOW,
    PHASE,
    SATURATED,
    SINKING,
    STALE,
    STIFFNESS,
    TIME,
    TOLERANCE,
    V_BODY,
    V_FOOT,
    X_BODY,
    X_FOOT,
)
from simulator.kernel.mechanics.body import make_body_acceleration
from simulator.kernel.mechanics.energy_book import make_energy
from simulator.kernel.mechanics.leg import make_lever, make_set_gains
from simulator.kernel.mechanics.margins import make_foot_margins, make_forces
from simulator.kernel.mechanics.motion import make_force_rate
from simulator.kernel.mechanics.moved_mass import make_moved_mass
from simulator.kernel.mechanics.platform import make_platform

Row = NDArray[np.float64]
CREEP_PERIODS = 10.0
"""Ringings of the foot in a millisecond from which on very stiff ground it is taken to creep."""
CREEP_WINDOW_S = 1e-3


@inner
def sign_beyond(force_n: float, most_n: float) -> float:
    """Sign of a force that is larger than its cap, 0 where it is not."""
    return 0.0 if abs(force_n) <= most_n else 1.0 if force_n > 0.0 else -1.0


@made_once
def make_note_saturation(composition: Composition) -> Function:
    """Note whether the leg's force is at its cap and at that of the cost, and with which sign: `(work)`, after gains
    have changed.
    """
    capped, cost_capped = composition.has("cap_n"), composition.has("cost_cap_n")
    if not capped and not cost_capped:
        return inner(lambda work: None)
    forces, lever, cost_cap_n = make_forces(composition), make_lever(composition), composition.slot("cost_cap_n")

    @inner
    def note(work: Row) -> None:
        commanded_n, applied_n, most_n = forces(work, NOW)
        if capped:
            work[SATURATED] = sign_beyond(commanded_n, most_n)
        if cost_capped:
            most_n = cost_cap_n(work, lever(work, work[NOW + X_BODY] - work[NOW + X_FOOT]))
            work[COST_CAPPED] = sign_beyond(applied_n, most_n)

    return note


@made_once
def make_creeps(composition: Composition) -> Function:
    """Whether a foot that starts to yield creeps instead of ringing, and goes on to: `(work, a_b, yielding_n)`.

    The ringing that creeping leaves out has the amplitude (yielding + force rate / omega) / K'; it must be far faster
    than a millisecond, and smaller than the local error allowed, relative to the depth. What the foot's own speed adds
    to the forces, which creeping leaves out too, must be as small beside what the ground holds.
    """
    if not composition.has("resistance_n") or composition.has("travel_m"):
        return inner(lambda work, a_b, yielding_n: False)
    slope = composition.slots["resistance_slope_n_m"]
    force_rate = make_force_rate(composition)
    moved_mass_kg = make_moved_mass(composition)
    has_drag, drag_kg_m = composition.has("quadratic_drag_kg_m"), composition.slot("quadratic_drag_kg_m")
    resistance_n = composition.slots["resistance_n"]
    damped, active = composition.has("compression_damping_kg_s"), composition.has("active_damping_kg_m")
    linear = composition.on("linear_active_damping")

    @inner
    def own_force_n(work: Row, depth_m: float, sinking_m_s: float) -> float:
        force_n = 0.0
        if damped:
            force_n += work[DAMPING] * sinking_m_s
        if active:
            leg_speed_m_s = abs(work[NOW + V_BODY]) + sinking_m_s
            force_n += work[ACTIVE_DAMPING] * sinking_m_s * (1.0 if linear else leg_speed_m_s)
        if has_drag:
            force_n += drag_kg_m(work, depth_m) * sinking_m_s * sinking_m_s
        return force_n

    @inner
    def creeps(work: Row, a_b: float, yielding_n: float) -> bool:
        depth_m = -work[NOW + X_FOOT]
        give_n_m = slope(work, depth_m)
        omega = math.sqrt(give_n_m / moved_mass_kg(work, depth_m))
        if omega * CREEP_WINDOW_S < 2.0 * math.pi * CREEP_PERIODS:
            return False
        rising_n_s = -force_rate(work, work[NOW + X_BODY] - work[NOW + X_FOOT], work[NOW + V_BODY], a_b)
        if rising_n_s <= 0.0:
            return False
        if own_force_n(work, depth_m, rising_n_s / give_n_m) > work[TOLERANCE] * resistance_n(work, depth_m):
            return False
        return (yielding_n + rising_n_s / omega) / give_n_m < work[TOLERANCE] * depth_m

    return creeps


def make_creep_on(composition: Composition) -> Function:
    """Let a foot that creeps through grains do so only as long as it may: `(work)`."""
    if not composition.has("resistance_n") or composition.has("travel_m"):
        return inner(lambda work: None)
    creeps, forces, margins = make_creeps(composition), make_forces(composition), make_foot_margins(composition)
    accelerate = make_body_acceleration(composition)

    @inner
    def creep_on(work: Row) -> None:
        if work[MODE] == CREEPING:
            applied_n = forces(work, NOW)[1]
            yielding_n = margins(work, NOW, applied_n)[1]
            if not creeps(work, accelerate(CREEPING, work, NOW, applied_n), abs(yielding_n)):
                work[MODE], work[STALE] = INTRUDING, 1

    return creep_on


def make_settle(composition: Composition, lift_off: Function) -> Function:
    """Decide what a foot at rest does: `(work)` lifts it, lets the ground yield, or holds it."""
    forces, margins, creeps = make_forces(composition), make_foot_margins(composition), make_creeps(composition)
    accelerate, follows = make_body_acceleration(composition), composition.follows
    at_the_print = composition.contact_at_the_print

    @inner
    def settle(work: Row) -> None:
        if follows and work[MODE] == CREEPING:  # a force that jumps is followed after a moment only
            work[MODE] = INTRUDING
            return
        _, applied_n, _ = forces(work, NOW)
        lifting_n, yielding_n = margins(work, NOW, applied_n)
        crept = work[MODE] == CREEPING
        work[MODE] = JAMMED
        if lifting_n > 0.0:
            lift_off(work)
            if not at_the_print or work[MODE] == FLIGHT:
                return
            _, applied_n, _ = forces(work, NOW)
            yielding_n = margins(work, NOW, applied_n)[1]
        if (yielding_n > 0.0 or crept) and creeps(work, accelerate(JAMMED, work, NOW, applied_n), abs(yielding_n)):
            work[MODE] = CREEPING
        elif yielding_n > 0.0:
            work[MODE] = INTRUDING

    return settle


def make_lift_off(composition: Composition) -> Function:
    """Leave the ground: `(work)`. The gains become those of flight.

    With contact at the print a lift-off that these gains take back is cancelled, and the controller sleeps. One that
    changes no gains is not asked again.
    """
    set_gains, note, energy = (
        make_set_gains(composition),
        make_note_saturation(composition),
        make_energy(composition),
    )
    keeps = composition.on("held_gains_in_flight") or composition.on("touchdown_impact")
    massless, granular = composition.on("massless_leg_in_flight"), composition.on("hydrostatic_stiffness")
    rest, forces, margins = (
        composition.position["rest_length"],
        make_forces(composition),
        make_foot_margins(composition),
    )
    at_the_print, holds_force = composition.contact_at_the_print, composition.on("held_force")
    emulated, platform = composition.has("travel_m"), make_platform(composition)
    upper, lower = composition.position["upper_link"], composition.position["lower_link"]

    @inner
    def lift_off(work: Row) -> None:
        if emulated and work[MODE] == CARRIED:  # or an error of the last steps would have it touch at once
            work[NOW + X_FOOT], work[NOW + V_FOOT], _ = platform(work, work[TIME])
        stiffness, damping, active = work[STIFFNESS], work[DAMPING], work[ACTIVE_DAMPING]
        if not keeps:
            work[PHASE] = COMPRESSION
            set_gains(work, False, 0.0)
            note(work)
        if at_the_print and work[ASLEEP] == 0:
            work[ASLEEP] = 1
            same = work[STIFFNESS] == stiffness and work[DAMPING] == damping and work[ACTIVE_DAMPING] == active
            if (holds_force or not same) and not margins(work, NOW, forces(work, NOW)[1])[0] > 0.0:
                work[CANCELLED] += 1
                return
        work[MODE], work[AIRBORNE] = FLIGHT, 1
        work[DEEPEST] = min(work[DEEPEST], work[NOW + X_FOOT])
        reach_m = work[upper] + work[lower]
        work[BEYOND] = 1 if work[NOW + X_BODY] - work[NOW + X_FOOT] > reach_m else 0
        work[CLEARED] = ABOVE_PRINT
        if granular and not margins(work, NOW, forces(work, NOW)[1])[0] > 0.0:
            work[CLEARED] = SINKING
        if massless:
            before_j = energy(FLIGHT, work)
            work[NOW + X_FOOT], work[NOW + V_FOOT] = work[NOW + X_BODY] - work[rest], work[NOW + V_BODY]
            below = IN_PRINT if work[NOW + V_FOOT] > 0.0 else SINKING
            in_print = work[NOW + X_FOOT] <= work[DEEPEST]
            work[CLEARED] = CLEAR if work[NOW + X_FOOT] > 0.0 else below if in_print else ABOVE_PRINT
            lost_j = before_j - energy(FLIGHT, work)
            work[IMPACT] += lost_j

    return lift_off
