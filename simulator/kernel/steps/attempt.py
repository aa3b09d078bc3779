"""One attempted step in any mode, its dense output, and its error in units of what is allowed."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from simulator.basics import GRAVITY_M_S2
from simulator.compiled import inner
from simulator.effects.effect import Function
from simulator.kernel.composition import Composition
from simulator.kernel.layout import (
    CREEPING,
    ERROR,
    EVALUATIONS,
    FLIGHT,
    HALF,
    INTRUDING,
    LEG_WORK,
    MODE,
    NOW,
    QUARTER,
    SATURATED,
    THREE_QUARTERS,
    TRIAL,
    V_BODY,
    V_FOOT,
    X_BODY,
    X_FOOT,
)
from simulator.kernel.mechanics.moved_mass import make_moved_mass
from simulator.kernel.steps.dense_output import make_fit_quintics, make_interpolate
from simulator.kernel.steps.linear_step import make_is_linear, make_linear_step
from simulator.kernel.steps.runge_kutta import make_runge_kutta

Row = NDArray[np.float64]
ORDER_RECIPROCAL = 0.2
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
    worst = inner(lambda work: 0.0)
    for one in composition.effect_states:
        worst = _with_error(worst, one.place, one.state.typical)
    return worst


def _with_error(before: Function, place: int, typical: float) -> Function:
    return inner(lambda work: max(before(work), abs(work[ERROR + place]) / max(typical, abs(work[TRIAL + place]))))


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
    """Step to take after one with this error, s."""
    return h * min(5.0, max(0.2, 0.9 * max(error_norm, 1e-10) ** -ORDER_RECIPROCAL))
