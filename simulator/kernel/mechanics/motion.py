"""Equations of motion in every contact mode, with the integrals of the energy book as states of their own.

    body   m_b a_b = -F - m_b g (+ forces of effects; at rest while one holds it)
    foot   (m_f + m_a) a_f = F + K + D w^2 (+ alpha w) - (m_f + m_a) g     intruding, w = -v_f
           m_f a_f = F - m_f g                                            flight
           at rest                                                        jammed

F is the leg's force, tension positive (`../docs/decisions.md` says how the book is kept).
"""

from __future__ import annotations

import math
from typing import Any

from simulator.compiled import Function, Row, inlined, inner
from simulator.effects.effect import MODES, BodyForce, Energy
from simulator.kernel.combined import in_turn, nothing, summed
from simulator.kernel.composition import Composition, made_once
from simulator.kernel.layout import (
    CARRIED,
    CREEPING,
    DEEPEST,
    EMULATOR_SINCE,
    FLIGHT,
    IMPACT,
    INTRUDING,
    LEG_WORK,
    MECHANICAL,
    MODE,
    NOW,
    RESET_FROM,
    SLIDES,
    STALE,
    STIFFNESS,
    TOLERANCE,
    V_BODY,
    V_FOOT,
    X_BODY,
    X_FOOT,
)
from simulator.kernel.mechanics.leg import make_apply, make_command, make_cost_force, make_lever, make_most
from simulator.parameter import GRAVITY_M_S2


@made_once
def make_moved_mass(composition: Composition) -> Function:
    """Compose `(work, depth_m)`: the mass that an intruding foot moves, kg."""
    foot = composition.position["foot_mass"]
    has_mass, mass = composition.optional("added_mass_kg")
    heavy, platform_kg = composition.optional("platform_mass_kg")

    @inner
    def moved_mass_kg(work: Row, depth_m: float) -> float:
        moved_kg = work[foot]
        if has_mass:
            moved_kg += mass(work, depth_m)
        if heavy:
            moved_kg += platform_kg(work)
        return moved_kg

    return moved_mass_kg


def _in_its_modes(force: BodyForce, newtons: Function) -> Function:
    """Compose `(mode, work, row)`: an effect's force, N, 0 in other modes than its own."""
    acts, always = tuple(mode in force.modes for mode in MODES), set(force.modes) == set(MODES)

    @inner
    def in_its_modes(mode: float, work: Row, row: int) -> float:
        if always or acts[int(mode)]:
            return newtons(work, row)
        return 0.0

    return in_its_modes


def _sum(composition: Composition, *, friction: bool) -> Any:
    """Compose `(mode, work, row)`: the effects' forces on the body, N, without that of `friction`; None without any."""
    found = [_in_its_modes(*one) for one in composition.body_forces if friction or not one[0].holds]
    return summed(found) if found else None


@made_once
def make_body_acceleration(composition: Composition) -> Function:
    """Compose `(mode, work, row, applied_n)`: the acceleration upward, m/s²; 0 while the body is held."""
    per_body, force_n = composition.position["inverse_body_mass"], _sum(composition, friction=True)
    (holds, held), forced = composition.optional("body_held"), force_n is not None

    @inner
    def acceleration_m_s2(mode: float, work: Row, row: int, applied_n: float) -> float:
        if holds and held(work):
            return 0.0
        a_b = -applied_n * work[per_body] - GRAVITY_M_S2
        if forced:
            a_b += force_n(mode, work, row) * work[per_body]
        return a_b

    return acceleration_m_s2


@made_once
def make_drive(composition: Composition) -> Function:
    """Compose `(mode, work, row, applied_n)`: the force on a body at rest but for the one that may hold it, N."""
    body, force_n = composition.position["body_mass"], _sum(composition, friction=False)
    forced = force_n is not None

    @inner
    def drive_n(mode: float, work: Row, row: int, applied_n: float) -> float:
        drive = -applied_n - work[body] * GRAVITY_M_S2
        if forced:
            drive += force_n(mode, work, row)
        return drive

    return drive_n


def make_force_losses(composition: Composition) -> Function:
    """Compose `(mode, work, row, stage)`: the rates of what each effect's force takes from the body, W."""
    return in_turn(
        _loss(_in_its_modes(force, newtons), composition.integrals[force.loss.name])
        for force, newtons in composition.body_forces
    )


def _loss(force_n: Function, place: int) -> Function:
    @inner
    def loss(mode: float, work: Row, row: int, stage: int) -> None:
        work[stage + place] = -force_n(mode, work, row) * work[row + V_BODY]

    return loss


@made_once
def make_platform(composition: Composition) -> Function:
    """Height, velocity and acceleration of the platform: `(work, t)`, moving only while it is being reset.

    Where nothing resets, the height is the lowest the foot has been at.
    """
    if not composition.has("travel_m"):
        return inner(lambda work, t: (work[DEEPEST], 0.0, 0.0))
    duration = composition.position["reset_time"]

    @inner
    def platform(work: Row, t: float) -> tuple[float, float, float]:
        start = work[RESET_FROM]
        if start >= 0.0:
            return work[DEEPEST], 0.0, 0.0
        length = work[duration]
        s = min(max((t - work[EMULATOR_SINCE]) / length, 0.0), 1.0)
        left = 1.0 - s
        height = start * (1.0 - s * s * s * (10.0 + s * (6.0 * s - 15.0)))
        velocity = -start * 30.0 * s * s * left * left / length
        acceleration = -start * 60.0 * s * left * (1.0 - 2.0 * s) / (length * length)
        return height, velocity, acceleration

    return platform


def make_slide(composition: Composition) -> Function:
    """Rates of a platform that slides on without the foot, and the power it loses: `(work, row, stage)`.

    m_p a_p = k z + alpha w + beta w^2, downwards at the speed w, its weight carried by its motors.
    """
    if composition.platform < 0:
        return inner(lambda work, row, stage: 0.0)
    place, mass_kg = composition.platform, composition.slots["platform_mass_kg"]
    resistance_n, linear = composition.slots["resistance_n"], composition.slots["linear_drag_kg_s"]
    quadratic = composition.slots["quadratic_drag_kg_m"]

    @inner
    def slide(work: Row, row: int, stage: int) -> float:
        if work[SLIDES] == 0:
            work[stage + place], work[stage + place + 1] = 0.0, 0.0
            return 0.0
        depth_m, sinking = -work[row + place], -work[row + place + 1]
        push_n = resistance_n(work, depth_m) + (linear(work) + quadratic(work, depth_m) * sinking) * sinking
        work[stage + place], work[stage + place + 1] = -sinking, push_n / mass_kg(work)
        return push_n * sinking

    return slide


def make_stop_platform(composition: Composition) -> Function:
    """Stop a sliding platform: `(work)`; what it moved with is lost and booked."""
    if composition.platform < 0:
        return nothing
    place, mass_kg = composition.platform, composition.slots["platform_mass_kg"]

    @inner
    def stop_platform(work: Row) -> None:
        if work[SLIDES] == 1:
            speed_m_s = work[NOW + place + 1]
            lost_j = 0.5 * mass_kg(work) * speed_m_s * speed_m_s
            work[IMPACT] += lost_j
            work[DEEPEST], work[SLIDES] = work[NOW + place], 0

    return stop_platform


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
    has_cap, cap_n = composition.optional("cap_n")
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
            most_n = cap_n(work, lever(work, length_m), 0.0)
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
    has_cap, cap_n = composition.optional("cap_n")
    foot, accelerate = composition.position["foot_mass"], make_body_acceleration(composition)

    @inner
    def follow_platform(work: Row, row: int) -> tuple[float, float]:
        x_b, v_b, x_f = work[row + X_BODY], work[row + V_BODY], work[row + X_FOOT]
        sinking = speed(work, x_b, v_b, x_f, 0.0)
        force_n = command(work, x_b - x_f, v_b + sinking, -sinking)
        if has_cap:
            most_n = cap_n(work, lever(work, x_b - x_f), 0.0)
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
        return nothing
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


def make_powers(composition: Composition) -> Function:
    """Rates of the drive's integrals: `(mode, work, stage, lever_m, leg_speed_m_s, commanded_n, applied_n)`."""
    cost_force, (other, mechanical_w) = make_cost_force(composition), composition.optional("mechanical_w")
    cost_powers = in_turn(_cost_power(composition, energy) for energy in composition.costs)

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
        cost_n = cost_force(work, lever_m, commanded_n, applied_n)
        work[stage + LEG_WORK] = -applied_n * speed_m_s
        work[stage + MECHANICAL] = mechanical_w(work, lever_m, speed_m_s, cost_n) if other else -cost_n * speed_m_s
        cost_powers(mode, work, stage, lever_m, speed_m_s, cost_n)

    return powers


def _cost_power(composition: Composition, energy: Energy) -> Function:
    """Compose `(mode, work, stage, lever_m, leg_speed_m_s, cost_n)`: the rate of a part of the cost."""
    power_w, place = composition.slots[f"{energy.name}_w"], composition.integrals[energy.name]
    always = not energy.singular or composition.on("cost_of_whole_jump")

    @inner
    def cost_power(mode: float, work: Row, stage: int, lever_m: float, speed_m_s: float, cost_n: float) -> None:
        work[stage + place] = power_w(work, lever_m, speed_m_s, cost_n) if always or mode != FLIGHT else 0.0

    return cost_power


def make_effect_rates(composition: Composition) -> Function:
    """Rates of the states that effects have of their own: `(work, row, stage)`."""
    return in_turn(_rate(one.rate, one.place) for one in composition.effect_states)


def _rate(rate: Function, place: int) -> Function:
    @inner
    def write_rate(work: Row, row: int, stage: int) -> None:
        work[stage + place] = rate(work, row)

    return write_rate


@made_once
def make_ground(composition: Composition) -> Function:
    """Acceleration of an intruding foot, the power that the ground takes, and that of the grains that move with it:
    `(work, applied_n, x_f, v_f)`.
    """
    foot = composition.position["foot_mass"]
    if not composition.has("resistance_n"):
        return inner(lambda work, applied_n, x_f, v_f: (0.0, 0.0, 0.0))
    resistance_n = composition.slots["resistance_n"]
    has_quadratic, quadratic = composition.optional("quadratic_drag_kg_m")
    has_linear, linear = composition.optional("linear_drag_kg_s")
    (has_mass, mass), mass_slope = composition.optional("added_mass_kg"), composition.slot("added_mass_slope_kg_m")
    heavy, platform_kg = composition.optional("platform_mass_kg")

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
        applied_n = apply(work, lever_arm_m, speed_m_s, commanded_n)
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
    has_cap, most, bends = composition.has("cap_n"), make_most(composition), composition.has("cap_bends")
    nudge_m = 1e-6

    @inner
    def force_rate(work: Row, length_m: float, v_b: float, a_b: float) -> float:
        nudge_s = 1e-6
        before_n = command(work, length_m, v_b, 0.0)
        if has_cap:
            most_n = most(work, lever(work, length_m), v_b, before_n)
            if abs(before_n) >= most_n:
                if bends:
                    ahead_n = most(work, lever(work, length_m + nudge_m), v_b, before_n)
                    behind_n = most(work, lever(work, length_m - nudge_m), v_b, before_n)
                    rate = (ahead_n - behind_n) / (2.0 * nudge_m) * v_b
                    return rate if before_n > 0.0 else -rate
                return 0.0
        after_n = command(work, length_m + v_b * nudge_s, v_b + a_b * nudge_s, 0.0)
        return (after_n - before_n) / nudge_s

    return force_rate
