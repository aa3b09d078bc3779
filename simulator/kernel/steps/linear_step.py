"""One step in closed form, where the leg is linear: the foot held (one oscillator) or in the air (a second, and a
ballistic centre of mass). The motion is exact; the integrals are taken by Boole's rule over five exact states, with the
difference to Simpson's rule as their error.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from simulator.compiled import inner
from simulator.effects.effect import Function
from simulator.kernel.composition import Composition, made_once
from simulator.kernel.layout import (
    ACTIVE_DAMPING,
    ASLEEP,
    DAMPING,
    ERROR,
    FLIGHT,
    JAMMED,
    K1,
    K2,
    K3,
    K4,
    K5,
    K7,
    LEG_WORK,
    MODE,
    NOW,
    QUARTER,
    SAMPLED_SPEED,
    SATURATED,
    SLIDES,
    STIFFNESS,
    TRIAL,
    V_BODY,
    V_FOOT,
    WIDTH,
    X_BODY,
    X_FOOT,
)
from simulator.kernel.steps.oscillator import oscillator
from simulator.kernel.working_row import choose

Row = NDArray[np.float64]


def make_coefficients(composition: Composition) -> Function:
    """Stiffness and damping of the leg while it is linear, 0 where its force is held or capped: `(held, saturated)`."""
    damped = composition.has("compression_damping_kg_s")
    sampled = composition.on("sampled_control") and not composition.on("continuous_foot_speed")
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
    bends, holds, held = composition.has("cap_bends"), composition.has("body_held"), composition.slot("body_held")
    jammed, flight = composition.closed_form("jammed"), composition.closed_form("flight")
    sampled = composition.on("sampled_control") and not composition.on("continuous_foot_speed")
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
