"""One attempted step in any mode, its dense output, and its error in units of what is allowed."""

from __future__ import annotations

import math

import numpy as np

from simulator.compiled import Function, Row, inner
from simulator.kernel.combined import largest
from simulator.kernel.composition import Composition, made_once
from simulator.kernel.layout import (
    ACTIVE_DAMPING,
    ASLEEP,
    CREEPING,
    DAMPING,
    ERROR,
    EVALUATIONS,
    FLIGHT,
    HALF,
    INTRUDING,
    JAMMED,
    K1,
    K2,
    K3,
    K4,
    K5,
    K6,
    K7,
    LEG_WORK,
    MODE,
    NOW,
    QUARTER,
    QUINTICS,
    SAMPLED_SPEED,
    SATURATED,
    SLIDES,
    STIFFNESS,
    THREE_QUARTERS,
    TRIAL,
    V_BODY,
    V_FOOT,
    WIDTH,
    X_BODY,
    X_FOOT,
)
from simulator.kernel.mechanics.motion import make_moved_mass
from simulator.kernel.working_row import choose, lanes_in, per_fifth_root_guess
from simulator.parameter import GRAVITY_M_S2

ORDER = 5


def make_runge_kutta(composition: Composition, rates_of: Function) -> Function:
    """Compose the step `(mode, t, h, work)`.

    The place `K1` holds the rates at the start; `TRIAL`, `K7` and `ERROR` receive the state at the end, the rates
    there and its estimated error.
    """
    size = composition.state_size
    acting_later = composition.platform >= 0 or composition.effect_states  # they follow the integrals
    moving = size if acting_later else LEG_WORK

    @inner
    def step(mode: int, t: float, h: float, work: Row) -> None:
        for i in range(moving):
            work[TRIAL + i] = work[NOW + i] + h * 0.2 * work[K1 + i]
        rates_of(mode, t + 0.2 * h, work, TRIAL, K2)
        for i in range(moving):
            work[TRIAL + i] = work[NOW + i] + h * (3.0 / 40.0 * work[K1 + i] + 9.0 / 40.0 * work[K2 + i])
        rates_of(mode, t + 0.3 * h, work, TRIAL, K3)
        for i in range(moving):
            work[TRIAL + i] = work[NOW + i] + h * (
                44.0 / 45.0 * work[K1 + i] - 56.0 / 15.0 * work[K2 + i] + 32.0 / 9.0 * work[K3 + i]
            )
        rates_of(mode, t + 0.8 * h, work, TRIAL, K4)
        for i in range(moving):
            work[TRIAL + i] = work[NOW + i] + h * (
                19372.0 / 6561.0 * work[K1 + i]
                - 25360.0 / 2187.0 * work[K2 + i]
                + 64448.0 / 6561.0 * work[K3 + i]
                - 212.0 / 729.0 * work[K4 + i]
            )
        rates_of(mode, t + h * (8.0 / 9.0), work, TRIAL, K5)
        for i in range(moving):
            work[TRIAL + i] = work[NOW + i] + h * (
                9017.0 / 3168.0 * work[K1 + i]
                - 355.0 / 33.0 * work[K2 + i]
                + 46732.0 / 5247.0 * work[K3 + i]
                + 49.0 / 176.0 * work[K4 + i]
                - 5103.0 / 18656.0 * work[K5 + i]
            )
        rates_of(mode, t + h, work, TRIAL, K6)
        for i in range(size):
            work[TRIAL + i] = work[NOW + i] + h * (
                35.0 / 384.0 * work[K1 + i]
                + 500.0 / 1113.0 * work[K3 + i]
                + 125.0 / 192.0 * work[K4 + i]
                - 2187.0 / 6784.0 * work[K5 + i]
                + 11.0 / 84.0 * work[K6 + i]
            )
        rates_of(mode, t + h, work, TRIAL, K7)
        for i in range(size):
            work[ERROR + i] = h * (
                71.0 / 57600.0 * work[K1 + i]
                - 71.0 / 16695.0 * work[K3 + i]
                + 71.0 / 1920.0 * work[K4 + i]
                - 17253.0 / 339200.0 * work[K5 + i]
                + 22.0 / 525.0 * work[K6 + i]
                - 1.0 / 40.0 * work[K7 + i]
            )

    return step


@inner
def _fit(h: float, work: Row, x: int, at: int) -> None:
    """Coefficients in powers of the share of the step, at the place `at`, of the height that is the state `x`."""
    v0, a0, v1, a1 = work[K1 + x] * h, work[K1 + x + 1] * h * h, work[K7 + x] * h, work[K7 + x + 1] * h * h
    d = work[TRIAL + x] - work[NOW + x] - v0 - 0.5 * a0
    e = v1 - v0 - a0
    f = a1 - a0
    work[at] = work[NOW + x]
    work[at + 1] = v0
    work[at + 2] = 0.5 * a0
    work[at + 3] = 10.0 * d - 4.0 * e + 0.5 * f
    work[at + 4] = -15.0 * d + 7.0 * e - f
    work[at + 5] = 6.0 * d - 3.0 * e + 0.5 * f


@inner
def _evaluate(h: float, s: float, work: Row, at: int, place: int) -> None:
    c1, c2, c3, c4, c5 = work[at + 1], work[at + 2], work[at + 3], work[at + 4], work[at + 5]
    work[place] = work[at] + s * (c1 + s * (c2 + s * (c3 + s * (c4 + s * c5))))
    work[place + 1] = (c1 + s * (2.0 * c2 + s * (3.0 * c3 + s * (4.0 * c4 + s * 5.0 * c5)))) / h


@inner
def interpolate(h: float, s: float, work: Row, row: int) -> None:
    """Write heights and speeds of body and foot at a share `s` of the step at the place `row`."""
    _evaluate(h, s, work, QUINTICS, row + X_BODY)
    _evaluate(h, s, work, QUINTICS + 6, row + X_FOOT)


@made_once
def make_interpolate(composition: Composition) -> Function:
    """Compose `(h, s, work, row)`, which also writes the states of effects, and those of a platform that can slide."""
    if composition.platform < 0 and not composition.effect_states:
        return interpolate
    platform, slides = composition.platform, composition.platform >= 0
    first, end = composition.integrals_end, composition.integrals_end + len(composition.effect_states)

    @inner
    def interpolate_all(h: float, s: float, work: Row, row: int) -> None:
        interpolate(h, s, work, row)
        for i in range(first, end):  # the cubic of state and rate at both ends
            rise, r0, r1 = work[TRIAL + i] - work[NOW + i], h * work[K1 + i], h * work[K7 + i]
            bend, turn = 3.0 * rise - 2.0 * r0 - r1, r0 + r1 - 2.0 * rise
            work[row + i] = work[NOW + i] + s * (r0 + s * (bend + s * turn))
        if slides:
            _evaluate(h, s, work, QUINTICS + 12, row + platform)

    return interpolate_all


def make_fit_quintics(composition: Composition) -> Function:
    """Compose `(h, work)`: fit the dense output to states and rates at both ends.

    Velocities are taken from the rates: a foot that creeps has one there only.
    """
    platform, slides = composition.platform, composition.platform >= 0

    @inner
    def fit_quintics(h: float, work: Row) -> None:
        _fit(h, work, X_BODY, QUINTICS)
        _fit(h, work, X_FOOT, QUINTICS + 6)
        if slides:
            _fit(h, work, platform, QUINTICS + 12)

    return fit_quintics


@inner
def oscillator(rate_1_s: float, square_1_s2: float, t: float) -> tuple[float, float, float]:
    """Fundamental solutions of x'' + 2 rate x' + square x = 0 at t.

    Returns (c, s, d) such that, whatever constant force acts beside, v(t) = c v(0) + s a(0) and
    x(t) = x(0) + s v(0) + d (a(0) + 2 rate v(0)): v satisfies the same equation, and x is its integral.
    Stable from undamped to far overdamped.
    """
    discriminant = square_1_s2 - rate_1_s * rate_1_s
    spread = discriminant * t * t
    s, c = 0.0 * t, 0.0 * t
    near, rings, creeps = abs(spread) < 0.05, spread >= 0.05, spread <= -0.05
    if lanes_in(near) != 0:  # near critical damping or a short time: series of sin(x)/x and cos(x)
        decay = math.exp(-rate_1_s * t)
        sine = decay * t * (1.0 - spread / 6.0 * (1.0 - spread / 20.0 * (1.0 - spread / 42.0 * (1.0 - spread / 72.0))))
        cosine = 1.0 - spread / 2.0 * (
            1.0 - spread / 12.0 * (1.0 - spread / 30.0 * (1.0 - spread / 56.0 * (1.0 - spread / 90.0)))
        )
        s, c = choose(near, sine, s), choose(near, decay * cosine + rate_1_s * sine, c)
    if lanes_in(rings) != 0:
        omega, decay = math.sqrt(choose(rings, discriminant, 1.0)), math.exp(-rate_1_s * t)
        sine = decay * math.sin(omega * t) / omega
        s, c = choose(rings, sine, s), choose(rings, decay * math.cos(omega * t) + rate_1_s * sine, c)
    if lanes_in(creeps) != 0:
        kappa = math.sqrt(choose(creeps, -discriminant, 1.0))
        slow, fast = math.exp(-square_1_s2 / (rate_1_s + kappa) * t), math.exp(-(rate_1_s + kappa) * t)
        sine = (slow - fast) / (2.0 * kappa)
        s, c = choose(creeps, sine, s), choose(creeps, 0.5 * (slow + fast) + rate_1_s * sine, c)
    # d = (1 - c) / square loses digits where the motion has hardly begun: its series there
    begun = choose(square_1_s2 * t * t < 1e-6, rate_1_s * t, 1.0) < 1e-3
    d = (1.0 - c) / choose(begun, 1.0, square_1_s2)
    if lanes_in(begun) != 0:
        two = 2.0 * rate_1_s
        third, fourth = two * two - square_1_s2, two * (two * two - 2.0 * square_1_s2)
        d = choose(begun, t * t * (0.5 - t * (two / 6.0 - t * (third / 24.0 - t * fourth / 120.0))), d)
    return c, s, d


def make_coefficients(composition: Composition) -> Function:
    """Stiffness and damping of the leg while it is linear, 0 where its force is held or capped: `(held, saturated)`."""
    damped = composition.has("compression_damping_kg_s")
    sampled = composition.samples_speed
    product = composition.has("active_damping_kg_m") and sampled and not composition.on("linear_active_damping")
    constant = composition.on("held_force")

    @inner
    def coefficients(work: Row, saturated: bool) -> tuple[float, float]:
        if constant and work[MODE] != FLIGHT and work[ASLEEP] == 0:
            return 0.0, 0.0
        damping = 0.0
        if damped:
            damping = work[DAMPING]
        if product:
            damping += work[ACTIVE_DAMPING] * work[SAMPLED_SPEED]
        return choose(saturated, 0.0, work[STIFFNESS]), choose(saturated, 0.0, damping)

    return coefficients


@made_once
def make_is_linear(composition: Composition) -> Function:
    """Whether the motion has a closed form: `(mode, held, saturated)`."""
    bends, (holds, held) = composition.has("cap_bends"), composition.optional("body_held")
    jammed, flight = composition.closed_form("jammed"), composition.closed_form("flight")
    sampled = composition.samples_speed
    follows, slides = composition.has("active_damping_kg_m") and not sampled, composition.platform >= 0

    @inner
    def is_linear(mode: int, work: Row, saturated: bool) -> bool:
        if mode not in (JAMMED, FLIGHT) or (bends and saturated):
            return False
        if (mode == JAMMED and not jammed) or (mode == FLIGHT and not flight):
            return False
        if holds and held(work):
            return False
        if slides and work[SLIDES] == 1:
            return False
        return not (follows and mode == FLIGHT and work[ACTIVE_DAMPING] > 0.0)

    return is_linear


def make_held_foot_motion(composition: Composition) -> tuple[Function, Function]:
    """Compose the motion of the body over a foot that is held, where it is linear.

    `(h, work)`: whether it decays so fast within a step that the dense output passes over that; `(time_s, work, row)`:
    put heights and speeds so long after the start of the step at the place `row`.
    """
    per_body = composition.position["inverse_body_mass"]
    coefficients, is_linear = make_coefficients(composition), make_is_linear(composition)

    @inner
    def decays_fast(h: float, work: Row) -> bool:
        saturated = work[SATURATED] != 0.0
        if work[MODE] != JAMMED or not is_linear(JAMMED, work, saturated):
            return False
        return coefficients(work, saturated)[1] * work[per_body] * h > 1.0

    @inner
    def move(time_s: float, work: Row, row: int) -> None:
        stiffness, damping = coefficients(work, work[SATURATED] != 0.0)
        two_rate, square = damping * work[per_body], stiffness * work[per_body]
        c, s, d = oscillator(0.5 * two_rate, square, time_s)
        v_b, a_b = work[NOW + V_BODY], work[K1 + V_BODY]
        work[row + X_BODY] = work[NOW + X_BODY] + s * v_b + d * (a_b + two_rate * v_b)
        work[row + V_BODY] = c * v_b + s * a_b
        work[row + X_FOOT], work[row + V_FOOT] = work[NOW + X_FOOT], work[NOW + V_FOOT]

    return decays_fast, move


def make_linear_step(composition: Composition, rates_of: Function) -> Function:
    """Compose the step `(mode, t, h, work, saturated, states, k, error)`.

    As the Runge-Kutta step; the places `QUARTER` to `THREE_QUARTERS` receive the exact states inside it.
    """
    body, foot = composition.position["body_mass"], composition.position["foot_mass"]
    per_body, per_foot = composition.position["inverse_body_mass"], composition.position["inverse_foot_mass"]
    coefficients = make_coefficients(composition)
    size = composition.state_size

    @inner
    def step(mode: int, t: float, h: float, work: Row, saturated: bool) -> None:
        stiffness, damping = coefficients(work, saturated)
        flying = mode == FLIGHT
        inverse_kg = work[per_body] + work[per_foot] if flying else work[per_body]
        two_rate, square = damping * inverse_kg, stiffness * inverse_kg
        quarter = 0.25 * h
        c, s, d = oscillator(0.5 * two_rate, square, quarter)
        body_share = work[body] / (work[body] + work[foot])
        foot_share = 1.0 - body_share
        fall = body_share * work[K1 + V_BODY] + foot_share * work[K1 + V_FOOT]
        x_b, v_b, x_f, v_f = work[NOW + X_BODY], work[NOW + V_BODY], work[NOW + X_FOOT], work[NOW + V_FOOT]
        for node in range(4):
            stage = K1 + WIDTH * node
            if flying:
                length, speed, acceleration = x_b - x_f, v_b - v_f, work[stage + V_BODY] - work[stage + V_FOOT]
                centre_speed = body_share * v_b + foot_share * v_f
                centre = body_share * x_b + foot_share * x_f + quarter * (centre_speed + 0.5 * quarter * fall)
                centre_speed += quarter * fall
                length += s * speed + d * (acceleration + two_rate * speed)
                speed = c * speed + s * acceleration
                x_b, x_f = centre + foot_share * length, centre - body_share * length
                v_b, v_f = centre_speed + foot_share * speed, centre_speed - body_share * speed
            else:
                acceleration = work[stage + V_BODY]
                x_b += s * v_b + d * (acceleration + two_rate * v_b)
                v_b = c * v_b + s * acceleration
            row = TRIAL if node == 3 else QUARTER + WIDTH * node
            work[row + X_BODY], work[row + V_BODY], work[row + X_FOOT], work[row + V_FOOT] = x_b, v_b, x_f, v_f
            rates_of(mode, t + (node + 1) * quarter, work, row, stage + WIDTH)
        # of a power that dies away before the second state the rule counts too much by a share that Simpson's shows
        # but a fourteenth of: it weighs the first state with 7/90 instead of 7.5/90
        unseen = choose(two_rate * quarter > 1.0, 14.0, 1.0)
        for i in range(LEG_WORK):
            work[ERROR + i] = 0.0
            work[K7 + i] = work[K5 + i]
        for i in range(LEG_WORK, size):  # a platform that rests has rates of 0
            ends, quarters, middle = work[K1 + i] + work[K5 + i], work[K2 + i] + work[K4 + i], work[K3 + i]
            boole = h / 90.0 * (7.0 * ends + 32.0 * quarters + 12.0 * middle)
            work[TRIAL + i] = work[NOW + i] + boole
            work[ERROR + i] = unseen * (boole - h / 12.0 * (ends + 4.0 * quarters + 2.0 * middle))
            work[K7 + i] = work[K5 + i]

    return step


LARGEST = 1e150
DEPTH_WEIGHT = 2.0
"""The depth is a sum of errors of one sign, made while the foot is stopped by the ground."""


def make_attempt(composition: Composition, rates_of: Function) -> Function:
    """Compose `(t, h, work, k, error)`: closed form where there is one. Returns whether there was."""
    runge_kutta = make_runge_kutta(composition, rates_of)
    linear_step, is_linear = make_linear_step(composition, rates_of), make_is_linear(composition)

    @inner
    def attempt(t: float, h: float, work: Row) -> bool:
        mode, saturated = work[MODE], work[SATURATED] != 0.0
        if is_linear(mode, work, saturated):
            linear_step(mode, t, h, work, saturated)
            work[EVALUATIONS] += 4
            return True
        runge_kutta(mode, t, h, work)
        work[EVALUATIONS] += 6
        return False

    return attempt


def make_sample_nodes(composition: Composition) -> Function:
    """Compose `(h, nodes, exact, work)`: fit the dense output, and put the motion at as many nodes of the step as are
    looked at into their places, where a closed form has not.
    """
    fit_quintics, interpolate = make_fit_quintics(composition), make_interpolate(composition)

    @inner
    def sample_nodes(h: float, nodes: int, exact: bool, work: Row) -> None:
        fit_quintics(h, work)
        if exact:
            return
        if nodes > 1:
            interpolate(h, 0.5, work, HALF)
        if nodes > 2:
            interpolate(h, 0.25, work, QUARTER)
            interpolate(h, 0.75, work, THREE_QUARTERS)

    return sample_nodes


def make_frequency(composition: Composition) -> Function:
    """Fastest frequency of the foot in its mode, rad/s: `(work, mode, depth_m, stiffness_n_m)`."""
    foot, body = composition.position["foot_mass"], composition.position["body_mass"]
    has_ground, slope = composition.has("resistance_n"), composition.slot("resistance_slope_n_m")
    moved_mass_kg = make_moved_mass(composition)

    @inner
    def frequency(work: Row, mode: int, depth_m: float, stiffness_n_m: float) -> float:
        if mode == FLIGHT:
            return math.sqrt(stiffness_n_m / work[foot] + stiffness_n_m / work[body])
        if has_ground and mode == INTRUDING:
            return math.sqrt((stiffness_n_m + slope(work, depth_m)) / moved_mass_kg(work, depth_m))
        return math.sqrt(stiffness_n_m / work[body])

    return frequency


def make_motion_error(composition: Composition) -> Function:
    """Compose `(work, mode, h, omega)`: the largest relative error of heights and speeds of body and foot."""
    at = composition.position
    body, per_rest, per_fall = at["body_mass"], at["inverse_rest_length"], at["inverse_fall_speed"]
    has_ground, slope = composition.has("resistance_n"), composition.slot("resistance_slope_n_m")

    @inner
    def motion_error(work: Row, mode: int, h: float, omega: float) -> float:
        per_length, per_speed = work[per_rest], work[per_fall]
        worst = max(abs(work[ERROR + X_BODY]) * per_length, abs(work[ERROR + V_BODY]) * per_speed)
        if mode in (INTRUDING, CREEPING):
            depth_m = max(-work[TRIAL + X_FOOT], abs(work[NOW + V_FOOT]) * h)
            if has_ground:
                depth_m = max(depth_m, 1e-3 * work[body] * GRAVITY_M_S2 / slope(work, max(-work[NOW + X_FOOT], 0.0)))
            worst = max(worst, DEPTH_WEIGHT * abs(work[ERROR + X_FOOT]) / depth_m)
            foot_speed_m_s = max(abs(work[NOW + V_FOOT]), max(abs(work[TRIAL + V_FOOT]), 0.1 * depth_m * omega))
            worst = max(worst, abs(work[ERROR + V_FOOT]) / foot_speed_m_s)
        elif mode == FLIGHT:
            worst = max(worst, max(abs(work[ERROR + X_FOOT]) * per_length, abs(work[ERROR + V_FOOT]) * per_speed))
        return worst

    return motion_error


def make_effects_error(composition: Composition) -> Function:
    """Compose `(work)`: the largest error of a state of an effect, as a share of its typical size or its own."""
    errors = [_state_error(one.place, one.state.typical) for one in composition.effect_states]
    return largest([inner(lambda work: 0.0), *errors])


def _state_error(place: int, typical: float) -> Function:
    return inner(lambda work: abs(work[ERROR + place]) / max(typical, abs(work[TRIAL + place])))


def make_error_norm(composition: Composition) -> Function:
    """Largest error of a step in units of what is allowed: `(work, mode, h, tolerance, omega)`.

    Body: against the rest length and the speed of falling through it. Foot: against its own depth, so that a shallow
    print in stiff ground is as accurate as a deep one. Energies: against those of one body lifted by a leg. States of
    effects: against their typical size.
    """
    at, motion_error = composition.position, make_motion_error(composition)
    per_rest, per_fall, per_lift = at["inverse_rest_length"], at["inverse_fall_speed"], at["inverse_lift_energy"]
    platform, integrals_end, size = composition.platform, composition.integrals_end, composition.state_size
    effects_error = make_effects_error(composition)

    @inner
    def norm(work: Row, mode: int, h: float, tolerance: float, omega: float) -> float:
        for i in range(size):
            if not abs(work[TRIAL + i]) < LARGEST:  # the stages overflowed
                return np.inf
        per_length, per_speed, per_energy = work[per_rest], work[per_fall], work[per_lift]
        worst = motion_error(work, mode, h, omega)
        if platform >= 0:
            worst = max(worst, abs(work[ERROR + platform]) * per_length, abs(work[ERROR + platform + 1]) * per_speed)
        for i in range(LEG_WORK, integrals_end):
            lifts = abs(work[TRIAL + i]) * per_energy
            share = abs(work[ERROR + i]) * per_energy
            worst = max(worst, share / lifts if lifts > 1.0 else share)
        worst = max(worst, effects_error(work))
        return worst / tolerance

    return norm


@inner
def next_step(h: float, error_norm: float) -> float:
    """Step to take after one with this error, s: by the method's order, its power to 0.3 % by one step of Newton's."""
    error = max(error_norm, 1e-10)
    power = per_fifth_root_guess(error)
    square = power * power
    power = power * (1.2 - 0.2 * error * (square * square * power))
    return h * min(5.0, max(0.2, 0.9 * power))
