"""The stance of set 2 as a plain compiled program: what somebody would write in numba for this one robot alone.

Dormand and Prince's pair of orders 5 and 4 with their dense output, which locates the events by itself; forces written
out once more from the thesis (3.1.2, 3.2, 3.3). No energy book, no margins of decisions, no growth of errors, no
outcome but lift-off, no other effects.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from simulator.accuracy.methods import NAMES, Attempt, Method, Outputs
from simulator.compiled import compiled
from simulator.kernel.limits import STOP_AFTER_LIFTOFF
from simulator.parameter import GRAVITY_M_S2 as G
from simulator.scene import Scene

Row = NDArray[np.float64]
STATES, GUARDS = 6, 4
"""Height and speed of body and foot, mechanical work and heat; those of the guards are named in `guards`."""
SIZES = np.array([0.27, 1.6, 0.027, 1.6, 5.0, 5.0])
"""Typical sizes, of which absolute tolerances are shares."""
FIRST_STEP_S, LONGEST_S, FOUND = 1e-3, 2.0, 1e-13
"""`FOUND`: share of a step to which an event is located."""


class Robot(NamedTuple):
    """What the program reads of a scene, and what follows of it."""

    body_mass: float
    foot_mass: float
    rest_length: float
    upper_link: float
    lower_link: float
    k_compression: float
    k_extension: float
    b_compression: float
    b_extension: float
    control_rate: float
    guard_length: float
    foot_radius: float
    force_cap: float
    initial_velocity: float
    added_mass_constant: float
    heat: float
    slope: float
    area: float
    penetration: float
    stress: float
    cone_depth: float
    density: float
    drag_per_area: float
    drag_constant: float


def robot_of(p: Mapping[str, float]) -> Robot:
    """Return the robot of a scene's values."""
    slope, area = p["mu"] / math.tan(p["cone_angle"]), math.pi * p["foot_radius"] ** 2
    density, drag = p["phi"] * p["rho"] * p["mu"], p["bg_scale"] * p["b_g"] * p["c_g"]
    return Robot(
        **{name: p[name] for name in Robot._fields[:15]},
        heat=0.5 * p["motor_resistance"] / p["torque_constant"] ** 2,
        slope=slope,
        area=area,
        penetration=p["kg_scale"] * p["k_sh"] / area,
        stress=p["kg_scale"] * p["sigma"] / math.cos(p["cone_angle"]),
        cone_depth=p["foot_radius"] / slope,
        density=density,
        drag_per_area=drag * density,
        drag_constant=drag * p["added_mass_constant"],
    )


@compiled
def ground(p: Robot, depth: float) -> tuple[float, float, float]:
    """Resistance (N), drag (kg/m) and added mass (kg) at a depth."""
    formed = min(max(depth, 0.0), p.cone_depth)
    covered = p.slope * formed
    free = p.foot_radius - covered
    volume = math.pi * formed * (p.foot_radius * free + covered * covered * (1.0 / 3.0))
    push = p.penetration * volume + p.stress * depth * (p.area + volume)
    drag = p.drag_per_area * (math.pi * free * free) + p.drag_constant
    return push, drag, p.density * volume + p.added_mass_constant * depth


@compiled
def rates(sinks: bool, side: float, k: float, b: float, p: Robot, y: Row, found: Row) -> None:
    """Rates of the state; the foot is in the ground, and rests unless it `sinks`; `side` is 0 below the force's cap."""
    length, speed = y[0] - y[2], y[1] - y[3]
    commanded = k * (length - p.rest_length) + b * speed
    applied = commanded if side == 0.0 else side * p.force_cap
    foot_speed, foot_rate = 0.0, 0.0
    if sinks:
        push, drag, mass = ground(p, -y[2])
        foot_speed, foot_rate = y[3], (applied + push + drag * y[3] * y[3]) / (p.foot_mass + mass) - G
    square, difference = length * length, p.upper_link * p.upper_link - p.lower_link * p.lower_link
    whole, part = 4.0 * p.upper_link * p.upper_link * square, difference + square
    torque = commanded * length * math.sqrt(max(whole - part * part, 1e-8 * whole)) / (square - difference)
    body_speed = y[1]
    found[0], found[1], found[2], found[3] = body_speed, -applied / p.body_mass - G, foot_speed, foot_rate
    found[4], found[5] = -commanded * speed, p.heat * torque * torque


@compiled
def guards(sinks: bool, side: float, k: float, b: float, sign: float, p: Robot, y: Row, found: Row) -> None:
    """What rises through zero at an event: the cap; the foot stops, or lifts off; the cone is complete, or the ground
    yields; the controller wants its other phase (`sign` 1 in compression, -1 in extension)."""
    length, speed = y[0] - y[2], y[1] - y[3]
    force = k * (length - p.rest_length) + b * speed
    found[0] = abs(force) - p.force_cap if side == 0.0 else p.force_cap - side * force
    if sinks:
        found[1], found[2] = y[3], -y[2] - p.cone_depth
    else:
        applied = force if side == 0.0 else side * p.force_cap
        push, _, mass = ground(p, -y[2])
        found[1], found[2] = applied - p.foot_mass * G, (p.foot_mass + mass) * G - applied - push
    found[3] = sign * max(min(speed, y[1]), p.guard_length - length)


@compiled
def between(h: float, s: float, y: Row, k: Row, found: Row) -> None:
    """Dense output of order 4 at a share of the step (Shampine 1986, as in scipy's RK45)."""
    w0 = s * (1.0 + s * (-8048581381 / 2820520608 + s * (8663915743 / 2820520608 - s * (12715105075 / 11282082432))))
    w2 = s * s * (131558114200 / 32700410799 + s * (-68118460800 / 10900136933 + s * (87487479700 / 32700410799)))
    w3 = s * s * (-1754552775 / 470086768 + s * (14199869525 / 1410260304 - s * (10690763975 / 1880347072)))
    w4 = s * s * (127303824393 / 49829197408 + s * (-318862633887 / 49829197408 + s * (701980252875 / 199316789632)))
    w5 = s * s * (-282668133 / 205662961 + s * (2019193451 / 616988883 - s * (1453857185 / 822651844)))
    w6 = s * s * (40617522 / 29380423 + s * (-110615467 / 29380423 + s * (69997945 / 29380423)))
    for i in range(STATES):
        found[i] = y[i] + h * (w0 * k[0, i] + w2 * k[2, i] + w3 * k[3, i] + w4 * k[4, i] + w5 * k[5, i] + w6 * k[6, i])


@compiled
def stance(p: Robot, rtol: float, sizes: Row, work: Row, found: Row) -> None:
    """Integrate from touchdown to lift-off; `found` receives depth, time, joules and how often rates were evaluated.

    `work`, shape (13, `STATES`): states, stages and guards.
    """
    y, new, inside, k = work[0], work[1], work[2], work[3:10]
    before, after, there = work[10], work[11], work[12]
    y[:] = 0.0
    y[0], y[1], y[3] = p.rest_length, p.initial_velocity, p.initial_velocity
    sinks, side, sign, stiffness, damping = True, 0.0, 1.0, p.k_compression, p.b_compression
    t, h, tick_s, evaluations, starts, deepest = 0.0, FIRST_STEP_S, np.inf, 0, True, 0.0
    while t < LONGEST_S:
        if starts:
            rates(sinks, side, stiffness, damping, p, y, k[0])
            guards(sinks, side, stiffness, damping, sign, p, y, before)
            evaluations, starts = evaluations + 1, False
        to_tick = t + h >= tick_s
        step = tick_s - t if to_tick else h
        for i in range(STATES):
            new[i] = y[i] + step * (1.0 / 5.0 * k[0, i])
        rates(sinks, side, stiffness, damping, p, new, k[1])
        for i in range(STATES):
            new[i] = y[i] + step * (3.0 / 40.0 * k[0, i] + 9.0 / 40.0 * k[1, i])
        rates(sinks, side, stiffness, damping, p, new, k[2])
        for i in range(STATES):
            new[i] = y[i] + step * (44.0 / 45.0 * k[0, i] - 56.0 / 15.0 * k[1, i] + 32.0 / 9.0 * k[2, i])
        rates(sinks, side, stiffness, damping, p, new, k[3])
        for i in range(STATES):
            new[i] = y[i] + step * (
                19372.0 / 6561.0 * k[0, i]
                - 25360.0 / 2187.0 * k[1, i]
                + 64448.0 / 6561.0 * k[2, i]
                - 212.0 / 729.0 * k[3, i]
            )
        rates(sinks, side, stiffness, damping, p, new, k[4])
        for i in range(STATES):
            new[i] = y[i] + step * (
                9017.0 / 3168.0 * k[0, i]
                - 355.0 / 33.0 * k[1, i]
                + 46732.0 / 5247.0 * k[2, i]
                + 49.0 / 176.0 * k[3, i]
                - 5103.0 / 18656.0 * k[4, i]
            )
        rates(sinks, side, stiffness, damping, p, new, k[5])
        for i in range(STATES):
            new[i] = y[i] + step * (
                35.0 / 384.0 * k[0, i]
                + 500.0 / 1113.0 * k[2, i]
                + 125.0 / 192.0 * k[3, i]
                - 2187.0 / 6784.0 * k[4, i]
                + 11.0 / 84.0 * k[5, i]
            )
        rates(sinks, side, stiffness, damping, p, new, k[6])
        evaluations += 6
        squares = 0.0
        for i in range(STATES):
            error = step * (
                71.0 / 57600.0 * k[0, i]
                - 71.0 / 16695.0 * k[2, i]
                + 71.0 / 1920.0 * k[3, i]
                - 17253.0 / 339200.0 * k[4, i]
                + 22.0 / 525.0 * k[5, i]
                - 1.0 / 40.0 * k[6, i]
            )
            share = error / (rtol * (sizes[i] + max(abs(y[i]), abs(new[i]))))
            squares += share * share
        norm = math.sqrt(squares / STATES)
        proposal = step * min(10.0, max(0.2, 0.9 * (norm + 1e-10) ** -0.2))
        if norm > 1.0:
            h = proposal
            continue
        guards(sinks, side, stiffness, damping, sign, p, new, after)
        event, share = -1, 1.0
        for one in range(GUARDS):
            if before[one] <= 0.0 and after[one] > 0.0 and not (one == 3 and tick_s < np.inf):
                low, high, g_low, g_high = 0.0, 1.0, before[one], after[one]
                while high - low > FOUND:  # false position, its old end halved
                    middle = high - g_high * (high - low) / (g_high - g_low)
                    if not low < middle < high:
                        break
                    between(step, middle, y, k, inside)
                    guards(sinks, side, stiffness, damping, sign, p, inside, there)
                    if there[one] > 0.0:
                        close, high, g_high, g_low = high - middle < FOUND, middle, there[one], 0.5 * g_low
                    else:
                        close, low, g_low, g_high = middle - low < FOUND, middle, there[one], 0.5 * g_high
                    if close:
                        break
                if high < share:
                    event, share = one, high
        if event == 3:  # decided at the next tick, to which this step is taken again
            tick_s, h = math.ceil((t + share * step) * p.control_rate) / p.control_rate, step
            continue
        starts = event >= 0 or to_tick
        if event >= 0:
            between(step, share, y, k, inside)
            t, new[:], h = t + share * step, inside, step
        else:
            t, h = tick_s if to_tick else t + step, h if to_tick else proposal
            k[0] = k[6]
            before[:] = after
        y[:] = new
        if event == 0:
            force = stiffness * (y[0] - y[2] - p.rest_length) + damping * (y[1] - y[3])
            side = 0.0 if side != 0.0 else math.copysign(1.0, force)
        elif event == 1 and not sinks:
            break
        elif event == 1:
            y[3], sinks, deepest = 0.0, False, max(deepest, -y[2])
        elif event == 2 and not sinks:
            sinks = True
        elif event < 0 and to_tick:
            tick_s = np.inf
            guards(sinks, side, stiffness, damping, sign, p, y, there)
            if there[3] > 0.0:
                sign = -sign
                stiffness, damping = (
                    (p.k_compression, p.b_compression) if sign > 0.0 else (p.k_extension, p.b_extension)
                )
                force = stiffness * (y[0] - y[2] - p.rest_length) + damping * (y[1] - y[3])
                side = 0.0 if abs(force) <= p.force_cap else math.copysign(1.0, force)
                guards(sinks, side, stiffness, damping, sign, p, y, there)
                if not sinks and there[1] > 0.0:
                    break
                sinks = sinks or there[2] > 0.0
    found[0], found[1], found[2], found[3] = deepest, t, y[4] + y[5], evaluations


def _prepare(scene: Scene, rtol: float, stop_after: int) -> Attempt:
    if stop_after != STOP_AFTER_LIFTOFF or scene["b_ad"] != 0.0 or scene["initial_height"] != 0.0:
        raise ValueError("the compiled peer knows a stance without active damping, from touchdown to lift-off.")
    found, work = np.zeros(4), np.zeros((13, STATES))
    robot = robot_of({name: scene[name] for name in scene.values})

    def outputs() -> Outputs:
        depth_m, time_s, cost_j, evaluations = found.tolist()
        values = dict.fromkeys(NAMES) | {"max_depth_m": depth_m, "liftoff_time_s": time_s, "cost_J": cost_j}
        return Outputs("liftoff", values, int(evaluations))

    return Attempt(partial(stance, robot, rtol, SIZES, work, found), outputs)


PEER = Method("compiled peer (numba)", "rtol", tuple(10.0**-power for power in range(3, 12)), _prepare)
