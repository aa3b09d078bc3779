"""One step of several lanes side by side, all in the same contact mode, each lane with its own clock and step.

What the scalar kernel's step does is done here where nothing happens in it: no event, no change of the leg's phase, no
force that reaches its cap. A lane in which something may happen is left as it was, for the scalar kernel to take the
step there (`simulator.kernel.lanes.pool`).
"""

from __future__ import annotations

from typing import Any

from simulator.compiled import Function, inlined, inner
from simulator.kernel.composition import Composition
from simulator.kernel.control.controller import make_growth, make_wants_switch
from simulator.kernel.events.first_event import may_peak
from simulator.kernel.events.guards import beyond_cap
from simulator.kernel.layout import (
    ACTIVE_DAMPING,
    BETWEEN,
    BEYOND,
    CAPPED,
    CLEAR,
    CLEARED,
    DECIDED,
    DEEPEST,
    DEPTH,
    ERROR,
    EVALUATIONS,
    FLIGHT,
    FOLDS,
    FRESH,
    HALF,
    INTRUDING,
    K1,
    LEG_WORK,
    LENGTH_UNIT,
    MARGIN,
    MARGIN_TICK,
    NEAR,
    NOW,
    PERSISTENT,
    PHASE,
    QUARTER,
    SAMPLED_SPEED,
    SATURATED,
    SPARE,
    SPEED_UNIT,
    STALE,
    STEP,
    STEPS,
    STEPS_ALLOWED,
    STIFFNESS,
    STRIDE,
    THREE_QUARTERS,
    TICK,
    TIME,
    TOLERANCE,
    TRIAL,
    V_BODY,
    V_FOOT,
    X_BODY,
    X_FOOT,
    places,
)
from simulator.kernel.limits import FINEST_TOLERANCE, LONGEST_FLIGHT_S, LONGEST_STANCE_S, NEAR_PEAK
from simulator.kernel.mechanics.leg import make_forces
from simulator.kernel.mechanics.motion import make_rates
from simulator.kernel.steps.attempt import (
    LARGEST,
    make_fit_quintics,
    make_frequency,
    make_interpolate,
    make_linear_step,
    make_motion_error,
    make_runge_kutta,
    next_step,
)
from simulator.kernel.steps.stride import (
    MANY_STEPS,
    SHORTEST_S,
    STRETCH,
    approach,
    make_first_tick,
    make_longest_step,
    make_spare,
    note_extremes,
    step_share,
    stops_unseen,
)
from simulator.kernel.working_row import choose, lanes_in

Lanes = Any
"""A number of every lane, or whether something holds in each (`simulator.kernel.lanes.numbers`)."""
Row = Any
"""The working rows of all lanes, place by place."""


def make_tick(composition: Composition, wants_switch: Function) -> Function:
    """Compose `(active, work)`: the tick that is due, where it changes no phase and brings no force to its cap.

    Returns in which lanes it does.
    """
    rate, active_damping = composition.position["control_rate"], composition.has("active_damping_kg_m")
    capped, forces = composition.has("cap_n"), make_forces(composition)
    grow = make_growth(composition)

    @inner
    def tick(active: Lanes, work: Row) -> Lanes:
        number, time_s = work[TICK], work[TIME]
        due = active & (number / work[rate] <= time_s)
        if lanes_in(due) == 0:
            return due
        wanted = wants_switch(work, work[PHASE], NOW, work[LENGTH_UNIT], work[SPEED_UNIT])
        leaves = due & ((wanted > 0.0) | (number + 1.0 == work[DECIDED]) | ((number + 1.0) / work[rate] <= time_s))
        sampled = due & ~due
        if active_damping:
            sampled = due & (work[ACTIVE_DAMPING] > 0.0)
            before = work[SAMPLED_SPEED]
            work[SAMPLED_SPEED] = choose(sampled, max(0.0, -work[NOW + V_FOOT]), before)
            if capped:
                commanded_n, _, most_n = forces(work, NOW)
                sign = choose(abs(commanded_n) <= most_n, 0.0, choose(commanded_n > 0.0, 1.0, -1.0))
                leaves |= sampled & (sign != work[SATURATED])
            work[SAMPLED_SPEED] = choose(leaves, before, work[SAMPLED_SPEED])
            grow(sampled & ~leaves, work)
        near = due & ~leaves & (abs(wanted) < min(work[MARGIN], NEAR_PEAK)) & (number > 0.0)
        work[MARGIN], work[MARGIN_TICK] = (
            choose(near, abs(wanted), work[MARGIN]),
            choose(near, number, work[MARGIN_TICK]),
        )
        work[TICK] = choose(due & ~leaves, number + 1.0, number)
        work[STALE] = choose(sampled & ~leaves, 1.0, work[STALE])
        return leaves

    return tick


def make_ticks_within(composition: Composition, wants_switch: Function) -> Function:
    """Compose `(h, until, considered, work)`: look at the ticks inside a step at which a decision may be near.

    Returns in which lanes the phase changes at one; in the others the ticks are passed.
    """
    rate, interpolate = composition.position["control_rate"], make_interpolate(composition)
    spare, first_tick = make_spare(composition), make_first_tick(composition)

    @inner
    def ticks_within(h: Lanes, until: Lanes, considered: Lanes, work: Row) -> tuple[Lanes, Lanes, Lanes, Lanes, Lanes]:
        number, margin, margin_tick, leaves = work[TICK], work[MARGIN], work[MARGIN_TICK], considered & ~considered
        left = work[SPARE]
        inside = considered & (number / work[rate] < until)
        if lanes_in(inside) == 0:
            return leaves, number, margin, margin_tick, 0.0 * h
        nearer = approach(h, work)
        if lanes_in(inside & (left < nearer)) != 0:
            wanted = wants_switch(work, work[PHASE], NOW, work[LENGTH_UNIT], work[SPEED_UNIT])
            left = choose(left < nearer, spare(wanted, work, NOW), left)
        number = choose(inside & (left >= nearer), max(number, first_tick(until, work)), number)
        after = choose(inside, max(left - nearer, 0.0), 0.0)
        while True:
            tick_s = number / work[rate]
            inside = considered & ~leaves & (tick_s < until)
            if lanes_in(inside) == 0:
                return leaves, number, margin, margin_tick, after
            interpolate(h, (tick_s - work[TIME]) / h, work, BETWEEN)
            wanted = wants_switch(work, work[PHASE], BETWEEN, work[LENGTH_UNIT], work[SPEED_UNIT])
            leaves |= inside & (wanted > 0.0)
            near = inside & (abs(wanted) < min(margin, NEAR_PEAK))
            margin, margin_tick = choose(near, abs(wanted), margin), choose(near, number, margin_tick)
            far_s = tick_s + spare(wanted, work, BETWEEN) / nearer * h
            number = choose(inside, max(number + 1.0, first_tick(min(until, far_s), work)), number)

    return ticks_within


GUARDS = 6
"""Guards a mode, in its own order: the leg is folded, straight; the foot stops or touches; in the ground the cone is
complete, in the air the foot clears; the body falls; the force reaches its cap."""
PROMPT = {INTRUDING: (0, 1, 2, 5), FLIGHT: (0, 1, 2, 3, 5)}
"""Those that are never positive while the mode lasts."""
AT_START, AT_QUARTER, AT_HALF, AT_THREE_QUARTERS, AT_END = places(PERSISTENT, PERSISTENT + 5 * GUARDS, GUARDS)
"""Places of the guards' values at the start of a step, inside it and at its end."""


def make_guards(composition: Composition, mode: int) -> Function:
    """Compose `(work, row, place)`: the guards of the mode at the state at `row`."""
    forces = make_forces(composition)
    upper, lower = composition.position["upper_link"], composition.position["lower_link"]
    capped, flying = composition.has("cap_n"), mode == FLIGHT
    (cone,) = composition.effect_guards  # no other scenes are in lanes
    is_complete = cone.value
    ends, levered = composition.straight_ends_flight, composition.levered

    @inlined
    def guards(work: Row, row: int, place: int) -> None:
        length_m = work[row + X_BODY] - work[row + X_FOOT]
        work[place] = work[lower] - work[upper] - length_m
        beyond_m = length_m - work[upper] - work[lower]
        work[place + 1] = beyond_m
        if flying:
            if levered and not ends:
                work[place + 1] = choose(work[BEYOND] == 0.0, beyond_m, -beyond_m)
            elif not ends:
                work[place + 1] = -1.0
            clear, height_m = work[CLEARED] == CLEAR, work[row + X_FOOT]
            work[place + 2] = choose(clear, -height_m, work[DEEPEST] - height_m)
            work[place + 3] = choose(clear, -1.0, height_m)
            work[place + 4] = -work[row + V_BODY]
        else:
            work[place + 2] = work[row + V_FOOT]
            work[place + 3] = is_complete(work, row)
            work[place + 4] = -1.0
        work[place + 5] = -1.0
        if capped:
            commanded_n, _, most_n = forces(work, row)
            work[place + 5] = beyond_cap(work[SATURATED], commanded_n, most_n)

    return guards


@inlined
def rises(before: int, after: int, work: Row) -> Lanes:
    """Whether some guard rises through zero between two nodes."""
    found = work[before] < work[before]
    for guard in range(GUARDS):
        found |= (work[before + guard] <= 0.0) & (work[after + guard] > 0.0)
    return found


@inlined
def peaks(earlier: int, before: int, after: int, near: int, work: Row) -> Lanes:
    """Whether some guard comes near zero between three nodes, as `simulator.kernel.events.first_event.peaks` has it.

    The first `near` guards are lengths, of which it is noted how near.
    """
    found = work[before] < work[before]
    for guard in range(GUARDS):
        distance = work[NEAR + FOLDS] if guard < near else 0.0
        found |= may_peak(work[earlier + guard], work[before + guard], work[after + guard], distance)
    return found


def make_events(composition: Composition, mode: int, guards: Function, *, exact: bool) -> Function:
    """Compose `(h, omega, considered, work)`: whether something may happen in the step, in considered lanes."""
    fit, interpolate = make_fit_quintics(composition), make_interpolate(composition)
    near = 2 if mode == INTRUDING else 3

    @inlined
    def place(h: Lanes, share: float, work: Row, row: int) -> None:
        if not exact:  # a closed form has put it there already
            interpolate(h, share, work, row)

    @inner
    def events(h: Lanes, omega: Lanes, considered: Lanes, work: Row) -> Lanes:
        fit(h, work)
        longest = step_share(work, mode)
        four, two = h * omega > 0.5 * longest, h * omega > 0.25 * longest
        if exact:
            four = two = considered
        guards(work, TRIAL, AT_END)
        found = rises(AT_START, AT_END, work) & ~two
        if lanes_in(two & considered) != 0:
            place(h, 0.5, work, HALF)
            guards(work, HALF, AT_HALF)
            halves = rises(AT_START, AT_HALF, work) | rises(AT_HALF, AT_END, work)
            found |= (halves | peaks(AT_START, AT_HALF, AT_END, near, work)) & two & ~four
            if lanes_in(four & considered) != 0:
                place(h, 0.25, work, QUARTER)
                guards(work, QUARTER, AT_QUARTER)
                place(h, 0.75, work, THREE_QUARTERS)
                guards(work, THREE_QUARTERS, AT_THREE_QUARTERS)
                first = rises(AT_START, AT_QUARTER, work) | rises(AT_QUARTER, AT_HALF, work)
                first |= peaks(AT_START, AT_QUARTER, AT_HALF, near, work)
                second = rises(AT_HALF, AT_THREE_QUARTERS, work) | rises(AT_THREE_QUARTERS, AT_END, work)
                second |= peaks(AT_HALF, AT_THREE_QUARTERS, AT_END, near, work)
                found |= (first | second) & four
        return found & considered

    return events


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
        leaves |= active & ((work[STEPS] >= work[STEPS_ALLOWED]) | (t >= last_s))
        work[SPARE] = choose(work[STALE] == 1.0, 0.0, work[SPARE])
        rates_of(mode, t, work, NOW, K1)
        guards(work, NOW, AT_START)
        for guard in prompt:
            leaves |= active & (work[AT_START + guard] > 0.0)
        omega = frequency(work, mode, max(-work[NOW + X_FOOT], 0.0), work[STIFFNESS])
        if intruding:
            leaves |= active & stops_unseen(omega, work)
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
        number, margin, margin_tick, left = work[TICK], work[MARGIN], work[MARGIN_TICK], work[SPARE]
        if intruding:
            switches, number, margin, margin_tick, left = ticks_within(h, after_s, taken & ~leaves, work)
            leaves |= switches
        tried = active & ~leaves
        taken = tried & accepted
        work[STEPS] = choose(tried, work[STEPS] + 1.0, work[STEPS])
        counted = work[EVALUATIONS] + evaluations + choose(work[STALE] == 1.0, 1.0, 0.0)
        work[EVALUATIONS] = choose(tried, counted, work[EVALUATIONS])
        proposal_s = next_step(h, error)
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
            work[TICK], work[SPARE] = choose(taken, number, work[TICK]), choose(taken, left, work[SPARE])
            work[MARGIN], work[MARGIN_TICK] = (
                choose(taken, margin, work[MARGIN]),
                choose(taken, margin_tick, work[MARGIN_TICK]),
            )
        return lanes_in(leaves)

    return step
