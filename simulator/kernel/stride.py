"""One step: chosen, tried, cut at the first event or deciding tick, and accepted or rejected."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from simulator.compiled import inner
from simulator.effects.effect import Function
from simulator.kernel.ahead import make_deciding_tick, make_longest_step, nodes_within, note_extremes
from simulator.kernel.attempt import make_attempt, make_error_norm, make_frequency, make_sample_nodes, next_step
from simulator.kernel.composition import Composition
from simulator.kernel.decide import make_must_land
from simulator.kernel.emulator import make_timer
from simulator.kernel.guards import make_guards
from simulator.kernel.interpolant import make_interpolate
from simulator.kernel.layout import (
    ALLOWED,
    DECIDED,
    EVALUATIONS,
    FLIGHT,
    FRESH,
    INTRUDING,
    K1,
    K7,
    MODE,
    NOW,
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
from simulator.kernel.limits import FINEST_TOLERANCE, FIXED_STEP_S, FLIP_TICK, LONGEST_FLIGHT_S, LONGEST_STANCE_S
from simulator.kernel.locate import make_at_once, make_first_event, make_land
from simulator.kernel.motion import make_rates

Row = NDArray[np.float64]
STRETCH = 1.01
"""A step that would end just short of a tick goes on to it."""
SHORTEST_S = 1e-13
"""Below it positions at both ends are equal but for rounding, and a dense output would make speeds of that. What
happens in so short a step is seen at its end, and a foot that the ground would stop within it stops at once."""
MANY_STEPS = 1000.0
"""From here on a jump's further steps are allowed ever less, so that errors that add up stay within what is allowed to
so many steps: a light foot that is held back by stiff dampers takes hundreds of thousands."""
UNEVENTFUL, TIMED, REJECTED = -1, -2, -3
"""What a step may give beside a guard: no event, the emulator's timer ran out at its end, its error was too large."""


def make_stride(composition: Composition, wants_switch: Function) -> Function:
    """Compose `(limits, work)`: take one step, its end in `TRIAL` and `K7`, its length in `STRIDE`.

    Returns the guard whose event ends it, or one of the codes above.
    """
    rates_of = make_rates(composition)
    attempt, norm, frequency = (
        make_attempt(composition, rates_of),
        make_error_norm(composition),
        make_frequency(composition),
    )
    guards, sample_nodes = make_guards(composition, wants_switch), make_sample_nodes(composition)
    interpolate = make_interpolate(composition)
    at_once, first_event, land = (
        make_at_once(guards),
        make_first_event(guards, interpolate),
        make_land(guards, interpolate, attempt),
    )
    size = composition.state_size
    must_land, deciding_tick = make_must_land(composition), make_deciding_tick(composition, wants_switch)
    timer, longest_step = make_timer(composition), make_longest_step(composition)
    sampled, sleeps = composition.on("sampled_control"), composition.sleeps_in_flight
    rate = composition.position.get("control_rate", -1)

    @inner
    def stay(event: int, work: Row) -> int:
        for i in range(size):
            work[TRIAL + i], work[K7 + i] = work[NOW + i], work[K1 + i]
        work[STRIDE], work[STALE] = 0.0, 1
        work[STEPS] += 1
        return event

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
        sinking = -work[NOW + V_FOOT]
        if mode == INTRUDING and sinking > 0.0 and max(work[K1 + V_FOOT], sinking * omega) * SHORTEST_S > sinking:
            event, slowing = stay(STOPS, work), max(work[K1 + V_FOOT], 0.0)
            work[TRIAL + X_FOOT] -= sinking * sinking / (slowing + math.hypot(slowing, sinking * omega))
            return event
        fixed_s = limits[FIXED_STEP_S]
        h = fixed_s if fixed_s > 0.0 else longest_step(work, mode, omega)
        end_s = min(LONGEST_FLIGHT_S if mode == FLIGHT else LONGEST_STANCE_S, timed_s)
        if sampled and must_land(work):
            end_s = min(end_s, work[TICK] / work[rate])
        to_end = t + h * STRETCH >= end_s
        if to_end:
            h = end_s - t
        exact = attempt(t, h, work)
        work[STEPS] += 1
        if fixed_s == 0.0:
            tolerance = work[TOLERANCE]
            if work[STEPS] > MANY_STEPS:
                tolerance = max(tolerance * MANY_STEPS / work[STEPS], min(tolerance, FINEST_TOLERANCE))
            error = norm(work, mode, h, tolerance, omega)
            proposal_s = next_step(h, error)
            if not error <= 1.0:
                work[STEP] = proposal_s
                return REJECTED
            if not to_end or proposal_s < work[STEP]:
                work[STEP] = proposal_s
        after_s = end_s if to_end else t + h
        guard, share = UNEVENTFUL, 1.0
        if h > SHORTEST_S:
            nodes = nodes_within(work, mode, h, omega, exact)
            sample_nodes(h, nodes, exact, work)
            guard, share = first_event(t, h, nodes, work)
        if sampled and not (sleeps and mode == FLIGHT) and h > SHORTEST_S:
            tick_s = deciding_tick(h, t + share * h if guard >= 0 else after_s, work, limits[FLIP_TICK])
            if tick_s < np.inf:
                guard, after_s, to_end, h = UNEVENTFUL, tick_s, False, tick_s - t
                attempt(t, h, work)
                work[STALE], work[DECIDED] = 1, work[TICK] + 1.0
        seen = guard >= 0
        if seen:
            guard, h = land(guard, share, work[ALLOWED], t, h, work)
        if sampled and seen and guard < 0 and not (sleeps and mode == FLIGHT):
            tick_s = deciding_tick(h, after_s, work, limits[FLIP_TICK])
            if tick_s < np.inf:
                after_s, to_end, h = tick_s, False, tick_s - t
                attempt(t, h, work)
                work[DECIDED] = work[TICK] + 1.0
        if guard >= 0:
            after_s, to_end = t + h, False
        note_extremes(h, work)
        work[TIME], work[STRIDE], work[FRESH] = after_s, h, 0
        if seen or to_end or h <= SHORTEST_S:
            work[STALE] = 1
        return TIMED if to_end and after_s == timed_s else guard

    return stride
