"""One step: chosen, tried, cut at the first event or deciding tick, and accepted or rejected."""

from __future__ import annotations

import math

import numpy as np

from simulator.compiled import Function, Row, inlined, inner
from simulator.kernel.composition import Composition
from simulator.kernel.control.controller import make_must_land, make_timer
from simulator.kernel.events.first_event import make_at_once, make_first_event, make_land
from simulator.kernel.events.guards import make_guards
from simulator.kernel.layout import (
    ACTIVE_DAMPING,
    ALLOWED,
    ASLEEP,
    BETWEEN,
    COMPRESSION,
    CREEPING,
    DAMPING,
    DECIDED,
    EVALUATIONS,
    FLIGHT,
    FRESH,
    INTRUDING,
    K1,
    K7,
    LENGTH_UNIT,
    LONGEST,
    LOWEST,
    MARGIN,
    MARGIN_TICK,
    MODE,
    NOW,
    PHASE,
    QUINTICS,
    SAMPLED_SPEED,
    SATURATED,
    SHORTEST,
    SPARE,
    SPEED_UNIT,
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
    V_BODY,
    V_FOOT,
    X_BODY,
    X_FOOT,
)
from simulator.kernel.limits import (
    EVENT_SHARE,
    FINEST_TOLERANCE,
    FIXED_STEP_S,
    FLIP_TICK,
    LONGEST_FLIGHT_S,
    LONGEST_STANCE_S,
    NEAR_PEAK,
)
from simulator.kernel.mechanics.leg import make_lever
from simulator.kernel.mechanics.motion import make_moved_mass, make_rates
from simulator.kernel.steps.attempt import (
    interpolate,
    make_attempt,
    make_error_norm,
    make_frequency,
    make_held_foot_motion,
    make_interpolate,
    make_is_linear,
    make_sample_nodes,
    next_step,
)
from simulator.kernel.working_row import choose, lanes_in

FRESH_SHARE = 0.2
"""First step after the ground yields or the foot leaves it, in units of the foot's time scale: shorter than an
intrusion that ends at once."""
QUIET_SHARE, LONGEST_QUIET_STEP_S = 0.1, 0.02
SPARED = 2.0
"""Distance that decisions keep to be passed unseen, in units of the largest that is noted: rounding is far less."""
STABLE_SHARE = 2.7
"""Longest step in units of the fastest damping: the method is stable to 3.3."""
INTRUDING_SHARE, SMOOTH_SHARE = 1.5, 0.7
"""Longest steps of a foot in the ground and otherwise, in the same units: no guard rises and falls unseen inside
one.
"""
TURNS, TURNED = 30, 1e-8
"""Most steps of Newton's to where leg or body turns, and the share of a step to which that is found; heights there err
by the square of it."""


def make_damping_rate(composition: Composition) -> Function:
    """Fastest rate at which dampers change the foot's speed, 1/s: `(work, mode)`, in flight and intruding."""
    foot = composition.position["foot_mass"]
    damped, held = composition.has("compression_damping_kg_s"), composition.on("held_force")
    active, linear = composition.has("active_damping_kg_m"), composition.on("linear_active_damping")
    sampled = composition.samples_speed
    has_quadratic, quadratic = composition.optional("quadratic_drag_kg_m")
    has_linear, drag_kg_s = composition.optional("linear_drag_kg_s")
    product, follows = active and sampled and not linear, active and not sampled
    slows, cap_n, lever = composition.has("cap_slows"), composition.slot("cap_n"), make_lever(composition)
    moved_mass_kg = make_moved_mass(composition)

    @inner
    def of_leg(work: Row, mode: float) -> float:
        damping = 0.0 * work[STIFFNESS]
        if slows and abs(work[SATURATED]) == 1.0:
            arm_m = lever(work, work[NOW + X_BODY] - work[NOW + X_FOOT])
            return cap_n(work, arm_m, 0.0) - cap_n(work, arm_m, 1.0)
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


@inlined
def _pace(at: int, work: Row) -> tuple[float, float]:
    """The most that a height changes by in a step's time, anywhere within the step, and its speed, times the step."""
    c2, c3, c4, c5 = abs(work[at + 2]), abs(work[at + 3]), abs(work[at + 4]), abs(work[at + 5])
    height = abs(work[at + 1]) + 2.0 * c2 + 3.0 * c3 + 4.0 * c4 + 5.0 * c5
    return height, 2.0 * c2 + 6.0 * c3 + 12.0 * c4 + 20.0 * c5


@inlined
def approach(h: float, work: Row) -> float:
    """The most by which a decision comes nearer within a step, in local errors, at an even pace.

    The rule takes the least and the largest of heights and speeds in their units, so that it changes no faster than
    these do: by the sizes of the dense output's coefficients.
    """
    (body_m, faster_body), (foot_m, faster_foot) = _pace(QUINTICS, work), _pace(QUINTICS + 6, work)
    return max((body_m + foot_m) / work[LENGTH_UNIT], (faster_body + faster_foot) / (h * work[SPEED_UNIT]), 1.0)


def make_spare(composition: Composition) -> Function:
    """Compose `(wish, work, row)`: how far the next decision is beyond what is noted at a state, in local errors."""
    latched = composition.on("latched_switching")

    @inlined
    def spare(wish: float, work: Row, row: int) -> float:
        distance = -wish
        if not latched:  # extension ends too where the foot comes out of the ground, which its wish does not foretell
            depth = -work[row + X_FOOT] / work[LENGTH_UNIT]
            distance = choose(work[PHASE] == COMPRESSION, distance, min(distance, depth))
        return max(distance - SPARED * NEAR_PEAK, 0.0)

    return spare


def make_first_tick(composition: Composition) -> Function:
    """Compose `(time_s, work)`: the number of the first tick that is not before this."""
    rate = composition.position.get("control_rate", -1)

    @inlined
    def first_tick(time_s: float, work: Row) -> float:
        number = math.floor(time_s * work[rate]) + 0.0
        return choose(number / work[rate] < time_s, number + 1.0, number)

    return first_tick


def make_deciding_tick(composition: Composition, wants_switch: Function) -> Function:
    """Find the first tick inside a step at which the phase changes: `(h, until, work, flip_tick)`.

    Returns its time, or infinity; ticks passed without a change count as decided, with their margins. Those before
    which no decision can come near are not looked at.
    """
    rate = composition.position.get("control_rate", -1)
    decays_fast, move = make_held_foot_motion(composition)
    spare, first_tick = make_spare(composition), make_first_tick(composition)

    @inner
    def deciding_tick(h: float, until: float, work: Row, flip_tick: float) -> float:
        left = work[SPARE]
        work[SPARE] = 0.0
        if not work[TICK] / work[rate] < until:
            return np.inf
        fast, nearer = decays_fast(h, work), np.inf
        if not (fast or flip_tick >= 0.0 or work[MODE] == CREEPING):
            nearer = approach(h, work)
            if left < nearer:
                wish = wants_switch(work, work[PHASE], NOW, work[LENGTH_UNIT], work[SPEED_UNIT])
                left = spare(wish, work, NOW)
            if left >= nearer:
                work[TICK], work[SPARE] = max(work[TICK], first_tick(until, work)), left - nearer
                return np.inf
        while work[TICK] / work[rate] < until:
            tick_s = work[TICK] / work[rate]
            if fast:
                move(tick_s - work[TIME], work, BETWEEN)
            else:
                interpolate(h, (tick_s - work[TIME]) / h, work, BETWEEN)
            wish = wants_switch(work, work[PHASE], BETWEEN, work[LENGTH_UNIT], work[SPEED_UNIT])
            if (wish > 0.0) != (work[TICK] == flip_tick) and tick_s > work[TIME]:
                return tick_s
            if abs(wish) < min(work[MARGIN], NEAR_PEAK):
                work[MARGIN], work[MARGIN_TICK] = abs(wish), work[TICK]
            far_s = tick_s + spare(wish, work, BETWEEN) / nearer * h
            work[TICK] = max(work[TICK] + 1.0, first_tick(min(until, far_s), work))
        return np.inf

    return deciding_tick


@inlined
def _speed(share: float, at: int, work: Row) -> tuple[float, float]:
    """A height's speed at a share of the step, times the step, and its rate of change over shares."""
    c2, c3, c4, c5 = 2.0 * work[at + 2], 3.0 * work[at + 3], 4.0 * work[at + 4], 5.0 * work[at + 5]
    speed = work[at + 1] + share * (c2 + share * (c3 + share * (c4 + share * c5)))
    return speed, c2 + share * (2.0 * c3 + share * (3.0 * c4 + share * 4.0 * c5))


@inlined
def turn(h: float, which: bool, before: float, after: float, foot: float, work: Row) -> None:
    """Put the motion into `BETWEEN` where a speed that changes its sign within the step is 0, by Newton's steps between
    ends that close in.

    It is that of the body, or of the leg's length where the foot's speed counts too: `foot` is 0 or 1.
    """
    low, high, share = 0.0 * h, 0.0 * h + 1.0, before / (before - after)
    for _ in range(TURNS):
        (of_body, body_rate), (of_foot, foot_rate) = _speed(share, QUINTICS, work), _speed(share, QUINTICS + 6, work)
        speed = of_body - foot * of_foot
        earlier = before * speed > 0.0
        low, high = choose(earlier, share, low), choose(earlier, high, share)
        closer = share - speed / (body_rate - foot * foot_rate)
        closer = choose((low <= closer) & (closer <= high), closer, 0.5 * (low + high))
        closer = choose(which, closer, share)  # a lane that is there waits for its neighbours
        which, share = which & (abs(closer - share) > TURNED), closer
        if lanes_in(which) == 0:
            break
    interpolate(h, share, work, BETWEEN)


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
        turn(h, turns, before, after, 0.0, work)
        work[LOWEST] = choose(turns, min(work[LOWEST], work[BETWEEN + X_BODY]), work[LOWEST])
    before, after = before - work[NOW + V_FOOT], after - work[TRIAL + V_FOOT]
    turns = which & (before * after < 0.0)
    if lanes_in(turns) != 0:
        turn(h, turns, before, after, 1.0, work)
        length_m = work[BETWEEN + X_BODY] - work[BETWEEN + X_FOOT]
        shortest, longest = (
            choose(turns, min(shortest, length_m), shortest),
            choose(turns, max(longest, length_m), longest),
        )
    work[SHORTEST], work[LONGEST] = choose(which, shortest, work[SHORTEST]), choose(which, longest, work[LONGEST])


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
def stops_unseen(omega: float, work: Row) -> bool:
    """Whether the ground stops an intruding foot in less time than a step may be short."""
    sinking = -work[NOW + V_FOOT]
    return (sinking > 0.0) & (max(work[K1 + V_FOOT], sinking * omega) * SHORTEST_S > sinking)


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
            work[STALE], work[SPARE] = 0, 0.0
        omega = frequency(work, mode, max(-work[NOW + X_FOOT], 0.0), work[STIFFNESS])
        stopping = mode == INTRUDING and stops_unseen(omega, work)
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
