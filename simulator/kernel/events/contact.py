"""Contact: what a resting foot does next, lift-off, and meeting the ground again."""

from __future__ import annotations

import math

from simulator.compiled import Function, Row, inner
from simulator.kernel.combined import nothing
from simulator.kernel.composition import Composition, made_once
from simulator.kernel.control.controller import make_hold
from simulator.kernel.layout import (
    ABOVE_PRINT,
    ACTIVE_DAMPING,
    AIRBORNE,
    ALLOWED,
    ASLEEP,
    BEYOND,
    BOTTOMED,
    CANCELLED,
    CARRIED,
    CLEAR,
    CLEARED,
    COMPRESSION,
    COST_CAPPED,
    CREEPING,
    DAMPING,
    DEEPEST,
    EMULATOR,
    EMULATOR_SINCE,
    ENGAGE,
    EXTENSION,
    FLIGHT,
    HOLD,
    IMPACT,
    IN_PRINT,
    INTRUDING,
    JAMMED,
    LENGTH_UNIT,
    MARGIN,
    MARGIN_TICK,
    MODE,
    NOW,
    OFFSET,
    PHASE,
    RESET,
    SATURATED,
    SINKING,
    SLIDES,
    STALE,
    STIFFNESS,
    TIME,
    TOLERANCE,
    TOUCHED_BEFORE_HOLD,
    TOUCHED_DURING_RESET,
    V_BODY,
    V_FOOT,
    X_BODY,
    X_FOOT,
)
from simulator.kernel.limits import NEAR_PEAK
from simulator.kernel.mechanics.leg import make_foot_margins, make_forces, make_lever, make_set_gains
from simulator.kernel.mechanics.motion import (
    make_body_acceleration,
    make_drive,
    make_force_rate,
    make_moved_mass,
    make_platform,
)
from simulator.kernel.report import make_energy


@inner
def note_near(distance: float, unit: float, work: Row) -> None:
    """Note how near another event was, in local errors of the state, by which the jump would have gone on otherwise."""
    if abs(distance) < unit * min(work[MARGIN], NEAR_PEAK):
        work[MARGIN], work[MARGIN_TICK] = abs(distance) / unit, -1.0


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
        return nothing
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


@made_once
def make_join_grains(composition: Composition) -> Function:
    """Let the grains under an old print move with the foot at once: `(work)`."""
    if not composition.has("added_mass_kg"):
        return nothing
    mass, grain = composition.slots["added_mass_kg"], composition.integrals["grain_energy"]

    @inner
    def join_grains(work: Row) -> None:
        work[NOW + grain] += 0.5 * mass(work, -work[NOW + X_FOOT]) * work[NOW + V_FOOT] * work[NOW + V_FOOT]

    return join_grains


def make_meet_ground(composition: Composition) -> Function:
    """Put the foot on the ground at t: `(work)`; the energy lost in an impact is booked."""
    platform = make_platform(composition)
    foot = composition.position["foot_mass"]
    emulated = composition.has("travel_m")
    yields, travel = composition.has("resistance_n"), composition.position.get("platform_travel", -1)
    join_grains, reset = make_join_grains(composition), composition.integrals.get("reset_work", -1)

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
            join_grains(work)
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


CREEP_PERIODS = 10.0
"""Ringings of the foot in a millisecond from which on very stiff ground it is taken to creep."""
CREEP_WINDOW_S = 1e-3


@inner
def sign_beyond(force_n: float, most_n: float) -> float:
    """Sign of a force that is larger than its cap, 0 where it is not; twice it where the cap is below 0."""
    if abs(force_n) <= max(most_n, 0.0):
        return 0.0
    sign = 1.0 if force_n > 0.0 else -1.0
    return sign if most_n >= 0.0 else 2.0 * sign


@made_once
def make_note_saturation(composition: Composition) -> Function:
    """Note whether the leg's force is at its cap and at that of the cost, and with which sign: `(work)`, after gains
    have changed.
    """
    capped, cost_capped = composition.has("cap_n"), composition.has("cost_cap_n")
    if not capped and not cost_capped:
        return nothing
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
    has_drag, drag_kg_m = composition.optional("quadratic_drag_kg_m")
    resistance_n = composition.slots["resistance_n"]
    damped, active = composition.has("compression_damping_kg_s"), composition.has("active_damping_kg_m")
    linear, slows = composition.on("linear_active_damping"), composition.has("cap_slows")

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
        if slows and work[SATURATED] != 0.0:  # then the force depends on the foot's speed
            return False
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
        return nothing
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
