"""One step: chosen, tried, cut at the first event or deciding tick, and accepted or rejected."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from simulator.compiled import inlined, inner
from simulator.effects.effect import Function
from simulator.kernel.composition import Composition
from simulator.kernel.control.decisions import make_must_land
from simulator.kernel.control.emulator import make_timer
from simulator.kernel.events.first_event import make_first_event
from simulator.kernel.events.guards import make_guards
from simulator.kernel.events.locate import make_at_once, make_land
from simulator.kernel.layout import (
    ALLOWED,
    ASLEEP,
    DECIDED,
    EVALUATIONS,
    FLIGHT,
    FRESH,
    INTRUDING,
    K1,
    K7,
    MODE,
    NOW,
    SATURATED,
    STALE,
    STEP,
    STEPS,
    STIFFNESS,
    STOPS,
    STRIDE,
    TICK,
    TIME,
    TOLERANCE,
    TRIAL,
    V_FOOT,
    X_FOOT,
)
from simulator.kernel.limits import (
    EVENT_SHARE,
    FINEST_TOLERANCE,
    FIXED_STEP_S,
    FLIP_TICK,
    LONGEST_FLIGHT_S,
    LONGEST_STANCE_S,
)
from simulator.kernel.mechanics.motion import make_rates
from simulator.kernel.steps.attempt import make_attempt, make_error_norm, make_frequency, make_sample_nodes, next_step
from simulator.kernel.steps.dense_output import make_interpolate
from simulator.kernel.steps.linear_step import make_is_linear
from simulator.kernel.steps.step_limits import make_deciding_tick, make_longest_step, nodes_within, note_extremes

Row = NDArray[np.float64]
STRETCH = 1.01
"""A step that would end just short of a tick goes on to it."""
SHORTEST_S = 1e-13
"""Below it positions at both ends are equal but for rounding, and a dense output would make speeds of that. What
happens in so short a step is seen at its end, and a foot that the ground would stop within it stops at once."""
STOPPING_SHARE = 0.75
"""Longest step of a foot that stops within so short a time, in units of that: it does not turn."""
MANY_STEPS = 1000.0
"""From here on a jump's further steps are allowed ever less, so that errors that add up stay within what is allowed to
so many steps: a light foot that is held back by stiff dampers takes hundreds of thousands."""
UNEVENTFUL, TIMED, REJECTED = -1, -2, -3
"""What a step may give beside a guard: no event, the emulator's timer ran out at its end, its error was too large."""


def make_stay(composition: Composition) -> Function:
    """Compose `(event, work)`: a step of no length, at whose end an event happens."""
    size = composition.state_size

    @inner
    def stay(event: int, work: Row) -> int:
        for i in range(size):
            work[TRIAL + i], work[K7 + i] = work[NOW + i], work[K1 + i]
        work[STRIDE], work[STALE] = 0.0, 1
        work[STEPS] += 1
        return event

    return stay


@inlined
def stops_unseen(mode: float, omega: float, work: Row) -> bool:
    """Whether the ground stops the foot in less time than a step may be short."""
    sinking = -work[NOW + V_FOOT]
    return mode == INTRUDING and sinking > 0.0 and max(work[K1 + V_FOOT], sinking * omega) * SHORTEST_S > sinking


@inlined
def stops_evenly(omega: float, work: Row) -> bool:
    """Whether such a foot slows down so evenly that steps take it on, with a way to go that its depth shows."""
    sinking, slowing = -work[NOW + V_FOOT], work[K1 + V_FOOT]
    rest_m = EVENT_SHARE * work[TOLERANCE] * -work[NOW + X_FOOT]
    return slowing > sinking * omega and 0.5 * sinking * sinking > rest_m * slowing


@inner
def sink(omega: float, work: Row) -> None:
    """Put the end of a step of no length as deep as the energy of the foot takes it."""
    sinking, slowing = -work[NOW + V_FOOT], max(work[K1 + V_FOOT], 0.0)
    work[TRIAL + X_FOOT] -= sinking * sinking / (slowing + math.hypot(slowing, sinking * omega))


def make_last_end(composition: Composition) -> Function:
    """Compose `(mode, timed_s, work)`: the instant at which a step must end at the latest, s."""
    must_land, sampled = make_must_land(composition), composition.on("sampled_control")
    rate = composition.position.get("control_rate", -1)

    @inlined
    def last_end(mode: float, timed_s: float, work: Row) -> float:
        end_s = min(LONGEST_FLIGHT_S if mode == FLIGHT else LONGEST_STANCE_S, timed_s)
        if sampled and must_land(work):
            end_s = min(end_s, work[TICK] / work[rate])
        return end_s

    return last_end


def make_accurate(composition: Composition) -> Function:
    """Compose `(mode, h, omega, to_end, work)`: whether a step's error is allowed; stores the step to try next."""
    norm = make_error_norm(composition)

    @inlined
    def accurate(mode: float, h: float, omega: float, to_end: bool, work: Row) -> bool:
        tolerance = work[TOLERANCE]
        if work[STEPS] > MANY_STEPS:
            tolerance = max(tolerance * MANY_STEPS / work[STEPS], min(tolerance, FINEST_TOLERANCE))
        error = norm(work, mode, h, tolerance, omega)
        proposal_s = next_step(h, error)
        allowed = error <= 1.0
        if not allowed or not to_end or proposal_s < work[STEP]:
            work[STEP] = proposal_s
        return allowed

    return accurate


def make_cut(composition: Composition, wants_switch: Function, attempt: Function) -> Function:
    """Compose `(mode, t, h, until, work, flip_tick)`: end a step at the first tick before `until` that changes gains.

    Returns that tick's time, or infinity where there is none.
    """
    if not composition.on("sampled_control"):
        return inner(lambda mode, t, h, until, work, flip_tick: np.inf)
    deciding_tick, sleeps = make_deciding_tick(composition, wants_switch), composition.sleeps_in_flight

    @inner
    def cut(mode: float, t: float, h: float, until: float, work: Row, flip_tick: float) -> float:
        if sleeps and (mode == FLIGHT or work[ASLEEP] == 1):
            return np.inf
        tick_s = deciding_tick(h, until, work, flip_tick)
        if tick_s < np.inf:
            attempt(t, tick_s - t, work)
            work[DECIDED] = work[TICK] + 1.0
        return tick_s

    return cut


def make_stride(composition: Composition, wants_switch: Function) -> Function:
    """Compose `(limits, work)`: take one step, its end in `TRIAL` and `K7`, its length in `STRIDE`.

    Returns the guard whose event ends it, or one of the codes above.
    """
    rates_of, interpolate = make_rates(composition), make_interpolate(composition)
    attempt, frequency = make_attempt(composition, rates_of), make_frequency(composition)
    guards, sample_nodes = make_guards(composition), make_sample_nodes(composition)
    at_once, first_event, land = (
        make_at_once(composition, guards),
        make_first_event(guards, interpolate, composition.guards),
        make_land(guards, interpolate, attempt, composition.guards),
    )
    stay, cut = make_stay(composition), make_cut(composition, wants_switch, attempt)
    timer, longest_step = make_timer(composition), make_longest_step(composition)
    is_linear = make_is_linear(composition)
    last_end, accurate = make_last_end(composition), make_accurate(composition)

    @inner
    def stride(limits: Row, work: Row) -> int:
        mode, t = work[MODE], work[TIME]
        timed_s = timer(work)
        prompt = at_once(t, work)
        if prompt < 0 and timed_s <= t:
            prompt = TIMED
        if prompt != UNEVENTFUL:
            return stay(prompt, work)
        if work[STALE] == 1:
            rates_of(mode, t, work, NOW, K1)
            work[EVALUATIONS] += 1
            work[STALE] = 0
        omega = frequency(work, mode, max(-work[NOW + X_FOOT], 0.0), work[STIFFNESS])
        stopping = stops_unseen(mode, omega, work)
        if stopping and not stops_evenly(omega, work):
            event = stay(STOPS, work)
            sink(omega, work)
            return event
        fixed_s = limits[FIXED_STEP_S]
        linear = is_linear(mode, work, work[SATURATED] != 0.0)
        h = fixed_s if fixed_s > 0.0 else longest_step(work, mode, omega, linear)
        if stopping:
            h = min(h, STOPPING_SHARE * -work[NOW + V_FOOT] / work[K1 + V_FOOT])
        end_s = last_end(mode, timed_s, work)
        to_end = t + h * STRETCH >= end_s
        if to_end:
            h = end_s - t
        exact = attempt(t, h, work)
        work[STEPS] += 1
        if fixed_s == 0.0 and not accurate(mode, h, omega, to_end, work):
            return REJECTED
        after_s = end_s if to_end else t + h
        guard, share = UNEVENTFUL, 1.0
        if h > SHORTEST_S:
            nodes = nodes_within(work, mode, h, omega, exact)
            sample_nodes(h, nodes, exact, work)
            guard, share = first_event(t, h, nodes, work)
            tick_s = cut(mode, t, h, t + share * h if guard >= 0 else after_s, work, limits[FLIP_TICK])
            if tick_s < np.inf:
                guard, after_s, to_end, h = UNEVENTFUL, tick_s, False, tick_s - t
                work[STALE] = 1
        seen = guard >= 0
        if seen:
            guard, h = land(guard, share, work[ALLOWED], t, h, work)
            if guard < 0:
                tick_s = cut(mode, t, h, after_s, work, limits[FLIP_TICK])
                if tick_s < np.inf:
                    after_s, to_end, h = tick_s, False, tick_s - t
        if guard >= 0:
            after_s, to_end = t + h, False
        note_extremes(h, True, work)
        work[TIME], work[STRIDE], work[FRESH] = after_s, h, 0
        if seen or to_end or h <= SHORTEST_S:
            work[STALE] = 1
        return TIMED if to_end and after_s == timed_s else guard

    return stride
