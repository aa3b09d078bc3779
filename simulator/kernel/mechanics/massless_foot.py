"""A foot without inertia on the emulator: below a gram or so it takes the speed that the platform gives it.

    F(w) + k z + alpha w + beta w^2 - m_f g = -m_f dw/dt        z the depth, w the speed of sinking, F tension positive

The foot's speed settles in m_f / alpha, far faster than anything else moves; explicit steps would have to be as short.
Here it is the root of the equation, with dw/dt taken from the root without inertia: the error is of second order in the
settling time.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from simulator.basics import GRAVITY_M_S2
from simulator.compiled import inner
from simulator.effects.effect import Function
from simulator.kernel.composition import Composition, made_once
from simulator.kernel.layout import (
    CREEPING,
    INTRUDING,
    MODE,
    NOW,
    STALE,
    STIFFNESS,
    TOLERANCE,
    V_BODY,
    V_FOOT,
    X_BODY,
    X_FOOT,
)
from simulator.kernel.mechanics.body import make_body_acceleration
from simulator.kernel.mechanics.leg import make_command, make_lever

Row = NDArray[np.float64]
NUDGE_S = 1e-5
LEAVING = 2.0
"""A foot that follows does so until its lag is a little larger than one that would begin to."""


@inner
def _root(square: float, linear: float, constant: float) -> float:
    """Positive root of a polynomial that is negative at 0 and rises."""
    if constant >= 0.0:
        return 0.0
    spread = math.sqrt(max(linear * linear - 4.0 * square * constant, 0.0))
    if linear >= 0.0:
        return -2.0 * constant / (linear + spread)
    return (spread - linear) / (2.0 * square)


def make_speed(composition: Composition) -> Function:
    """Compose `(work, x_b, v_b, x_f, inertia_n)`: the speed of sinking at which the forces on the foot sum to that."""
    command, lever = make_command(composition), make_lever(composition)
    has_cap, cap_n = composition.has("cap_n"), composition.slot("cap_n")
    resistance_n, linear_kg_s = composition.slots["resistance_n"], composition.slots["linear_drag_kg_s"]
    quadratic_kg_m = composition.slots["quadratic_drag_kg_m"]
    foot = composition.position["foot_mass"]

    @inner
    def speed(work: Row, x_b: float, v_b: float, x_f: float, inertia_n: float) -> float:
        length_m, depth_m = x_b - x_f, -x_f
        still_n = command(work, length_m, v_b, 0.0)
        slow_n = command(work, length_m, v_b + 1.0, -1.0)
        fast_n = command(work, length_m, v_b + 2.0, -2.0)
        curved = 0.5 * (fast_n - 2.0 * slow_n + still_n)  # the leg's force is at most quadratic in the foot's speed
        sloped = slow_n - still_n - curved
        ground_n = resistance_n(work, depth_m) - work[foot] * GRAVITY_M_S2 + inertia_n
        drag, damping = quadratic_kg_m(work, depth_m), linear_kg_s(work)
        sinking = _root(curved + drag, sloped + damping, still_n + ground_n)
        if has_cap:
            most_n = cap_n(work, lever(work, length_m))
            force_n = still_n + (sloped + curved * sinking) * sinking
            if abs(force_n) > most_n:
                sinking = _root(drag, damping, math.copysign(most_n, force_n) + ground_n)
        return sinking

    return speed


@made_once
def make_follow_platform(composition: Composition) -> Function:
    """Compose `(work, row)`: velocity (m/s, up) and acceleration of a foot that follows."""
    if not composition.follows:
        return inner(lambda work, row: (0.0, 0.0))
    speed, command, lever = make_speed(composition), make_command(composition), make_lever(composition)
    has_cap, cap_n = composition.has("cap_n"), composition.slot("cap_n")
    foot, accelerate = composition.position["foot_mass"], make_body_acceleration(composition)

    @inner
    def follow_platform(work: Row, row: int) -> tuple[float, float]:
        x_b, v_b, x_f = work[row + X_BODY], work[row + V_BODY], work[row + X_FOOT]
        sinking = speed(work, x_b, v_b, x_f, 0.0)
        force_n = command(work, x_b - x_f, v_b + sinking, -sinking)
        if has_cap:
            most_n = cap_n(work, lever(work, x_b - x_f))
            force_n = min(max(force_n, -most_n), most_n)
        a_b = accelerate(CREEPING, work, row, force_n)
        moved_m, faster_m_s = NUDGE_S * v_b, NUDGE_S * a_b
        later = speed(work, x_b + moved_m, v_b + faster_m_s, x_f - NUDGE_S * sinking, 0.0)
        before = speed(work, x_b - moved_m, v_b - faster_m_s, x_f + NUDGE_S * sinking, 0.0)
        slower_m_s2 = -(later - before) / (2.0 * NUDGE_S)
        return -speed(work, x_b, v_b, x_f, -work[foot] * slower_m_s2), slower_m_s2

    return follow_platform


def make_try_to_follow(composition: Composition) -> Function:
    """Compose `(work)`: let an intruding foot follow, once its speed has settled and where its inertia is too small to
    be seen at the error allowed; and no longer where its speed changes so fast that it lags.
    """
    if not composition.follows:
        return inner(lambda work: None)
    follow_platform = make_follow_platform(composition)
    damping, stiffness = composition.slots["linear_drag_kg_s"], composition.slots["resistance_slope_n_m"]
    foot, body = composition.position["foot_mass"], composition.position["body_mass"]
    per_lift = composition.position["inverse_lift_energy"]

    @inner
    def lag(work: Row, velocity_m_s: float, acceleration_m_s2: float) -> float:
        changing = math.sqrt((stiffness(work, -work[NOW + X_FOOT]) + work[STIFFNESS]) / work[body])
        changing = max(changing, abs(acceleration_m_s2) / (abs(velocity_m_s) + 1e-300))
        return work[foot] * changing / (damping(work) + 1e-300)

    @inner
    def try_to_follow(work: Row) -> None:
        if work[MODE] != INTRUDING and work[MODE] != CREEPING:
            return
        velocity_m_s, acceleration_m_s2 = follow_platform(work, NOW)
        lagging = lag(work, velocity_m_s, acceleration_m_s2)
        if work[MODE] == CREEPING:
            if lagging * lagging > LEAVING * work[TOLERANCE]:
                work[MODE], work[STALE] = INTRUDING, 1
            return
        if lagging * lagging > work[TOLERANCE]:
            return
        apart_m_s = abs(work[NOW + V_FOOT] - velocity_m_s)
        lost = work[foot] * -velocity_m_s * apart_m_s * work[per_lift]  # of the energy that errors are measured by
        settled = apart_m_s < math.sqrt(work[TOLERANCE]) * -velocity_m_s
        if velocity_m_s < 0.0 and settled and lost < work[TOLERANCE]:
            work[MODE], work[STALE] = CREEPING, 1
            work[NOW + V_FOOT] = velocity_m_s

    return try_to_follow
