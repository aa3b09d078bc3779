"""What limits a step before it is taken, and what control does inside it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from simulator.compiled import inlined, inner
from simulator.effects.effect import Function
from simulator.kernel.composition import Composition
from simulator.kernel.layout import (
    ACTIVE_DAMPING,
    ALLOWED,
    ASLEEP,
    BETWEEN,
    DAMPING,
    FLIGHT,
    FRESH,
    INTRUDING,
    LENGTH_UNIT,
    LONGEST,
    LOWEST,
    MARGIN,
    MARGIN_TICK,
    NOW,
    PHASE,
    SAMPLED_SPEED,
    SATURATED,
    SHORTEST,
    SPEED_UNIT,
    STEP,
    STIFFNESS,
    TICK,
    TIME,
    TRIAL,
    V_BODY,
    V_FOOT,
    X_BODY,
    X_FOOT,
)
from simulator.kernel.mechanics.moved_mass import make_moved_mass
from simulator.kernel.steps.dense_output import interpolate
from simulator.kernel.steps.linear_step import make_held_foot_motion
from simulator.kernel.working_row import choose, lanes_in

Row = NDArray[np.float64]
FRESH_SHARE = 0.2
"""First step after the ground yields or the foot leaves it, in units of the foot's time scale: shorter than an
intrusion that ends at once."""
QUIET_SHARE, LONGEST_QUIET_STEP_S = 0.1, 0.02
STABLE_SHARE = 2.7
"""Longest step in units of the fastest damping: the method is stable to 3.3."""
INTRUDING_SHARE, SMOOTH_SHARE = 1.5, 0.7
"""Longest steps of a foot in the ground and otherwise, in the same units: no guard rises and falls unseen inside
one.
"""
LEG_TURNS, BODY_TURNS = 30, 20
"""Times a step is halved to find where leg or body turns; heights there err by the square of what is left."""


def make_damping_rate(composition: Composition) -> Function:
    """Fastest rate at which dampers change the foot's speed, 1/s: `(work, mode)`, in flight and intruding."""
    foot = composition.position["foot_mass"]
    damped, held = composition.has("compression_damping_kg_s"), composition.on("held_force")
    active, linear = composition.has("active_damping_kg_m"), composition.on("linear_active_damping")
    sampled = composition.on("sampled_control") and not composition.on("continuous_foot_speed")
    has_quadratic, quadratic = composition.has("quadratic_drag_kg_m"), composition.slot("quadratic_drag_kg_m")
    has_linear, drag_kg_s = composition.has("linear_drag_kg_s"), composition.slot("linear_drag_kg_s")
    product, follows = active and sampled and not linear, active and not sampled
    moved_mass_kg = make_moved_mass(composition)

    @inner
    def of_leg(work: Row, mode: float) -> float:
        damping = 0.0 * work[STIFFNESS]
        if held and mode != FLIGHT and work[ASLEEP] == 0:
            return damping
        if damped:
            damping = damping + work[DAMPING]
        if product:
            damping = damping + work[ACTIVE_DAMPING] * work[SAMPLED_SPEED]
        elif follows:
            sinking = max(-work[NOW + V_FOOT], 0.0)
            at_once = 1.0 if linear else sinking + abs(work[NOW + V_BODY] + sinking)
            damping = damping + choose(sinking > 0.0, work[ACTIVE_DAMPING] * at_once, 0.0)
        return choose(work[SATURATED] == 0.0, damping, 0.0)

    @inner
    def damping_rate(work: Row, mode: float) -> float:
        damping, moved_kg = of_leg(work, mode), work[foot]
        if mode == INTRUDING:
            depth_m = -work[NOW + X_FOOT]
            if has_quadratic:
                damping += 2.0 * quadratic(work, depth_m) * abs(work[NOW + V_FOOT])
            if has_linear:
                damping += drag_kg_s(work)
            moved_kg = moved_mass_kg(work, depth_m)
        return damping / moved_kg

    return damping_rate


def make_longest_step(composition: Composition) -> Function:
    """Longest step in a mode whose fastest frequency is `omega` (rad/s), s: `(work, mode, omega, exact)`.

    In flight a leg that has stopped ringing, to what an event is allowed, limits nothing. Where dampers are stiffer
    than the motion is fast, steps stay within what is stable, unless they are exact: a control that finds this limit by
    errors, step after step, lets every step err by all that is allowed.
    """
    rest, damping_rate = composition.position["rest_length"], make_damping_rate(composition)

    @inner
    def longest_step(work: Row, mode: float, omega: float, exact: bool) -> float:
        longest_s = min(work[STEP], step_share(work, mode) / omega)
        if not exact and mode in (FLIGHT, INTRUDING):
            rate = damping_rate(work, mode)
            stiff = rate * longest_s > STABLE_SHARE
            if lanes_in(stiff) != 0:
                longest_s = choose(stiff, STABLE_SHARE / rate, longest_s)
        if mode == FLIGHT:
            stretch_m = work[NOW + X_BODY] - work[NOW + X_FOOT] - work[rest]
            ringing_m = abs(stretch_m) + abs(work[NOW + V_BODY] - work[NOW + V_FOOT]) / omega
            quiet = ringing_m < QUIET_SHARE * work[ALLOWED] * work[rest]
            longest_s = choose(quiet, min(work[STEP], LONGEST_QUIET_STEP_S), longest_s)
        return longest_s

    return longest_step


@inner
def nodes_within(work: Row, mode: float, h: float, omega: float, exact: bool) -> int:
    """At how many nodes of a step guards are looked at: 4 in the longest one and in closed form, where the motion does
    not limit steps; fewer in one cut short by a tick.
    """
    if exact or h * omega > 0.5 * step_share(work, mode):
        return 4
    return 2 if h * omega > 0.25 * step_share(work, mode) else 1


@inner
def step_share(work: Row, mode: float) -> float:
    """Longest step of a mode in units of its time scale."""
    return choose(work[FRESH] == 1.0, FRESH_SHARE, INTRUDING_SHARE if mode == INTRUDING else SMOOTH_SHARE)


def make_deciding_tick(composition: Composition, wants_switch: Function) -> Function:
    """Find the first tick inside a step at which the phase changes: `(h, until, work, flip_tick)`.

    Returns its time, or infinity; ticks passed without a change count as decided, with their margins.
    """
    rate = composition.position.get("control_rate", -1)
    decays_fast, move = make_held_foot_motion(composition)

    @inner
    def deciding_tick(h: float, until: float, work: Row, flip_tick: float) -> float:
        fast = decays_fast(h, work)
        while work[TICK] / work[rate] < until:
            tick_s = work[TICK] / work[rate]
            if fast:
                move(tick_s - work[TIME], work, BETWEEN)
            else:
                interpolate(h, (tick_s - work[TIME]) / h, work, BETWEEN)
            wish = wants_switch(work, work[PHASE], BETWEEN, work[LENGTH_UNIT], work[SPEED_UNIT])
            if (wish > 0.0) != (work[TICK] == flip_tick) and tick_s > work[TIME]:
                return tick_s
            if abs(wish) < work[MARGIN]:
                work[MARGIN], work[MARGIN_TICK] = abs(wish), work[TICK]
            work[TICK] += 1
        return np.inf

    return deciding_tick


@inlined
def turn(h: float, before: float, foot: float, rounds: int, work: Row) -> None:
    """Put the motion into `BETWEEN` where a speed that has changed its sign within the step is 0, by halving the step.

    It is that of the body, or of the leg's length where the foot's speed counts too: `foot` is 0 or 1.
    """
    low, high = 0.0 * h, 0.0 * h + 1.0
    for _ in range(rounds):
        share = 0.5 * (low + high)
        interpolate(h, share, work, BETWEEN)
        earlier = before * (work[BETWEEN + V_BODY] - foot * work[BETWEEN + V_FOOT]) > 0.0
        low, high = choose(earlier, share, low), choose(earlier, high, share)


@inner
def note_extremes(h: float, which: bool, work: Row) -> None:
    """Keep the lowest body, the shortest and the longest leg; inside a step they are where a speed changes its sign.

    The body is lowest where it turns, or as the jump begins or ends. In lanes `which` says whose step is taken.
    """
    length_m = work[TRIAL + X_BODY] - work[TRIAL + X_FOOT]
    shortest, longest = min(work[SHORTEST], length_m), max(work[LONGEST], length_m)
    before, after = work[NOW + V_BODY], work[TRIAL + V_BODY]
    turns = which & (before < 0.0) & (after >= 0.0)
    if lanes_in(turns) != 0:
        turn(h, before, 0.0, BODY_TURNS, work)
        work[LOWEST] = choose(turns, min(work[LOWEST], work[BETWEEN + X_BODY]), work[LOWEST])
    before, after = before - work[NOW + V_FOOT], after - work[TRIAL + V_FOOT]
    turns = which & (before * after < 0.0)
    if lanes_in(turns) != 0:
        turn(h, before, 1.0, LEG_TURNS, work)
        length_m = work[BETWEEN + X_BODY] - work[BETWEEN + X_FOOT]
        shortest, longest = (
            choose(turns, min(shortest, length_m), shortest),
            choose(turns, max(longest, length_m), longest),
        )
    work[SHORTEST], work[LONGEST] = choose(which, shortest, work[SHORTEST]), choose(which, longest, work[LONGEST])
