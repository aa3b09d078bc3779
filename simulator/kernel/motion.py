"""Equations of motion in every contact mode, with the integrals of the energy book as states of their own.

    body   m_b a_b = -F - m_b g (- rail friction)
    foot   (m_f + m_a) a_f = F + K + D w^2 (+ alpha w) - (m_f + m_a) g     intruding, w = -v_f
           m_f a_f = F - m_f g                                            flight
           at rest                                                        jammed

F is the leg's force, tension positive (`../docs/decisions.md` says how the book is kept).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from simulator.basics import GRAVITY_M_S2
from simulator.compiled import inner
from simulator.effects.effect import Function
from simulator.kernel.composition import Composition
from simulator.kernel.layout import (
    CARRIED,
    CREEPING,
    FLIGHT,
    INTRUDING,
    LEG_WORK,
    MECHANICAL,
    RAIL,
    V_BODY,
    V_FOOT,
    X_BODY,
    X_FOOT,
)
from simulator.kernel.leg import make_apply, make_command, make_lever
from simulator.kernel.platform import make_platform

Row = NDArray[np.float64]


def make_powers(composition: Composition) -> Function:
    """Rates of the drive's integrals: `(work, stage, lever_m, leg_speed_m_s, commanded_n, applied_n)`."""
    has_heat, has_drag = composition.has("heat_w"), composition.has("drag_w")
    heat_w, drag_w = composition.slot("heat_w"), composition.slot("drag_w")
    heat, drag = composition.integrals.get("heat", -1), composition.integrals.get("drag", -1)
    chosen = composition.slot("cost_force_n")
    choose = composition.has("cost_force_n")

    @inner
    def powers(work: Row, stage: int, lever_m: float, speed_m_s: float, commanded_n: float, applied_n: float) -> None:
        cost_n = chosen(work, lever_m, commanded_n, applied_n) if choose else applied_n
        work[stage + LEG_WORK] = -applied_n * speed_m_s
        work[stage + MECHANICAL] = -cost_n * speed_m_s
        if has_heat:
            work[stage + heat] = heat_w(work, lever_m, speed_m_s, cost_n)
        if has_drag:
            work[stage + drag] = drag_w(work, lever_m, speed_m_s, cost_n)

    return powers


def make_ground(composition: Composition) -> Function:
    """Acceleration of an intruding foot, and the rates of the ground's integrals: `(work, stage, applied_n, x_f,
    v_f)`.
    """
    foot = composition.position["foot_mass"]
    if not composition.has("resistance_n"):
        return inner(lambda work, stage, applied_n, x_f, v_f: 0.0)
    resistance_n = composition.slots["resistance_n"]
    quadratic, linear = composition.slot("quadratic_drag_kg_m"), composition.slot("linear_drag_kg_s")
    mass, mass_slope = composition.slot("added_mass_kg"), composition.slot("added_mass_slope_kg_m")
    has_quadratic, has_linear = composition.has("quadratic_drag_kg_m"), composition.has("linear_drag_kg_s")
    has_mass = composition.has("added_mass_kg")
    loss, grain = composition.integrals["ground_loss"], composition.integrals.get("grain_energy", -1)

    @inner
    def ground(work: Row, stage: int, applied_n: float, x_f: float, v_f: float) -> float:
        depth_m, sinking = -x_f, -v_f
        push_n = resistance_n(work, depth_m)
        if has_quadratic:
            push_n += quadratic(work, depth_m) * sinking * sinking
        if has_linear:
            push_n += linear(work) * sinking
        work[stage + loss] = push_n * sinking
        moved_kg = work[foot]
        if has_mass:
            added_kg = mass(work, depth_m)
            moved_kg += added_kg
            work[stage + grain] = sinking * (
                added_kg * GRAVITY_M_S2 + 0.5 * mass_slope(work, depth_m) * sinking * sinking
            )
        return (applied_n + push_n) / moved_kg - GRAVITY_M_S2

    return ground


def make_rates(composition: Composition) -> Function:
    """Rates of the whole state: `(mode, t, work, row, rates, stage)`.

    The state is at the place `row`; the rates are written at the place `stage`, every one of them.
    """
    foot = composition.position["foot_mass"]
    per_body, per_foot = composition.position["inverse_body_mass"], composition.position["inverse_foot_mass"]
    lever, command, apply = make_lever(composition), make_command(composition), make_apply(composition)
    powers, ground, creep = make_powers(composition), make_ground(composition), make_creep(composition)
    has_friction = composition.has("rail_friction_n")
    friction_n = composition.slot("rail_friction_n")
    friction = composition.integrals.get("friction_loss", -1)
    has_loss, loss = "ground_loss" in composition.integrals, composition.integrals.get("ground_loss", -1)
    has_grain, grain = "grain_energy" in composition.integrals, composition.integrals.get("grain_energy", -1)
    resistance_n = composition.slot("resistance_n")
    platform = make_platform(composition)
    emulated, reset_work = composition.has("travel_m"), composition.integrals.get("reset_work", -1)

    @inner
    def rates_of(mode: int, t: float, work: Row, row: int, stage: int) -> None:
        x_b, v_b = work[row + X_BODY], work[row + V_BODY]
        x_f, v_f = work[row + X_FOOT], work[row + V_FOOT]
        length_m, speed_m_s = x_b - x_f, v_b - v_f
        lever_arm_m = lever(work, length_m)
        commanded_n = command(work, length_m, speed_m_s, v_f)
        applied_n = apply(work, lever_arm_m, commanded_n)
        work[stage + X_BODY] = v_b
        work[stage + V_BODY] = -applied_n * work[per_body] - GRAVITY_M_S2
        if has_friction:
            sign = work[RAIL]
            work[stage + V_BODY] = (
                0.0 if sign == 0.0 else work[stage + V_BODY] - sign * friction_n(work) * work[per_body]
            )
            work[stage + friction] = friction_n(work) * sign * v_b
        if has_loss:
            work[stage + loss] = 0.0
        if has_grain:
            work[stage + grain] = 0.0
        if emulated:
            work[stage + reset_work] = 0.0
        if mode == FLIGHT:
            work[stage + X_FOOT] = v_f
            work[stage + V_FOOT] = applied_n * work[per_foot] - GRAVITY_M_S2
        elif mode == INTRUDING:
            work[stage + X_FOOT] = v_f
            work[stage + V_FOOT] = ground(work, stage, applied_n, x_f, v_f)
        else:
            work[stage + X_FOOT] = 0.0
            work[stage + V_FOOT] = 0.0
            if has_loss and mode == CREEPING:
                sinking = creep(work, length_m, v_b, work[stage + V_BODY], -x_f)
                work[stage + X_FOOT] = -sinking
                work[stage + loss] = resistance_n(work, -x_f) * sinking
            if emulated and mode == CARRIED:
                work[stage + X_FOOT] = v_f
                lifting_m_s2 = platform(work, t)[2]
                work[stage + V_FOOT] = lifting_m_s2
                work[stage + reset_work] = (work[foot] * (lifting_m_s2 + GRAVITY_M_S2) - applied_n) * v_f
        powers(work, stage, lever_arm_m, speed_m_s, commanded_n, applied_n)

    return rates_of


def make_creep(composition: Composition) -> Function:
    """Sinking speed of a foot that follows a rising force on very stiff ground, quasi-statically.

    From d/dt [F + K - (m_f + m_a) g] = 0 with the foot's speed left out of the leg's: K' z' = -(k v_b + b a_b) + ...
    """
    if not composition.has("resistance_n"):
        return inner(lambda work, length_m, v_b, a_b, depth_m: 0.0)
    slope = composition.slots["resistance_slope_n_m"]
    force_rate = make_force_rate(composition)
    has_mass, mass_slope = composition.has("added_mass_kg"), composition.slot("added_mass_slope_kg_m")

    @inner
    def creep(work: Row, length_m: float, v_b: float, a_b: float, depth_m: float) -> float:
        give_n_m = slope(work, depth_m)
        if has_mass:
            give_n_m -= mass_slope(work, depth_m) * GRAVITY_M_S2
        return -force_rate(work, length_m, v_b, a_b) / give_n_m

    return creep


def make_force_rate(composition: Composition) -> Function:
    """Rate of the applied force while the foot rests, N/s: `(work, length_m, v_b, a_b)`."""
    lever, command = make_lever(composition), make_command(composition)
    has_cap, bends, cap_n = composition.has("cap_n"), composition.has("cap_bends"), composition.slot("cap_n")
    nudge_m = 1e-6

    @inner
    def force_rate(work: Row, length_m: float, v_b: float, a_b: float) -> float:
        nudge_s = 1e-6
        before_n = command(work, length_m, v_b, 0.0)
        if has_cap:
            most_n = cap_n(work, lever(work, length_m))
            if abs(before_n) >= most_n:
                if bends:
                    ahead_n = cap_n(work, lever(work, length_m + nudge_m))
                    behind_n = cap_n(work, lever(work, length_m - nudge_m))
                    rate = (ahead_n - behind_n) / (2.0 * nudge_m) * v_b
                    return rate if before_n > 0.0 else -rate
                return 0.0
        after_n = command(work, length_m + v_b * nudge_s, v_b + a_b * nudge_s, 0.0)
        return (after_n - before_n) / nudge_s

    return force_rate
