"""The leg: the force its controller commands, and what the motors apply (thesis Eq. 3.1, 3.2, 3.2.1)."""

from __future__ import annotations

import numpy as np

from simulator.compiled import Function, Row, inner
from simulator.kernel.composition import Composition, made_once
from simulator.kernel.layout import (
    ACTIVE_DAMPING,
    ASLEEP,
    DAMPING,
    EMULATOR,
    FLIGHT,
    HELD_FORCE,
    HOLD,
    MODE,
    SAMPLED_SPEED,
    STIFFNESS,
    V_BODY,
    V_FOOT,
    X_BODY,
    X_FOOT,
)
from simulator.kernel.working_row import choose
from simulator.kinematics import lever_m
from simulator.parameter import GRAVITY_M_S2


@made_once
def make_lever(composition: Composition) -> Function:
    """Lever arm of the joint at a leg length, m: the five-bar's, where no effect gives another.

    It is 1 where nothing in force asks for it, which compiles to nothing.
    """
    upper, lower = composition.position["upper_link"], composition.position["lower_link"]
    if not composition.levered:
        return inner(lambda work, leg_length_m: 1.0)
    if composition.has("lever_m"):
        return composition.slots["lever_m"]

    @inner
    def lever(work: Row, leg_length_m: float) -> float:
        return lever_m(work[upper], work[lower], leg_length_m)

    return lever


@made_once
def make_command(composition: Composition) -> Function:
    """Commanded force of the leg, N, tension positive: `(work, length_m, speed_m_s, foot_speed_m_s)`."""
    rest = composition.position["rest_length"]
    damped = composition.has("compression_damping_kg_s")
    active = composition.has("active_damping_kg_m")
    linear, held = composition.on("linear_active_damping"), composition.on("held_force")
    sampled = composition.samples_speed

    @inner
    def command(work: Row, length_m: float, speed_m_s: float, foot_speed_m_s: float) -> float:
        force = work[STIFFNESS] * (length_m - work[rest])
        if damped:
            force += work[DAMPING] * speed_m_s
        if active:
            downwards = work[SAMPLED_SPEED] if sampled else max(0.0, -foot_speed_m_s)
            if linear:
                force += work[ACTIVE_DAMPING] * downwards
            else:
                force += work[ACTIVE_DAMPING] * downwards * speed_m_s
        if held and work[MODE] != FLIGHT and work[ASLEEP] == 0:
            force = work[HELD_FORCE]
        return force

    return command


@made_once
def make_most(composition: Composition) -> Function:
    """Largest size of a force of this sign, N: `(work, lever_m, leg_speed_m_s, force_n)`; below 0 the motors give none.

    A force in tension drives a leg that shortens.
    """
    if not composition.has("cap_n"):
        return inner(lambda work, lever_m, speed_m_s, force_n: np.inf)
    cap_n = composition.slots["cap_n"]

    @inner
    def most(work: Row, lever_m: float, speed_m_s: float, force_n: float) -> float:
        return cap_n(work, lever_m, choose(force_n > 0.0, -speed_m_s, speed_m_s))

    return most


@made_once
def make_apply(composition: Composition) -> Function:
    """Force that the motors apply for a commanded one, N: `(p, lever_m, leg_speed_m_s, commanded_n)`."""
    if not composition.has("cap_n"):
        return inner(lambda work, lever_m, speed_m_s, commanded_n: commanded_n)
    most_n, slows = make_most(composition), composition.has("cap_slows")

    @inner
    def apply(work: Row, lever_m: float, speed_m_s: float, commanded_n: float) -> float:
        most = most_n(work, lever_m, speed_m_s, commanded_n)
        if slows:
            most = max(most, 0.0)
        return min(max(commanded_n, -most), most)

    return apply


@made_once
def make_cost_force(composition: Composition) -> Function:
    """Force that the cost counts, N: `(work, lever_m, commanded_n, applied_n)`."""
    if not composition.has("cost_force_n"):
        return inner(lambda work, lever_m, commanded_n, applied_n: applied_n)
    return composition.slots["cost_force_n"]


@made_once
def make_set_gains(composition: Composition) -> Function:
    """Set the gains of a phase: `(work, extending, foot_speed_m_s)`; active damping acts in extension only."""
    k_compression, k_extension = composition.position["k_compression"], composition.position["k_extension"]
    damped = composition.has("compression_damping_kg_s")
    active = composition.has("active_damping_kg_m")
    b_compression = composition.slot("compression_damping_kg_s")
    b_extension = composition.slot("extension_damping_kg_s")
    b_active = composition.slot("active_damping_kg_m")

    @inner
    def set_gains(work: Row, extending: bool, foot_speed_m_s: float) -> None:
        work[STIFFNESS] = work[k_extension] if extending else work[k_compression]
        if damped:
            work[DAMPING] = b_extension(work) if extending else b_compression(work)
        if active:
            work[ACTIVE_DAMPING] = b_active(work) if extending else 0.0
            work[SAMPLED_SPEED] = max(0.0, -foot_speed_m_s) if extending else 0.0

    return set_gains


AT_REST = 1e-12
"""Share of the forces on a foot that counts as rounding: less neither lifts it nor makes the ground yield."""


@made_once
def make_forces(composition: Composition) -> Function:
    """Commanded and applied force of the leg, and its cap, N: `(work, row)`."""
    lever, command, apply = make_lever(composition), make_command(composition), make_apply(composition)
    most = make_most(composition)

    @inner
    def forces(work: Row, row: int) -> tuple[float, float, float]:
        length_m, speed_m_s = work[row + X_BODY] - work[row + X_FOOT], work[row + V_BODY] - work[row + V_FOOT]
        arm_m = lever(work, length_m)
        commanded_n = command(work, length_m, speed_m_s, work[row + V_FOOT])
        most_n = most(work, arm_m, speed_m_s, commanded_n)
        return commanded_n, apply(work, arm_m, speed_m_s, commanded_n), most_n

    return forces


@made_once
def make_foot_margins(composition: Composition) -> Function:
    """What lifts a resting foot and what makes the ground yield, N: `(work, row, applied_n)`.

    Both are positive only beyond rounding. Rigid ground, a ratchet outside *hold* and a platform at its stop do not
    yield.
    """
    foot = composition.position["foot_mass"]
    resistance_n = composition.slot("resistance_n")
    yields = composition.has("resistance_n")
    has_mass, mass = composition.optional("added_mass_kg")
    emulated, travel_m = composition.optional("travel_m")

    @inner
    def margins(work: Row, row: int, applied_n: float) -> tuple[float, float]:
        weight_n = work[foot] * GRAVITY_M_S2
        lifting_n = applied_n - weight_n - AT_REST * (abs(applied_n) + weight_n)
        if not yields:
            return lifting_n, -1.0
        depth_m = -work[row + X_FOOT]
        if emulated and (work[EMULATOR] != HOLD or depth_m >= travel_m(work)):
            return lifting_n, -1.0
        if has_mass:
            weight_n += mass(work, depth_m) * GRAVITY_M_S2
        hold_n = resistance_n(work, depth_m)
        yielding_n = weight_n - applied_n - hold_n - AT_REST * (abs(applied_n) + weight_n + hold_n)
        return lifting_n, yielding_n

    return margins
