"""One step of several lanes side by side, all in the same contact mode, each lane with its own clock and step.

What the scalar kernel's step does is done here where nothing happens in it: no event, no change of the leg's phase, no
force that reaches its cap. A lane in which something may happen is left as it was, for the scalar kernel to take the
step there (`simulator.kernel.lanes.pool`).
"""

from __future__ import annotations

from typing import Any

from simulator.compiled import inlined, inner
from simulator.effects.effect import Function
from simulator.kernel.composition import Composition
from simulator.kernel.control.controller import make_wants_switch
from simulator.kernel.lanes.control import make_tick, make_ticks_within
from simulator.kernel.lanes.events import AT_START, FREE, PROMPT, make_events, make_guards
from simulator.kernel.lanes.numbers import numbers_of, width_of
from simulator.kernel.layout import (
    ACTIVE_DAMPING,
    CAPPED,
    DEPTH,
    ERROR,
    EVALUATIONS,
    FLIGHT,
    FRESH,
    INTRUDING,
    K1,
    LEG_WORK,
    LOOK,
    MARGIN,
    MARGIN_TICK,
    NOW,
    SATURATED,
    STALE,
    STEP,
    STEPS,
    STIFFNESS,
    STRIDE,
    TICK,
    TIME,
    TOLERANCE,
    TRIAL,
    V_FOOT,
    X_FOOT,
    places,
)
from simulator.kernel.limits import FINEST_TOLERANCE, LONGEST_FLIGHT_S, LONGEST_STANCE_S
from simulator.kernel.mechanics.motion import make_rates
from simulator.kernel.steps.attempt import LARGEST, make_frequency, make_motion_error, next_step
from simulator.kernel.steps.linear_step import make_linear_step
from simulator.kernel.steps.runge_kutta import make_runge_kutta
from simulator.kernel.steps.step_limits import (
    make_longest_step,
    note_extremes,
)
from simulator.kernel.steps.stride import MANY_STEPS, SHORTEST_S, STRETCH
from simulator.kernel.working_row import choose, lanes_in

Lanes = Any
"""A number of every lane, or whether something holds in each (`simulator.kernel.lanes.numbers`)."""
Row = Any
"""The working rows of all lanes, place by place."""
SMALL_ERROR, LARGE_ERROR = 1.88e-4, 1.9e3
"""Errors of a step, in units of what is allowed, up to which the next one is five times as long, from which a fifth."""
FACTOR, EACH_ERROR = places(FREE, FREE + 2, 1)
"""Places of what is computed lane by lane: the length of the next step in units of this one, and this one's error."""


def make_norm(composition: Composition, mode: int) -> Function:
    """Compose `(h, omega, work)`: the largest error of a step relative to what is allowed, as in the scalar kernel."""
    per_lift, motion_error = composition.position["inverse_lift_energy"], make_motion_error(composition)
    integrals_end, size = composition.integrals_end, composition.state_size

    @inlined
    def norm(h: Lanes, omega: Lanes, work: Row) -> Lanes:
        per_energy, worst = work[per_lift], motion_error(work, mode, h, omega)
        for i in range(LEG_WORK, integrals_end):
            lifts, share = abs(work[TRIAL + i]) * per_energy, abs(work[ERROR + i]) * per_energy
            worst = max(worst, share / max(lifts, 1.0))
        tolerance, steps = work[TOLERANCE], work[STEPS] + 1.0
        finer = max(tolerance * MANY_STEPS / steps, min(tolerance, FINEST_TOLERANCE))
        worst = worst / choose(steps > MANY_STEPS, finer, tolerance)
        fits = worst <= LARGEST
        for i in range(size):
            fits &= abs(work[TRIAL + i]) < LARGEST
        return choose(fits, worst, LARGEST)

    return norm


@inner
def next_steps(h: Lanes, error: Lanes, which: Lanes, work: Row) -> Lanes:
    """Steps to take after those with these errors, s, in the lanes of a mask, as the scalar kernel chooses them.

    Only where the step neither grows nor shrinks by the most that it may is a power taken, lane by lane.
    """
    factor = choose(error <= SMALL_ERROR, 5.0, 0.2)
    powers = lanes_in(which & (error > SMALL_ERROR) & (error < LARGE_ERROR))
    if powers != 0:
        work[FACTOR], work[EACH_ERROR] = factor, error
        one = numbers_of(work)
        for lane in range(width_of(work)):
            if powers >> lane & 1:
                one[FACTOR * width_of(work) + lane] = next_step(1.0, one[EACH_ERROR * width_of(work) + lane])
        factor = work[FACTOR]
    return h * factor


def make_step(composition: Composition, mode: int) -> Function:
    """Compose `(occupied, work)`: a step of every occupied lane, a number that is 1 where it is.

    Returns as bits in which lanes something may happen; nothing has been done there but, perhaps, the tick.
    """
    rates_of = make_rates(composition, creeping=False)
    runge_kutta, linear_step = make_runge_kutta(composition, rates_of), make_linear_step(composition, rates_of)
    frequency, norm = make_frequency(composition), make_norm(composition, mode)
    exact, bends = mode == FLIGHT and composition.closed_form("flight"), composition.has("cap_bends")
    evaluations = 4.0 if exact else 6.0
    guards = make_guards(composition, mode)
    events, longest_step = (
        make_events(composition, mode, guards, exact=exact),
        make_longest_step(composition),
    )
    wants_switch = make_wants_switch(composition)
    tick, ticks_within = make_tick(composition, wants_switch), make_ticks_within(composition, wants_switch)
    intruding, active_damping = mode == INTRUDING, composition.has("active_damping_kg_m")
    rate, size = composition.position["control_rate"], composition.state_size
    prompt, last_s = PROMPT[mode], LONGEST_STANCE_S if intruding else LONGEST_FLIGHT_S

    @inner
    def step(occupied: Lanes, work: Row) -> int:
        active = occupied == 1.0
        leaves = active & ~active
        if intruding:
            leaves = tick(active, work)
        t = work[TIME]
        leaves |= active & ((work[STEPS] >= work[LOOK]) | (t >= last_s))
        rates_of(mode, t, work, NOW, K1)
        guards(work, NOW, AT_START)
        for guard in prompt:
            leaves |= active & (work[AT_START + guard] > 0.0)
        omega = frequency(work, mode, max(-work[NOW + X_FOOT], 0.0), work[STIFFNESS])
        if intruding:
            sinking = -work[NOW + V_FOOT]
            leaves |= active & (sinking > 0.0) & (max(work[K1 + V_FOOT], sinking * omega) * SHORTEST_S > sinking)
        h, end_s = longest_step(work, mode, omega, exact), 0.0 * t + last_s
        if intruding and active_damping:
            end_s = choose(work[ACTIVE_DAMPING] > 0.0, min(end_s, work[TICK] / work[rate]), end_s)
        to_end = t + h * STRETCH >= end_s
        h = choose(to_end, end_s - t, h)
        leaves |= active & (h <= SHORTEST_S)
        if exact:
            linear_step(mode, t, h, work, work[SATURATED] != 0.0)
            if bends:
                leaves |= active & (work[SATURATED] != 0.0)
        else:
            runge_kutta(mode, t, h, work)
        error = norm(h, omega, work)
        accepted = error <= 1.0
        taken = active & ~leaves & accepted
        after_s = choose(to_end, end_s, t + h)
        leaves |= events(h, omega, taken, work)
        number, margin, margin_tick = work[TICK], work[MARGIN], work[MARGIN_TICK]
        if intruding:
            switches, number, margin, margin_tick = ticks_within(h, after_s, taken & ~leaves, work)
            leaves |= switches
        tried = active & ~leaves
        taken = tried & accepted
        work[STEPS] = choose(tried, work[STEPS] + 1.0, work[STEPS])
        counted = work[EVALUATIONS] + evaluations + choose(work[STALE] == 1.0, 1.0, 0.0)
        work[EVALUATIONS] = choose(tried, counted, work[EVALUATIONS])
        proposal_s = next_steps(h, error, tried, work)
        retried = ~accepted | ~to_end | (proposal_s < work[STEP])
        work[STEP] = choose(tried & retried, proposal_s, work[STEP])
        work[STALE] = choose(tried, choose(taken & to_end, 1.0, 0.0), work[STALE])
        note_extremes(h, taken, work)
        for i in range(size):
            work[NOW + i] = choose(taken, work[TRIAL + i], work[NOW + i])
        work[TIME], work[STRIDE] = choose(taken, after_s, t), choose(taken, h, work[STRIDE])
        work[FRESH] = choose(taken, 0.0, work[FRESH])
        work[CAPPED] = choose(taken & (work[SATURATED] != 0.0), work[CAPPED] + h, work[CAPPED])
        if intruding:
            work[DEPTH] = choose(taken, max(work[DEPTH], -work[NOW + X_FOOT]), work[DEPTH])
            work[TICK] = choose(taken, number, work[TICK])
            work[MARGIN], work[MARGIN_TICK] = (
                choose(taken, margin, work[MARGIN]),
                choose(taken, margin_tick, work[MARGIN_TICK]),
            )
        return lanes_in(leaves)

    return step
