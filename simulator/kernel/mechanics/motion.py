"""Equations of motion in every contact mode, with the integrals of the energy book as states of their own.

    body   m_b a_b = -F - m_b g (+ forces of effects; at rest while one holds it)
    foot   (m_f + m_a) a_f = F + K + D w^2 (+ alpha w) - (m_f + m_a) g     intruding, w = -v_f
           m_f a_f = F - m_f g                                            flight
           at rest                                                        jammed

F is the leg's force, tension positive (`../docs/decisions.md` says how the book is kept).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from simulator.basics import GRAVITY_M_S2
from simulator.compiled import inlined, inner
from simulator.effects.effect import Energy, Function
from simulator.kernel.composition import Composition, made_once
from simulator.kernel.layout import (
    CARRIED,
    CREEPING,
    FLIGHT,
    INTRUDING,
    LEG_WORK,
    MECHANICAL,
    V_BODY,
    V_FOOT,
    X_BODY,
    X_FOOT,
)
from simulator.kernel.mechanics.body import make_body_acceleration, make_force_losses
from simulator.kernel.mechanics.leg import make_apply, make_command, make_lever
from simulator.kernel.mechanics.massless_foot import make_follow_platform
from simulator.kernel.mechanics.platform import make_platform, make_slide

Row = NDArray[np.float64]


def make_powers(composition: Composition) -> Function:
    """Rates of the drive's integrals: `(mode, work, stage, lever_m, leg_speed_m_s, commanded_n, applied_n)`."""
    chosen = composition.slot("cost_force_n")
    choose = composition.has("cost_force_n")
    cost_powers: Function = inner(lambda mode, work, stage, lever_m, speed_m_s, cost_n: None)
    for energy in composition.costs:
        cost_powers = _also(cost_powers, composition, energy)

    @inner
    def powers(
        mode: float,
        work: Row,
        stage: int,
        lever_m: float,
        speed_m_s: float,
        commanded_n: float,
        applied_n: float,
    ) -> None:
        cost_n = chosen(work, lever_m, commanded_n, applied_n) if choose else applied_n
        work[stage + LEG_WORK] = -applied_n * speed_m_s
        work[stage + MECHANICAL] = -cost_n * speed_m_s
        cost_powers(mode, work, stage, lever_m, speed_m_s, cost_n)

    return powers


def _also(before: Function, composition: Composition, energy: Energy) -> Function:
    """Compose `(mode, work, stage, lever_m, leg_speed_m_s, cost_n)`: one more part of the cost."""
    power_w, place = composition.slots[f"{energy.name}_w"], composition.integrals[energy.name]
    always = not energy.singular or composition.on("cost_of_whole_jump")

    @inner
    def cost_powers(mode: float, work: Row, stage: int, lever_m: float, speed_m_s: float, cost_n: float) -> None:
        before(mode, work, stage, lever_m, speed_m_s, cost_n)
        work[stage + place] = power_w(work, lever_m, speed_m_s, cost_n) if always or mode != FLIGHT else 0.0

    return cost_powers


def make_effect_rates(composition: Composition) -> Function:
    """Rates of the states that effects have of their own: `(work, row, stage)`."""
    rates = inner(lambda work, row, stage: None)
    for one in composition.effect_states:
        rates = _with_rate(rates, one.rate, one.place)
    return rates


def _with_rate(before: Function, rate: Function, place: int) -> Function:
    @inner
    def rates(work: Row, row: int, stage: int) -> None:
        before(work, row, stage)
        work[stage + place] = rate(work, row)

    return rates


@made_once
def make_ground(composition: Composition) -> Function:
    """Acceleration of an intruding foot, the power that the ground takes, and that of the grains that move with it:
    `(work, applied_n, x_f, v_f)`.
    """
    foot = composition.position["foot_mass"]
    if not composition.has("resistance_n"):
        return inner(lambda work, applied_n, x_f, v_f: (0.0, 0.0, 0.0))
    resistance_n = composition.slots["resistance_n"]
    quadratic, linear = composition.slot("quadratic_drag_kg_m"), composition.slot("linear_drag_kg_s")
    mass, mass_slope = composition.slot("added_mass_kg"), composition.slot("added_mass_slope_kg_m")
    has_quadratic, has_linear = composition.has("quadratic_drag_kg_m"), composition.has("linear_drag_kg_s")
    has_mass = composition.has("added_mass_kg")
    heavy, platform_kg = composition.has("platform_mass_kg"), composition.slot("platform_mass_kg")

    @inner
    def ground(work: Row, applied_n: float, x_f: float, v_f: float) -> tuple[float, float, float]:
        depth_m, sinking = -x_f, -v_f
        push_n, moved_kg, grain_w = resistance_n(work, depth_m), work[foot], 0.0
        if has_quadratic:
            push_n += quadratic(work, depth_m) * sinking * sinking
        if has_linear:
            push_n += linear(work) * sinking
        if has_mass:
            added_kg = mass(work, depth_m)
            moved_kg += added_kg
            grain_w = sinking * (added_kg * GRAVITY_M_S2 + 0.5 * mass_slope(work, depth_m) * sinking * sinking)
        up_n = applied_n + push_n
        if heavy:  # the platform's weight is carried by its motors
            moved_kg += platform_kg(work)
            up_n += platform_kg(work) * GRAVITY_M_S2
        return up_n / moved_kg - GRAVITY_M_S2, push_n * sinking, grain_w

    return ground


def make_rates(composition: Composition, *, creeping: bool = True) -> Function:
    """Rates of the whole state: `(mode, t, work, row, rates, stage)`; not those of a creeping foot without `creeping`.

    The state is at the place `row`; the rates are written at the place `stage`, every one of them.
    """
    foot = composition.position["foot_mass"]
    per_foot, accelerate = composition.position["inverse_foot_mass"], make_body_acceleration(composition)
    lever, command, apply = make_lever(composition), make_command(composition), make_apply(composition)
    powers, ground, creep = make_powers(composition), make_ground(composition), make_creep(composition)
    forced, losses = bool(composition.body_forces), make_force_losses(composition)
    stateful, effect_rates = bool(composition.effect_states), make_effect_rates(composition)
    has_loss, loss = "ground_loss" in composition.integrals, composition.integrals.get("ground_loss", -1)
    creeps = has_loss and creeping
    has_grain, grain = "grain_energy" in composition.integrals, composition.integrals.get("grain_energy", -1)
    resistance_n = composition.slot("resistance_n")
    platform, slide, slides = make_platform(composition), make_slide(composition), composition.platform >= 0
    follows, follow_platform = composition.follows, make_follow_platform(composition)
    emulated, reset_work = composition.has("travel_m"), composition.integrals.get("reset_work", -1)

    @inlined
    def rates_of(mode: int, t: float, work: Row, row: int, stage: int) -> None:
        x_b, v_b = work[row + X_BODY], work[row + V_BODY]
        x_f, v_f = work[row + X_FOOT], work[row + V_FOOT]
        following_m_s2 = 0.0
        if follows and mode == CREEPING:
            v_f, following_m_s2 = follow_platform(work, row)
            work[row + V_FOOT] = v_f
        length_m, speed_m_s = x_b - x_f, v_b - v_f
        lever_arm_m = lever(work, length_m)
        commanded_n = command(work, length_m, speed_m_s, v_f)
        applied_n = apply(work, lever_arm_m, commanded_n)
        a_b = accelerate(mode, work, row, applied_n)
        sinking, a_f, loss_w, grain_w, reset_w = -v_f, 0.0, 0.0, 0.0, 0.0
        if forced:
            losses(mode, work, row, stage)
        if stateful:
            effect_rates(work, row, stage)
        if slides:
            loss_w = slide(work, row, stage)
        if mode == FLIGHT:
            a_f = applied_n * work[per_foot] - GRAVITY_M_S2
        elif mode == INTRUDING:
            a_f, loss_w, grain_w = ground(work, applied_n, x_f, v_f)
        elif follows and mode == CREEPING:
            _, loss_w, _ = ground(work, applied_n, x_f, v_f)
            a_f = following_m_s2
        elif creeps and mode == CREEPING:
            sinking = creep(work, length_m, v_b, a_b, -x_f)
            loss_w = resistance_n(work, -x_f) * sinking
        elif emulated and mode == CARRIED:
            a_f = platform(work, t)[2]
            reset_w = (work[foot] * (a_f + GRAVITY_M_S2) - applied_n) * v_f
        else:
            sinking = 0.0
        # written only now: the compiler then knows that what was computed twice has not changed
        work[stage + X_BODY], work[stage + V_BODY] = v_b, a_b
        work[stage + X_FOOT], work[stage + V_FOOT] = -sinking, a_f
        if has_loss:
            work[stage + loss] = loss_w
        if has_grain:
            work[stage + grain] = grain_w
        if emulated:
            work[stage + reset_work] = reset_w
        powers(mode, work, stage, lever_arm_m, v_b + sinking, commanded_n, applied_n)

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


@made_once
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
